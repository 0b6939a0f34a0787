#!/usr/bin/python3
"""The scripts that a user calls, from outside: scripts_test.py PROGRAM"""

import importlib.machinery
import importlib.util
import json
import os
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path
from unittest import mock

import numpy as np
from scipy import io

SCRIPTS = Path(__file__).resolve().parents[2] / "scripts"
sys.dont_write_bytecode = True
sys.path.insert(0, str(SCRIPTS))
PROGRAM = sys.argv.pop(1) if len(sys.argv) > 1 else "build/release/bin/armukf"
PROGRAM_PATH = Path(PROGRAM).resolve()
# Two events, the first of which has settled; the second began while the first was not yet told.
EVENT = {"onset": 2.0, "what": "k_a", "from": 11.0, "sd": 0.1, "p": 0.9, "also_possible": ["a_g", "payload_change"]}
EVENTS = [{**EVENT, "t": 2.3, "to": 13.4, "settled": False}, {**EVENT, "t": 3.6, "to": 13.2, "settled": True},
          {**EVENT, "t": 2.4, "onset": 2.2, "what": "torque_gain", "from": 0.0, "to": -0.2, "settled": False}]
EVENT_LINES = "".join(json.dumps(event) + "\n" for event in EVENTS)
KNOWN = (SCRIPTS.parent / "data/known_noise.toml").read_text().replace("sensor = 0.05", "sensor = 1.0").replace(
    "motor_torque = 0.0 ", "motor_torque = 0.00447 ")


def run(*words, **options):
    return subprocess.run([str(word) for word in words], capture_output=True, text=True,
                          check=False, **options)


