"""The live page: who is let in, and what they may say to Meshcat."""

import json
import math
import os
import re
import socket
import subprocess
import sys
import time
import urllib.request
from urllib.parse import urljoin

import msgpack
import psutil
import pytest

from drake_linefoot.errors import InputError
from drake_linefoot.lab.visualization.live import live_page
from drake_linefoot.lab.visualization.page_access import INDEX, is_ours
from drake_linefoot.lab.visualization.page_messages import order
from tests.helpers.page_client import origin_of, say, status_of, text_of, websocket_status

QUIT, SPEED = "Quit (Esc)", "ahead m/s"
MALFORMED = (b"\x81\xa4\x74\x79", b"", b"\xc1", b"\x93" * 4000, b"\xdd\xff\xff\xff\xff")


@pytest.fixture(scope="module")
def live():
    with live_page() as live:
        live.meshcat.AddButton(QUIT)
        live.meshcat.AddSlider(SPEED, -1.0, 1.0, 0.1, 0.0)
        yield live


def slider(value):
    return {"type": "slider", "name": SPEED, "value": value}


def test_the_page_and_what_it_needs_are_served(live):
    assert re.fullmatch(r"http://localhost:7\d{3}/[\w-]{22}/", live.url)
    assert status_of(live.url) == 200
    assert status_of(f"{live.url}nothing") == 404
    assert status_of(f"{live.url}../{'x' * 30}") in {400, 403, 404}


LISTENING = """
import psutil
from drake_linefoot.lab.visualization.live import live_page
with live_page() as live:
    this = psutil.Process()
    for process in (this, *this.children()):
        for c in process.net_connections("tcp"):
            if c.status == psutil.CONN_LISTEN:
                print(c.laddr.ip)
"""


def test_the_script_of_the_page_is_served(live):
    page = urllib.request.urlopen(live.url).read().decode()
    (script,) = re.findall(r'<script[^>]*src="([^"]+)"', page)
    with urllib.request.urlopen(urljoin(live.url, script)) as answer:
        assert "html" not in answer.headers.get("Content-Type", "")
        assert answer.headers["X-Content-Type-Options"] == "nosniff"
        assert "object-src 'none'" in answer.headers["Content-Security-Policy"]
        assert len(answer.read()) > 1e6


def test_nothing_but_loopback_is_listened_on():
    done = subprocess.run(
        [sys.executable, "-c", LISTENING], capture_output=True, text=True, check=True, timeout=60
    )
    addresses = done.stdout.split()
    assert len(addresses) >= 2  # Meshcat, and the page
    assert all(ip == "::1" or ip.startswith("127.") for ip in addresses)


@pytest.mark.skipif(sys.platform != "linux", reason="127.0.0.0/8 is loopback on Linux")
def test_meshcat_itself_is_not_where_it_is_looked_for(live):
    address = live.meshcat.web_url().removeprefix("http://").partition(":")[0]
    assert address.startswith("127.")
    assert address != "127.0.0.1"
    with live_page() as other:
        assert other.meshcat.web_url().partition(":")[2] != live.meshcat.web_url()
        assert other.url != live.url


def test_without_the_token_nothing_is_let_in(live):
    wrong = re.sub(r"/[\w-]{22}/", f"/{'x' * 22}/", live.url)
    for url in (wrong, f"{origin_of(live.url)}/", f"{origin_of(live.url)}/favicon.ico"):
        assert status_of(url) == 403
        assert websocket_status(url) == 403


@pytest.mark.parametrize("origin", ["http://evil.example", "https://localhost", "null"])
def test_another_page_is_refused(live, origin):
    assert websocket_status(live.url, Origin=origin) == 403
    assert status_of(live.url, Origin=origin) == 403
    assert websocket_status(live.url, Origin=origin_of(live.url)) == 101


def test_another_name_of_this_machine_is_refused(live):
    """As of a page whose name was made to lead here: it has the origin that it names."""
    headers = {"Host": "evil.example:7000", "Origin": "http://evil.example:7000"}
    assert status_of(live.url, **headers) == 403
    assert websocket_status(live.url, **headers) == 403


