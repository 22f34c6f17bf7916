"""Figure 3: commanded velocity, the MPC's, and what came of it, while walking and turning."""

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from drake_linefoot.lab.results.metrics import segment_velocity
from drake_linefoot.lab.simulation.recording import Run
from studies.common import runs
from studies.common.drawing import BLUE, GREY, ORANGE, array, legend, over
from studies.common.types import Array, Data
from studies.paper.figure import Claim

TITLE = "Commanded, planned and resulting velocity of the centre of mass"
RELATIVE, ABSOLUTE = 0.10, 0.05  # [-], [m/s, rad/s] a command is tracked within the larger one
AXES = ("forward [m/s]", "left [m/s]", "turn rate [rad/s]")


def compute(quick: bool) -> Data:
    """Simulate the walk and take its velocities in the heading frame."""
    return measure(runs.simulated(runs.paper_scenario(quick)))


def measure(run: Run) -> Data:
    """Return curves and means over the segments of one run.

    The MPC's velocity is the mean over the horizon of each plan, 0.56 s: its first instants
    start at the measured state, so that they would agree with it whatever it plans. It is
    taken in the heading the robot is to have in the middle of the horizon. The MPC plans no
    turn rate of its own.
    """
    stride = runs.stride_time(run.scenario)
    com = np.gradient(run.com, run.time, axis=0)
    rate = runs.turn_rate(run)
    measured = np.column_stack([runs.in_heading(run, com)[:, :2], rate])
    half = 0.5 * run.scenario.mpc.knots * run.scenario.mpc.knot_step
    ahead = half * run.reference_command[:, 2]
    planned = runs.in_heading(run, run.mpc_mean_velocity, ahead)[:, :2]
    return {
        **runs.facts(run),
        "stride": stride,
        "time": runs.decimated(run.time),
        "commanded": runs.decimated(run.command[:, :3]),
        "limited": runs.decimated(run.reference_command),
        "measured": runs.decimated(measured),
        "mean": runs.decimated(runs.stride_mean(run.time, measured, stride)),
        "planned": runs.decimated(runs.stride_mean(run.time, planned, stride)),
        "rows": _segment_rows(run, planned),
    }


def _segment_rows(run: Run, planned: Array) -> list[dict[str, Any]]:
    rows, end = [], 0.0
    for segment in run.scenario.segments:
        start, end = end, end + segment.duration
        late = (run.time >= 0.5 * (start + end)) & (run.time <= end)
        resulting = segment_velocity(run, start, end)
        rows.append(
            {
                "name": segment.name,
                "walk": segment.walk,
                "commanded": [*segment.velocity, segment.turn_rate],
                "planned": planned[late].mean(axis=0).tolist() if late.any() else None,
                "resulting": None if resulting is None else resulting.tolist(),
            }
        )
    return rows


def draw(data: Data) -> Figure:
    """Draw commanded, planned and resulting velocity over time."""
    figure, axes = over(f"Figure 3. {TITLE}, heading frame", data, 3)
    time = array(data["time"])
    for i, (ax, name) in enumerate(zip(axes, AXES, strict=True)):
        ax.plot(time, array(data["measured"])[:, i], color=BLUE, lw=0.5, alpha=0.5, label="CoM")
        label = f"CoM, mean over a stride ({data['stride']:.2f} s)"
        ax.plot(time, array(data["mean"])[:, i], color=BLUE, lw=2.0, label=label)
        if i < 2:
            label = "MPC, mean over its horizon and a stride"
            ax.plot(time, array(data["planned"])[:, i], color=ORANGE, lw=2.0, label=label)
        ax.plot(time, array(data["commanded"])[:, i], color=GREY, ls="--", label="commanded")
        label = "commanded, after rate limits"
        ax.plot(time, array(data["limited"])[:, i], color="k", ls=":", label=label)
        ax.set_ylabel(name)
    return legend(figure, axes[0], 3)


def table(data: Data) -> list[list[str]]:
    """Return commanded, planned and resulting velocity of each segment."""
    header = ["segment (second half)", "commanded", "MPC", "resulting", "error"]
    rows = [header]
    for row in data["rows"]:
        error = row["resulting"] and np.subtract(row["resulting"], row["commanded"]).tolist()
        values = (row["commanded"], row["planned"], row["resulting"], error)
        rows.append([row["name"], *map(_words, values)])
    return rows


def claims(data: Data) -> list[Claim]:
    """Return the two statements: the MPC follows the command, and the robot does."""
    result = []
    for key, claim in (
        ("planned", "The MPC's velocities are close to the commanded ones"),
        ("resulting", "The resulting velocities are close to the commanded ones"),
    ):
        rows = [row for row in data["rows"] if row["walk"]]
        off = [_worst(row["commanded"], row[key]) for row in rows if row[key] is not None]
        worst = max(off, key=lambda pair: pair[0] / pair[1]) if off else (np.nan, 1.0)
        ours = "fell before" if not off else f"at most {worst[0]:.3f} off, {worst[1]:.3f} allowed"
        note = (
            "Mean over the second half of each segment of walking, cut to whole strides for what "
            "resulted; allowed are 10 % of the command or 0.05 (m/s, rad/s), the larger one. "
            "The speed is learned from step to step, and the command rises at most 1 m/s per s."
        )
        holds = len(off) == len(rows) and worst[0] <= worst[1]
        result.append(Claim(claim, "close (a picture, no number)", ours, holds, note))
    return result


def _worst(commanded: list[float], found: list[float]) -> tuple[float, float]:
    """Return the error that is largest for what is allowed, and what is allowed."""
    pairs = [
        (abs(f - c), max(ABSOLUTE, RELATIVE * abs(c)))
        for c, f in zip(commanded, found, strict=False)
    ]
    return max(pairs, key=lambda pair: pair[0] / pair[1])


def _words(values: list[float] | None) -> str:
    return "-" if values is None else " ".join(f"{v:.3f}" for v in values)
