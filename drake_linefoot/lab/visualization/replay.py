"""Replays: a run as one HTML file that needs nothing else.

The page shows status, plots and a play bar beside the robot.

Drake's Meshcat listens on a port even when nobody is to look, and ends its process at a malformed
message. So what is simulated or kept is drawn by a process of its own:
`python -m drake_linefoot.lab.visualization.replay LOG PAGE TITLE`.
"""

import html
import json
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from pydrake.geometry import Meshcat, MeshcatAnimation, MeshcatVisualizer, MeshcatVisualizerParams
from pydrake.systems.framework import DiagramBuilder

from drake_linefoot.axes import FEET
from drake_linefoot.errors import InputError
from drake_linefoot.files import write_file, writing
from drake_linefoot.lab.plants.scene import add_plant
from drake_linefoot.lab.simulation.drake_logging import silence_drake
from drake_linefoot.lab.simulation.recording import CHANNELS, LOG, Run
from drake_linefoot.lab.simulation.run_view import robot_of
from drake_linefoot.lab.simulation.velocity import WINDOW, mean_velocity
from drake_linefoot.lab.visualization.drawing import Drawing
from drake_linefoot.lab.visualization.map_outlines import outlines_of
from drake_linefoot.lab.visualization.overlays import PERIOD, OverlayPainter, legend_of
from drake_linefoot.lab.visualization.view import open_meshcat, set_up_view
from drake_linefoot.math.rotation import roll_pitch_yaw
from drake_linefoot.page import Page
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.types import Array

WEB = Path(__file__).with_name("web")
SOURCES = ("true", "estimated")  # of what the controller knows of the state
LONGEST = 120.0  # [s] of a replay; of a longer run it is the end, for a page holds all of it
PROGRAM = (sys.executable, "-P", "-m", __spec__.name if __spec__ else __name__)


@contextmanager
def recording(meshcat: Meshcat, begin: float = 0.0) -> Iterator[None]:
    """Record what is drawn inside the `with` block from `begin` [s] on, and publish it at its end.

    The recording then plays by itself in every browser that shows `meshcat`
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
    return with_overlay(page, run, robot_of(run), begin)


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


def play(run: Run, meshcat: Meshcat, begin: float = 0.0) -> None:
    """Draw a recorded run again from its logged states, without simulating anything.

    Args:
        run: what was recorded; its scenario names robot and scene.
        meshcat: where to draw it.
        begin: where to [s]; from there on two minutes are drawn at most.

    Raises:
        InputError: the robot is not the one that was recorded any more, or there is no sample.
    """
    if not len(run.time):
        raise InputError("run", "", "0 samples", "nothing to show: it ended before the first one")
    humanoid = robot_of(run)
    if humanoid.description.actuated_joints != run.joint_names:
        allowed = "must have the joints of the recording"
        raise InputError("run", "robot", run.scenario.robot, allowed)
    builder = DiagramBuilder()
    plant, scene_graph, ground = add_plant(builder, humanoid, run.scenario)
    MeshcatVisualizer.AddToBuilder(builder, scene_graph, meshcat, MeshcatVisualizerParams())
    diagram = builder.Build()
    context = diagram.CreateDefaultContext()
    plant_context = plant.GetMyMutableContextFromRoot(context)
    outlines = outlines_of(run.scenario, humanoid, ground)
    painter = OverlayPainter(humanoid, meshcat, run.scenario.mpc.friction, ground, outlines)
    set_up_view(meshcat, humanoid, ground)
    times = run.time
    end = min(float(times[-1]), begin + LONGEST)
    frames = np.searchsorted(times, np.arange(begin, end + 1e-9, PERIOD))
    shown = {name: getattr(run, name)[frames] for name in CHANNELS}  # each read once, when stored
    for i, time in enumerate(map(float, shown["time"])):
        context.SetTime(time)
        plant.SetPositions(plant_context, shown["q"][i])
        diagram.ForcedPublish(context)
        painter.draw({name: values[i] for name, values in shown.items()})


def with_overlay(page: str, run: Run, humanoid: Humanoid, begin: float) -> str:
    """Return Meshcat's page of a recording that begins at a time [s] with the overlay in it."""
    style, *scripts = (
        (WEB / name).read_text(encoding="utf-8") for name in ("page.css", "scene.js", "replay.js")
    )
    # "<" would end the script when a name has a tag in it
    data = json.dumps(replay_data(run, humanoid, begin), allow_nan=False).replace("<", "\\u003c")
    phone = '<meta name="viewport" content="width=device-width, initial-scale=1">'
    added = f"{phone}<style>{style}</style><script>{''.join(scripts)}Linefoot.replay({data});"
    before, body, after = page.rpartition("</body>")
    return f"{before}{added}</script>{body}{after}"


