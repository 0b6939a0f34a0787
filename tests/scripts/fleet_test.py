#!/usr/bin/python3
"""What fleet.py makes of what a program says of many records."""

import csv
import json
import re
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

HERE = Path(__file__).resolve().parent
SCRIPTS = HERE.parents[1] / "scripts"
FAKE = HERE / "fake_fleet_armukf.py"
sys.dont_write_bytecode = True
sys.path.insert(0, str(SCRIPTS))

import fleet  # noqa: E402
import numpy as np  # noqa: E402
from trends import change_of, rate_of, strays  # noqa: E402

MONTHS = [f"2026-{month:02}-01" for month in range(1, 9)]


class Fleet(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        (self.folder / "records").mkdir()

    def record(self, name, *told):
        (self.folder / "records" / name).write_text(" ".join(map(str, told)))

    def fleet(self, *words, place="records"):
        done = subprocess.run([sys.executable, str(SCRIPTS / "fleet.py"), place, "--program", str(FAKE), *map(str, words)],
                              capture_output=True, text=True, check=False, cwd=self.folder)
        return done.returncode, done.stderr

    def table(self, name="fleet"):
        with (self.folder / f"{name}.csv").open(newline="") as file:
            return list(csv.DictReader(file))

    def calls(self):
        return [json.loads(line) for line in (self.folder / "records/calls").read_text().splitlines()]

    def test_change_from_record_to_record_is_told_worst_arm_first(self):
        for k, month in enumerate(MONTHS):
            wiggle = 0.01 * (-1) ** k
            self.record(f"calm_{month}.csv", 10.0 + wiggle, 0.01)
            self.record(f"stepped_{month}.csv", (10.0 if k < 5 else 9.0) + wiggle, 0.01)
            self.record(f"worn_{month}T10-30-00.csv", 10.0 + 0.05 * k + wiggle, 0.01)
        self.assertEqual(self.fleet("--json", "all.json"), (0, ""))
        stepped, worn, calm = self.table()
        self.assertEqual([stepped[c] for c in ("arm", "what", "how", "since", "records", "unit")],
                         ["stepped", "k_a", "step", "2026-06-01", "3 of 8", "N.m/rad"])
        self.assertAlmostEqual(float(stepped["percent"]), -10.0, delta=0.2)
        self.assertEqual([worn[c] for c in ("arm", "how", "since")], ["worn", "drift", "2026-01-01T10:30:00"])
        self.assertAlmostEqual(float(worn["to"]), 10.35, delta=0.03)
        self.assertEqual([calm[c] for c in ("arm", "what", "records")], ["calm", "nothing", "8"])
        self.assertEqual(len(json.loads((self.folder / "all.json").read_text())), 24)

    def test_broken_records_are_named_and_the_others_go_on(self):
        self.record("<b>arm_2026-01-01.csv", 10.0, 0.1)
        self.record("bad_2026-01-01.csv", "broken", "<script>1</script>")
        self.record("killed_2026-01-01.csv", "dies")
        self.record("notes.csv", 10.0, 0.1)
        self.record("when_2026-13-01.csv", 10.0, 0.1)
        status, complaints = self.fleet()
        self.assertEqual(status, 1)
        self.assertEqual(complaints.splitlines(), [
            "fleet.py: notes.csv: its name does not tell arm and date; see --names",
            "fleet.py: bad_2026-01-01.csv:17: u: '<script>1</script>' is not a number",
            f"fleet.py: killed_2026-01-01.csv: {FAKE}: exit status -9",
            "fleet.py: when_2026-13-01.csv: name: '2026-13-01' is no date"])
        self.assertEqual([row["what"] for row in self.table()], ["failed"] * 4 + ["nothing"])
        page = (self.folder / "fleet.html").read_text()
        self.assertIn("&lt;b&gt;arm", page)
        self.assertIn("&lt;script&gt;1&lt;/script&gt;", page)
        for markup in ("<b>arm", "<script", "http:", "https:"):
            self.assertNotIn(markup, page)
        # What failed is tried again, what did not is not; a record that was mended counts anew.
        self.record("bad_2026-01-01.csv", 10.0, 0.1)
        before = len(self.calls())
        self.assertEqual(self.fleet()[0], 1)
        self.assertEqual(sorted(Path(words[3]).name for words in self.calls()[before:]),
                         ["bad_2026-01-01.csv", "killed_2026-01-01.csv"])

    def test_killed_run_goes_on_and_what_is_asked_otherwise_is_asked_anew(self):
        for month in MONTHS:
            self.record(f"arm_{month}.csv", 10.0, 0.1)
        self.assertEqual(self.fleet("--workers", 1), (0, ""))
        whole = [(self.folder / f"fleet.{suffix}").read_bytes() for suffix in ("csv", "html")]
        state = self.folder / "fleet.state.jsonl"
        lines = state.read_text().splitlines()
        state.write_text("\n".join(lines[:3]) + "\n" + lines[3][:50])  # as a kill leaves it
        self.assertEqual(self.fleet("--workers", 2), (0, ""))
        self.assertEqual(len(self.calls()), 8 + 5)
        self.assertEqual([(self.folder / f"fleet.{suffix}").read_bytes() for suffix in ("csv", "html")], whole)
        (self.folder / "models").mkdir()
        (self.folder / "models/arm.toml").write_text("k_a = 11.0")
        self.assertEqual(self.fleet("--models", "models", "--", "--free-initial", "all"), (0, ""))
        (self.folder / "models/arm.toml").write_text("k_a = 12.0")
        self.assertEqual(self.fleet("--models", "models", "--", "--free-initial", "all"), (0, ""))
        self.assertEqual(len(self.calls()), 8 + 5 + 2 * 8)
        self.assertEqual(self.calls()[-1][4:8], ["--model", str(self.folder.resolve() / "models/arm.toml"), "--free-initial",
                                                 "all"])

    def test_events_and_effects_are_told_with_what_else_they_may_be(self):
        self.record("a.csv", 10.0, 0.1)
        self.record("b.csv", 12.0, 0.1, "event", "effect")
        self.record("c.csv", 12.0, 0.1, "effect")
        (self.folder / "list.csv").write_text("file,arm,date\n" + "".join(
            f"records/{name}.csv,arm 1,2026-02-0{k}T08:00:00+01:00\n" for k, name in enumerate("abc", 1)))
        self.assertEqual(self.fleet("--job", "watch", place="list.csv"), (0, ""))
        [event] = self.table()  # the step from the first record to the second is the event
        self.assertEqual([event[c] for c in ("arm", "what", "how", "since", "t", "to", "sd", "percent", "sure", "note")],
                         ["arm 1", "k_a", "event", "2026-02-02T07:00:00", "5", "12", "0.1", "20", "0.97", "or a_g"])
        self.assertEqual(self.fleet("--job", "diagnose", "-o", "found", place="list.csv"), (0, ""))
        [effect] = self.table("found")
        self.assertEqual([effect[c] for c in ("what", "how", "since", "records", "note")],
                         ["backlash", "effect", "2026-02-02T07:00:00", "2 of 3",
                          "backlash_gap = 0.02 ± 0.001 rad; or gear_hysteresis"])

    def test_names_may_be_of_another_form(self):
        self.record("20260301-press.csv", 10.0, 0.1)
        self.assertEqual(self.fleet("--names", r"(?P<date>\d{8})-(?P<arm>.*)\.csv"), (0, ""))
        self.assertEqual(self.table()[0]["arm"], "press")

    def test_wrong_input_takes_one_line(self):
        self.record("a_2026-01-01.csv", 10.0, 0.1)
        self.assertEqual(self.fleet("-o", "no/fleet", "--state", "state"),
                         (2, "fleet.py: no/fleet.csv: No such file or directory\n"))
        table = self.folder / "list.csv"
        table.write_text("name,arm\na.csv,a\n")
        (self.folder / "empty").mkdir()
        for message, place, names in (
                ("No such file or directory", self.folder / "nowhere", fleet.NAMES), ("no column file", table, fleet.NAMES),
                ("holds no records", self.folder / "empty", fleet.NAMES), ("missing ), unterminated", table, "("),
                ("needs the groups (?P<arm>...) and (?P<date>...)", table, "x")):
            with self.assertRaisesRegex(fleet.Trouble, re.escape(message)):
                fleet.records_of(place, names)


class Trends(unittest.TestCase):
    """Of a change in a series of simulated values."""

    def changes(self, shift, count, points=10):
        draw = np.random.default_rng(1)
        for _ in range(count):
            yield change_of(np.arange(points), draw.normal(size=points) + shift(np.arange(points)), np.ones(points), 1)

    def test_chance_is_taken_for_a_change_as_seldom_as_p_says(self):
        found = sum(change.p < 0.05 for change in self.changes(lambda k: 0 * k, 400))
        self.assertLess(found, 0.05 * 400 + 3 * np.sqrt(0.05 * 400))  # three deviations of a Poisson count

    def test_step_is_found_where_it_is(self):
        found = [c.how == "step" and c.begins == 6 for c in self.changes(lambda k: 8.0 * (k >= 6), 100)]
        self.assertGreater(np.mean(found), 0.95)

    def test_drift_is_no_step(self):
        found = [c.how == "drift" and abs(c.end - c.start - 18.0) < 3 * c.sd for c in self.changes(lambda k: 2.0 * k, 100)]
        self.assertGreater(np.mean(found), 0.95)

    def test_rate_has_the_deviation_that_it_tells(self):
        draw, times = np.random.default_rng(2), np.arange(12.0)
        errors = [(rate - 0.3) / sd for rate, sd in (
            rate_of(times, 0.3 * times + draw.normal(size=12), np.ones(12)) for _ in range(400))]
        self.assertAlmostEqual(np.std(errors), 1.0, delta=0.15)  # 400 draws: 0.035, and Student's wider tails

    def test_what_stands_alone_is_a_stray_and_steps_and_drifts_are_none(self):
        sds = np.full(8, 0.1)
        self.assertEqual(list(np.flatnonzero(strays([1, 1, 1, 9, 1, 1, 1, 1], sds))), [3])
        self.assertFalse(strays([1, 1, 1, 1, 9, 9, 9, 9], sds).any())
        self.assertFalse(strays(np.arange(8.0), sds).any())
        self.assertIsNone(change_of([0.0], [1.0], [0.1], 1))
        self.assertIsNone(rate_of([0.0, 0.0, 0.0], [1.0, 2.0, 3.0], [0.1] * 3))


if __name__ == "__main__":
    unittest.main()
