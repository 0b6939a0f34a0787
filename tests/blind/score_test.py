#!/usr/bin/python3
"""Laws of scripts/blind_score.py, with a program whose answers are known."""

import math
import sys
import tempfile
import unittest
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.dont_write_bytecode = True
sys.path.insert(0, str(HERE.parent.parent / "scripts"))

import blind_score as score  # noqa: E402
import blind_table as table  # noqa: E402
from blind_calibration import TOLERANCE, calibrated, reachable, size_for, sized  # noqa: E402
from blind_cases import (CATALOGUE, COUNTED_GROWTH, COUNTS, FOREIGN, GROUPS, HALVES,  # noqa: E402
                         ONE_DELAY, WANTED_GROWTH, Case, cases_of, counts_as)
from blind_programs import Programs, called, largest_sizes  # noqa: E402

FAKE = str(HERE / "fake_program.py")
PROGRAMS = Programs(FAKE, FAKE)
STAMP = PROGRAMS.stamp()
NULL_ERROR, CALM_ERROR = 0.04, 0.001


def tried(group, *effects, seed=1, cache=None):
    case = Case(group, seed, tuple((name, 2.0) for name, _ in effects))
    return score.tried(PROGRAMS, case, effects, cache or score.Cache(None), STAMP)


class Cases(unittest.TestCase):
    def test_no_two_cases_share_a_seed(self):
        seeds = [c.seed for h in HALVES for g in GROUPS for c in cases_of(h, g)]
        self.assertEqual(len(seeds), len(set(seeds)))

    def test_score_half_has_what_was_asked_for(self):
        sizes = {g: len(cases_of("score", g)) for g in GROUPS}
        self.assertGreaterEqual(sizes["single"], 200)
        self.assertEqual((sizes["null"], sizes["several"]), (100, 30))
        self.assertGreaterEqual(sizes["foreign"], 30)
        self.assertEqual(len(cases_of("tuning", "null")), 60)

    def test_every_name_is_tried_equally_often(self):
        for group, names in (("single", CATALOGUE), ("foreign", FOREIGN)):
            found = [c.names[0] for c in cases_of("score", group)]
            self.assertEqual([found.count(n) for n in names],
                             [COUNTS["score"][group]] * len(names))

    def test_wanted_growth_stays_within_what_counts(self):
        low, high = (1 + (1 + sign * TOLERANCE) * (w - 1)
                     for sign, w in zip((-1, 1), WANTED_GROWTH))
        self.assertTrue(COUNTED_GROWTH[0] <= low and high <= COUNTED_GROWTH[1])

    def test_effects_of_several_are_of_different_classes_and_not_one_delay(self):
        for case in cases_of("score", "several"):
            self.assertEqual(len({counts_as(n) for n in case.names}), len(case.names))
            self.assertLessEqual(len(ONE_DELAY & set(case.names)), 1)
            # Together they grow by no more than the most that is wanted.
            self.assertLessEqual(sum(w - 1 for _, w in case.wanted), WANTED_GROWTH[1] - 1)


class Score(unittest.TestCase):
    def test_third_record_judges_against_the_same_seed_without_the_effect(self):
        o = tried("several", ("torque_bias", 0.4), ("torque_bias.unknown", 0.2))
        self.assertAlmostEqual(o.growth, 1 + 0.2 / NULL_ERROR)
        for use, floor in (("test", NULL_ERROR), ("calm", CALM_ERROR)):
            for found, right in zip(o.errors(use), (floor + 0.05, floor + 0.01, floor)):
                self.assertAlmostEqual(found, right)
        self.assertAlmostEqual(o.removed_percent, 80.0)

    def test_avoidable_part_is_not_told_where_there_is_hardly_any(self):
        self.assertTrue(math.isnan(tried("single", ("torque_bias", 0.05)).removed_percent))

    def test_site_of_a_flexible_mode_is_no_part_of_its_name(self):
        self.assertEqual(tried("single", ("flexible_mode.gear", 0.3)).named, "yes")
        self.assertEqual(counts_as("flexible_mode_arm:2"), "flexible_mode")

    def test_name_in_a_list_of_three_counts_apart_and_a_later_one_not(self):
        self.assertEqual(tried("single", ("drive_lag", 0.3)).named, "yes")
        self.assertEqual(tried("single", ("sensor_lag", 0.3)).named, "list")
        self.assertEqual(tried("single", ("torque_gain", 0.3)).named, "no")

    def test_unfound_effect_is_not_named(self):
        o = tried("single", ("torque_bias", 0.1))
        self.assertEqual((o.added, o.named, o.verdict), ([], "no", "model sufficient"))

    def test_several_are_named_only_by_all(self):
        mode = ("flexible_mode.motor", 0.3)
        self.assertEqual(tried("several", mode, ("torque_bias", 0.3)).named, "yes")
        self.assertEqual(tried("several", mode, ("sensor_lag", 0.3)).named, "list")
        self.assertEqual(tried("several", mode, ("torque_bias", 0.1)).named, "no")

    def test_worse_is_what_the_third_record_says(self):
        def outcome(completed):
            return table.Outcome(Case("null", 1), (), {
                "plain": {"test": 1.0}, "floor": {"test": 1.0}, "completed": {"test": completed}})
        self.assertTrue(outcome(1.03).made_worse)
        self.assertFalse(outcome(1.01).made_worse)

    def test_time_is_told(self):
        self.assertGreater(tried("null").answer["diagnose"]["cpu_seconds"], 0.0)


