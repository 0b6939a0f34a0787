#!/usr/bin/python3
"""A picture of the beginning of a page, as Debian's Chromium shows it: page_picture.py PAGE -o PICTURE.png

    page_picture.py report.html -o report.png [--width 1200] [--height 1000]
"""

import argparse
import asyncio
import sys
from pathlib import Path

from browser import browser


async def taken(page, picture, width, height):
    async with browser() as tab:
        shown = await tab()
        await shown.size(width, height)
        await shown.open(page.resolve().as_uri())
        await shown.wait_for("charts.every((c) => c.plot.bbox.width > 0)")
        await shown.screenshot(picture)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("page", type=Path)
    parser.add_argument("-o", "--output", type=Path, required=True)
    parser.add_argument("--width", type=int, default=1200)
    parser.add_argument("--height", type=int, default=1000)
    options = parser.parse_args()
    asyncio.run(taken(options.page, options.output, options.width, options.height))


if __name__ == "__main__":
    sys.exit(main())
