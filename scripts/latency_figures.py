#!/usr/bin/python3
"""How long after a sample its row comes out, live: samples at 2 kHz into a pipe, each row waited for.

    latency_figures.py [--seconds 600] [--filter ukf] [--watch] [--checkpoint] [--program build/release/bin/armukf]

From the write of a sample's line to the arrival of its row's last character, after the first second. With
--checkpoint one is written every second meanwhile. Exit status 1 where a figure is missed.
"""

import argparse
import os
import selectors
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from recursive_figures import Checks
from soak_figures import tails_of
from sweeps import PROGRAM, TRUTH, simulate

RATE_HZ = 2000
RECORD_S = 100  # what is simulated; the same again after it, the time going on
MEDIAN_MS, P99_MS, CHECKPOINT_MS = 1.0, 5.0, 5.0
PATIENCE_S = 1.0  # after which a row counts as lost


class Rows:
    """What comes out of a pipe, by lines."""

    def __init__(self, pipe):
        self.descriptor, self.rest = pipe.fileno(), b""
        self.selector = selectors.DefaultSelector()
        self.selector.register(pipe, selectors.EVENT_READ)

    def arrive(self, count):
        """Waits for as many; how many have come, and when the last did."""
        while self.rest.count(b"\n") < count and self.selector.select(PATIENCE_S):
            piece = os.read(self.descriptor, 1 << 16)
            if not piece:
                break
            self.rest += piece
        now, found = time.monotonic(), self.rest.count(b"\n")
        self.rest = self.rest[self.rest.rindex(b"\n") + 1:] if found else self.rest
        return found, now


def latencies(process, tails, seconds):
    """Of every sample after the first second, in s; and how many rows came in all."""
    rows, found, delays = Rows(process.stdout), 0, []
    process.stdin.write(b"t,u,y\n")
    begin = time.monotonic()
    for k in range(seconds * RATE_HZ):
        line = b"%.4f,%b" % (k / RATE_HZ, tails[k % len(tails)])
        time.sleep(max(0.0, begin + k / RATE_HZ - time.monotonic()))
        sent = time.monotonic()
        process.stdin.write(line)
        come, now = rows.arrive(2 if k == 0 else 1)  # the header comes with the first row
        found += come
        if k >= RATE_HZ:
            delays.append(now - sent)
    return delays, found - 1


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--seconds", type=int, default=600)
    parser.add_argument("--filter", default="ukf")
    parser.add_argument("--watch", action="store_true")
    parser.add_argument("--checkpoint", action="store_true")
    parser.add_argument("--program", default=str(PROGRAM))
    options = parser.parse_args()
    checks = Checks()
    with tempfile.TemporaryDirectory() as folder:
        record = simulate(options.program, Path(folder, "record.csv"), 1, 0.1, 0.0, TRUTH, RECORD_S * RATE_HZ)
        tails = [tail.encode() for tail in tails_of(record)]
        words = [options.program, "-", "--quiet", "--filter", options.filter, *["--watch"] * options.watch]
        if options.checkpoint:
            words += ["--checkpoint", f"{folder}/belief", "--every-s", "1"]
        with subprocess.Popen(words, stdin=subprocess.PIPE, stdout=subprocess.PIPE, bufsize=0) as process:
            delays, found = latencies(process, tails, options.seconds)
            process.stdin.close()
    ms = sorted(1e3 * d for d in delays)
    median, p99, worst = ms[len(ms) // 2], ms[int(len(ms) * 0.99)], ms[-1]
    checks.expect(found == options.seconds * RATE_HZ, f"{found} rows of {options.seconds * RATE_HZ} samples")
    checks.expect(median <= MEDIAN_MS and p99 <= P99_MS,
                  f"median {median:.3f} ms ({MEDIAN_MS:g}), 99 % within {p99:.3f} ms ({P99_MS:g}), all within "
                  f"{worst:.1f} ms")
    if options.checkpoint:
        late = sum(d > CHECKPOINT_MS for d in ms)
        checks.expect(late == 0, f"{late} rows later than {CHECKPOINT_MS:g} ms, a checkpoint every second (none)")
    return 1 if checks.missed else 0


if __name__ == "__main__":
    sys.exit(main())