@pytest.mark.parametrize(
    ("host", "listens_on", "ours"),
    [
        ("localhost:7000", "localhost", True),
        ("127.0.0.1:8000", "localhost", True),
        ("[::1]:7000", "localhost", True),
        ("192.168.0.7:7000", "localhost", False),
        ("127.0.0.1.evil.example", "localhost", False),
        ("", "localhost", False),
        ("[", "localhost", False),
        ("192.168.0.7:7000", "0.0.0.0", True),
        ("evil.example:7000", "0.0.0.0", False),
        ("robot.lan:7000", "robot.lan", True),
        (f"{socket.gethostname()}:7000", "0.0.0.0", True),
    ],
)
def test_names_of_this_server(host, listens_on, ours):
    assert is_ours(host, listens_on) is ours


def test_a_stranger_cannot_quit(live):
    clicks = live.meshcat.GetButtonClicks(QUIT)
    assert websocket_status(live.url, Origin="http://evil.example") == 403
    assert live.meshcat.GetButtonClicks(QUIT) == clicks
    say(live.url, {"type": "button", "name": QUIT})
    assert live.meshcat.GetButtonClicks(QUIT) == clicks + 1


def test_sliders_move_within_reason(live):
    say(live.url, slider(0.5))
    assert live.meshcat.GetSliderValue(SPEED) == 0.5
    for value in (math.nan, math.inf, "1", None, [1.0], True, {}):
        say(live.url, slider(value), wait=0.1)
        assert live.meshcat.GetSliderValue(SPEED) == 0.5
    say(live.url, slider(1e300))
    assert live.meshcat.GetSliderValue(SPEED) == 1e6


def test_malformed_messages_change_nothing(live):
    """The first of them, straight to Meshcat, ends its process: see docs/drake_meshcat_abort.md."""
    for message in MALFORMED:
        say(live.url, message, wait=0.1)
    say(live.url, {"type": "camera_pose", "camera_pose": [0.0] * 16, "is_perspective": True})
    assert websocket_status(live.url) == 101
    assert live.meshcat.GetTrackedCameraPose() is None
    say(live.url, slider(0.25))
    assert live.meshcat.GetSliderValue(SPEED) == 0.25


def test_what_meshcat_shows_is_passed_on(live):
    live.meshcat.SetProperty("/here", "visible", True)
    heard = say(live.url)
    assert {"set_property", "set_control", "show_realtime_rate"} <= set(heard)


def test_a_client_that_does_not_read_is_left(live):
    port = int(origin_of(live.url).rpartition(":")[2])
    token = live.url.rstrip("/").rpartition("/")[2]
    children = psutil.Process().children()
    (server,) = (c for c in children if any(s.laddr.port == port for s in c.net_connections()))
    with socket.create_connection(("127.0.0.1", port)) as client:
        client.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        lines = f"GET /{token}/ HTTP/1.1", f"Host: localhost:{port}", "Upgrade: websocket"
        key = "Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA=="
        more = "Connection: Upgrade", "Sec-WebSocket-Version: 13", key
        client.sendall("\r\n".join((*lines, *more, "", "")).encode())
        assert client.recv(12) == b"HTTP/1.1 101"
        before = server.memory_info().rss, psutil.Process().memory_info().rss
        time.sleep(2.5)  # the scene is through
        for _ in range(400):
            live.meshcat.SetProperty("/here", "position", [0.0] * 25_000)  # 225 kB
            live.meshcat.Flush()
        grown = server.memory_info().rss - before[0], psutil.Process().memory_info().rss - before[1]
    assert max(grown) < 60e6
    assert websocket_status(live.url) == 101


def test_a_port_is_taken_or_refused(live):
    port = int(origin_of(live.url).rpartition(":")[2])
    for number, allowed in ((port, "is taken, or not allowed"), (22, "must be 1024 or more")):
        with (
            pytest.raises(InputError, match=rf"--port = {number}: {allowed}"),
            live_page(port=number),
        ):
            pass
    with (
        pytest.raises(InputError, match=r"--host = '192\.0\.2\.1': cannot be listened on"),
        live_page("192.0.2.1"),
    ):
        pass