class Table(unittest.TestCase):
    def test_failure_is_a_line_of_the_table(self):
        o = tried("single", ("gravity", 0.3))
        self.assertEqual(o.failure, "the numbers went wrong")
        self.assertIn("failed: the numbers went wrong", table.row(o))

    def test_every_row_has_the_columns_of_the_head(self):
        outcomes = [tried("single", ("gravity", 0.3)), tried("single", ("backlash", 0.3)),
                    tried("null", seed=7)]
        self.assertEqual({len(table.row(o)) for o in outcomes}, {len(table.HEAD)})

    def test_head_tells_what_made_it(self):
        text = table.header("tuning", STAMP, [tried("null")])
        for part in ("fake 1", STAMP["armukf"], "tree: ", "command: ", "date: ", "a diagnosis: "):
            self.assertIn(part, text)

    def test_summary_of_null_counts_records_with_false_alarms(self):
        outcomes = [tried("null", seed=s) for s in (6, 7)]
        self.assertIn("an effect accepted: 1 of 2 (50 %)", table.summary("null", outcomes))

    def test_summary_counts_only_what_has_grown(self):
        outcomes = [tried("single", ("torque_bias", 0.3)), tried("single", ("sensor_lag", 0.3)),
                    tried("single", ("backlash", 0.3)), tried("single", ("torque_bias", 0.05)),
                    tried("single", ("torque_bias", 2.0))]
        text = table.summary("single", outcomes)
        self.assertIn("all: named outright 1 of 3 (33 %), at least in a list of 3 2 of 3 (67 %)", text)
        self.assertIn("not counted, growth not from ×1.3 to ×40: 2", text)
        self.assertIn("avoidable error removed: median 0 %, at least 80 % in 1 of 3 (33 %)", text)

    def test_summary_of_several_counts_each_effect_too(self):
        text = table.summary("several", [tried("several", ("flexible_mode.motor", 0.3),
                                               ("torque_bias", 0.1))])
        self.assertIn("one by one: outright 1 of 2 (50 %), at least in a list 1 of 2", text)

    def test_summary_of_foreign_counts_content_with_the_model(self):
        self.assertIn("'model sufficient': 1 of 1 (100 %), two_modes 1",
                      table.summary("foreign", [tried("foreign", ("two_modes", 0.5))]))


class Cache(unittest.TestCase):
    def test_answer_is_found_again_for_the_same_programs_sizes_and_options_only(self):
        with tempfile.TemporaryDirectory() as folder:
            asked = {**STAMP, "seed": 1}
            self.assertEqual(score.Cache(folder).answer(asked, lambda: {"a": 1}), {"a": 1})
            self.assertEqual(score.Cache(folder).answer(asked, self.fail), {"a": 1})
            other = {**asked, "armukf": "another"}
            self.assertEqual(score.Cache(folder).answer(other, lambda: {"a": 2}), {"a": 2})

    def test_failure_is_tried_again(self):
        with tempfile.TemporaryDirectory() as folder:
            score.Cache(folder).answer({}, lambda: {"failure": "timeout"})
            self.assertEqual(score.Cache(folder).answer({}, lambda: {"a": 1}), {"a": 1})

    def test_shards_make_the_whole(self):
        cases = cases_of("tuning", "null")
        parts = [cases[i - 1::n] for i, n in (score.shard_of(f"{k}/7") for k in range(1, 8))]
        self.assertEqual(sorted(c.seed for p in parts for c in p), [c.seed for c in cases])


class Calibration(unittest.TestCase):
    def test_size_makes_the_error_grow_as_wanted(self):
        for wanted in WANTED_GROWTH:
            case = Case("single", 1, (("torque_bias", wanted),))
            found = calibrated(PROGRAMS, case, 0, largest_sizes(PROGRAMS)["torque_bias"])
            self.assertAlmostEqual(found["growth"], 1 + found["size"] ** 2 / NULL_ERROR, 2)
            self.assertLessEqual(abs((found["growth"] - 1) / (wanted - 1) - 1), TOLERANCE)

    def test_growth_out_of_reach_is_drawn_anew_within_it(self):
        case = Case("single", 1, (("gravity", 30.0),))
        found = calibrated(PROGRAMS, case, 0, largest_sizes(PROGRAMS)["gravity"])
        self.assertLessEqual(found["size"], 0.25)
        self.assertLess(found["wanted"], 1 + 0.25**2 / NULL_ERROR)
        self.assertGreater(found["wanted"], WANTED_GROWTH[0])
        self.assertAlmostEqual(reachable(WANTED_GROWTH[1], 5.0, 1), 5.0)

    def test_case_without_a_size_is_refused(self):
        with self.assertRaisesRegex(SystemExit, "no size of 1 gravity: run --calibrate"):
            sized(Case("single", 1, (("gravity", 2.0),)), {})

    def test_search_stays_below_instability(self):
        size, growth = size_for(2.5, lambda s: 1 + s**4 if s < 1.3 else math.inf, 30.0, 20.0)
        self.assertAlmostEqual(growth, 2.5, delta=1.5 * TOLERANCE)
        self.assertEqual(size_for(2.5, lambda s: 1 + 0.01 * s, 4.0, 1.0)[0], 4.0)


class SlowProgram(unittest.TestCase):
    def test_is_a_failure(self):
        with self.assertRaisesRegex(score.Failure, "timeout"):
            called(["sleep", "5"], 0.1)


if __name__ == "__main__":
    unittest.main()
