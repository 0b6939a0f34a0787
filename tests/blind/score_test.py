#!/usr/bin/python3
"""Laws of scripts/blind_score.py, with a program whose answers are known."""

import math
import sys
import unittest
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.dont_write_bytecode = True
sys.path.insert(0, str(HERE.parent.parent / "scripts"))

import blind_score as score  # noqa: E402
from blind_calibration import GROWTH, TOLERANCE, calibrated, size_for  # noqa: E402
from blind_cases import Case, Programs  # noqa: E402

FAKE = str(HERE / "fake_program.py")
PROGRAMS = Programs(FAKE, FAKE)
NULL_ERROR = 0.04


def tried(group, *effects, seed=1):
    return score.tried(PROGRAMS, Case(group, effects, seed))


class Score(unittest.TestCase):
    def test_avoidable_part_is_counted_against_the_fit_that_is_told(self):
        o = tried("large", ("torque_bias", 0.3))
        self.assertEqual((o.effects, o.named), (("torque_bias",), "yes"))
        self.assertAlmostEqual(o.growth, 1 + 0.09 / NULL_ERROR)
        self.assertAlmostEqual(o.achievable, NULL_ERROR)
        self.assertAlmostEqual(o.removed_percent, 75.0)

    def test_site_of_a_flexible_mode_is_no_part_of_its_name(self):
        self.assertEqual(tried("large", ("flexible_mode.gear", 0.3)).named, "yes")

    def test_confused_name_counts_apart_from_the_right_one(self):
        self.assertEqual(tried("large", ("sensor_lag", 0.3)).named, "confused")

    def test_unfound_effect_is_not_named(self):
        o = tried("small", ("torque_bias", 0.1))
        self.assertEqual((o.effects, o.named, o.removed_percent), ((), "no", 0.0))

    def test_pair_is_named_only_by_both(self):
        mode = ("flexible_mode.motor", 0.3)
        self.assertEqual(tried("pairs", mode, ("torque_bias", 0.3)).named, "yes")
        self.assertEqual(tried("pairs", mode, ("torque_bias", 0.1)).named, "no")

    def test_effect_outside_the_catalogue_has_no_achievable_error(self):
        self.assertTrue(math.isnan(tried("large", ("backlash", 0.3)).achievable))

    def test_failure_is_a_line_of_the_table(self):
        o = tried("large", ("gravity", 0.3))
        self.assertEqual(o.failure, "the numbers went wrong")
        self.assertIn("failed: the numbers went wrong", score.row(o))

    def test_every_row_has_the_columns_of_the_head(self):
        outcomes = [tried("large", ("gravity", 0.3)), tried("large", ("backlash", 0.3))]
        table = [x for x in score.section("large", outcomes).splitlines() if x.startswith("|")]
        self.assertEqual({x.count("|") for x in table}, {13})

    def test_summary_of_null_counts_false_alarms(self):
        outcomes = [tried("null", seed=s) for s in (6, 7)]
        self.assertIn("effects accepted: 1 in 2 records (above 1 in 60)",
                      score.summary("null", outcomes))

    def test_summary_counts_only_what_has_grown_as_the_group_says(self):
        outcomes = [tried("large", ("torque_bias", 0.3)), tried("large", ("sensor_lag", 0.3)),
                    tried("large", ("backlash", 0.3)), tried("large", ("torque_bias", 0.1))]
        text = score.summary("large", outcomes)
        self.assertIn("named, or among the confused: 2 of 3 (67 %); outright 1; found anything 2", text)
        self.assertIn("1 left out", text)

    def test_summary_of_foreign_counts_content_with_the_model(self):
        self.assertIn("'model sufficient': 1 of 1",
                      score.summary("foreign", [tried("foreign", ("two_modes", 0.5))]))


class Calibration(unittest.TestCase):
    def test_sizes_make_the_error_grow_as_wanted(self):
        sizes = calibrated(PROGRAMS, "torque_bias", 1)
        for group, wanted in GROWTH.items():
            exact = math.sqrt((wanted - 1) * NULL_ERROR)
            # growth - 1 goes with the square of the size
            self.assertAlmostEqual(sizes[group]["size"] / exact, 1, delta=TOLERANCE / 2 + 0.01)

    def test_search_stays_below_instability_and_the_largest_size(self):
        size, growth = size_for(2.5, lambda s: 1 + s**4 if s < 1.3 else math.inf, 30.0, start=20.0)
        self.assertAlmostEqual(growth, 2.5, delta=1.5 * TOLERANCE)
        self.assertEqual(size_for(2.5, lambda s: 1 + 0.01 * s, 4.0)[0], 4.0)


if __name__ == "__main__":
    unittest.main()
