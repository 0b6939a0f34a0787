#!/usr/bin/python3
"""A page that shows an estimate while it runs: parameters with bands, innovations, NIS, states, changes.

    armukf run.csv | live.py                              then open http://127.0.0.1:8765
    tail -f live.csv | armukf --watch --events events.jsonl | live.py --events events.jsonl --pass > rows.csv
    live.py rows.csv --follow                             rows that another program writes

It is a script beside the filter, not a part of it: nothing that serves pages runs in the process that keeps time
with a robot; any number of people look at once; and `ssh robot armukf ... | live.py` puts page and filter on
two machines.

Reads the rows of `armukf estimate`, thins them as they come (live_history.py says how and what is kept) and sends
browsers what is new ten times a second. Needs no internet. Listens on this machine only, unless --host says
otherwise; there is no password, so rather reach it through `ssh -L 8765:localhost:8765 robot`.

Goes on showing what there was when the stream has ended; --until-end ends with it. SIGINT and SIGTERM end it,
with --pass when the rows that are on their way have gone through; a second one ends it at once.
"""

import argparse
import asyncio
import errno
import fcntl
import json
import os
import select
import signal
import stat
import sys
import time
from array import array
from contextlib import suppress
from pathlib import Path
from urllib.parse import urlsplit

from aiohttp import WSMsgType, web

from live_columns import InputError
from live_stream import Events, Stream, shown_name

PAGE = Path(__file__).resolve().parent / "live_page"
ASSETS = {"/": ("page.html", "text/html"), "/page.css": ("page.css", "text/css"),
          "/colours.css": ("colours.css", "text/css"), "/drawing.js": ("drawing.js", "text/javascript"),
          "/uPlot.min.css": ("uPlot.min.css", "text/css"),
          "/uPlot.iife.min.js": ("uPlot.iife.min.js", "text/javascript"),
          "/history.js": ("history.js", "text/javascript"), "/charts.js": ("charts.js", "text/javascript"),
          "/page.js": ("page.js", "text/javascript")}
# Only what comes from here may run or be loaded, and no text becomes markup.
POLICY = ("default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; img-src data:; "
          "base-uri 'none'; form-action 'none'; frame-ancestors 'none'; require-trusted-types-for 'script'")
HEADERS = {"Content-Security-Policy": POLICY, "X-Content-Type-Options": "nosniff", "Cache-Control": "no-store",
           "Referrer-Policy": "no-referrer"}
HERE = {"127.0.0.1", "localhost", "::1"}

MOST_BYTES = 1 << 16   # of a piece that is read at once; holes of more would not be filled again
PLENTY_BYTES = 1 << 15  # after which more is read without a pause
PIPE_BYTES = 1 << 20   # that a filter can be ahead of this page before it has to wait: most of a second at 2 kHz
PAUSE_S = 0.02         # between pieces otherwise: a filter writes each row at once, and a read a row costs too much
FRAME_S = 0.1          # between what a browser is sent
TABLE_S = 1.0          # between tables of arms
HEARTBEAT_S = 20.0     # after twice as long a browser that is gone is given up


def go_on(path, fd):
    """At the end of a file that is still written: it may have been cut, or another may have its name now."""
    if not stat.S_ISREG(os.fstat(fd).st_mode):
        return
    if os.fstat(fd).st_size < os.lseek(fd, 0, os.SEEK_CUR):
        os.lseek(fd, 0, os.SEEK_SET)
    with suppress(FileNotFoundError):  # the other is not there yet
        if os.stat(path).st_ino != os.fstat(fd).st_ino:
            other = os.open(path, os.O_RDONLY)
            os.dup2(other, fd)
            os.close(other)


async def pieces(fd, path=None):
    """What can be read, as it comes; with a path, also after its end."""
    while True:
        ready = select.select([fd], [], [], 0)[0]
        piece = os.read(fd, MOST_BYTES) if ready else None
        if piece:
            yield piece
        elif piece == b"" and path is None:
            return
        elif piece == b"":
            go_on(path, fd)
        await asyncio.sleep(PAUSE_S if not piece or len(piece) < PLENTY_BYTES else 0)


