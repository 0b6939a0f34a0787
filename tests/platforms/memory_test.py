#!/usr/bin/python3
"""No job of the program reads what nothing has written, by valgrind, which the sanitizers do not see:

    memory_test.py PROGRAM

The models are of as many states as each kind of filter has room for, and fewer. Exit status 77:
there is no valgrind.
"""

import shutil
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

RECORD = Path(__file__).resolve().parents[2] / "data" / "short_record.csv"
ROWS = 40
MODE = ["--effect", "flexible_mode_motor"]
MANY = [*MODE, "--effect", "flexible_mode_gear", "--effect", "drive_lag", "--effect", "torque_ripple"]
JOBS = {
    "ukf": ["estimate", "--effect", "torque_bias"],
    "ukf with many effects": ["estimate", *MANY],
    "ekf": ["estimate", "--filter", "ekf", "--effect", "torque_bias"],
    "ekf with many effects": ["estimate", "--filter", "ekf", *MANY],
    "square root": ["estimate", "--filter", "srukf", *MODE],
    "adaptive and iterated": ["estimate", "--filter", "adaptive_iekf", *MODE],
    "watch": ["estimate", "--watch"],
    "smoother": ["smooth", "--filter", "ekf", *MODE],
    "prediction": ["evaluate", "--horizon", 50, *MODE],
    "prediction with many effects": ["evaluate", "--horizon", 50, *MANY],
    "fit": ["fit", "--iterations", 2, "--no-blocks", *MANY],
}


class Memory(unittest.TestCase):
    program = ""

    def test_is_written_before_it_is_read(self):
        with tempfile.TemporaryDirectory() as folder:
            record = Path(folder, "record.csv")
            record.write_text("".join(RECORD.read_text().splitlines(keepends=True)[:ROWS]))
            for name, (job, *words) in JOBS.items():
                with self.subTest(name):
                    done = subprocess.run(
                        ["valgrind", "--quiet", "--error-exitcode=99", self.program, job, record, *map(str, words),
                         "--quiet"], cwd=folder, capture_output=True, text=True, check=False)
                    self.assertEqual(done.returncode, 0, done.stderr[:2000])


if __name__ == "__main__":
    if shutil.which("valgrind") is None:
        print("skipped: valgrind is not installed")
        sys.exit(77)
    Memory.program = sys.argv.pop(1)
    unittest.main()
