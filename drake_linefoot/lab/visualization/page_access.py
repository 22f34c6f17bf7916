"""Who is let in to a live page: who knows its token, comes from this page and by its name."""

import hmac
import ipaddress
import re
import socket
from typing import Any, ClassVar, NamedTuple
from urllib.parse import urlsplit

from tornado.web import RequestHandler
from tornado.websocket import WebSocketHandler

MOST_CLIENTS = 16
INDEX = "index.html"  # of the files that a page is given: shown in place of the live page
PATH = re.compile(r"[A-Za-z0-9._-]*(/[A-Za-z0-9._-]+)*")
HEADERS = {
    "Referrer-Policy": "no-referrer",  # the address has the token
    "X-Frame-Options": "SAMEORIGIN",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cross-Origin-Opener-Policy": "same-origin",
    "X-Content-Type-Options": "nosniff",
    "Content-Security-Policy": "; ".join(
        [
            "default-src 'self' data: blob:",  # Meshcat's page has its textures in data: and blob:
            "script-src 'self' 'unsafe-inline' 'unsafe-eval'",
            "style-src 'self' 'unsafe-inline'",
            "connect-src 'self' ws: data: blob:",
            "worker-src 'self' blob:",
            *("object-src 'none'", "base-uri 'none'", "form-action 'none'"),
            "frame-ancestors 'self'",
        ]
    ),
}


class Settings(NamedTuple):
    """What the server is given."""

    host: str  # to listen on
    ports: list[int]  # the first one that is free is taken
    token: str  # first part of every path
    meshcat: str  # where Meshcat is, "127.1.2.3:4567"
    files: str = ""  # folder of what can be downloaded; empty for nothing


def set_headers(handler: RequestHandler) -> None:
    """Say that no other page may have what is served, nor it anything of theirs."""
    handler.clear_header("Server")
    for name, value in HEADERS.items():
        handler.set_header(name, value)


class Guarded(WebSocketHandler):
    """Lets in who knows the token, and comes from this page; not too many of a kind."""

    clients: ClassVar[set[Any]]  # of each kind, with a websocket

    async def get(self, *path: str) -> None:
        """Answer a browser, or open a websocket."""
        if self.request.headers.get("Upgrade", "").lower() != "websocket":
            await self.answer(path[-1])
        elif len(self.clients) >= MOST_CLIENTS:
            self.send_error(503)
        else:
            await super().get(*path)

    async def answer(self, name: str) -> None:
        """Answer a browser that asks for a file."""
        raise NotImplementedError

    def set_default_headers(self) -> None:
        """Let no other page have what is served."""
        set_headers(self)

    def prepare(self) -> None:
        """Refuse who does not know the token, or was sent by another page."""
        headers, settings = self.request.headers, self.settings["given"]
        host, origin = headers.get("Host", ""), headers.get("Origin")
        known = hmac.compare_digest(self.path_args[0].encode(), settings.token.encode())
        if not (known and is_ours(host, settings.host) and origin in {None, f"http://{host}"}):
            self.send_error(403)

    def check_origin(self, origin: str) -> bool:
        """Agree: `prepare` has checked it."""
        return True

    def get_compression_options(self) -> None:
        """Compress nothing: it is on this machine, or near."""


def is_ours(host: str, listens_on: str) -> bool:
    """Whether the host of a request is a name of this server's: others can be made to lead here."""
    try:
        name = urlsplit(f"//{host}").hostname or ""
    except ValueError:
        return False
    if is_loopback(listens_on):
        return name == "localhost" or (_is_address(name) and is_loopback(name))
    names = {"localhost", listens_on, socket.gethostname(), socket.getfqdn()}
    return name in {each.lower() for each in names} or _is_address(name)


def is_loopback(host: str) -> bool:
    """Whether only this machine can reach what listens on a host."""
    return host == "localhost" or (_is_address(host) and ipaddress.ip_address(host).is_loopback)


def _is_address(name: str) -> bool:
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return False
    return True
