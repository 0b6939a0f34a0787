#!/usr/bin/python3
"""Session.run of the Python package beside the C++ loop, the same million samples in the same minute.

    cmake --preset bench && cmake --build --preset bench && scripts/python_rate.py

In processor time of the thread that asks, the best of a few rounds: what else this machine does counts little
then. All threads together, with the one that fetches memory, are told beside it.
"""

import subprocess
import sys
import tempfile
import time

from sweeps import ROOT

BUILD = ROOT / "build/bench"
sys.path.insert(0, str(BUILD / "python"))
import armukf  # noqa: E402

ROUNDS = 4
LEAST = 0.9  # of the C++ loop's rate


def main():
    samples = armukf.simulate(samples=1_000_000, sensor_noise=0.1).samples
    ours, together, loops = [], [], []
    with tempfile.NamedTemporaryFile() as file:
        samples.tofile(file.name)
        for _ in range(ROUNDS):
            loops += map(float, subprocess.run([BUILD / "bin/session_loop", file.name, "1"], capture_output=True, text=True,
                                               check=True).stdout.split())
            session = armukf.Session()
            begin, all_begin = time.thread_time(), time.process_time()
            session.run(samples)
            ours.append(time.thread_time() - begin)
            together.append(time.process_time() - all_begin)
    n = len(samples)
    print(f"C++ loop {n / min(loops):.0f} samples/s, Session.run {n / min(ours):.0f}: "
          f"{100 * min(loops) / min(ours):.1f} %, asked {100 * LEAST:.0f} %; "
          f"of all threads together {100 * min(loops) / min(together):.1f} %")
    return 0 if min(loops) / min(ours) >= LEAST else 1


if __name__ == "__main__":
    sys.exit(main())
