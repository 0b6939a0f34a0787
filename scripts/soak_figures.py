#!/usr/bin/python3
"""Streams a very long record, and looks at what must stay as it is: memory, speed, sound beliefs.

    soak_figures.py [--samples 100000000] [--filter ukf] [--watch] [--program build/release/bin/armukf]

The record is one period of a simulated arm with noise, again and again with the time going on; rows
are written as ever, and thrown away. Speed is counted in rows per second of the program's own
processor time, so that what runs beside it does not matter. Exit status 1 where a figure is missed.
"""

import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path

from processes import memory_kb, processor_s
from recursive_figures import Checks
from sweeps import PROGRAM, TRUTH, simulate

PERIOD = 200000  # samples
STEP_S = 5e-4
PIECES = 20  # parts of the whole that are compared
LEAST_PIECE = 500000  # samples; of the first ones the program keeps some for the summary
MOST_GROWTH = 1.02  # of the memory, from the first part's end to the last's
LEAST_SPEED = 0.95


def tails_of(record):
    """The rows of a record without their time."""
    rows = (line for line in record.read_text().splitlines() if line[0].isdigit())
    return [line.split(",", 1)[1] + "\n" for line in rows]


def streamed(process, tails, samples):
    """Feeds it; after each piece (rows so far, its memory in kB, its processor time in s)."""
    seen = []
    piece = samples // PIECES
    with process.stdin as pipe:
        pipe.write("t,u,y\n")
        for first in range(0, samples, 10000):
            last = min(first + 10000, samples)
            pipe.write("".join([f"{n * STEP_S:.4f},{tails[n % PERIOD]}" for n in range(first, last)]))
            if last // piece > first // piece:
                pipe.flush()
                seen.append((last, memory_kb(process.pid), processor_s(process.pid)))
                print(f"{last} rows, {seen[-1][1]} kB, {seen[-1][2]:.0f} s", file=sys.stderr, flush=True)
    return seen


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--samples", type=int, default=100_000_000)
    parser.add_argument("--filter", default="ukf")
    parser.add_argument("--watch", action="store_true")
    parser.add_argument("--program", default=str(PROGRAM))
    options = parser.parse_args()
    if options.samples < PIECES * LEAST_PIECE:
        parser.error(f"--samples: at least {PIECES * LEAST_PIECE}")
    with tempfile.TemporaryDirectory() as folder:
        record, summary = Path(folder, "record.csv"), Path(folder, "summary.json")
        tails = tails_of(simulate(options.program, record, seed=1, noise=0.1, disturbance=0.2, samples=PERIOD))
        words = ["--watch"] if options.watch else []
        process = subprocess.Popen([options.program, "-", "--filter", options.filter, *words, "--json", str(summary),
                                    "--quiet"], stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True)
        seen = streamed(process, tails, options.samples)
        if process.wait() != 0:
            return 1
        found = json.loads(summary.read_text())
    speeds = [(b[0] - a[0]) / (b[2] - a[2]) for a, b in zip(seen, seen[1:])]
    quarter = len(speeds) // 4
    first, last = sum(speeds[:quarter]) / quarter, sum(speeds[-quarter:]) / quarter
    checks = Checks()
    checks.expect(found["samples"] == options.samples, f"{found['samples']} samples, each estimated")
    checks.expect(seen[-1][1] <= MOST_GROWTH * seen[0][1],
                  f"memory {seen[0][1]} kB after a {PIECES}th, {seen[-1][1]} kB in the end")
    checks.expect(last >= LEAST_SPEED * first, f"{first:.0f} rows per s of processor time in the first quarter, "
                                               f"{last:.0f} in the last: {100 * last / first:.1f} %")
    checks.expect(found["resets"] == 0, f"{found['resets']} resets")
    for name, truth in TRUTH.items():
        p = found["parameters"][name]
        checks.expect(p["value"] is not None and abs(p["value"] - truth) < 0.05 * truth,
                      f"{name} {p['value']:.6g} ± {p['sd']:.2g}, in truth {truth:.6g}")
    return 1 if checks.missed else 0


if __name__ == "__main__":
    sys.exit(main())
