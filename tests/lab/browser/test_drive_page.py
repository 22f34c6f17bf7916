"""The driving page in a browser: keys change the command, and the robot follows."""

import re
import threading
import time

import pytest

from drake_linefoot.lab.drive.drive import Drive
from drake_linefoot.lab.scenario import Scenario
from drake_linefoot.lab.visualization.live import live_page
from tests.helpers.page_client import say, websocket_status

LONGEST = 240.0  # [s] of wall time for a drive


class Driven:
    """A drive in a thread of its own, which makes its Meshcat, and what it said."""

    def __init__(self):
        self.url, self.session, self.lines, self.error = "", None, [], None
        self._ready = threading.Event()
        self.thread = threading.Thread(target=self._run, daemon=True)
        self.thread.start()
        assert self._ready.wait(60.0)

    def _run(self):
        try:
            with live_page() as page:
                self.url = page.url
                drive = Drive(Scenario(), page, record=True, say=self._say)
                self._ready.set()
                self.session = drive.run(LONGEST)
        except BaseException as error:
            self.error = error
        self._ready.set()

    def _say(self, lines):
        self.lines = lines

    def said(self, start):
        """Return what follows a word in what is said now; empty when nothing does."""
        return next(
            (x.removeprefix(start).strip() for x in list(self.lines) if x[: len(start)] == start),
            "",
        )

    def numbers(self, start):
        return [float(word) for word in self.said(start).split()]

    def wait(self, condition, what):
        end = time.monotonic() + 120.0
        while not condition():
            assert self.error is None
            assert time.monotonic() < end, f"{what}: {self.lines}"
            time.sleep(0.1)


@pytest.fixture
def driven():
    driven = Driven()
    yield driven
    driven.thread.join(LONGEST)
    assert driven.error is None


SIZES = ((1280, 800), (1920, 950), (900, 560), (390, 844))
# In one go: while it draws, in software, the page takes long to answer.
LAID_OUT = """() => {
    const all = selector =>
        [...document.querySelectorAll(selector)].filter(box => box.checkVisibility());
    const cut = all(".lf, .lf-status td").filter(box => box.scrollWidth > box.clientWidth);
    return {
        width: document.documentElement.scrollWidth,
        boxes: all(".lf").map(box => box.getBoundingClientRect().toJSON()),
        cut: cut.map(box => box.innerText),
    };
}"""


def assert_nothing_is_cut(page, width, height):
    found = page.evaluate(LAID_OUT)
    assert found["width"] <= width
    assert found["boxes"]
    for at in found["boxes"]:
        assert at["left"] >= 0 <= at["top"]
        assert at["left"] < at["right"] <= width
        assert at["top"] < at["bottom"] <= height
    assert found["cut"] == []


def it_is_drawn_with_shadows(page):
    """Also where Meshcat drew some of another size before; else all would lie in the dark."""
    shadow = 'viewer.scene_tree.find(["Lights", "FillLight", "<object>"]).object.shadow'
    smaller = f"s = {shadow}; s.mapSize.set(512, 512); s.map.dispose(); s.map = null"
    page.wait_for_function(
        "window.viewer && viewer.scene_tree.children.drake && viewer.scene_tree.children.overlays",
        timeout=60_000,
    )
    page.wait_for_function(f"{shadow}.map")
    page.evaluate(f"() => {{ const {smaller}; viewer.set_dirty(); }}")
    page.wait_for_function(f"{shadow}.map && {shadow}.map.width === 512")
    page.evaluate("Linefoot.sharpen(viewer)")
    page.wait_for_function(f"{shadow}.map && {shadow}.map.width === 2048", timeout=20_000)


def steer_with_held_keys(page, driven):
    page.keyboard.press("s")
    page.keyboard.down("q")
    driven.wait(lambda: driven.numbers("commanded:") == [0.2, 0.0, 1.0], "Q is held")
    page.keyboard.up("q")
    driven.wait(lambda: driven.numbers("commanded:") == [0.2, 0.0, 0.0], "Q is let go")


