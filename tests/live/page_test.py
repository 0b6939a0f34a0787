#!/usr/bin/python3
"""The live page in a real browser: what it shows is what the rows say. page_test.py PROGRAM

Exit status 77 where aiohttp or Chromium is not installed."""

import csv
import json
import re
import subprocess
import sys
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from browser_case import SCRIPTS, BrowserCase

LIVE = SCRIPTS / "live.py"
PROGRAM = sys.argv.pop(1) if len(sys.argv) > 1 else "build/release/bin/armukf"

PARAMETERS = ["a_m", "a_g", "k_g1", "k_g3", "d_g", "k_a", "d_a"]
STATES = ["twist_gear", "twist_arm", "speed_motor", "speed_gear", "speed_arm"]
HOSTILE = "<img src=x onerror='document.title=\"executed\"'>"
MEASURED = re.compile(r"(-?[\d.]+(?:e[-+]\d+)?) ± ([\d.]+(?:e[-+]\d+)?)")
DRAWN = "view.history && !view.due && view.bins.length ? view.bins.at(-1)[1] : null"


def estimated(*words):
    done = subprocess.run([PROGRAM, *map(str, words), "--quiet"], capture_output=True, text=True, check=True)
    return done.stdout.splitlines(keepends=True)


class LivePage(BrowserCase):
    def start(self, *words, port=0):
        self.server = self.stack.enter_context(subprocess.Popen(
            [LIVE, "--port", str(port), *map(str, words)], stdin=subprocess.PIPE, stderr=subprocess.PIPE))
        self.stack.callback(self.server.kill)
        self.address = self.server.stderr.readline().decode().split()[-1]

    def give(self, lines):
        self.server.stdin.write("".join(lines).encode())
        self.server.stdin.flush()

    async def drawn_up_to(self, t):
        await self.page.wait_for(f"({DRAWN}) === {t!r}")

    async def expect_numbers_of(self, row):
        """Each caption says the row's value and deviation, to as many digits as it shows."""
        for name in PARAMETERS + STATES:
            text = await self.page.text(f"figure[data-name={name}] output")
            found = MEASURED.match(text)
            self.assertIsNotNone(found, f"{name}: {text}")
            for shown, exact in zip(found.groups(), (row[name], row[name + "_sd"])):
                self.assertAlmostEqual(float(shown), float(exact), delta=0.5001 * last_digit(shown),
                                       msg=f"{name}: {text}")

    async def expect_innovations_of(self, rows):
        """What is drawn of the innovations has the extremes of every stretch of the rows between two points."""
        times, high, low = await self.page.value("[0, 3, 4].map((i) => Array.from(view.charts[0].plot.data[i]))")
        begin = 0
        for t, most, least in zip(times, high, low):
            end = next(i for i in range(begin, len(rows)) if float(rows[i]["t"]) == t) + 1
            innovations = [float(row["innovation"]) for row in rows[begin:end]]
            self.assertEqual((most, least), (max(innovations), min(innovations)), f"up to {t} s")
            begin = end
        self.assertEqual(begin, len(rows))

    async def expect_lines_drawn(self):
        """There is more on each chart in sight than its paper."""
        painted = await self.page.value("""view.charts.filter((c) => c.inSight).map((c) => {
            const { ctx, bbox } = c.plot, pixels = ctx.getImageData(bbox.left, bbox.top, bbox.width, bbox.height).data;
            let count = 0;
            for (let i = 0; i < pixels.length; i += 4) count += pixels[i + 3] > 200 && pixels[i + 2] > pixels[i] + 60;
            return count; })""")
        self.assertGreater(len(painted), 3)
        self.assertGreater(min(painted), 100)

    def expect_no_complaints(self):
        self.assertEqual(self.page.complaints, [])

    async def test_numbers_are_those_of_the_rows_also_after_a_reload(self):
        record, events = self.folder / "record.csv", self.folder / "events.jsonl"
        subprocess.run([PROGRAM, "simulate", "-o", record, "--samples", "8000", "--sensor-noise", "0.1", "--quiet"],
                       check=True)
        lines = estimated(record)
        rows = list(csv.DictReader(lines))
        self.start("--events", events)
        await self.page.open(self.address)
        await self.page.wait_for("document.getElementById('state').textContent === 'waiting for rows'")
        self.give(lines[:3001])
        await self.drawn_up_to(float(rows[2999]["t"]))
        self.assertEqual(await self.page.text("#counts"), "3,000 rows")
        await self.expect_numbers_of(rows[2999])

        self.give(lines[3001:5001])
        await self.page.open(self.address)  # in mid-stream
        await self.drawn_up_to(float(rows[4999]["t"]))
        self.give([*lines[5001:], "nonsense\n"])
        await self.drawn_up_to(float(rows[-1]["t"]))
        await self.page.wait_for("document.getElementById('state').textContent === 'live'")
        await self.expect_numbers_of(rows[-1])
        await self.expect_innovations_of(rows)
        await self.expect_lines_drawn()
        self.assertEqual(await self.page.text("#counts"), "8,000 rows · 1 unreadable")

        events.write_text(json.dumps({"t": 2.2, "onset": 2.0, "what": "k_a", "from": 13.8, "to": 16.04, "sd": 0.1,
                                      "p": 0.97, "also_possible": [HOSTILE], "settled": False}) + "\n")
        await self.page.wait_for("document.querySelector('#events tbody tr') !== null")
        cells = await self.page.value("[...document.querySelectorAll('#events td')].map((c) => c.textContent)")
        self.assertEqual(cells, ["2", "2.2", "", "k_a", "13.8", "16.04", "0.1", "0.97", HOSTILE, "not yet"])
        self.server.stdin.close()
        await self.page.wait_for("document.getElementById('state').textContent === 'stream ended'")
        await self.expect_numbers_of(rows[-1])
        self.expect_no_complaints()

    async def test_zoom_pause_and_a_server_that_comes_back(self):
        lines = estimated(SCRIPTS.parent / "data/short_record.csv")
        self.start()
        await self.page.open(self.address)
        self.give(lines[:1501])
        await self.drawn_up_to(0.7495)
        await self.page.value("document.getElementById('pause').click()")
        self.give(lines[1501:])
        await self.page.wait_for("view.history.all().at(-1)[1] === 0.9995 && !view.due")
        self.assertEqual(await self.page.value("view.bins.at(-1)[1]"), 0.7495)  # also while the next drawing is due
        await self.page.value("document.getElementById('pause').click()")
        await self.drawn_up_to(0.9995)

        first = await self.page.value("view.bins[0][1]")
        box = await self.page.value("""(() => { const b = document.querySelector('[data-name=NIS] .u-over')
            .getBoundingClientRect(); return [b.left, b.top, b.width, b.height]; })()""")
        left, top, width, height = box
        for kind, share in (("mouseMoved", 0.2), ("mousePressed", 0.2), ("mouseMoved", 0.5), ("mouseReleased", 0.5)):
            await self.page.call("Input.dispatchMouseEvent", type=kind, x=left + share * width, y=top + height / 2,
                                 button="none" if kind == "mouseMoved" else "left", clickCount=1,
                                 buttons=0 if kind == "mouseReleased" else 1)
        await self.page.wait_for("view.fixed && !view.due")
        for chart in ("view.charts[0]", "view.charts[5]"):
            low, high = await self.page.value(f"[{chart}.plot.scales.x.min, {chart}.plot.scales.x.max]")
            self.assertAlmostEqual(low, first + 0.2, delta=0.005)  # of the second that was shown
            self.assertAlmostEqual(high, first + 0.5, delta=0.005)
        await self.page.value("document.querySelector('#windows button').click()")
        await self.page.wait_for("!view.fixed && !view.due")

        port = int(self.address.rsplit(":", 1)[1])
        self.server.kill()
        self.server.wait()
        await self.page.wait_for("document.getElementById('state').dataset.state === 'lost'")
        self.page.complaints.clear()
        self.start(port=port)
        self.give(lines[:101])
        await self.drawn_up_to(float(lines[100].split(",")[0]))
        await self.page.wait_for("document.getElementById('state').dataset.state === 'live'")

    async def test_many_arms_worst_first_and_nothing_is_executed(self):
        record = (SCRIPTS.parent / "data/short_record.csv").read_text().splitlines()
        samples = [line for line in record if line[0].isdigit()]
        fleet = self.folder / "fleet.csv"
        with fleet.open("w") as file:
            file.write("arm,t,u,y\n")
            for i, line in enumerate(samples):
                t, u, y = line.split(",")
                file.write(f"good,{line}\n{HOSTILE},{t},{u},{float(y) + 30 * (i > 1000 and i % 10 == 0)}\n")
        lines = estimated(fleet, "--key", "arm")
        self.start()
        self.give(lines)
        await self.page.open(self.address)
        await self.drawn_up_to(0.9995)
        links = "[...document.querySelectorAll('#arms a')].map((a) => a.textContent)"
        await self.page.wait_for(f"{links}.length === 2")
        self.assertEqual(await self.page.value(links), [HOSTILE, "good"])
        self.assertEqual(await self.page.text("#title"), HOSTILE)
        await self.page.value("document.querySelectorAll('#arms a')[1].click()")
        await self.page.wait_for("view.arm === 'good' && view.bins.length && !view.due")
        good = [row for row in csv.DictReader(lines) if row["arm"] == "good"]
        await self.expect_numbers_of(good[-1])
        self.assertNotIn("executed", await self.page.value("document.title"))
        self.expect_no_complaints()


def last_digit(text):
    """The worth of the last digit shown."""
    digits, _, power = text.partition("e")
    return 10.0 ** (int(power or 0) - len(digits.partition(".")[2]))


if __name__ == "__main__":
    unittest.main()
