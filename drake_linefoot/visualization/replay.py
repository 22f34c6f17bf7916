"""Replays: a run as one HTML file that needs nothing else, or shown again live.

Drake's Meshcat listens on a port even when nobody is to look, and ends its process at a malformed
message. So what is simulated or kept is drawn by a process of its own:
`python -m drake_linefoot.visualization.replay LOG PAGE TITLE`.
"""

import html
import signal
import subprocess
import sys
import time as clock
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from pydrake.geometry import Meshcat, MeshcatAnimation, MeshcatVisualizer, MeshcatVisualizerParams
from pydrake.systems.framework import DiagramBuilder

from drake_linefoot.errors import InputError, LinefootError
from drake_linefoot.files import write_file, writing
from drake_linefoot.robot.humanoid import load_humanoid
from drake_linefoot.simulation.quiet import quieten_drake
from drake_linefoot.simulation.recording import CHANNELS, Run
from drake_linefoot.simulation.scene import add_plant
from drake_linefoot.visualization.overlays import PERIOD, OverlayPainter
from drake_linefoot.visualization.replay_page import with_overlay
from drake_linefoot.visualization.view import open_meshcat, set_up_view

LONGEST = 120.0  # [s] of a replay; of a longer run it is the end, for a page holds all of it
PROGRAM = (sys.executable, "-P", "-m", __spec__.name if __spec__ else __name__)


@contextmanager
def recording(meshcat: Meshcat, begin: float = 0.0) -> Iterator[None]:
    """Record what is drawn inside the `with` block from `begin` [s] on, and publish it at its end.

    The recording then plays by itself, over and over, in every browser that shows `meshcat`
    and in what `replay_html` returns. What is left on an error is not published.
    """
    meshcat.DeleteRecording()
    meshcat.StartRecording(
        frames_per_second=1.0 / PERIOD,  # the viewer interpolates
        set_visualizations_while_recording=True,
    )
    meshcat.get_mutable_recording().set_start_time(begin)
    try:
        yield
    finally:
        meshcat.StopRecording()
    animation = meshcat.get_mutable_recording()
    animation.set_autoplay(True)
    animation.set_loop_mode(MeshcatAnimation.LoopMode.kLoopRepeat)
    meshcat.PublishRecording()


def replay_html(
    meshcat: Meshcat, title: str = "drake_linefoot", run: Run | None = None, begin: float = 0.0
) -> str:
    """Return a published recording as a page that needs no other file.

    The page plays by itself and keeps the robot in view.

    Args:
        meshcat: holds the recording.
        title: of the page.
        run: what was recorded, for status, plots and a play bar; without, none of them.
        begin: of the recording [s].
    """
    page: str = meshcat.StaticHtml()
    page = page.replace("<title>Drake MeshCat</title>", f"<title>{html.escape(title)}</title>", 1)
    if run is None:
        return page
    return with_overlay(page, run, load_humanoid(run.scenario.robot), begin)


def run_title(run: Run) -> str:
    """Return the title of a run's replay: scenario and version."""
    return f"{run.scenario.name}, drake_linefoot {run.version}"


def write_replay(
    meshcat: Meshcat, path: str | Path, title: str = "drake_linefoot", run: Run | None = None
) -> None:
    """Write `replay_html` to a file.

    Raises:
        OutputError: it cannot be written.
    """
    with writing(path):
        Path(path).write_text(replay_html(meshcat, title, run), encoding="utf-8")


def play(run: Run, meshcat: Meshcat, realtime_rate: float = 1.0, begin: float = 0.0) -> None:
    """Show a recorded run again from its logged states, without simulating anything.

    Args:
        run: what was recorded; its scenario names robot and scene.
        meshcat: where to show it.
        realtime_rate: 1 is real time, 2 twice as fast; 0 as fast as possible.
        begin: where to [s].

    Raises:
        InputError: the robot is not the one that was recorded any more.
    """
    humanoid = load_humanoid(run.scenario.robot)
    if humanoid.description.actuated_joints != run.joint_names or humanoid.nq != run.q.shape[1]:
        allowed = "must have the joints of the recording"
        raise InputError("run", "robot", run.scenario.robot, allowed)
    builder = DiagramBuilder()
    plant, scene_graph, ground = add_plant(builder, humanoid, run.scenario)
    MeshcatVisualizer.AddToBuilder(builder, scene_graph, meshcat, MeshcatVisualizerParams())
    diagram = builder.Build()
    context = diagram.CreateDefaultContext()
    plant_context = plant.GetMyMutableContextFromRoot(context)
    painter = OverlayPainter(humanoid, meshcat, run.scenario.mpc.friction, ground)
    set_up_view(meshcat, humanoid, ground)
    start = clock.perf_counter()
    times = run.time
    frames = np.searchsorted(times, np.arange(begin, times[-1] + 1e-9, PERIOD))
    shown = {name: getattr(run, name)[frames] for name in CHANNELS}  # each read once, when stored
    for i, time in enumerate(map(float, shown["time"])):
        context.SetTime(time)
        plant.SetPositions(plant_context, shown["q"][i])
        diagram.ForcedPublish(context)
        painter.draw({name: values[i] for name, values in shown.items()})
        if realtime_rate > 0.0:
            due = (time - begin) / realtime_rate
            clock.sleep(max(0.0, due - (clock.perf_counter() - start)))


def draw_replay(log: str | Path, page: str | Path, title: str = "") -> None:
    """Draw a recorded run, or the last two minutes of it, as a page that plays by itself.

    Args:
        log: what `Run.load` takes.
        page: the file to write; all of it or nothing.
        title: of the page; else scenario and version.

    Raises:
        LinefootError: it was not drawn.
    """
    command = [*PROGRAM, str(log), str(page), title]
    done = subprocess.run(
        command, check=False, stdin=subprocess.DEVNULL, capture_output=True, text=True
    )
    if done.returncode:
        said = done.stderr.strip().splitlines()[-1:] or [_ending(done.returncode)]
        raise LinefootError(f"{page}: not drawn: {said[0]}")


def _ending(status: int) -> str:
    """Return how a process ended that said nothing."""
    if status >= 0:
        return f"its process ended with status {status}"
    return f"its process was ended by {signal.Signals(-status).name}"


def main(log: str, page: str, title: str) -> None:
    """Draw it in this process."""
    quieten_drake()
    run, meshcat = Run.load(log), open_meshcat()
    begin, title = max(0.0, float(run.time[-1]) - LONGEST), title or run_title(run)
    if begin:
        title += f", from {begin:g} s on"
    with recording(meshcat, begin):
        play(run, meshcat, realtime_rate=0.0, begin=begin)
    write_file(page, replay_html(meshcat, title, run, begin).encode())


if __name__ == "__main__":
    main(*sys.argv[1:])
