"""A page that shows what Meshcat draws, to those who have its address."""

import json
import secrets
import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import NamedTuple

from pydrake.geometry import Meshcat

from drake_linefoot.errors import InputError, LinefootError
from drake_linefoot.visualization.page_server import Settings, is_loopback
from drake_linefoot.visualization.view import open_meshcat

LOCAL = "localhost"
PORTS = range(7000, 8000)  # of a page; the first free one
LOWEST_PORT = 1024  # below it a browser opens nothing, nor may everybody listen
ANY = {"0.0.0.0", "::", ""}  # hosts that stand for every address of the machine
PROGRAM = (sys.executable, "-P", "-m", "drake_linefoot.visualization.page_server")


class Live(NamedTuple):
    """A page that is served.

    Attributes:
        meshcat: what it shows; to be used by the thread that opened it.
        url: of the page; who knows it may drive.
        open: whether other machines reach it.
    """

    meshcat: Meshcat
    url: str
    open: bool


@contextmanager
def live_page(host: str = LOCAL, port: int | None = None, stats: bool = False) -> Iterator[Live]:
    """Serve a page inside the `with` block.

    Args:
        host: name or address to listen on; "localhost" is reached from this machine only, "0.0.0.0"
            from everywhere.
        port: of the page; None for the first free one of 7000 to 7999.
        stats: whether it shows how fast it draws.

    Raises:
        InputError: the port or the host cannot be used.
        LinefootError: the page cannot be served.
    """
    if port is not None and port < LOWEST_PORT:
        raise InputError("--port", "", port, f"must be {LOWEST_PORT} or more")
    meshcat = open_meshcat(stats=stats)
    token, ports = secrets.token_urlsafe(16), list(PORTS) if port is None else [port]
    settings = Settings(host, ports, token, meshcat.web_url().removeprefix("http://"))
    # A session of its own: Ctrl-C is for this process, which may show more until it ends.
    with subprocess.Popen(
        PROGRAM,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
        start_new_session=True,
    ) as server:
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
            yield Live(meshcat, url, not is_loopback(host))
        finally:
            server.kill()


def _refusal(host: str, port: int | None, reason: str) -> LinefootError:
    if port is not None and host == LOCAL:
        return InputError("--port", "", port, "is taken, or not allowed")
    if host != LOCAL:
        return InputError("--host", "", host, f"cannot be listened on: {reason}")
    return LinefootError(f"the live page cannot be served: {reason}")
