#!/usr/bin/python3
"""An estimate between two topics of a real Mosquitto, as the manual writes it: every row of the record
comes out once, and as it does without a broker. Exit status 77 where Mosquitto is not installed.

    mosquitto_test.py PROGRAM
"""

import subprocess
import sys
import tempfile
from contextlib import ExitStack
from pathlib import Path

from broker import SKIPPED, answers, free_port, missing, simulated, started, wait_until

ROWS = 4000
# Nothing is thrown away while a subscriber is slower than the publisher.
CONFIGURATION = """listener {port} 127.0.0.1
allow_anonymous true
max_queued_messages 0
max_inflight_messages 0
"""


def lines_of(path):
    return path.read_text().splitlines() if path.exists() else []


def main():
    program = Path(sys.argv[1])
    if missing("mosquitto", "mosquitto_sub", "mosquitto_pub"):
        return SKIPPED
    with tempfile.TemporaryDirectory() as name, ExitStack() as stack:
        folder, port = Path(name), free_port()
        (folder / "broker.conf").write_text(CONFIGURATION.format(port=port))
        record, rows, report = folder / "record.csv", folder / "rows.csv", folder / "summary.json"
        simulated(program, record, ROWS)
        wanted = subprocess.run([program, record, "--quiet"], capture_output=True, text=True,
                                check=True).stdout.splitlines()
        log = stack.enter_context((folder / "broker.log").open("w"))
        started(stack, ["mosquitto", "-c", folder / "broker.conf", "-v"], stdout=log, stderr=log)
        wait_until("the broker", lambda: answers(port))

        def client(kind, topic, *words, **pipes):
            return started(stack, [f"mosquitto_{kind}", "-p", port, "-q", "2", "-t", topic, *words], **pipes)

        client("sub", "arm/belief", stdout=stack.enter_context(rows.open("w")))
        source = client("sub", "arm/samples", stdout=subprocess.PIPE)
        estimate = started(stack, [program, "--quiet", "--json", report], stdin=source.stdout,
                           stdout=subprocess.PIPE)
        client("pub", "arm/belief", "-l", stdin=estimate.stdout)
        wait_until("subscriptions", lambda: (folder / "broker.log").read_text().count("Sending SUBACK") == 2)
        with record.open() as lines:
            subprocess.run(["mosquitto_pub", "-p", str(port), "-q", "2", "-t", "arm/samples", "-l"], stdin=lines,
                           check=True)
        wait_until("the last row", lambda: len(lines_of(rows)) >= len(wanted))
        estimate.terminate()
        if estimate.wait() != 0 or not report.exists():
            sys.exit("mosquitto_test: the estimate did not end with its summary")
        found = lines_of(rows)
        if found != wanted:
            different = sum(a != b for a, b in zip(found, wanted))
            sys.exit(f"mosquitto_test: {len(found)} rows instead of {len(wanted)}, {different} others")
    print(f"{len(wanted) - 1} rows through the broker, each once and the same")
    return 0


if __name__ == "__main__":
    sys.exit(main())
