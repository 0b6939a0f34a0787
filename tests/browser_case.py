"""What tests of a page have in common: Debian's Chromium at it, a tab, a folder.

Whoever imports this ends with exit status 77 where aiohttp or Chromium is not installed."""

import logging
import sys
import tempfile
import unittest
from contextlib import AsyncExitStack
from pathlib import Path

SCRIPTS = Path(__file__).resolve().parents[1] / "scripts"
sys.dont_write_bytecode = True
sys.path.insert(0, str(SCRIPTS))

try:
    import browser
except ImportError:
    print("skipped: python3-aiohttp is not installed")
    sys.exit(77)
if not browser.PROGRAM:
    print("skipped: chromium is not installed")
    sys.exit(77)

logging.getLogger("asyncio").setLevel(logging.ERROR)  # unittest's loop tells of every slow step


class BrowserCase(unittest.IsolatedAsyncioTestCase):
    """`page`, a tab as wide as WIDTH pixels; what `stack` holds ends with the test."""

    WIDTH = 1300

    async def asyncSetUp(self):
        self.stack = AsyncExitStack()
        self.addAsyncCleanup(self.stack.aclose)
        self.folder = Path(self.stack.enter_context(tempfile.TemporaryDirectory()))
        tab = await self.stack.enter_async_context(browser.browser())
        self.page = await tab()
        await self.page.size(self.WIDTH, 900)
