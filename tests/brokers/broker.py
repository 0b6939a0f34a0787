"""What the tests of brokers share."""

import shutil
import socket
import subprocess
import sys
import time

SKIPPED = 77  # exit status
PATIENCE_S = 120.0


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def answers(port):
    with socket.socket() as probe:
        return probe.connect_ex(("127.0.0.1", port)) == 0


def wait_until(what, true):
    end = time.monotonic() + PATIENCE_S
    while not true():
        if time.monotonic() > end:
            sys.exit(f"{sys.argv[0]}: {what} did not happen within {PATIENCE_S:g} s")
        time.sleep(0.05)


def started(stack, words, **how):
    """A process that ends with the stack."""
    process = stack.enter_context(subprocess.Popen([str(w) for w in words], **how))
    stack.callback(process.kill)
    return process


def simulated(program, path, samples, seed=1):
    """A record of the published arm."""
    subprocess.run([str(program), "simulate", "-o", str(path), "--samples", str(samples), "--seed", str(seed),
                    "--sensor-noise", "0.1", "--quiet"], check=True)
    return path


def missing(*programs):
    """Says so where one of them is not installed."""
    absent = [name for name in programs if not shutil.which(name)]
    if absent:
        print(f"skipped: {', '.join(absent)} not installed")
    return absent
