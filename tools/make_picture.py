"""Make docs/walk.webp anew: a walk into a right turn, drawn by its replay in a headless Chromium.

Also docs/walk.png, a still of it. Needs Chromium (`apt-get install chromium`) and some minutes:

    make picture
"""

from __future__ import annotations

import io
import shutil
import sys
import tempfile
from pathlib import Path

import numpy as np
from PIL import Image
from playwright.sync_api import Page, sync_playwright

from drake_linefoot.scenario import Scenario, Segment
from drake_linefoot.simulation.run import simulate
from drake_linefoot.visualization.replay import recording, write_replay
from drake_linefoot.visualization.view import open_meshcat
from drake_linefoot.wiring.closed_loop import build_closed_loop

DOCS = Path(__file__).resolve().parents[1] / "docs"
SIZE = {"width": 860, "height": 510}  # [pixels]
SEGMENTS = [
    Segment("stand", 0.5),
    Segment("forward", 1.5, walk=True, velocity=[0.5, 0.0]),
    Segment("right turn", 2.9, walk=True, velocity=[0.5, 0.0], turn_rate=-0.6),
]
STILL = 4.31  # [s] of the still, in the swing of a foot
BEGIN, END, RATE = 0.9, 4.9, 12.5  # [s], [s], [frames/s] of the animation
QUALITY = 62  # of its frames, out of 100
CAMERA, TARGET = (0.88, -0.80, 0.86), (-0.1, 0.06, 0.34)  # [m] from below the robot
FLAGS = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]


def main() -> None:
    """Simulate, write a replay and photograph it."""
    program = shutil.which("chromium") or shutil.which("google-chrome")
    if program is None:
        sys.exit("no Chromium: apt-get install chromium")
    meshcat = open_meshcat()
    with recording(meshcat):
        run = simulate(build_closed_loop(Scenario(name="right turn", segments=SEGMENTS), meshcat))
    meshcat.SetCameraPose(CAMERA, TARGET)
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        replay = Path(folder) / "replay.html"
        write_replay(meshcat, replay, run=run)
        browser = playwright.chromium.launch(executable_path=program, args=FLAGS)
        page = browser.new_page(viewport=SIZE)
        page.goto(replay.as_uri())
        page.wait_for_function("viewer.animator && viewer.animator.duration > 0", timeout=60_000)
        page.add_style_tag(content=".dg, .lf { display: none !important; }")
        page.evaluate("viewer.animator.pause()")
        photograph(page, STILL).save(DOCS / "walk.png", optimize=True)
        frames = [photograph(page, time) for time in np.arange(BEGIN, END, 1.0 / RATE)]
        browser.close()
    frames[0].save(
        DOCS / "walk.webp",
        save_all=True,
        append_images=frames[1:],
        duration=round(1000.0 / RATE),
        loop=0,
        quality=QUALITY,
        method=6,
    )
    print(f"wrote {DOCS}/walk.png and walk.webp; look at them")


def photograph(page: Page, time: float) -> Image.Image:
    """Return the scene of the replay at a time [s], without the controls of the page."""
    page.evaluate(f"viewer.animator.seek({time})")
    page.wait_for_timeout(100)
    page.evaluate("new Promise(drawn => requestAnimationFrame(() => requestAnimationFrame(drawn)))")
    return Image.open(io.BytesIO(page.screenshot())).convert("RGB")


if __name__ == "__main__":
    main()
