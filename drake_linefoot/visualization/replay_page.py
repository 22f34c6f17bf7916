"""What a replay shows beside the robot: status, plots and a play bar, inside its one file."""

import json
from pathlib import Path
from typing import Any

import numpy as np

from drake_linefoot.math.rotation import roll_pitch_yaw
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.simulation.channels import FEET
from drake_linefoot.simulation.heading import mean_velocity
from drake_linefoot.simulation.recording import Run
from drake_linefoot.simulation.run import WINDOW
from drake_linefoot.types import Array
from drake_linefoot.visualization.overlays import LEGEND, PERIOD

WEB = Path(__file__).with_name("web")
SOURCES = ("on the truth", "on the estimate")  # of what the controller knows of the state


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
    times = run.time
    at = np.searchsorted(times, np.arange(begin, times[-1], PERIOD) + 1e-9, side="right") - 1
    at = np.unique([*at, len(times) - 1])  # the end, too
    names = ("time", "q", "com", "command", "true_force", "push", "contact_flag", "mpc_failures")
    shown = {name: getattr(run, name)[at] for name in (*names, "estimate_pose")}
    rpy = roll_pitch_yaw(shown["q"][:, :4])
    segments = run.scenario.segments
    begins = np.cumsum([0.0, *(segment.duration for segment in segments)])
    failures = np.nan_to_num(shown["mpc_failures"]).astype(int)
    return {
        "legend": LEGEND,
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
        "fell": run.fall_reason if run.fell else "",
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
