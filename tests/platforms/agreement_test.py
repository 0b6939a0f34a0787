#!/usr/bin/python3
"""What agreement.py finds, and what it does not take for a difference."""

import copy
import json
import math
import unittest

import agreement

REPORT = {"samples": 3, "filter": "ukf", "innovation": {"rmse": 0.05, "ljung_box_p": 1e-3},
          "parameters": {"k_a": {"value": 11.7, "sd": 0.03, "known": False}},
          "matrix": [[1.0, 0.5], [0.5, 2.0]], "seconds": 0.1, "samples_per_second": 30.0}
ROWS = [["t", "innovation", "status", "k_a"],
        ["0.5", "-1", "ok", "20"], ["1", "1e-9", "missing", "nan"], ["1.5", "2", "ok", "11.7"]]


def text(rows):
    return "".join(",".join(row) + "\n" for row in rows)


def difference(compare, one, two):
    found = agreement.Difference()
    compare(one, two, found)
    return found.size


def reports(one, two):
    return difference(agreement.compare_reports, json.dumps(one), json.dumps(two))


def rows(one, two):
    return difference(agreement.compare_rows, text(one), text(two))


def variants(report):
    """Copies of it, each with another number raised by 1e-6 of itself."""
    if agreement.is_number(report):
        yield report * (1 + 1e-6)
    elif isinstance(report, dict):
        for key, value in report.items():
            yield from (report | {key: other} for other in variants(value))
    elif isinstance(report, list):
        for i, value in enumerate(report):
            yield from (report[:i] + [other] + report[i + 1:] for other in variants(value))


class Reports(unittest.TestCase):
    def test_same_report_has_no_difference(self):
        self.assertEqual(reports(REPORT, REPORT), 0.0)

    def test_every_number_counts_but_the_time_taken(self):
        found = [reports(REPORT, other) for other in variants(REPORT)]
        # All 1e-6 of themselves, or of the largest in a list; p = 1e-3 counts as a share of 1.
        expected = [1e-6, 1e-6, 1e-9, 1e-6, 1e-6, 1e-6, 0.5e-6, 0.25e-6, 1e-6, 0.0, 0.0]
        self.assertEqual(len(found), len(expected))
        for size, other in zip(found, expected):
            self.assertAlmostEqual(size, other, delta=1e-3 * other)

    def test_other_names_words_and_nulls_are_differences(self):
        for key, value in (("samples", None), ("filter", "ekf"), ("more", 1), ("matrix", [[1.0]])):
            self.assertEqual(reports(REPORT, REPORT | {key: value}), math.inf, key)
        self.assertEqual(reports({}, {}), math.inf)


class Rows(unittest.TestCase):
    def with_cell(self, row, column, value):
        other = copy.deepcopy(ROWS)
        other[row][column] = value
        return other

    def test_same_rows_have_no_difference(self):
        self.assertEqual(rows(ROWS, ROWS), 0.0)

    def test_column_that_keeps_its_sign_counts_number_by_number(self):
        self.assertAlmostEqual(rows(ROWS, self.with_cell(1, 0, "0.5000005")), 1e-6, delta=1e-9)

    def test_column_through_zero_counts_by_its_largest(self):
        self.assertAlmostEqual(rows(ROWS, self.with_cell(2, 1, "2.001e-6")), 1e-6, delta=1e-9)

    def test_words_and_missing_numbers_are_differences(self):
        for place in ((1, 2, "rejected"), (2, 3, "12"), (3, 3, "nan"), (3, 3, "inf"), (3, 3, "x"),
                      (0, 3, "k_g1")):
            self.assertEqual(rows(ROWS, self.with_cell(*place)), math.inf, place)

    def test_lost_rows_are_a_difference(self):
        self.assertEqual(rows(ROWS, ROWS[:-1]), math.inf)
        self.assertEqual(rows(ROWS[:1], ROWS[:1]), math.inf)


if __name__ == "__main__":
    unittest.main()
