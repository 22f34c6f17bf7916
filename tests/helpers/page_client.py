"""A client of a live page that is no browser: what it asks for, sends and is sent."""

import asyncio
import contextlib
import http.client
import urllib.request
from concurrent.futures import ThreadPoolExecutor
from urllib.parse import urlsplit

import msgpack
from tornado.httpclient import HTTPRequest
from tornado.websocket import websocket_connect

UPGRADE = {
    "Upgrade": "websocket",
    "Connection": "Upgrade",
    "Sec-WebSocket-Version": "13",
    "Sec-WebSocket-Key": "AAAAAAAAAAAAAAAAAAAAAA==",
}


def status_of(url, **headers):
    """Return the status of a GET."""
    parts = urlsplit(url)
    connection = http.client.HTTPConnection(parts.hostname, parts.port, timeout=20.0)
    with contextlib.closing(connection):
        connection.request("GET", parts.path, headers=headers)
        return connection.getresponse().status


def text_of(url):
    """Return what a GET is answered with."""
    with urllib.request.urlopen(url, timeout=20.0) as answer:
        return answer.read().decode()


def websocket_status(url, **headers):
    """Return the status with which a websocket is opened, 101, or refused."""
    return status_of(url, **UPGRADE, **headers)


def origin_of(url):
    return f"http://{urlsplit(url).netloc}"


def say(url, *messages, wait=0.5):
    """Send messages, packed when they are not bytes; return the types of what was sent back."""

    async def talk():
        address = url.replace("http://", "ws://", 1)
        request = HTTPRequest(address, headers={"Origin": origin_of(url)})
        socket = await websocket_connect(request, max_message_size=2**28)
        for message in messages:
            raw = message if isinstance(message, bytes) else msgpack.packb(message)
            await socket.write_message(raw, binary=True)
        heard = []

        async def listen():
            while (message := await socket.read_message()) is not None:
                if isinstance(message, bytes):  # a driving page gets lines
                    heard.append(msgpack.unpackb(message, strict_map_key=False).get("type"))

        listening = asyncio.create_task(listen())
        await asyncio.wait([listening], timeout=wait)
        socket.close()
        await asyncio.wait_for(listening, 20.0)
        return heard

    with ThreadPoolExecutor(1) as thread:  # playwright's has an event loop of its own
        return thread.submit(lambda: asyncio.run(talk())).result()
