"""Make docs/walk.png anew: a walk in a left turn, drawn by its replay in a headless Chromium.

Needs Chromium (`apt-get install chromium`). Run from the root of the repository:

    python tools/make_picture.py
"""

from __future__ import annotations

import shutil
import sys
import tempfile
from pathlib import Path

from playwright.sync_api import sync_playwright

from drake_linefoot.scenario import Scenario, Segment
from drake_linefoot.simulation.run import simulate
from drake_linefoot.visualization.replay import recording, write_replay
from drake_linefoot.visualization.view import open_meshcat
from drake_linefoot.wiring.closed_loop import build_closed_loop

PICTURE = Path(__file__).resolve().parents[1] / "docs" / "walk.png"
SIZE = {"width": 860, "height": 510}  # [pixels]
SEGMENTS = [
    Segment("stand", 0.5),
    Segment("forward", 1.5, walk=True, velocity=[0.5, 0.0]),
    Segment("left turn", 2.6, walk=True, velocity=[0.5, 0.0], turn_rate=0.6),
]
TIME = 4.31  # [s] of the picture, in the swing of the left foot
CAMERA, TARGET = (0.82, -0.85, 0.70), (-0.27, 0.0, 0.38)  # [m] from below the robot
FLAGS = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]


def main() -> None:
    """Simulate, write a replay and photograph it."""
    program = shutil.which("chromium") or shutil.which("google-chrome")
    if program is None:
        sys.exit("no Chromium: apt-get install chromium")
    meshcat = open_meshcat()
    with recording(meshcat):
        simulate(build_closed_loop(Scenario(name="left turn", segments=SEGMENTS), meshcat))
    meshcat.SetCameraPose(CAMERA, TARGET)
    with tempfile.TemporaryDirectory() as folder:
        replay = Path(folder) / "replay.html"
        write_replay(meshcat, replay)
        photograph(program, replay)
    print(f"wrote {PICTURE}; look at it")


def photograph(program: str, replay: Path) -> None:
    """Save the replay at `TIME` as the picture, without the controls of the page."""
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=program, args=FLAGS)
        page = browser.new_page(viewport=SIZE)
        page.goto(replay.as_uri())
        page.wait_for_function("viewer.animator && viewer.animator.duration > 0", timeout=60_000)
        page.add_style_tag(content=".dg { display: none; }")
        page.evaluate(f"viewer.animator.pause(); viewer.animator.seek({TIME})")
        page.wait_for_timeout(3000)  # it draws in software
        page.screenshot(path=PICTURE)
        browser.close()


if __name__ == "__main__":
    main()