class Live:
    """A stream, its events, and what the pages are told of them."""

    def __init__(self):
        self.stream = Stream()
        self.events = Events()
        self.table, self.table_made = [], 0.0

    async def read_rows(self, fd, options):
        async for piece in pieces(fd, options.file if options.follow and options.file != "-" else None):
            if options.passes:
                await asyncio.to_thread(write_all, piece)
            try:
                self.stream.feed(piece, time.monotonic())
            except InputError as error:
                raise InputError(f"{options.file}:{self.stream.lines}: {error}") from None
        self.stream.end()
        if options.passes:
            os.close(sys.stdout.fileno())

    async def read_events(self, path):
        while not os.path.exists(path):  # the filter makes it
            await asyncio.sleep(FRAME_S)
        async for piece in pieces(os.open(path, os.O_RDONLY | os.O_NONBLOCK), path):
            for event in self.events.feed(piece):
                if arm := self.stream.arms.get(str(event.get("arm", "")).encode()):
                    arm.change = str(event.get("what", ""))

    async def close_late_bins(self):
        while True:
            await asyncio.sleep(FRAME_S)
            self.stream.close_late(time.monotonic())

    def arms_table(self):
        if (now := time.monotonic()) - self.table_made >= TABLE_S:
            self.table, self.table_made = self.stream.table(now), now
        return self.table

    def arm_for(self, name):
        """The one of that name, or the worst; its name and itself."""
        if (arm := self.stream.arms.get(name.encode())) or not self.stream.arms:
            return name, arm
        worst = self.arms_table()[0]["arm"] if self.stream.layout.keyed and self.arms_table() else ""
        return worst, self.stream.arms.get(worst.encode())


class Viewer:
    """One browser: what it looks at, and what it has been sent."""

    def __init__(self, live, socket):
        self.live, self.socket = live, socket
        self.name, self.wanted = None, ""
        self.history, self.cursor = None, 0
        self.events_sent, self.table_sent = 0, 0.0

    async def feed(self):
        while True:
            text, bins = self.frame()
            await self.socket.send_str(json.dumps(text))
            if bins is not None:
                await self.socket.send_bytes(bins)
            await asyncio.sleep(FRAME_S)

    def frame(self):
        """What is new: JSON, and bins as doubles: 1 if they are all there are or else 0, then one after another."""
        stream, events = self.live.stream, self.live.events
        text = {"malformed": stream.malformed + events.malformed, "ended": stream.ended, "arms": len(stream.arms)}
        if new := events.since(self.events_sent):
            text["events"], self.events_sent = new, events.count
        if stream.layout and stream.layout.keyed and self.live.arms_table() and \
                self.table_sent != self.live.table_made:
            text["table"], self.table_sent = self.live.table, self.live.table_made
        self.name, arm = self.live.arm_for(self.wanted)
        if not arm:
            return text, None
        text["arm"], text["counts"] = shown_name(self.name.encode()), arm.counts
        if arm.history is not self.history:
            self.history, self.cursor, self.wanted = arm.history, -1, self.name
            text["layout"] = arm.layout.told()
        bins, anew = self.history.since(self.cursor)
        self.cursor = self.history.written
        return text, b"".join([array("d", [anew]), *bins]) if bins or anew else None


def forbidden(request):
    """Why a request is none of a page of ours: another site's page may not look through the user's browser."""
    host = urlsplit("//" + request.host)
    if request.app["here"] and host.hostname not in HERE:
        return "unknown host"
    origin = request.headers.get("Origin")
    if origin is not None and urlsplit(origin).netloc != request.host:
        return "another site"
    return None


@web.middleware
async def only_ours(request, handler):
    if reason := forbidden(request):
        raise web.HTTPForbidden(text=reason)
    return await handler(request)


async def watch(request):
    """A page's socket: frames go out, the name of the arm to show comes in."""
    socket = web.WebSocketResponse(heartbeat=HEARTBEAT_S, compress=False, max_msg_size=4096)
    await socket.prepare(request)
    viewer = Viewer(request.app["live"], socket)
    feeding = asyncio.create_task(viewer.feed())
    try:
        async for message in socket:
            if message.type == WSMsgType.TEXT:
                viewer.wanted = message.data
    finally:
        feeding.cancel()
        await asyncio.gather(feeding, return_exceptions=True)
    return socket


