#!/usr/bin/python3
"""The scripts that a user calls, from outside: scripts_test.py PROGRAM"""

import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import numpy as np
from scipy import io

SCRIPTS = Path(__file__).resolve().parents[2] / "scripts"
PROGRAM = sys.argv.pop(1) if len(sys.argv) > 1 else "build/release/bin/armukf"


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
        self.armukf("fit", "record.csv", "--json", "fit.json", "--save", "fit.toml")
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


if __name__ == "__main__":
    unittest.main()
