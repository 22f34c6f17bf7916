"""The server of a live page, which stands before Drake's Meshcat: a program of its own.

Drake's Meshcat answers everybody, keeps what slow clients have not read, and ends its process at a
malformed message. So it listens where nobody looks, and browsers come here: who does not know the
token in the address, or comes from another page, or by another name, is refused; what a page says
is checked (`page_messages`); who does not read is disconnected.

`python -m drake_linefoot.lab.visualization.page_server` reads a line of JSON, the `Settings`, from
stdin, answers with one, `{"port": ...}` or `{"error": ...}`, and serves until stdin ends. A further
line goes to every page around Meshcat's (TOKEN/view/); what such a page says comes out as a line.
"""

import asyncio
import json
import os
import socket
import sys
import threading
import time
from pathlib import Path
from typing import Any, ClassVar

from tornado.httpclient import AsyncHTTPClient
from tornado.httpserver import HTTPServer
from tornado.netutil import bind_sockets
from tornado.web import Application, RequestHandler
from tornado.websocket import WebSocketClosedError, websocket_connect

from drake_linefoot.lab.visualization.page_access import INDEX, PATH, Guarded, Settings, set_headers
from drake_linefoot.lab.visualization.page_messages import LARGEST_MESSAGE, checked, order

BACKLOG = 32_000_000  # [bytes] that a client may leave unread, beside the scene
SCENE_TIME = 2.0  # [s] in which the scene comes, whose size has no limit
PER_MESSAGE = 100  # [bytes] to keep one, beside its content
LARGEST_ANSWER = 2**30  # [bytes] of Meshcat
LAST_WORDS = 0.2  # [s] in which the last line goes out
PASSED_HEADERS = ("Content-Type", "Content-Disposition", "Cache-Control", "Meshcat-Cas-Filename")
MOST_WAITING = 256  # lines that a page may leave unread
WEB = Path(__file__).with_name("web")  # the page around Meshcat's
KINDS = {".html": "text/html", ".js": "text/javascript", ".css": "text/css"}


class LivePage(Guarded):
    """Passes on Meshcat's page and its files, and the messages of its websocket."""

    clients: ClassVar[set[Any]] = set()

    async def answer(self, name: str) -> None:
        """Answer with a file of Meshcat's."""
        if not PATH.fullmatch(name):
            self.send_error(404)
            return
        address = f"http://{self.settings['given'].meshcat}/{name}"
        answer = await self.settings["http"].fetch(address, raise_error=False)
        self.set_status(answer.code)
        self.set_header("Content-Type", KINDS[".js"])  # Meshcat's script has none itself
        for header in PASSED_HEADERS:
            if header in answer.headers:
                self.set_header(header, answer.headers[header])
        self.finish(answer.body or b"")

    async def open(self, *path: str) -> None:
        """Connect to Meshcat, and begin to pass on what it says."""
        self.clients.add(self)
        self.set_nodelay(True)
        self._unread: asyncio.Queue[bytes] = asyncio.Queue()
        self._backlog, self._allowed = 0, BACKLOG
        self._tasks: list[asyncio.Task[None]] = []
        address = f"ws://{self.settings['given'].meshcat}/"
        self._meshcat = await websocket_connect(address, max_message_size=LARGEST_ANSWER)
        self._tasks = [asyncio.create_task(work()) for work in (self._receive, self._send)]

    def on_message(self, message: bytes | str) -> None:
        """Pass on what a page may say."""
        passed = checked(message)
        if passed is not None:
            self._meshcat.write_message(passed, binary=True)

    def on_close(self) -> None:
        """Leave Meshcat."""
        self.clients.discard(self)
        for task in self._tasks:
            task.cancel()
        if self._tasks:
            self._meshcat.close()

    async def _receive(self) -> None:
        """Take what Meshcat says at once, so that it keeps nothing."""
        loop = asyncio.get_running_loop()
        begun = loop.time()
        while isinstance(message := await self._meshcat.read_message(), bytes):
            cost = len(message) + PER_MESSAGE
            self._allowed += cost if loop.time() < begun + SCENE_TIME else 0
            self._backlog += cost
            if self._backlog > self._allowed:
                break
            self._unread.put_nowait(message)
        self._unread = asyncio.Queue()
        self.close()

    async def _send(self) -> None:
        """Let the browser have it, as fast as it reads."""
        try:
            while True:
                message = await self._unread.get()
                await self.write_message(message, binary=True)
                self._backlog -= len(message) + PER_MESSAGE
        except WebSocketClosedError:
            self.close()