class InFolder(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def expect_refused(self, message, *words):
        done = run("/usr/bin/python3", *words, cwd=self.folder)
        self.assertEqual((done.returncode, done.stderr, done.stdout), (2, message + "\n", ""))


class Tidy(InFolder):
    """What is known to be clean is so on every machine."""

    def rules_by(self, version, processor):
        loader = importlib.machinery.SourceFileLoader("tidy", str(SCRIPTS / "tidy"))
        tidy = importlib.util.module_from_spec(importlib.util.spec_from_loader("tidy", loader))
        loader.exec_module(tidy)
        program = self.folder / "clang-tidy"
        program.write_text(f"#!/bin/sh\necho 'Debian LLVM version {version}'\necho '  Host CPU: {processor}'\n")
        program.chmod(0o755)
        with mock.patch.dict(os.environ, {"PATH": f"{self.folder}:{os.environ['PATH']}"}):
            return tidy.common()

    def test_rules_do_not_depend_on_the_processor_but_on_the_version(self):
        rules = self.rules_by("14.0.6", "znver3")
        self.assertEqual(rules, self.rules_by("14.0.6", "znver5"))
        self.assertNotEqual(rules, self.rules_by("14.0.7", "znver3"))


class Plot(InFolder):
    """Every picture of a short simulated record is made, and is a picture."""

    def setUp(self):
        super().setUp()
        self.armukf("simulate", "-o", "record.csv", "--samples", 6000, "--sensor-noise", 0.1)
        (self.folder / "estimate.csv").write_text(self.armukf("record.csv", "--quiet"))
        self.armukf("fit", "record.csv", "--json", "fit.json", "--save", "fit.toml",
                    "--effect", "friction_curve", "--effect", "angle_curve")
        self.armukf("evaluate", "record.csv", "--rows", "rows.csv", "--json", "evaluation.json")
        (self.folder / "events.jsonl").write_text(EVENT_LINES)

    def armukf(self, *words):
        done = run(PROGRAM, *words, cwd=self.folder)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout

    def test_every_picture_is_made(self):
        for suffix, (picture, *files) in enumerate((
                ("records", "record.csv", "record.csv"), ("fit", "rows.csv", "rows.csv"),
                ("errors", "rows.csv"), ("response", "rows.csv"), ("correlation", "evaluation.json"),
                ("parameters", "estimate.csv", "--batch", "fit.json", "--truth"),
                ("laws", "fit.json"), ("events", "estimate.csv", "events.jsonl"),
                ("innovations", "estimate.csv"), ("nis", "estimate.csv"))):
            output = self.folder / f"{picture}.{('png', 'svg', 'pdf')[suffix % 3]}"
            done = run("/usr/bin/python3", SCRIPTS / "plot.py", picture, *files, "-o", output,
                       cwd=self.folder)
            self.assertEqual((done.returncode, done.stderr), (0, ""), picture)
            begins = {".png": b"\x89PNG", ".svg": b"<?xml", ".pdf": b"%PDF"}[output.suffix]
            self.assertTrue(output.read_bytes().startswith(begins), picture)
            self.assertGreater(output.stat().st_size, 5000, picture)

    def test_wrong_input_takes_one_line(self):
        plot = SCRIPTS / "plot.py"
        self.expect_refused("nowhere.csv: No such file or directory", plot, "fit", "nowhere.csv",
                            "-o", "a.png")
        self.expect_refused("record.csv: no column y_hat", plot, "fit", "record.csv", "-o", "a.png")
        self.expect_refused("fit.json: holds no residual; is it what armukf wrote?", plot,
                            "correlation", "fit.json", "-o", "a.png")
        self.expect_refused("evaluation.json: holds no laws; is it what armukf wrote?", plot,
                            "laws", "evaluation.json", "-o", "a.png")
        self.expect_refused("events takes two files, ESTIMATE.csv and EVENTS.jsonl", plot, "events", "estimate.csv",
                            "-o", "a.png")
        self.expect_refused("fit.json: holds no events; is it what armukf wrote?", plot, "events", "estimate.csv",
                            "fit.json", "-o", "a.png")
        (self.folder / "empty.csv").write_text("")
        self.expect_refused("empty.csv: file is empty", plot, "records", "empty.csv", "-o", "a.png")
        (self.folder / "text.csv").write_text("t,u,y\n0,1,2\n0.0005,1,abc\n")
        self.expect_refused("text.csv: y: 'abc' is not a number", plot, "records", "text.csv", "-o",
                            "a.png")
        self.expect_refused("a.txt: the suffix must be .png, .svg or .pdf", plot, "fit", "rows.csv",
                            "-o", "a.txt")

    def test_rows_are_record_and_simulation(self):
        rows = np.genfromtxt(self.folder / "rows.csv", delimiter=",", names=True)
        self.assertEqual(rows.dtype.names, ("t", "u", "y", "y_hat", "residual"))
        self.assertEqual(len(rows), 6000)
        np.testing.assert_allclose(rows["residual"], rows["y"] - rows["y_hat"], atol=1e-12)


class Events(unittest.TestCase):
    """The picture of events, of rows that are made up."""

    def setUp(self):
        import pictures
        from events import events_in
        columns = ["t", "nis", "k_g1", "k_a", "k_g1_sd", "k_a_sd"]
        rows = np.ones(1000, dtype=[(name, float) for name in columns])
        rows["t"] = np.linspace(0.0, 4.0, 1000)
        self.figure = pictures.events(rows, events_in(EVENT_LINES))

    def test_every_onset_is_marked_and_boldly_where_it_is_this_parameter(self):
        _, k_g1, k_a, nis = self.figure.axes
        for axis, widths in ((k_g1, [0.8, 0.8]), (k_a, [2.0, 0.8]), (nis, [0.8, 0.8])):
            marks = [line for line in axis.lines if len(set(line.get_xdata())) == 1]
            self.assertEqual([line.get_xdata()[0] for line in marks], [2.0, 2.2])
            self.assertEqual([line.get_linewidth() for line in marks], widths)

    def test_an_event_is_one_label_with_its_settled_value_and_no_two_overlap(self):
        labels = self.figure.axes[0].texts
        self.assertEqual([label.get_text() for label in labels],
                         ["k_a: 11 → 13.2 ± 0.1, or a_g, payload_change",
                          "torque_gain: 0 → -0.2 ± 0.1, or a_g, payload_change"])
        self.figure.tight_layout()
        first, second = (label.get_window_extent(self.figure.canvas.get_renderer()) for label in labels)
        self.assertFalse(first.overlaps(second))


class ImportRobotarm(InFolder):
    def setUp(self):
        super().setUp()
        random = np.random.default_rng(1)
        self.content = {kind + suffix: random.normal(size=(count, 1))
                        for suffix, count in (("e", 50), ("v1", 40), ("v2", 30), ("v3", 20))
                        for kind in "uy"}

    def save(self, **options):
        io.savemat(self.folder / "data.mat", self.content, **options)

    def test_records_hold_the_same_numbers(self):
        self.save()
        done = run("/usr/bin/python3", SCRIPTS / "import_robotarm.py", "data.mat", "-o", "out",
                   cwd=self.folder)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        rows = np.genfromtxt(self.folder / "out/robotarm_validation2.csv", delimiter=",", names=True)
        np.testing.assert_array_equal(rows["u"], self.content["uv2"].ravel())
        np.testing.assert_array_equal(rows["y"], self.content["yv2"].ravel())
        np.testing.assert_allclose(np.diff(rows["t"]), 5e-4, atol=1e-12)
        self.assertEqual(len(list((self.folder / "out").iterdir())), 4)

    def test_wrong_input_takes_one_line(self):
        script = SCRIPTS / "import_robotarm.py"
        self.expect_refused("data.mat: No such file or directory", script, "data.mat")
        del self.content["yv3"]
        self.save()
        self.expect_refused("data.mat: has no variable yv3", script, "data.mat")
        self.content["yv3"] = np.zeros((7, 1))
        self.save()
        self.expect_refused("data.mat: uv3 has 20 samples, yv3 7", script, "data.mat")


class Sweeps(InFolder):
    """tune.py, montecarlo.py and compare.py over a few short runs."""

    def setUp(self):
        super().setUp()
        for seed in (1, 2):
            done = run(PROGRAM, "simulate", "-o", f"{seed}.csv", "--seed", seed, "--sensor-noise", 0.1,
                       "--torque-disturbance", 0.2, "--samples", 6000, cwd=self.folder)
            self.assertEqual(done.returncode, 0, done.stderr)

    def script(self, name, *words):
        done = run("/usr/bin/python3", SCRIPTS / name, *words, "--program", PROGRAM_PATH, "--json", "out.json",
                   cwd=self.folder)
        self.assertEqual((done.returncode, done.stderr), (0, ""), name)
        return json.loads((self.folder / "out.json").read_text())

    def tuned(self, *words):
        return self.script("tune.py", "1.csv", "--validate", "2.csv", "--model", "known.toml", "--tune",
                           "noise.sensor", "--starts", 2, "--rounds", 3, *words)

    def test_tuning_finds_the_sensor_noise_and_writes_a_model(self):
        (self.folder / "known.toml").write_text(KNOWN)
        result = self.tuned("--save", "tuned.toml", "--state", "state.jsonl")
        self.assertAlmostEqual(result["tuned"]["noise.sensor"]["value"], 0.1, delta=0.01)
        self.assertFalse(result["tuned"]["noise.sensor"]["at_bound"])
        self.assertGreater(result["after"]["validation"]["log_likelihood_per_sample"],
                           result["before"]["validation"]["log_likelihood_per_sample"])
        taken = run(PROGRAM_PATH, "estimate", "2.csv", "--model", "tuned.toml", "--score", cwd=self.folder)
        score = json.loads(taken.stdout)["parts"][0]
        self.assertAlmostEqual(score["log_likelihood_per_sample"],
                               result["after"]["validation"]["log_likelihood_per_sample"])

    def test_killed_run_goes_on_to_the_same_result(self):
        (self.folder / "known.toml").write_text(KNOWN)
        whole = self.tuned("--state", "state.jsonl")
        lines = (self.folder / "state.jsonl").read_text().splitlines()
        self.assertGreaterEqual(len(lines), 2)
        # As a kill leaves it: one round done, the next line cut short.
        (self.folder / "state.jsonl").write_text(lines[0] + "\n" + lines[1][:40])
        self.assertEqual(self.tuned("--state", "state.jsonl", "--workers", 1), whole)

    def test_value_at_its_bound_is_said(self):
        (self.folder / "known.toml").write_text(KNOWN)
        done = run("/usr/bin/python3", SCRIPTS / "tune.py", "1.csv", "--validate", "2.csv", "--model",
                   "known.toml", "--tune", "noise.arm_torque", "--starts", 1, "--program", PROGRAM_PATH,
                   cwd=self.folder)
        self.assertIn("at its bound: the records do not determine it", done.stdout, done.stderr)

    def test_monte_carlo_repeats_itself_with_any_workers(self):
        words = ("--seeds", 2, "--arms", 2, "--filters", "ekf", "--settings", "known", "default")
        one = self.script("montecarlo.py", *words, "--workers", 1)
        self.assertEqual(self.script("montecarlo.py", *words, "--workers", 2), one)
        self.assertEqual([s["runs"] for s in one.values()], [4, 4])
        self.assertEqual(one["ekf, known settings"]["lost"], 0)

    def test_comparison_makes_table_and_picture(self):
        result = self.script("compare.py", "1.csv", "2.csv", "--starts", 2, "--filters", "ekf", "--picture",
                             "compare.png")
        self.assertEqual(result["ekf"]["runs"], 4)
        self.assertLess(result["ekf"]["parameters"]["a_m"]["median_difference_percent"], 5.0)
        self.assertTrue((self.folder / "compare.png").read_bytes().startswith(b"\x89PNG"))

    def test_wrong_input_takes_one_line(self):
        self.expect_refused("tune.py: --tune: unknown 'noise.senor'; known are: noise.sensor, "
                            "noise.motor_torque, noise.gear_torque, noise.arm_torque, "
                            "noise.model_error.start, noise.model_error.least, noise.model_error.gain, "
                            "noise.model_error.time_s, noise.parameter_walk.start, "
                            "noise.parameter_walk.floor, noise.parameter_walk.time_s, prior.twist, "
                            "prior.speed", SCRIPTS / "tune.py", "1.csv", "--tune", "noise.senor")
        self.expect_refused("tune.py: nowhere.csv: No such file or directory", SCRIPTS / "tune.py",
                            "nowhere.csv", "--program", PROGRAM_PATH)
        (self.folder / "blind.csv").write_text(
            "t,u,y\n" + "".join(f"{k * 5e-4:.4f},1.0,nan\n" for k in range(1000)))
        self.expect_refused("tune.py: no finite likelihood anywhere: the filter fails on these records "
                            "whatever the noise", SCRIPTS / "tune.py", "blind.csv", "--tune",
                            "noise.sensor", "--starts", "1", "--rounds", "1", "--program", PROGRAM_PATH)
        self.expect_refused("compare.py: nowhere.csv: no such file", SCRIPTS / "compare.py", "nowhere.csv")
        self.expect_refused("montecarlo.py: no Dask scheduler at tcp://127.0.0.1:9: Timed out trying to "
                            "connect to tcp://127.0.0.1:9 after 5 s", SCRIPTS / "montecarlo.py",
                            "--scheduler", "tcp://127.0.0.1:9")


class Fleet(InFolder):
    """fleet.py over a few short records by armukf itself; fleet_test.py tests what it makes of them."""

    def setUp(self):
        super().setUp()
        for seed in range(4):
            done = run(PROGRAM, "simulate", "-o", f"arm{seed % 2}_2026-0{1 + seed // 2}-01.csv", "--seed", seed,
                       "--sensor-noise", 0.1, "--samples", 4000, "--set", "k_a=11" if seed == 3 else "k_a=14",
                       cwd=self.folder)
            self.assertEqual(done.returncode, 0, done.stderr)
        (self.folder / "arm1_2026-03-01.csv").write_text("t,u,y\n0,1,abc\n")

    def table(self, *words):
        done = run("/usr/bin/python3", SCRIPTS / "fleet.py", ".", "--program", PROGRAM_PATH, "-o", "out", *words,
                   cwd=self.folder)
        self.assertEqual((done.returncode, done.stderr),
                         (1, "fleet.py: arm1_2026-03-01.csv:2: y: 'abc' is not a number\n"))
        (self.folder / "out.state.jsonl").unlink()
        return [(self.folder / f"out.{suffix}").read_text() for suffix in ("csv", "html")]

    def test_same_table_with_one_and_two_workers_and_by_address(self):
        from dask.distributed import LocalCluster
        options = ("--", "--no-blocks", "--free-initial", "all")
        one = self.table("--workers", 1, *options)
        self.assertIn("\narm1,k_a,step,2026-02-01,", one[0])
        self.assertEqual(self.table("--workers", 2, *options), one)
        with LocalCluster(n_workers=2, threads_per_worker=1, processes=False, protocol="tcp",
                          dashboard_address=":0") as cluster:
            self.assertEqual(self.table("--scheduler", cluster.scheduler_address, *options), one)

    def test_watched_records_tell_their_parameters(self):
        table, page = self.table("--job", "watch")
        self.assertEqual(sum(line.startswith("arm0,") for line in table.splitlines()), 1)
        self.assertIn("<b>k_a</b>", page)


if __name__ == "__main__":
    unittest.main()