def slow_motion_and_a_gamepad(page, driven):
    say(f"{driven.url}view/", b'{"set": ["speed", 0.1]}')
    driven.wait(lambda: re.search(r", 0\.(09|10) x real time$", driven.lines[0]), "slow motion")
    say(f"{driven.url}view/", b'{"set": ["speed", 1.0]}')
    pad = "navigator.getGamepads = () => [{connected: true, axes: [0.0, %g, %g, 0.0]}]"
    page.evaluate(pad % (-0.5, 0.25))
    driven.wait(
        lambda: driven.numbers("commanded:")[0] > 0.0 > driven.numbers("commanded:")[2], "a stick"
    )
    page.evaluate(pad % (0.0, 0.0))
    page.keyboard.press("x")
    driven.wait(lambda: driven.numbers("commanded:") == [0.0, 0.0, 0.0], "the stick is let go")


def on_the_estimate_and_back(page, driven, shot):
    page.keyboard.press("o")
    driven.wait(lambda: "state: estimated" in driven.lines, "O switches to the estimate")
    status = "document.querySelector('.lf-status').textContent.includes('estimated')"
    page.wait_for_function(f"document.querySelector('[data-action=estimate].on') && {status}")
    ghost = "'estimated robot' in viewer.scene_tree.children.overlays.children"
    page.wait_for_function(ghost)
    shot("drive_on_the_estimate")
    page.keyboard.press("o")
    driven.wait(lambda: "state: true" in driven.lines, "and to the truth again")


@pytest.mark.slow
def test_a_drive(page, driven, shot):
    page.goto(f"{driven.url}view/")
    it_is_drawn_with_shadows(page)
    robot = "viewer.scene_tree.children.drake.children.visualizer.children.mit_humanoid"
    assert "torso" in page.evaluate(f"Object.keys({robot}.children)")
    driven.wait(lambda: driven.said("on ground:") == "left right", "it stands")
    hint = page.locator(".lf-hint", has_text="Press W to walk")
    hint.wait_for()
    for width, height in SIZES:
        page.set_viewport_size({"width": width, "height": height})
        page.wait_for_timeout(500)
        assert_nothing_is_cut(page, width, height)
        shot(f"drive_standing_{width}")
    page.set_viewport_size({"width": 900, "height": 560})  # quicker to draw

    # strangers, and nonsense
    assert websocket_status(driven.url, Origin="http://evil.example") == 403
    assert websocket_status(f"{driven.url}view/", Origin="http://evil.example") == 403
    assert websocket_status(driven.url[:-5], Origin="http://evil.example") == 403
    say(
        f"{driven.url}view/",
        b"\x81\xa4\x74\x79",
        b'{"set": ["left", NaN]}',
        b'{"set": ["left", 1e12]}',
    )
    driven.wait(lambda: driven.numbers("commanded:") == [0.0, 0.4, 0.0], "the end of a slider")
    say(f"{driven.url}view/", b'{"set": ["left", 0]}')
    driven.wait(lambda: driven.numbers("commanded:") == [0.0, 0.0, 0.0], "the slider is back")
    page.wait_for_timeout(1000)
    for _ in range(3):
        page.keyboard.press("w")
    driven.wait(lambda: driven.numbers("commanded:") == [0.3, 0.0, 0.0], "W is taken")
    hint.wait_for(state="hidden")
    driven.wait(lambda: driven.numbers("measured:")[0] > 0.2, "the robot follows")
    shot("drive_walking")
    steer_with_held_keys(page, driven)
    page.keyboard.press("Space")
    driven.wait(lambda: any("paused" in line for line in driven.lines), "Space pauses")
    assert page.evaluate("scrollY") == 0
    page.keyboard.press("Space")
    page.keyboard.press("x")
    driven.wait(lambda: driven.numbers("commanded:") == [0.0, 0.0, 0.0], "X stops")
    driven.wait(lambda: max(map(abs, driven.numbers("measured:"))) < 0.05, "it stands again")
    slow_motion_and_a_gamepad(page, driven)
    page.get_by_text("model", exact=True).click()
    page.locator("[data-action='model srbm']").click()
    driven.wait(lambda: driven.said("single rigid body:") != "", "the model changes")
    on_the_estimate_and_back(page, driven, shot)
    page.keyboard.press("r")
    driven.wait(lambda: float(driven.lines[0].split()[0]) < 1.0, "R begins again")
    page.keyboard.press("ArrowRight")
    driven.wait(lambda: driven.said("aim of P:") == "push right", "arrows aim")
    page.keyboard.press("p")
    driven.wait(lambda: float(driven.lines[0].split()[0]) > 1.2, "time goes on")
    shot("drive_pushed")
    page.keyboard.press("Escape")
    driven.thread.join(60.0)
    run = driven.session.run()
    assert not run.fell
    assert run.v[:, 4].min() < -0.03  # the push
