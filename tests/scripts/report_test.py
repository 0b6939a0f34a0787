#!/usr/bin/python3
"""The page that report.py makes of a diagnosis, without a browser. The diagnosis is made up."""

import json
import re
import subprocess
import sys
import tempfile
import unittest
from html.parser import HTMLParser
from pathlib import Path

import numpy as np

import made_up_diagnosis as made_up

SCRIPTS = Path(__file__).resolve().parents[2] / "scripts"
sys.dont_write_bytecode = True
sys.path.insert(0, str(SCRIPTS))

import report_charts as charts
import report_words as words

MOST_BYTES = 1_500_000
HOSTILE = "</script><script>document.title='executed'</script><img src=x onerror=alert(1)>"
EFFECTS = SCRIPTS.parent / "data/manual/reference/effects.md"


class Markup(HTMLParser):
    """The elements of a page, and its text."""

    def __init__(self, text):
        super().__init__()
        self.tags, self.words = [], []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        self.tags.append((tag, dict(attributes)))

    def handle_data(self, data):
        self.words.append(data)


def content_of(text):
    return json.loads(re.search(r'<script type="application/json" id="content">(.*?)</script>', text, re.S).group(1))


class Page(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def report(self, *words_):
        return subprocess.run([SCRIPTS / "report.py", *map(str, words_), "-o", self.folder / "report.html"],
                              capture_output=True, text=True, check=False)

    def made(self, found, rows):
        done = self.report(*made_up.write(self.folder, found, rows))
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        return (self.folder / "report.html").read_text(encoding="utf-8")

    def test_ten_seconds_fit_into_a_small_file_without_a_row_left_out(self):
        text = self.made(made_up.found(), rows := made_up.rows(20000))
        self.assertLess(len(text.encode()), MOST_BYTES)
        columns = content_of(text)["columns"]
        np.testing.assert_allclose(columns["residual_before"], rows["residual_before"], rtol=1e-4)
        np.testing.assert_allclose(columns["t"], rows["t"], rtol=1e-8)

    def test_a_long_record_is_no_larger_and_keeps_every_extreme_at_its_own_time(self):
        rows = made_up.rows(60000)
        rows["residual_after"][47777] = 9.0  # of one sample
        text = self.made(made_up.found(), rows)
        self.assertLess(len(text.encode()), MOST_BYTES)
        columns = content_of(text)["columns"]
        self.assertLessEqual(len(columns["t"]), charts.MOST_ROWS)
        at = columns["residual_after"].index(9.0)
        self.assertAlmostEqual(columns["t"][at], rows["t"][47777], places=7)
        for column in charts.COLUMNS:
            self.assertAlmostEqual(max(columns[column]), max(rows[column]), delta=1e-3)
            self.assertAlmostEqual(min(columns[column]), min(rows[column]), delta=1e-3)

    def test_nothing_from_a_record_becomes_markup_or_ends_a_script(self):
        found = made_up.found()
        harmless = [tag for tag, _ in Markup(self.made(found, made_up.rows())).tags]
        hostile = json.loads(json.dumps(found).replace("first.csv", HOSTILE).replace("its size", HOSTILE)
                             .replace("slow motion", HOSTILE).replace('"N.m"', json.dumps(HOSTILE)))
        hostile["unexplained"] = []
        for effect in hostile["effects"]:
            effect["confused_with"] = [HOSTILE]
        hostile["effects"][1]["confused_with"] = [HOSTILE]
        text = self.made(hostile, made_up.rows())
        page = Markup(text)
        extra = {tag for tag, _ in page.tags} - set(harmless)
        self.assertEqual(extra, set())
        self.assertEqual(sum(tag == "script" for tag, _ in page.tags), harmless.count("script"))
        self.assertFalse([a for _, a in page.tags if any(name.startswith("on") for name in a)])
        self.assertIn(HOSTILE, " ".join(page.words))
        self.assertTrue(content_of(text)["charts"])

    def test_it_asks_nothing_of_a_network(self):
        text = self.made(made_up.found(), made_up.rows())
        self.assertIn("default-src 'none'", text)
        for tag, attributes in Markup(text).tags:
            for name in ("src", "href"):
                self.assertIn(attributes.get(name, "data:,"), ("data:,",), tag)

    def test_every_candidate_has_its_reason(self):
        page = " ".join(Markup(self.made(found := made_up.found(), made_up.rows())).words)
        for candidate in found["candidates"]:
            self.assertIn(candidate["name"], page)
            self.assertIn(candidate.get("refused_because", "accepted"), page)

    def test_what_is_missing_is_said(self):
        rows = made_up.rows()
        found = made_up.found()
        del found["parameters"]
        self.assertIn("holds no parameters before and after", self.made(found, rows))
        few = np.zeros(len(rows), dtype=[(c, float) for c in ("t", "y", "residual_before", "residual_after")])
        for column in few.dtype.names:
            few[column] = rows[column]
        text = self.made(found, few)
        self.assertIn("no motor_angle", text)
        self.assertIn("The rows hold no torque of it", text)
        done = self.report(self.folder / "found.json")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("There are no rows, so there are no charts", (self.folder / "report.html").read_text())

    def test_wrong_input_takes_one_line(self):
        found, rows = made_up.write(self.folder, made_up.found(), made_up.rows())
        for words_, message in (
                ((self.folder / "no.json", rows), f"{self.folder}/no.json: No such file or directory\n"),
                ((rows, rows), f"{rows}: holds no verdict; is it what armukf wrote?\n"),
                ((found, found), f"{found}: no column t\n")):
            done = self.report(*words_)
            self.assertEqual((done.returncode, done.stderr, done.stdout), (2, message, ""))


class Charts(unittest.TestCase):
    def test_bands_hold_the_residual_s_power(self):
        judged = charts.Judged(made_up.rows(8000))
        bands = charts.by_band(judged)
        for place, column in ((2, "residual_before"), (3, "residual_after")):
            total = sum(band[place] ** 2 for band in bands) ** 0.5
            self.assertAlmostEqual(total / charts.rms(judged[column]), 1.0, delta=0.03)
        self.assertAlmostEqual(bands[3][2], 0.5 / 2 ** 0.5, delta=0.02)  # 10 to 30 Hz: the sine of 0.5 at 20 Hz
        self.assertEqual([band[1] for band in bands], [1, 3, 10, 30, 100, 300, 1000])

    def test_an_offset_is_of_the_slowest_band(self):
        rows = made_up.rows(8000)
        rows["residual_before"] += 3.0
        before = charts.by_band(charts.Judged(rows))[0][2]
        self.assertAlmostEqual(before, 3.0, delta=0.05)

    def test_a_gap_breaks_the_lines_and_a_second_record_follows_the_first(self):
        rows = made_up.rows(3000)
        rows["t"][1000:] += 0.7
        rows["t"][2000:] -= rows["t"][2000]
        rows["residual_after"][500:520] = np.nan
        judged = charts.Judged(rows)
        self.assertEqual([(p.start, p.stop) for p in judged.pieces], [(0, 1000), (1000, 2000), (2000, 3000)])
        columns = charts.shared_columns(judged)
        self.assertTrue(all(a < b for a, b in zip(columns["t"], columns["t"][1:])))
        self.assertEqual([i for i, v in enumerate(columns["residual_before"]) if v is None], [1000, 2001])
        self.assertEqual(columns["residual_after"][500:520], [None] * 20)
        self.assertIn("2 records", charts.over_time(judged)[0]["about"])

    def test_a_shape_is_that_of_the_torque_and_bins_of_few_samples_are_empty(self):
        judged = charts.Judged(made_up.rows(8000))
        view = charts.shape_of(made_up.found()["effects"][0], judged, {})["views"][0]
        self.assertEqual(view["x"]["name"], "gear twist")
        mean = next(line["values"] for line in view["lines"] if line["name"] == "mean")
        for at, value, count in zip(view["at"], mean, view["counts"]):
            self.assertEqual(value is None, count < charts.FEWEST)
            if value is not None:
                self.assertAlmostEqual(value, 0.2 * np.tanh(at / 0.02), delta=0.005)

    def test_a_learnt_law_is_drawn_with_its_band_before_all_else(self):
        judged = charts.Judged(made_up.rows(4000))
        law = {"over": "twist", "unit": "rad", "gives": "torque at the gear", "quantity": "torque", "at": [-0.1, 0.0, 0.1],
               "torque": [-1.0, 0.0, 1.0], "sd": [None, 0.1, 0.2]}
        view = charts.shape_of(made_up.found()["effects"][0], judged, {"backlash": law})["views"][0]
        values = {line["name"]: line["values"] for line in view["lines"]}
        self.assertEqual(values["the law"], [-1.0, 0.0, 1.0])
        self.assertEqual(values["90 % band, upper end"], [None, 0.1645, 1.329])
        self.assertEqual(sum(view["counts"]), 4000)
        # Half way between the law's points, where no twist of a record lies by rounding on the one side or the other.
        self.assertEqual(view["counts"][0], np.count_nonzero(judged["twist_gear"] < -0.05))


    def test_a_learnt_law_of_the_sensor_is_drawn_though_no_mass_feels_it(self):
        judged = charts.Judged(made_up.rows(4000))
        law = {"over": "speed_motor", "unit": "rad/s", "gives": "shown speed", "quantity": "speed", "at": [-9.0, 0.0, 9.0],
               "speed": [-0.5, 0.0, 0.5], "sd": [0.1, 0.0, 0.1]}
        sensor = {"name": "sensor_curve", "parameters": {}}
        chart = charts.shape_of(sensor, judged, {"sensor_curve": law})
        self.assertEqual(chart["title"], "shown speed")
        [view] = chart["views"]
        self.assertEqual(view["y"], {"name": "speed", "unit": "rad/s", "log": False})
        self.assertEqual(view["lines"][-1]["values"], [-0.5, 0.0, 0.5])
        self.assertIsNone(charts.shape_of(sensor, judged, {}))


class Words(unittest.TestCase):
    def test_the_lead_says_what_how_sure_how_much_and_what_next(self):
        what, sure, much, then = (answer for _, answer in words.lead(made_up.found()))
        self.assertIn("Two effects are missing", what)
        self.assertIn("play in the gear (backlash, 0.01000 ± 0.00020 rad)", what)
        self.assertIn("less than one in a thousand", sure)
        self.assertIn("cannot tell gravity from torque_bias", sure)
        self.assertIn("by 0.400 rad/s rms; completed, by 0.100 (93.8 % less squared error)", much)
        self.assertIn("slow motion over the whole range of the joint", then)

    def test_a_free_simulation_is_told_beside_one_over_the_measured_angle(self):
        found = made_up.found()
        for when, mse in (("before", 1.0), ("after", 4.0)):
            found[when]["validation"].update(over_measured_angle=True, free={"mse": mse, "fit_percent": 50.0})
        much = words.lead(found)[2][1]
        self.assertIn("Simulated over the measured angle", much)
        self.assertIn("Simulated freely, its own angle drifting, by 2.00 instead of 1.00 rad/s.", much)

    def test_it_does_not_claim_more_than_was_found(self):
        found = {**made_up.found(), "effects": [], "verdict": "model sufficient"}
        found["candidates"] = [c for c in found["candidates"] if not c["accepted"]]
        self.assertIn("none explains more than chance", words.lead(found)[0][1])
        self.assertIn("What came nearest, torque_bias, was refused: another explains more.", words.lead(found)[1][1])
        found = {**found, "verdict": "residual unexplained", "unexplained": ["a torque"]}
        self.assertIn("it has no name", words.lead(found)[0][1])
        found = {**made_up.found(), "base_fit": {"starts": 4, "starts_agreeing": 1}}
        self.assertIn("end apart", words.lead(found)[1][1])

    def test_it_tells_what_the_values_were_fitted_to(self):
        found = made_up.found()
        self.assertNotIn("all records together", words.lead(found)[1][1])
        found["files"]["values_fitted_to"] = "estimation and validation"
        self.assertIn("its values were fitted to all records together", words.lead(found)[1][1])

    def test_every_effect_of_the_manual_has_plain_words(self):
        named = set(re.findall(r"^### (\w+)$", EFFECTS.read_text(encoding="utf-8"), re.M))
        self.assertEqual(named, set(words.PLAIN))


if __name__ == "__main__":
    unittest.main()
