#!/usr/bin/python3
"""The page of a diagnosis in a real browser: what it shows is what the JSON and the rows say.

Exit status 77 where aiohttp or Chromium is not installed."""

import base64
import re
import subprocess
import sys
import unittest
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from browser_case import SCRIPTS, BrowserCase, browser
import made_up_diagnosis as made_up

HOSTILE = "</script><img src=x onerror='document.title=\"executed\"'><script>document.title='executed'</script>"
PHONE, DESK = 390, 1200  # pixels
NUMBER = re.compile(r"-?[\d.]+(?:e[-+]\d+)?")


class ReportPage(BrowserCase):
    WIDTH = DESK

    async def asyncSetUp(self):
        await super().asyncSetUp()
        self.found, self.rows = made_up.found(), made_up.rows()

    async def show(self):
        json, rows = made_up.write(self.folder, self.found, self.rows)
        subprocess.run([SCRIPTS / "report.py", json, rows, "-o", self.folder / "report.html"], check=True)
        await self.page.open((self.folder / "report.html").as_uri())
        await self.page.wait_for("charts.length > 0 && charts.every((c) => c.plot.bbox.width > 0)")

    async def cells(self, table):
        """The texts of a table's rows."""
        return await self.page.value(f"[...document.querySelectorAll('{table} tbody tr')].map((row) => "
                                     "[...row.cells].map((cell) => cell.textContent))")

    async def box(self, chart):
        return await self.page.value(f"""(() => {{
            const over = document.querySelector('#chart-{chart} .u-over');
            over.scrollIntoView({{ block: 'center', behavior: 'instant' }});
            const b = over.getBoundingClientRect(); return [b.left, b.top, b.width, b.height]; }})()""")

    async def mouse(self, chart, *steps):
        left, top, width, height = await self.box(chart)
        for kind, share in steps:
            await self.page.call("Input.dispatchMouseEvent", type=kind, x=left + share * width, y=top + height / 2,
                                 button="none" if kind == "mouseMoved" else "left", clickCount=1,
                                 buttons=0 if kind == "mouseReleased" else 1)

    async def legend(self, chart):
        """{name: text} under the pointer."""
        told = await self.page.value(f"[...document.querySelectorAll('#chart-{chart} .legend > span')].map((s) => "
                                     "[s.firstChild.textContent || s.childNodes[1].textContent, "
                                     "s.querySelector('output').textContent])")
        return {name.strip(): text for name, text in told}

    def expect_number(self, text, exact, digits=4):
        shown = float(NUMBER.search(text).group())
        self.assertAlmostEqual(shown, exact, delta=abs(exact) * 0.51 * 10 ** (1 - digits) + 1e-12, msg=text)

    async def test_tables_hold_the_numbers_of_the_json(self):
        await self.show()
        shown = [row for row in await self.cells("#measures") if len(row) == 3]
        for row, (record, key) in zip(shown, ((r, k) for r in ("validation", "estimation") for k in (
                "fit_percent", "mse", "one_step_rmse", "log_likelihood", "ljung_box_p"))):
            for text, when in zip(row[1:], ("before", "after")):
                self.expect_number(text, self.found[when][record][key], 6)
        shown = await self.cells("#parameters")
        self.assertEqual([row[0] for row in shown], list(self.found["parameters"]))
        for row, told in zip(shown, self.found["parameters"].values()):
            self.expect_number(row[3], told["after"], 5)
            self.expect_number(row[3].partition("±")[2], told["after_sd"], 2)
        self.assertEqual([row[4] for row in shown], ["+2.3 %", "+12 %", "was known", "new"])
        ranks = await self.cells(".round")
        for candidate in self.found["candidates"]:
            row = next(row for row in ranks if row[0].startswith(candidate["name"]))
            self.assertEqual(row[-1], candidate.get("refused_because", "accepted"))
        lead = await self.page.text("#lead")
        self.assertIn("Two effects are missing", lead)

    async def test_pointing_tells_the_rows_values_and_zoom_goes_together(self):
        await self.show()
        self.assertIn("rad/s rms", (await self.legend("residual"))["before"])
        await self.mouse("residual", ("mouseMoved", 0.31))
        await self.page.wait_for("charts.find((c) => c.what.id === 'residual').plot.cursor.idx !== null")
        told = await self.legend("residual")
        t = float(told["time"].removesuffix(" s"))
        at = int(np.argmin(np.abs(self.rows["t"] - t)))
        for name in ("before", "after"):
            self.assertTrue(told[name].endswith(" rad/s"))
            self.expect_number(told[name], self.rows[f"residual_{name}"][at])
        self.expect_number((await self.legend("speed"))["measured"], self.rows["y"][at])  # the pointer goes along

        await self.mouse("residual", ("mouseMoved", 0.2), ("mousePressed", 0.2), ("mouseMoved", 0.5),
                         ("mouseReleased", 0.5))
        scale = "charts.find((c) => c.what.id === '{}').plot.scales.x.{}"
        await self.page.wait_for(scale.format("speed", "min") + " > 0.1")
        span = self.rows["t"][-1]
        for chart in ("residual", "speed"):
            self.assertAlmostEqual(await self.page.value(scale.format(chart, "min")), 0.2 * span, delta=0.01)
            self.assertAlmostEqual(await self.page.value(scale.format(chart, "max")), 0.5 * span, delta=0.01)
        band = await self.page.value(scale.format("band", "max"))
        self.assertGreater(band, 900)  # Hz: not zoomed
        await self.page.value("document.querySelector('#chart-speed .whole').click()")
        await self.page.wait_for(scale.format("residual", "max") + f" > {0.99 * span}")
        self.assertEqual(self.page.complaints, [])

    async def test_every_view_of_every_chart_is_drawn(self):
        await self.show()
        painted = await self.page.value("""(async () => {
            const counts = [];
            for (const chart of charts) for (const view of chart.what.views) {
              chart.show(view);
              await new Promise((done) => setTimeout(done, 20));
              const { ctx, bbox: { left, top, width, height } } = chart.plot;
              const { data } = ctx.getImageData(left, top, width, height);
              let count = 0;
              for (let i = 0; i < data.length; i += 4) {
                count += data[i + 3] > 200 && Math.abs(data[i + 2] - data[i]) > 60;
              }
              counts.push([chart.what.id, view.name, count]);
            }
            return counts; })()""")
        self.assertGreater(len(painted), 15)
        for chart, view, count in painted:
            self.assertGreater(count, 100, f"{chart} {view}")
        self.assertEqual(self.page.complaints, [])

    async def test_nothing_of_a_record_is_executed(self):
        self.found["files"]["estimation"] = self.found["effects"][0]["name"] = HOSTILE
        self.found["unexplained"] = [HOSTILE]
        self.found["candidates"][1]["refused_because"] = HOSTILE
        await self.show()
        self.assertIn(HOSTILE, await self.page.text("main"))
        self.assertNotEqual(await self.page.value("document.title"), "executed")
        self.assertEqual(await self.page.value("document.images.length"), 0)
        self.assertEqual(self.page.complaints, [])
        with self.assertRaises(browser.BrowserError):  # text is not taken for a script, even by a script
            await self.page.value("const s = document.createElement('script');"
                                  "s.text = 'document.title = \"executed\"'; document.body.append(s)")
        self.assertNotEqual(await self.page.value("document.title"), "executed")

    async def test_a_finger_zooms(self):
        await self.page.size(PHONE, 800, True)
        await self.page.call("Emulation.setTouchEmulationEnabled", enabled=True)
        await self.show()
        left, top, width, height = await self.box("residual")
        for kind, share in (("touchStart", 0.2), ("touchMove", 0.25), ("touchMove", 0.4), ("touchMove", 0.5),
                            ("touchEnd", None)):
            points = [] if share is None else [{"x": left + share * width, "y": top + height / 2}]
            await self.page.call("Input.dispatchTouchEvent", type=kind, touchPoints=points)
        await self.page.wait_for("charts.find((c) => c.what.id === 'speed').span[0] !== null")
        span = self.rows["t"][-1]
        for share, end in ((0.2, "min"), (0.5, "max")):
            shown = await self.page.value(f"charts.find((c) => c.what.id === 'speed').plot.scales.x.{end}")
            self.assertAlmostEqual(shown, share * span, delta=0.03 * span)

    async def test_it_fits_a_phone_and_paper(self):
        for width, mobile in ((PHONE, True), (DESK, False)):
            await self.page.size(width, 800, mobile)
            await self.show()
            self.assertLessEqual(await self.page.value("document.documentElement.scrollWidth"), width)
            narrow = await self.page.value("Math.min(...charts.map((c) => c.plot.width))")
            self.assertGreater(narrow, 0.8 * PHONE)
        printed = await self.page.call("Page.printToPDF", printBackground=True)
        self.assertTrue(base64.b64decode(printed["data"]).startswith(b"%PDF"))
        self.assertTrue(await self.page.value("[...document.querySelectorAll('details')].every((d) => d.open)"))


if __name__ == "__main__":
    unittest.main()
