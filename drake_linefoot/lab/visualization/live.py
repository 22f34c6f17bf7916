"""A page that shows what Meshcat draws, to those who have its address."""

import json
import secrets
import socket
import subprocess
import sys
import tempfile
import threading
from collections import deque
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, NamedTuple

from pydrake.geometry import Meshcat

from drake_linefoot.errors import InputError, LinefootError
from drake_linefoot.lab.visualization.page_access import Settings, is_loopback
from drake_linefoot.lab.visualization.view import open_meshcat

LOCAL = "localhost"
VIEW = "view/"  # path of the page around Meshcat's
PORTS = range(7000, 8000)  # of a page; the first free one
LOWEST_PORT = 1024  # below it a browser opens nothing, nor may everybody listen
ANY = {"0.0.0.0", "::", ""}  # hosts that stand for every address of the machine
MOST_ORDERS = 1000  # that wait; older ones are dropped
PROGRAM = (sys.executable, "-P", "-m", "drake_linefoot.lab.visualization.page_server")


class Link:
    """Talks with the live pages: what they show, what they order.

    Attributes:
        files: folder of what they can download; `page_access.INDEX` in it is shown instead of them.
    """

    def __init__(self, server: "subprocess.Popen[str]", files: Path) -> None:
        self.files, self._server = files, server
        self._orders: deque[dict[str, Any]] = deque(maxlen=MOST_ORDERS)
        threading.Thread(target=self._listen, daemon=True).start()

    def show(self, kind: str, content: Any) -> None:
        """Let every page show something; a page that comes later gets the last of each kind."""
        assert self._server.stdin is not None
        try:
            self._server.stdin.write(json.dumps({kind: content}) + "\n")
            self._server.stdin.flush()
        except BrokenPipeError:
            pass  # its server ended; the simulation goes on without pages

    def orders(self) -> list[dict[str, Any]]:
        """Return what was ordered since the last call, checked by `page_messages.order`."""
        return [self._orders.popleft() for _ in range(len(self._orders))]

    def _listen(self) -> None:
        assert self._server.stdout is not None
        for line in self._server.stdout:
            self._orders.append(json.loads(line))


class Live(NamedTuple):
    """A page that is served.

    Who knows the address may drive; `url` is of the page around Meshcat's.
    """

    meshcat: Meshcat  # what it shows; to be used by the thread that opened it
    url: str  # of Meshcat's page; with `VIEW` behind it that of ours
    open: bool  # whether other machines reach it
    link: Link  # with the pages


@contextmanager
def live_page(host: str = LOCAL, port: int | None = None) -> Iterator[Live]:
    """Serve a page inside the `with` block.

    Args:
        host: name or address to listen on; "localhost" is reached from this machine only, "0.0.0.0"
            from everywhere.
        port: of the page; None for the first free one of 7000 to 7999.

    Raises:
        InputError: the port or the host cannot be used.
        LinefootError: the page cannot be served.
    """
    if port is not None and port < LOWEST_PORT:
        raise InputError("--port", "", port, f"must be {LOWEST_PORT} or more")
    meshcat = open_meshcat()
    token, ports = secrets.token_urlsafe(16), list(PORTS) if port is None else [port]
    with (
        tempfile.TemporaryDirectory() as files,
        subprocess.Popen(
            PROGRAM,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
            start_new_session=True,  # Ctrl-C is for this process, which may show more until it ends
        ) as server,
    ):
        where = meshcat.web_url().removeprefix("http://")
        settings = Settings(host, ports, token, where, files)
        assert server.stdin is not None
        assert server.stdout is not None
        try:
            server.stdin.write(json.dumps(settings._asdict()) + "\n")
            server.stdin.flush()
            answer = json.loads(server.stdout.readline() or "{}")
            if "port" not in answer:
                raise _refusal(host, port, answer.get("error", "its server ended"))
            name = socket.gethostname() if host in ANY else host
            url = f"http://{f'[{name}]' if ':' in name else name}:{answer['port']}/{token}/"
            yield Live(meshcat, url, not is_loopback(host), Link(server, Path(files)))
        finally:
            with suppress(BrokenPipeError, subprocess.TimeoutExpired):
                server.stdin.close()  # it tells its pages what is left, and ends
                server.wait(1.0)
            server.kill()


def _refusal(host: str, port: int | None, reason: str) -> LinefootError:
    if port is not None and host == LOCAL:
        return InputError("--port", "", port, "is taken, or not allowed")
    if host != LOCAL:
        return InputError("--host", "", host, f"cannot be listened on: {reason}")
    return LinefootError(f"the live page cannot be served: {reason}")
