#!/usr/bin/python3
"""Kills an estimate with -9 at random instants, resumes it from its checkpoint until it comes to the
end, and compares every row with those of an undisturbed run, bit by bit.

    kill_figures.py [--times 200] [--filter ukf] [--seed 1] [--program build/release/bin/armukf]

Exit status 1 where a row differs or is missing, or a checkpoint cannot be read.
"""

import argparse
import random
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from sweeps import PROGRAM, simulate

ROWS = 24000
EVERY_S = "0.002"
MOST_KILLS = 4  # of one estimate


def rows_of(path):
    """Whole rows by their time; a row that was cut has no newline."""
    lines = path.read_text().split("\n")[:-1]
    return {line.split(",", 1)[0]: line for line in lines if line and not line.startswith("t,")}


class Estimate:
    """An estimate of one record in a folder of its own, killed as often as one likes."""

    def __init__(self, options, record, folder):
        self.words = [options.program, str(record), "--quiet", "--filter", options.filter,
                      "--checkpoint", str(folder / "belief"), "--every-s", EVERY_S]
        self.checkpoint = folder / "belief"
        self.folder = folder
        self.pieces = []

    def run(self, killed_after=None):
        """Whether it came to its end; SystemExit where it failed by itself."""
        words = list(self.words)
        if self.checkpoint.exists():
            words += ["--resume", str(self.checkpoint)]
        self.pieces.append(self.folder / f"rows{len(self.pieces)}")
        with self.pieces[-1].open("w") as output:
            process = subprocess.Popen(words, stdout=output, stderr=subprocess.PIPE, text=True)
        if killed_after is not None:
            time.sleep(killed_after)
            process.kill()
        error = process.communicate()[1]
        if process.returncode not in (0, -9):
            sys.exit(f"kill_figures: {error}")
        return process.returncode == 0


def undisturbed(options, record, folder):
    """Rows of a whole run, and how long it takes."""
    path = folder / "whole"
    begin = time.monotonic()
    with path.open("w") as output:
        subprocess.run([options.program, str(record), "--quiet", "--filter", options.filter],
                       stdout=output, check=True)
    return rows_of(path), time.monotonic() - begin


def faults_of(estimate, whole):
    """What is wrong with the rows of all pieces together, as text; empty if nothing is."""
    seen = {}
    for piece in estimate.pieces:
        for t, row in rows_of(piece).items():
            if whole.get(t) != row or seen.setdefault(t, row) != row:
                return f"another row at {t} s"
    return "" if len(seen) == len(whole) else f"{len(whole) - len(seen)} rows are missing"


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--times", type=int, default=200)
    parser.add_argument("--filter", default="ukf")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--program", default=str(PROGRAM))
    options = parser.parse_args()
    draw = random.Random(options.seed)
    kills = wrong = resumed = 0
    with tempfile.TemporaryDirectory() as folder:
        record = Path(folder) / "record.csv"
        simulate(options.program, record, seed=1, noise=0.1, samples=ROWS)
        whole, seconds = undisturbed(options, record, Path(folder))
        while kills < options.times:
            with tempfile.TemporaryDirectory(dir=folder) as own:
                estimate = Estimate(options, record, Path(own))
                ended = False
                for _ in range(min(draw.randint(1, MOST_KILLS), options.times - kills)):
                    ended = estimate.run(draw.uniform(0.0, seconds))
                    kills += not ended
                    if ended:
                        break
                    resumed += estimate.checkpoint.exists()
                if not ended:
                    estimate.run()
                left = len(list(Path(own).glob("*.tmp")))
                if fault := faults_of(estimate, whole) or ("a piece is left" if left else ""):
                    wrong += 1
                    print(f"after {len(estimate.pieces) - 1} kills: {fault}")
    print(f"{kills} kills, {resumed} with a checkpoint to resume from, {wrong} estimates wrong")
    return 1 if wrong or not resumed else 0


if __name__ == "__main__":
    sys.exit(main())