def application(live, here):
    app = web.Application(middlewares=[only_ours])
    app["live"], app["here"] = live, here

    async def guarded(_request, response):
        response.headers.update(HEADERS)
    app.on_response_prepare.append(guarded)
    for address, (name, kind) in ASSETS.items():
        content = (PAGE / name).read_bytes()

        async def asset(_request, content=content, kind=kind):
            return web.Response(body=content, content_type=kind, charset="utf-8")
        app.router.add_get(address, asset)
    app.router.add_get("/stream", watch)
    return app


async def listening(app, host, port):
    """What serves the pages."""
    runner = web.AppRunner(app, access_log=None)
    await runner.setup()
    try:
        await web.TCPSite(runner, host, port, shutdown_timeout=1.0).start()
    except OSError as error:
        if error.errno == errno.EADDRINUSE:
            raise InputError(f"port {port} is in use, perhaps by another page; --port takes another") from None
        raise InputError(f"{host}:{port}: {error.strerror or error}") from None
    return runner


def write_all(piece):
    while piece:
        piece = piece[os.write(sys.stdout.fileno(), piece):]


def opened(name):
    if name == "-" and sys.stdin.isatty():
        raise InputError("no rows: armukf run.csv | live.py")
    try:
        fd = sys.stdin.fileno() if name == "-" else os.open(name, os.O_RDONLY)
    except OSError as error:
        raise InputError(f"{name}: {error.strerror}") from None
    with suppress(OSError):  # what is no pipe has no size
        fcntl.fcntl(fd, fcntl.F_SETPIPE_SZ, PIPE_BYTES)
    return fd


async def serve(options):
    rows, live, stop = opened(options.file), Live(), asyncio.Event()
    runner = await listening(application(live, options.host in HERE), options.host, options.port)
    host, port = runner.addresses[0][:2]
    print(f"live: http://{f'[{host}]' if ':' in host else host}:{port}", file=sys.stderr, flush=True)

    def asked_to_stop():
        if stop.is_set():
            os._exit(1)
        stop.set()
    for number in (signal.SIGINT, signal.SIGTERM):
        asyncio.get_running_loop().add_signal_handler(number, asked_to_stop)
    reading = asyncio.create_task(live.read_rows(rows, options))
    beside = [asyncio.create_task(live.close_late_bins()), asyncio.create_task(stop.wait())]
    beside += [asyncio.create_task(live.read_events(options.events))] if options.events else []
    await first_of(reading, *beside)
    if not stop.is_set() and not options.until_end:
        await first_of(*beside)
    elif options.passes:
        await reading
    for task in (reading, *beside):
        task.cancel()
    await runner.cleanup()


async def first_of(*tasks):
    """Waits for one of them; what went wrong in it is raised."""
    done, _ = await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
    for task in done:
        task.result()


def port_number(text):
    if not text.isdecimal() or int(text) > 65535:
        raise argparse.ArgumentTypeError(f"'{text}' is no port, 0 to 65535")
    return int(text)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("file", nargs="?", default="-", metavar="ROWS.csv", help="- or nothing is standard input")
    parser.add_argument("--follow", action="store_true", help="ROWS.csv is still written: wait for more")
    parser.add_argument("--events", metavar="FILE", help="what `armukf estimate --watch --events FILE` writes; "
                        "a FIFO will do")
    parser.add_argument("--pass", dest="passes", action="store_true", help="pass rows on to standard output")
    parser.add_argument("--until-end", action="store_true", help="end with the stream")
    parser.add_argument("--port", type=port_number, metavar="PORT", default=8765,
                        help="8765 by default; 0 takes one that is free")
    parser.add_argument("--host", default="127.0.0.1", help="address to listen on, 127.0.0.1 by default")
    asyncio.run(serve(parser.parse_args()))


if __name__ == "__main__":
    try:
        main()
    except InputError as error:
        print(f"live.py: {error}", file=sys.stderr)
        sys.exit(2)
    except OSError as error:
        sys.exit(f"live.py: {error}")
