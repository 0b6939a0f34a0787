#!/usr/bin/python3
"""Injects faults into a record, estimates each with each filter, and writes what was lost, as Markdown.

    fault_table.py [--save data/fault_table.md] [--filters ukf,ekf,...] [--record FILE] [--threads 2]
                   [--program build/release/bin/armukf]

Without --record the record is simulated: the published arm, 40 s at 2 kHz, sensor noise of 0.1 rad/s,
torque disturbance of 0.2 N.m a sample. A run is held against the one of the same filter without the
fault: how far the worst parameter is off, in its standard deviations and in percent, and how many points
the simulation fit is lower on the record without the fault. Faults of the start (prior, start values)
are of that run as well.
"""

import argparse
import csv
import math
import random
import subprocess
import sys
import tempfile
import tomllib
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from sweeps import PROGRAM, ROOT, TRUTH, Failed, Trouble, armukf, simulate

FILTERS = "ukf,srukf,ckf,ekf,iekf,adaptive"
SAMPLES = 80000
RATE = 2000  # 1/s
MOST_SD, MOST_PERCENT, MOST_POINTS = 2.0, 3.0, 1.0


class Record:
    """Columns t, u, y as numbers, to be spoilt."""

    def __init__(self, rows):
        self.rows = rows

    def spoilt(self, change):
        """change(index, row) gives the row as it should be, or None for none."""
        changed = (change(i, list(row)) for i, row in enumerate(self.rows))
        return Record([row for row in changed if row is not None])

    def write(self, path):
        with path.open("w") as file:
            file.write("t,u,y\n")
            file.writelines(f"{t!r},{u!r},{'' if math.isnan(y) else repr(y)}\n" for t, u, y in self.rows)


def single(column, value, at):
    """value(old) in one row."""
    def change(i, row):
        if i == at:
            row[column] = value(row[column])
        return row
    return change


def some(share, seed, column, value):
    draw = random.Random(seed)
    chosen = [draw.random() < share for _ in range(10 * SAMPLES)]

    def change(i, row):
        if chosen[i]:
            row[column] = value(row[column])
        return row
    return change


def during(begin, seconds, column, value):
    first = {}

    def change(i, row):
        if begin <= i < begin + int(seconds * RATE):
            first.setdefault("row", list(row))
            row[column] = value(row[column], first["row"][column])
        return row
    return change


def dropped(share, seed):
    draw = random.Random(seed)
    chosen = [draw.random() < share for _ in range(10 * SAMPLES)]
    return lambda i, row: None if chosen[i] and i > 0 else row


def jittered(share, seed):
    draw = random.Random(seed)

    def change(_, row):
        row[0] += draw.uniform(-share, share) / RATE / 2
        return row
    return change


def record_faults(count):
    """Name, change, and whether it passes (it is judged by what is left of it at the end)."""
    middle = count // 2
    spikes = (50.0, 1e3, 1e4, 1e300)
    faults = [("one NaN", single(2, lambda _: math.nan, middle)),
              ("1 % NaN", some(0.01, 1, 2, lambda _: math.nan))]
    for size in spikes:
        faults.append((f"one spike of {size:g} rad/s", single(2, lambda y, s=size: y + s, middle)))
    for size in spikes:
        faults.append((f"spikes of {size:g} rad/s in 1 % of rows",
                       some(0.01, 2, 2, lambda y, s=size: y + s)))
    return faults + [
        ("5 % of rows dropped", dropped(0.05, 3)),
        ("gap of 2 s", lambda i, row: None if middle <= i < middle + 2 * RATE else row),
        ("sensor stuck for 1 s", during(middle, 1, 2, lambda _, first: first)),
        ("sensor x 0.5 for 1 s", during(middle, 1, 2, lambda y, _: 0.5 * y)),
        ("torque column stuck at 0 for 1 s", during(middle, 1, 1, lambda *_: 0.0)),
        ("times jitter by 20 %", jittered(0.2, 4)),
        ("speed in steps of 0.5 rad/s",
         lambda _, row: [row[0], row[1], 0.5 * round(row[2] / 0.5)])]


def spread_model(factor):
    """The default model with wider priors of what is unknown."""
    usual = tomllib.loads((ROOT / "data/arm.toml").read_text())["parameters"]
    return "[parameters]\n" + "".join(f"{name}.spread = {factor * usual[name]['spread']}\n" for name in TRUTH)


def start_words(factor):
    """Options that put the start values off the truth, each by the factor or its inverse."""
    words = []
    for i, name in enumerate(("k_g1", "d_g", "k_a", "d_a")):
        words += ["--set", f"{name}={TRUTH[name] * (factor if i % 2 else 1 / factor)!r}"]
    return words


