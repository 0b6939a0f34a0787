#!/usr/bin/python3
"""What the live page costs, and how far it is behind: measured with a filter, its page and a real browser.

    live_figures.py pace [--seconds 60]    samples at 2 kHz through filter and page: the server's share of a core,
                                           and how far what the browser has drawn is behind the sample sent last, and
                                           what memory both have come to
    live_figures.py hour [--rows 7200000]  an hour of rows as fast as they are taken: JavaScript heap of the page
                                           and memory of the server before and after, bins that both hold
"""

import argparse
import asyncio
import os
import re
import subprocess
import sys
import tempfile
import time
from contextlib import contextmanager
from pathlib import Path

from browser import browser
from processes import memory_kb, processor_s
from sweeps import PROGRAM, write_json

RATE_HZ = 2000
RECORD_S = 600  # what is simulated at most
LIVE = Path(__file__).resolve().parent / "live.py"


@contextmanager
def page_server(source):
    """live.py over these rows: its process and its address."""
    server = subprocess.Popen([LIVE, "--port", "0"], stdin=source, stderr=subprocess.PIPE, text=True)
    try:
        yield server, re.search(r"http://\S+", server.stderr.readline()).group()
    finally:
        server.kill()
        server.wait()


async def heap_mb(page):
    await page.call("HeapProfiler.collectGarbage")
    used = await page.call("Runtime.getHeapUsage")
    return (used["usedSize"] + used.get("backingStorageSize", 0)) / 1e6  # objects, and the numbers of arrays


async def sent(lines, pipe, begin, seconds):
    """Samples at RATE_HZ, a hundred times a second what is due; after the last line the first again, the time
    going on."""
    rests = [line[line.index(","):] for line in lines]
    done = 0
    while done < seconds * RATE_HZ:
        due = min(int((time.monotonic() - begin) * RATE_HZ), seconds * RATE_HZ)
        pipe.write("".join(f"{k / RATE_HZ:.4f}{rests[k % len(rests)]}" for k in range(done, due)).encode())
        pipe.flush()
        done = due
        await asyncio.sleep(0.01)


async def pace(program, seconds):
    with tempfile.TemporaryDirectory() as folder:
        record = Path(folder, "record.csv")
        subprocess.run([program, "simulate", "-o", record, "--samples", str(min(seconds, RECORD_S) * RATE_HZ),
                        "--sensor-noise", "0.1", "--quiet"], check=True)
        header, *lines = [f"{line}\n" for line in record.read_text().splitlines() if line[0] != "#"]
    with subprocess.Popen([program, "-", "--quiet"], stdin=subprocess.PIPE, stdout=subprocess.PIPE) as estimate, \
            page_server(estimate.stdout) as (server, address):
        async with browser() as tab:
            page = await tab()
            await page.open(address)
            estimate.stdin.write(header.encode())
            begin, before, heap_before = time.monotonic(), processor_s(server.pid), await heap_mb(page)
            sending = asyncio.create_task(sent(lines, estimate.stdin, begin, seconds))
            behind = []
            while not sending.done():
                await asyncio.sleep(0.07)
                now = time.monotonic() - begin
                drawn = await page.value("view.drawn.at ? view.bins.at(-1)?.[1] ?? null : null")
                if drawn is not None and now > 2:
                    behind.append(now - drawn)
            used = processor_s(server.pid) - before
            heap_after, server_mb = await heap_mb(page), memory_kb(server.pid) / 1024
        estimate.stdin.close()
    behind.sort()
    return {"seconds": seconds, "server_percent_of_a_core": 100 * used / (time.monotonic() - begin),
            "behind_s": {"median": behind[len(behind) // 2], "p99": behind[int(len(behind) * 0.99)],
                         "worst": behind[-1]}, "heap_mb": {"before": heap_before, "after": heap_after},
            "server_mb": server_mb}


def hour_of_rows(program, rows, pipe):
    """The rows of one estimate over and over, the time going on."""
    with tempfile.TemporaryDirectory() as folder:
        record = Path(folder, "record.csv")
        subprocess.run([program, "simulate", "-o", record, "--sensor-noise", "0.1", "--quiet"], check=True)
        text = subprocess.run([program, record, "--quiet"], capture_output=True, check=True).stdout
    header, *lines = text.splitlines(keepends=True)
    rests = [line[line.index(b","):] for line in lines]
    with pipe:
        pipe.write(header)
        for i in range(0, rows, 1000):
            pipe.write(b"".join(b"%.4f%b" % (k / RATE_HZ, rests[k % len(rests)])
                                for k in range(i, min(i + 1000, rows))))


async def hour(program, rows):
    out, into = os.pipe()
    with os.fdopen(out, "rb") as source, page_server(source) as (server, address):
        async with browser() as tab:
            page = await tab()
            await page.open(address)
            await page.wait_for("document.getElementById('state').dataset.state === 'waiting'")
            before = {"heap_mb": await heap_mb(page), "server_mb": memory_kb(server.pid) / 1024}
            begin = time.monotonic()
            sending = asyncio.to_thread(hour_of_rows, program, rows, os.fdopen(into, "wb"))
            await sending
            await page.wait_for("document.getElementById('state').dataset.state === 'ended'")
            seconds = time.monotonic() - begin
            await asyncio.sleep(1)
            after = {"heap_mb": await heap_mb(page), "server_mb": memory_kb(server.pid) / 1024}
            bins = await page.value("view.bins.length")
            last = await page.value("view.bins.at(-1)[1]")
    return {"rows": rows, "rows_per_second": rows / seconds, "before": before, "after": after, "bins": bins,
            "last_t": last}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("job", choices=["pace", "hour"])
    parser.add_argument("--seconds", type=int, default=60)
    parser.add_argument("--rows", type=int, default=3600 * RATE_HZ)
    parser.add_argument("--program", default=str(PROGRAM), help="armukf")
    options = parser.parse_args()
    job = pace(options.program, options.seconds) if options.job == "pace" else hour(options.program, options.rows)
    write_json("-", asyncio.run(job))


if __name__ == "__main__":
    sys.exit(main())