def test_it_is_opened_to_others_when_that_is_asked_for():
    with live_page("0.0.0.0") as live:
        assert live.open
        assert socket.gethostname() in live.url
        port = origin_of(live.url).rpartition(":")[2]
        token = live.url.rstrip("/").rpartition("/")[2]
        assert status_of(f"http://127.0.0.1:{port}/{token}/") == 200
        assert status_of(f"http://127.0.0.1:{port}/{'x' * 22}/") == 403


def test_its_server_ends_with_the_program(tmp_path):
    code = (
        "import os; from drake_linefoot.lab.visualization.live import live_page\n"
        "with live_page() as live: print(live.url, flush=True); os.kill(os.getpid(), 9)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == -9
    port = int(origin_of(done.stdout.strip()).rpartition(":")[2])
    end = time.monotonic() + 10.0
    while time.monotonic() < end:
        with socket.socket() as client:
            if client.connect_ex(("127.0.0.1", port)):
                break
        time.sleep(0.05)
    else:
        pytest.fail("it still listens")


def test_the_server_does_not_import_drake():
    code = "import sys, drake_linefoot.lab.visualization.page_server;"
    code += "sys.exit('pydrake' in sys.modules or 'numpy' in sys.modules)"
    subprocess.run([sys.executable, "-c", code], check=True, timeout=60, env={**os.environ})


def test_messages_are_made_anew():
    from drake_linefoot.lab.visualization.page_messages import checked

    more = {"type": "button", "name": "X", "camera_pose": [1.0]}
    assert msgpack.unpackb(checked(msgpack.packb(more))) == {"type": "button", "name": "X"}


def test_orders_of_a_driving_page_are_made_anew():
    good = ({"press": "stop"}, {"set": ["left", 0.2]}, {"stick": [0.0, 1.0, -1.0]}, {"drag": None})
    assert [order(json.dumps(each)) for each in good] == list(good)
    assert order('{"stick": [9, -9, 0]}') == {"stick": [1.0, -1.0, 0.0]}
    assert order('{"set": ["left", 1e300]}') == {"set": ["left", 1e6]}
    assert order(f'{{"set": ["left", -1{"0" * 400}]}}') == {"set": ["left", -1e6]}
    bad = (
        *("", "[]", "{}", "\\u0000", "[" * 4000, '{"press": 1}', '{"press": "a", "drag": null}'),
        *('{"set": ["left", NaN]}', '{"set": ["left", true]}', '{"set": [1, 1]}', '{"drag": [1]}'),
        *('{"stick": [0, 0, Infinity]}', '{"quit": 1}', json.dumps({"press": "x" * 5000})),
    )
    assert [order(each) for each in bad] == [None] * len(bad)
    assert order(b"\xff\xfe{") is None


def test_the_driving_page_is_served_with_its_files_alone(live):
    page = f"{live.url}view/"
    for name in ("", "live.js", "scene.js", "page.css"):
        assert status_of(page + name) == 200
    index = live.link.files / INDEX
    index.write_text("a page of its own")
    assert text_of(page) == "a page of its own"
    index.unlink()
    assert "live.js" in text_of(page)
    (live.link.files / "log.arrow").write_bytes(b"log")
    assert status_of(f"{page}files/log.arrow") == 200
    for name in (
        "files/",
        "files/index.html",
        "files/none",
        "../page.html",
        "files/../log.arrow",
        "x/live.js",
    ):
        assert status_of(page + name) in {400, 403, 404}, name
    assert status_of(page, Origin="http://evil.example") == 403
    assert websocket_status(page, Origin="http://evil.example") == 403
    assert websocket_status(page.replace("/view/", "x/view/")) == 403


def test_what_a_driving_page_orders_comes_out_checked(live):
    live.link.show("setup", {"sliders": []})
    live.link.orders()
    say(f"{live.url}view/", b'{"set": ["left", 0.5]}', b"nonsense", b'{"press": "stop"}')
    end = time.monotonic() + 10.0
    orders = []
    while len(orders) < 2 and time.monotonic() < end:
        orders += live.link.orders()
        time.sleep(0.02)
    assert orders[:2] == [{"set": ["left", 0.5]}, {"press": "stop"}]