class Suite:
    def __init__(self, options, folder):
        self.options = options
        self.folder = folder
        self.clean = folder / "clean.csv"

    def run(self, record, kind, words=()):
        """What an estimate ends with, and the fit of its parameters on the clean record; None if it fails."""
        saved = self.folder / f"{record.stem}_{kind}_{abs(hash(tuple(words)))}.toml"
        try:
            result = armukf(self.options.program, "estimate", record, "--filter", kind, "--on-error", "skip",
                            "--save", saved, *words)
            fit = armukf(self.options.program, "evaluate", self.clean, "--model", saved, "--initial-from", 0.1)
        except (Failed, Trouble):
            return None
        return result | {"clean_fit": fit["experiments"][0]["fit_percent"]}


def loss(clean, spoilt):
    """(worst parameter in sd, in percent, points of fit) where all is finite and physical."""
    if spoilt is None:
        return None
    sd = percent = 0.0
    misses = False
    for name in TRUTH:
        a, b = clean["parameters"][name], spoilt["parameters"][name]
        if b["value"] is None or b["sd"] is None or not b["value"] >= 0.0:
            return None
        off = abs(b["value"] - a["value"])
        in_sd = off / max(a["sd"], b["sd"])
        in_percent = 100 * off / abs(a["value"])
        misses |= in_sd > MOST_SD and in_percent > MOST_PERCENT
        if min(in_sd / MOST_SD, in_percent / MOST_PERCENT) >= min(sd / MOST_SD, percent / MOST_PERCENT):
            sd, percent = in_sd, in_percent
    points = clean["clean_fit"] - spoilt["clean_fit"]
    return sd, percent, points, misses or points > MOST_POINTS


def cell(found):
    if found is None:
        return "**failed**"
    sd, percent, points, misses = found
    text = f"{sd:.1f} sd, {percent:.2g} %, {points:+.2f}"
    return f"**{text}**" if misses else text


def read(path):
    with path.open() as file:
        rows = csv.DictReader(line for line in file if not line.startswith("#"))
        return Record([[float(r["t"]), float(r["u"]), float(r["y"] or "nan")] for r in rows])


def table(options, filters, faults, results):
    version = subprocess.run([options.program, "--version"], capture_output=True, text=True).stdout.strip()
    lines = ["# What faults cost", "",
             f"By `scripts/fault_table.py`, {version.split(' (')[0]}, record: {options.record or 'simulated'}. "
             "Against the same filter without the fault: the worst parameter, in its standard deviations and in "
             "percent, and the points by which the simulation fit on the record without the fault changes (+ is "
             f"lost). Bold: a parameter beyond {MOST_SD:g} sd and {MOST_PERCENT:g} %, or more than {MOST_POINTS:g} "
             "point of fit lost, or no finite, physical result.", "",
             "| fault | " + " | ".join(f"`{f}`" for f in filters) + " |",
             "|---|" + "---|" * len(filters)]
    for fault in faults:
        lines.append(f"| {fault} | " + " | ".join(cell(results[fault, f]) for f in filters) + " |")
    missed = sum(1 for r in results.values() if r is None or r[3])
    return "\n".join(lines + ["", f"{len(results) - missed} of {len(results)} within the bounds.", ""]), missed


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--save", default="")
    parser.add_argument("--filters", default=FILTERS)
    parser.add_argument("--record", default="")
    parser.add_argument("--samples", type=int, default=SAMPLES)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--program", default=str(PROGRAM))
    options = parser.parse_args()
    filters = options.filters.split(",")
    with tempfile.TemporaryDirectory() as name:
        suite = Suite(options, Path(name))
        source = Path(options.record or suite.folder / "simulated.csv")
        if not options.record:
            simulate(options.program, source, seed=1, noise=0.1, disturbance=0.2, samples=options.samples)
        record = read(source)
        record.write(suite.clean)
        jobs = {}
        for i, (fault, change) in enumerate(record_faults(len(record.rows))):
            path = suite.folder / f"fault{i}.csv"
            record.spoilt(change).write(path)
            jobs[fault] = (path, ())
        for factor in (3, 5, 10):
            model = suite.folder / f"prior{factor}.toml"
            model.write_text(spread_model(factor))
            jobs[f"prior x {factor}"] = (suite.clean, ("--model", str(model)))
        jobs["start values off by x 2"] = (suite.clean, tuple(start_words(2)))
        with ThreadPoolExecutor(options.threads) as pool:
            clean = dict(zip(filters, pool.map(lambda f: suite.run(suite.clean, f), filters)))
            keys = [(fault, f) for fault in jobs for f in filters]
            found = pool.map(lambda k: loss(clean[k[1]], suite.run(jobs[k[0]][0], k[1], jobs[k[0]][1])), keys)
            results = dict(zip(keys, found))
    text, missed = table(options, filters, list(jobs), results)
    if options.save:
        Path(options.save).write_text(text)
    print(text)
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
