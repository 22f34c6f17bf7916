"""The driving page's part of the server: its files, downloads, and the lines of its socket."""

import asyncio
import json
from pathlib import Path
from typing import Any, ClassVar

from tornado.websocket import WebSocketClosedError

from drake_linefoot.visualization.page_access import PATH, Guarded
from drake_linefoot.visualization.page_messages import order

MOST_WAITING = 256  # lines that a driving page may leave unread
WEB = Path(__file__).with_name("web")  # the driving page
KINDS = {".html": "text/html", ".js": "text/javascript", ".css": "text/css"}


class DrivingPage(Guarded):
    """The page around Meshcat's: its files, what can be downloaded, and the lines of its socket."""

    clients: ClassVar[set[Any]] = set()
    last: ClassVar[dict[str, str]] = {}  # of each kind of line, for a page that comes later

    async def answer(self, name: str) -> None:
        """Answer with a file of the page, or one that can be downloaded."""
        name, files = name or "drive.html", self.settings["given"].files
        folder = Path(files) if name.startswith("files/") and files else WEB
        file = folder / name.removeprefix("files/")
        if not PATH.fullmatch(name) or file.parent != folder or not file.is_file():
            self.send_error(404)
            return
        self.set_header("Content-Type", KINDS.get(file.suffix, "application/octet-stream"))
        self.set_header("Cache-Control", "no-store")
        if folder is not WEB:
            self.set_header("Content-Disposition", f'attachment; filename="{file.name}"')
        self.finish(file.read_bytes())

    async def open(self, *path: str) -> None:
        """Begin with the last line of each kind."""
        self.set_nodelay(True)
        self._waiting = 0
        self._tasks: set[asyncio.Task[None]] = set()
        self.clients.add(self)
        for line in DrivingPage.last.values():
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
        DrivingPage.last[next(iter(json.loads(line)))] = line
        for page in list(DrivingPage.clients):
            page.hand(line)


def say(answer: dict[str, Any]) -> None:
    """Answer the program that started this one."""
    print(json.dumps(answer), flush=True)
