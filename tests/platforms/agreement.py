"""How far two runs of armukf are apart, number by number: rows as CSV, reports as JSON.

A difference is relative. What it is relative to depends on where the number stands:
  a column that keeps its sign, a single number of a report   the number itself
  a column that passes through zero, a list of numbers        the largest magnitude in it
  a correlation, a probability, a share                       1
  a fit in percent                                            100, a fit of everything
"""

import csv
import io
import json
import math
import re

TIMED = re.compile(r"(^|\.)(seconds|samples_per_second)$")
SHARES = re.compile(r"correlation|ljung_box_p|p_value")
PERCENT = re.compile(r"fit_percent$")
INFINITE = math.inf


class Difference:
    """The largest one found so far, and the place of it."""

    def __init__(self):
        self.size, self.place = 0.0, "nowhere"

    def note(self, size, place):
        if size > self.size:
            self.size, self.place = size, place

    def __str__(self):
        return f"{self.size:.1e} at {self.place}" if self.size else "none"


def relative(a, b, scale):
    """|a - b| / scale; infinite if only one of them is a number, or finite."""
    if a == b or (math.isnan(a) and math.isnan(b)):
        return 0.0
    size = abs(a - b) / scale if scale > 0 else INFINITE
    return size if math.isfinite(size) else INFINITE


def largest(values):
    return max((abs(v) for v in values if math.isfinite(v)), default=0.0)


def keeps_sign(values):
    return all(v > 0 for v in values) or all(v < 0 for v in values)


def columns(text):
    """Columns of rows by their names, numbers where all of a column are; empty without rows."""
    header, *rows = csv.reader(io.StringIO(text))
    found = {}
    for name, *cells in zip(header, *rows, strict=True):
        try:
            found[name] = [float(cell) for cell in cells]
        except ValueError:
            found[name] = cells
    return found if rows else {}


def compare_rows(text, other, difference):
    one, two = columns(text), columns(other)
    shape = [(name, len(column)) for name, column in one.items()]
    if not shape or shape != [(name, len(column)) for name, column in two.items()]:
        difference.note(INFINITE, "the header or the number of rows")
        return
    for name, column in one.items():
        compare_columns(name, column, two[name], difference)


def compare_columns(name, one, two, difference):
    if isinstance(one[0], str) or isinstance(two[0], str):
        if one != two:
            difference.note(INFINITE, name)
        return
    signed = keeps_sign([v for v in one if not math.isnan(v)])
    whole = largest(one)
    for row, (a, b) in enumerate(zip(one, two), 1):
        difference.note(relative(a, b, abs(a) if signed else whole), f"{name}, row {row}")


def leaves(report, path=""):
    """Path and value of all that is neither object nor list; with it, of a number in a list, the
    largest magnitude there."""
    if isinstance(report, dict):
        for key, value in report.items():
            yield from leaves(value, f"{path}.{key}" if path else key)
    elif isinstance(report, list):
        numbers = [v for v in report if is_number(v)]
        for index, value in enumerate(report):
            if is_number(value):
                yield f"{path}[{index}]", value, largest(numbers)
            else:
                yield from leaves(value, f"{path}[{index}]")
    else:
        yield path, report, None


def is_number(value):
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def scale_of(path, value, in_list):
    if SHARES.search(path):
        return 1.0
    if PERCENT.search(path):
        return 100.0
    return in_list if in_list is not None else abs(value)


def compare_reports(text, other, difference):
    """A number that is not finite is null there, which equals itself alone."""
    one, two = ([leaf for leaf in leaves(json.loads(t)) if not TIMED.search(leaf[0])]
                for t in (text, other))
    if [path for path, _, _ in one] != [path for path, _, _ in two] or not one:
        difference.note(INFINITE, "the names in the report")
        return
    for (path, a, in_list), (_, b, _) in zip(one, two):
        if is_number(a) and is_number(b):
            difference.note(relative(a, b, scale_of(path, a, in_list)), path)
        elif a != b:
            difference.note(INFINITE, path)
