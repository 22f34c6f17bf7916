"""Make the moving pictures of the documentation anew: replays, drawn in a headless Chromium.

docs/walk.webp, a walk into a right turn, and docs/walk.png, a still of it; or a run of a sweep,
around its first push; some steps at a speed, slowed down; some seconds of a scenario.
docs/drive.webp and docs/g1.webp are cut from what the browser shows of a drive and of the replay
of a G1. Needs Chromium (`apt-get install chromium`) and some minutes:

    make picture
    make picture ARGS="--run wide_push 7 docs/robustness/saved.webp"
    make picture ARGS="--speed 2.0 docs/running.webp"
    make picture ARGS="--scenario examples/stairs.yaml 1.5 6.5 docs/stairs.webp"
"""

from __future__ import annotations

import argparse
import io
import shutil
import sys
import tempfile
from pathlib import Path

import numpy as np
from PIL import Image
from playwright.sync_api import Page, sync_playwright

from drake_linefoot.lab.scenario import Scenario, Segment
from drake_linefoot.lab.scenario.load import load_scenario, parse_scenario
from drake_linefoot.lab.simulation.run import simulate
from drake_linefoot.lab.sweep.file import load_sweep
from drake_linefoot.lab.sweep.jobs import job
from drake_linefoot.lab.visualization.replay import recording, write_replay
from drake_linefoot.lab.visualization.view import open_meshcat
from drake_linefoot.lab.wiring.closed_loop import build_closed_loop

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
BEFORE, AFTER = 0.4, 2.4  # [s] of a push
REACHED, STEPS, SLOWER = 5.0, 1.36, 3.0  # [s] after which it is that fast, [s] shown, [-]
SWEEP = DOCS.parent / "examples" / "sweeps" / "robustness.yaml"
FLAGS = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]


def main() -> None:
    """Simulate, write a replay and photograph it."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--run", nargs=3, metavar=("GROUP", "INDEX", "FILE"), help="of the sweep")
    parser.add_argument("--speed", nargs=2, metavar=("M/S", "FILE"), help="steps at a speed")
    parser.add_argument(
        "--scenario", nargs=4, metavar=("SCENARIO", "FROM", "TO", "FILE"), help="times of it [s]"
    )
    parser.add_argument("--sweep", type=Path, default=SWEEP, help="of the run")
    arguments = parser.parse_args()
    program = shutil.which("chromium") or shutil.which("google-chrome")
    if program is None:
        sys.exit("no Chromium: apt-get install chromium")
    if arguments.speed is not None:
        ahead = Segment(
            "ahead", REACHED + STEPS, walk=True, velocity=[float(arguments.speed[0]), 0.0]
        )
        scenario = Scenario(name="ahead", segments=[Segment("stand", 0.5), ahead])
        begin = 0.5 + REACHED
        film(program, scenario, (begin, begin + STEPS), Path(arguments.speed[1]), slower=SLOWER)
        return
    if arguments.scenario is not None:
        scenario_file, start, end, out = arguments.scenario
        film(program, load_scenario(scenario_file), (float(start), float(end)), Path(out))
        return
    if arguments.run is None:
        walk = Scenario(name="right turn", segments=SEGMENTS)
        film(program, walk, (BEGIN, END), DOCS / "walk.webp", still=DOCS / "walk.png")
        return
    name, index, file = arguments.run
    sweep = load_sweep(arguments.sweep)
    groups = {group.name: group for group in sweep.groups}
    if name not in groups or not index.isdecimal():
        parser.error(f"--run: a group ({', '.join(groups)}) and a number, not {name} {index}")
    scenario = parse_scenario(job(sweep, groups[name], int(index)).scenario, name)
    if not scenario.pushes:
        parser.error(f"--run: nothing pushes the runs of {name}")
    push = scenario.pushes[0]
    film(program, scenario, (push.time - BEFORE, push.time + AFTER), Path(file))


def film(
    program: str,
    scenario: Scenario,
    span: tuple[float, float],
    file: Path,
    still: Path | None = None,
    slower: float = 1.0,
) -> None:
    """Write a film of a scenario from one time to another [s], and a still at `STILL`.

    It is shown so many times `slower`.
    """
    meshcat = open_meshcat()
    with recording(meshcat):
        run = simulate(build_closed_loop(scenario, meshcat))
    end = min(span[1], float(run.time[-1]))
    meshcat.SetCameraPose(CAMERA, TARGET)  # the page follows the robot
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        replay = Path(folder) / "replay.html"
        write_replay(meshcat, replay, run=run)
        browser = playwright.chromium.launch(executable_path=program, args=FLAGS)
        page = browser.new_page(viewport=SIZE)
        page.goto(replay.as_uri())
        page.wait_for_function("viewer.animator && viewer.animator.duration > 0", timeout=60_000)
        page.add_style_tag(content=".dg, .lf { display: none !important; }")
        page.evaluate("viewer.animator.pause()")
        if still is not None:
            photograph(page, STILL).save(still, optimize=True)
        frames = [photograph(page, time) for time in np.arange(span[0], end, 1.0 / (slower * RATE))]
        browser.close()
    frames[0].save(
        file,
        save_all=True,
        append_images=frames[1:],
        duration=round(1000.0 / RATE),
        loop=0,
        quality=QUALITY,
        method=6,
    )
    print(f"wrote {file}{f' and {still}' if still else ''}; look at it")


def photograph(page: Page, time: float) -> Image.Image:
    """Return the scene of the replay at a time [s], without the controls of the page."""
    page.evaluate(f"viewer.animator.seek({time})")
    page.wait_for_timeout(100)
    page.evaluate("new Promise(drawn => requestAnimationFrame(() => requestAnimationFrame(drawn)))")
    return Image.open(io.BytesIO(page.screenshot())).convert("RGB")


if __name__ == "__main__":
    main()