def replay_data(run: Run, humanoid: Humanoid, begin: float = 0.0) -> dict[str, Any]:
    """Return what a replay from `begin` [s] on shows, one sample for each of its pictures."""
    times, end = run.time, min(float(run.time[-1]), begin + LONGEST)
    wanted = np.append(np.arange(begin, end, PERIOD), end)
    at = np.unique(np.searchsorted(times, wanted + 1e-9, side="right") - 1)
    names = ("time", "q", "com", "command", "true_force", "push", "contact_flag", "mpc_failures")
    shown = {name: getattr(run, name)[at] for name in (*names, "estimate_pose")}
    rpy = roll_pitch_yaw(shown["q"][:, :4])
    segments = run.scenario.segments
    begins = np.cumsum([0.0, *(segment.duration for segment in segments)])
    failures = np.nan_to_num(shown["mpc_failures"]).astype(int)
    return {
        "legend": legend_of(run.scenario),
        "torso": torso_path(humanoid),
        "begin": begin,
        "segments": [(t - begin, s.name) for t, s in zip(begins, segments, strict=False)],
        "time": rounded(shown["time"] - begin),
        "asked": rounded(shown["command"][:, :3]),
        "walks": rounded(_velocities(shown["time"], shown["com"], np.unwrap(rpy[:, 2]))),
        "force": rounded(shown["true_force"][:, :, 2]),
        "tilt": rounded(np.degrees(rpy[:, :2])),
        "push": rounded(np.linalg.norm(shown["push"], axis=1)),
        "feet": [on_ground(flags) for flags in shown["contact_flag"]],
        "solver": [f"{count} failures" for count in failures],
        "source": [SOURCES[known] for known in np.isfinite(shown["estimate_pose"][:, 0]).tolist()],
        "fell": run.fall_reason if run.fell and end == times[-1] else "",
    }


def torso_path(humanoid: Humanoid) -> list[str]:
    """Return where the base of a robot is in the tree of a page."""
    robot = humanoid.plant.GetModelInstanceName(humanoid.base.model_instance())
    return ["drake", "visualizer", robot, humanoid.base.name()]


def on_ground(flags: Array) -> str:
    """Return the names of the feet that are on the ground, by their flags, shape (2,)."""
    return " ".join(f for f, on in zip(FEET, flags, strict=True) if on > 0.5) or "none"


def _velocities(time: Array, com: Array, yaw: Array) -> Array:
    """Return `mean_velocity` over the half second up to each sample, shape (n, 3)."""
    first = np.minimum(np.searchsorted(time, time - WINDOW - 1e-9), np.arange(len(time)) - 1)
    out = np.zeros((len(time), 3))
    for i in range(1, len(time)):
        window = slice(max(first[i], 0), i + 1)
        out[i] = mean_velocity(time[window], com[window], yaw[window])
    return out


def rounded(values: Array) -> list[Any]:
    """Return an array as lists of numbers with 3 decimals; None for one that is not finite."""
    if values.ndim > 1:
        return [rounded(row) for row in values]
    return [round(float(v), 3) + 0.0 if np.isfinite(v) else None for v in values]


def draw_replay(log: str | Path, page: str | Path, title: str = "") -> None:
    """Draw a recorded run, or the last two minutes of it, as a page that plays by itself.

    Args:
        log: what `Run.load` takes.
        page: the file to write; all of it or nothing.
        title: of the page; else scenario and version.

    Raises:
        LinefootError: it was not drawn.
    """
    with begin_replay(log, page, title) as drawing:
        drawing.wait()


def begin_replay(log: str | Path, page: str | Path, title: str = "") -> Drawing:
    """Begin what `draw_replay` does, while the caller does something else."""
    return Drawing([*PROGRAM, str(log), str(page), title], page)


def show_run(run: Run, height: int) -> Page:
    """Return the replay of a run as a page, see `Run.show`."""
    with tempfile.TemporaryDirectory() as folder:
        log, page = Path(folder, LOG), Path(folder, "replay.html")
        run.save(log)
        draw_replay(log, page)
        return Page(page.name, page.read_text(encoding="utf-8"), height).presented()


def draw(run: Run, meshcat: Meshcat, begin: float | None = None, title: str = "") -> str:
    """Return a recorded run as a page that plays by itself.

    Args:
        run: what was recorded.
        meshcat: where it is drawn.
        begin: where the page begins [s]; None for its last two minutes, which is the most.
        title: of the page; else scenario and version.

    Raises:
        InputError: as of `play`; or the run had ended before it begins.
    """
    last = float(run.time[-1:].sum())
    if begin is not None and begin >= last > 0.0:
        raise InputError("--begin", "", begin, f"must be before the end at {last:g} s")
    since = max(0.0, last - LONGEST) if begin is None else begin
    title = (title or run_title(run)) + (f", from {since:g} s on" if since else "")
    with recording(meshcat, since):
        play(run, meshcat, since)
    return replay_html(meshcat, title, run, since)


def main(log: str, page: str, title: str) -> None:
    """Draw it in this process."""
    silence_drake()
    write_file(page, draw(Run.load(log), open_meshcat(), title=title).encode())


if __name__ == "__main__":
    main(*sys.argv[1:])
