"""Debian's Chromium without a screen, over its DevTools protocol; for tests and figures of the live page."""

import asyncio
import base64
import shutil
import tempfile
from contextlib import AsyncExitStack, asynccontextmanager
from pathlib import Path

import aiohttp

PROGRAM = shutil.which("chromium")
PATIENCE_S = 60.0


class BrowserError(Exception):
    pass


class Page:
    """A tab."""

    def __init__(self, socket):
        self.socket = socket
        self.sent = 0
        self.complaints = []  # exceptions and what a policy has forbidden

    async def call(self, method, **parameters):
        self.sent += 1
        await self.socket.send_json({"id": self.sent, "method": method, "params": parameters})
        while True:
            answer = await self.socket.receive_json(timeout=PATIENCE_S)
            if answer.get("id") == self.sent:
                if "error" in answer:
                    raise BrowserError(f"{method}: {answer['error']['message']}")
                return answer["result"]
            if answer.get("method") in ("Runtime.exceptionThrown", "Log.entryAdded"):
                self.complaints.append(answer["params"])

    async def open(self, address):
        await self.call("Page.navigate", url=address)
        await self.wait_for("document.readyState === 'complete'")

    async def value(self, expression):
        """Of a JavaScript expression, as JSON can tell it."""
        answer = await self.call("Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True)
        if "exceptionDetails" in answer:
            raise BrowserError(str(answer["exceptionDetails"]))
        return answer["result"].get("value")

    async def text(self, selector):
        return await self.value(f"document.querySelector({selector!r})?.textContent")

    async def wait_for(self, expression):
        end = asyncio.get_running_loop().time() + PATIENCE_S
        while not (found := await self.value(expression)):
            if asyncio.get_running_loop().time() > end:
                raise BrowserError(f"did not happen within {PATIENCE_S:g} s: {expression}; {self.complaints}")
            await asyncio.sleep(0.05)
        return found

    async def size(self, width, height, mobile=False, dark=False):
        await self.call("Emulation.setDeviceMetricsOverride", width=width, height=height,
                        deviceScaleFactor=2 if mobile else 1, mobile=mobile)
        await self.call("Emulation.setEmulatedMedia", features=[
            {"name": "prefers-color-scheme", "value": "dark" if dark else "light"}])

    async def screenshot(self, path, whole=False):
        picture = await self.call("Page.captureScreenshot", format="png", captureBeyondViewport=whole)
        Path(path).write_bytes(base64.b64decode(picture["data"]))


@asynccontextmanager
async def browser():
    """A function that opens tabs."""
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        process = await asyncio.create_subprocess_exec(
            PROGRAM, "--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--no-first-run",
            "--disable-background-networking", "--disable-component-update", "--disable-extensions",
            "--remote-debugging-port=0", f"--user-data-dir={folder}", "about:blank",
            stdout=asyncio.subprocess.DEVNULL, stderr=asyncio.subprocess.DEVNULL)
        try:
            async with aiohttp.ClientSession() as session, AsyncExitStack() as stack:
                port = await devtools_port(Path(folder, "DevToolsActivePort"))

                async def tab():
                    async with session.put(f"http://127.0.0.1:{port}/json/new?about:blank") as answer:
                        address = (await answer.json())["webSocketDebuggerUrl"]
                    page = Page(await stack.enter_async_context(session.ws_connect(address, max_msg_size=0)))
                    for domain in ("Page", "Runtime", "Log"):
                        await page.call(domain + ".enable")
                    return page
                yield tab
        finally:
            process.terminate()
            await process.wait()


async def devtools_port(path):
    end = asyncio.get_running_loop().time() + PATIENCE_S
    while not (path.exists() and path.read_text().count("\n")):
        if asyncio.get_running_loop().time() > end:
            raise BrowserError("Chromium did not start")
        await asyncio.sleep(0.05)
    return int(path.read_text().splitlines()[0])
