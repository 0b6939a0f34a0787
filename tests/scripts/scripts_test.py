#!/usr/bin/python3
"""The scripts that a user calls, from outside: scripts_test.py PROGRAM"""

import json
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import numpy as np
from scipy import io

SCRIPTS = Path(__file__).resolve().parents[2] / "scripts"
PROGRAM = sys.argv.pop(1) if len(sys.argv) > 1 else "build/release/bin/armukf"
PROGRAM_PATH = Path(PROGRAM).resolve()
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


class Plot(InFolder):
    """Every picture of a short simulated record is made, and is a picture."""

    def setUp(self):
        super().setUp()
        self.armukf("simulate", "-o", "record.csv", "--samples", 6000, "--sensor-noise", 0.1)
        (self.folder / "estimate.csv").write_text(self.armukf("record.csv", "--quiet"))
        self.armukf("fit", "record.csv", "--json", "fit.json", "--save", "fit.toml",
                    "--effect", "friction_curve", "--effect", "angle_curve")
        self.armukf("evaluate", "record.csv", "--rows", "rows.csv", "--json", "evaluation.json")

    def armukf(self, *words):
        done = run(PROGRAM, *words, cwd=self.folder)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout

    def test_every_picture_is_made(self):
        for suffix, (picture, *files) in enumerate((
                ("records", "record.csv", "record.csv"), ("fit", "rows.csv", "rows.csv"),
                ("errors", "rows.csv"), ("response", "rows.csv"), ("correlation", "evaluation.json"),
                ("parameters", "estimate.csv", "--batch", "fit.json", "--truth"),
                ("laws", "fit.json"), ("innovations", "estimate.csv"), ("nis", "estimate.csv"))):
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
        self.expect_refused("a.txt: the suffix must be .png, .svg or .pdf", plot, "fit", "rows.csv",
                            "-o", "a.txt")

    def test_rows_are_record_and_simulation(self):
        rows = np.genfromtxt(self.folder / "rows.csv", delimiter=",", names=True)
        self.assertEqual(rows.dtype.names, ("t", "u", "y", "y_hat", "residual"))
        self.assertEqual(len(rows), 6000)
        np.testing.assert_allclose(rows["residual"], rows["y"] - rows["y_hat"], atol=1e-12)


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


if __name__ == "__main__":
    unittest.main()