class View(Guarded):
    """The page around Meshcat's: its files, what can be downloaded, and the lines of its socket."""

    clients: ClassVar[set[Any]] = set()
    last: ClassVar[dict[str, str]] = {}  # of each kind of line, for a page that comes later

    async def answer(self, name: str) -> None:
        """Answer with a file of the page, or one that can be downloaded."""
        files = self.settings["given"].files
        folder = Path(files) if name.startswith("files/") and files else WEB
        file = folder / (name.removeprefix("files/") or "page.html")
        if not name and files and (Path(files) / INDEX).is_file():
            folder, file = Path(files), Path(files) / INDEX
        if not PATH.fullmatch(name) or file.parent != folder or not file.is_file():
            self.send_error(404)
            return
        self.set_header("Content-Type", KINDS.get(file.suffix, "application/octet-stream"))
        self.set_header("Cache-Control", "no-store")
        if name and folder is not WEB:
            self.set_header("Content-Disposition", f'attachment; filename="{file.name}"')
        self.finish(file.read_bytes())

    async def open(self, *path: str) -> None:
        """Begin with the last line of each kind."""
        self.set_nodelay(True)
        self._waiting = 0
        self._tasks: set[asyncio.Task[None]] = set()
        self.clients.add(self)
        for line in View.last.values():
            self.hand(line)

    def on_message(self, message: bytes | str) -> None:
        """Pass on what a page may order."""
        passed = order(message)
        if passed is not None:
            say(passed)

    def on_close(self) -> None:
        """Let it go, and what it held."""
        self.clients.discard(self)
        say({"drag": None, "stick": None})

    def hand(self, line: str) -> None:
        """Send a line; a page that does not read is left."""
        if self._waiting >= MOST_WAITING:
            self.close()
            return
        self._waiting += 1
        task = asyncio.create_task(self._send(line))
        self._tasks.add(task)  # or it may be collected
        task.add_done_callback(self._tasks.discard)

    async def _send(self, line: str) -> None:
        try:
            await self.write_message(line)
        except WebSocketClosedError:
            return
        self._waiting -= 1

    @staticmethod
    def broadcast(line: str) -> None:
        """Send a line, `{kind: content}`, to every page."""
        View.last[next(iter(json.loads(line)))] = line
        for page in list(View.clients):
            page.hand(line)


def say(answer: dict[str, Any]) -> None:
    """Answer the program that started this one."""
    print(json.dumps(answer), flush=True)


class Refused(RequestHandler):
    """What is beside the page's path."""

    def set_default_headers(self) -> None:
        """Let no other page have what is served."""
        set_headers(self)

    def prepare(self) -> None:
        """Say nothing of what there is."""
        self.send_error(403)


def listen(settings: Settings) -> list[socket.socket]:
    """Return sockets that listen on the first port that is free.

    Raises:
        OSError: there is none.
    """
    *others, last = settings.ports
    for port in others:
        try:
            return bind_sockets(port, settings.host)
        except OSError:
            continue
    return bind_sockets(last, settings.host)


async def serve(settings: Settings) -> None:
    """Serve until the process ends."""
    sockets = listen(settings)
    application = Application(
        [(r"/([^/]+)/view/(.*)", View), (r"/([^/]+)/(.*)", LivePage), (r".*", Refused)],
        log_function=lambda handler: None,
        websocket_max_message_size=LARGEST_MESSAGE,
        given=settings,
        http=AsyncHTTPClient(max_body_size=LARGEST_ANSWER),
    )
    server = HTTPServer(application, max_body_size=0, max_header_size=16384)
    server.add_sockets(sockets)
    loop = asyncio.get_running_loop()
    threading.Thread(target=read_lines, args=(loop,), daemon=True).start()
    say({"port": sockets[0].getsockname()[1]})
    await asyncio.Event().wait()


def read_lines(loop: asyncio.AbstractEventLoop) -> None:
    """Broadcast what the program says that started this one, and end with it."""
    for line in sys.stdin:
        loop.call_soon_threadsafe(View.broadcast, line.strip())
    time.sleep(LAST_WORDS)
    os._exit(0)


if __name__ == "__main__":
    given = Settings(**json.loads(sys.stdin.readline()))
    try:
        asyncio.run(serve(given))
    except OSError as problem:
        say({"error": problem.strerror or str(problem)})
