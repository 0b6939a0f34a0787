#!/usr/bin/python3
"""What montecarlo.py makes of runs that are lost, by a program that loses them."""

import json
import subprocess
import sys
import unittest
from pathlib import Path

HERE = Path(__file__).resolve().parent
SCRIPT = HERE.parents[1] / "scripts/montecarlo.py"


def run(*words):
    return subprocess.run([sys.executable, str(SCRIPT), "--program", str(HERE / "fake_armukf.py"), *words],
                          capture_output=True, text=True, check=False)


class MonteCarlo(unittest.TestCase):
    def summary(self, seeds):
        done = run("--seeds", str(seeds), "--filters", "ukf", "--json", "-")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        return json.loads(done.stdout)["ukf, default settings"]

    def test_intervals_of_lost_runs_hold_nothing(self):
        # 1 and 2 end well, the first without k_a; 3 to 9 are lost, each in its own way; 10 ends well.
        found = self.summary(10)
        self.assertEqual((found["runs"], found["lost"]), (10, 7))
        self.assertAlmostEqual(found["parameters"]["a_m"]["coverage_percent"], 30.0)
        self.assertAlmostEqual(found["parameters"]["k_a"]["coverage_percent"], 20.0)
        # What is left is told of those that are left.
        self.assertAlmostEqual(found["parameters"]["a_m"]["bias_percent"], 1.0)
        self.assertEqual(found["fit_percent"], 99.0)

    def test_all_lost_is_a_table_nevertheless(self):
        sys.path.insert(0, str(SCRIPT.parent))
        import montecarlo
        item = {"arm": 0, "spread": 0.2}
        found = montecarlo.summary([item] * 3, [{"lost": True}] * 3)
        self.assertEqual((found["lost"], found["parameters"]["a_m"]["coverage_percent"]), (3, 0.0))
        self.assertIn("| a_m | - | - | 0 |", montecarlo.text_of("none", found))

    def test_wrong_option_is_no_lost_run(self):
        done = run("--seeds", "2", "--filters", "none")
        self.assertEqual((done.returncode, done.stderr), (2, "montecarlo.py: unknown filter 'none'\n"))


if __name__ == "__main__":
    unittest.main()
