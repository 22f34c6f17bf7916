"""Figure 5: force and torque errors between the solutions of MPC and whole-body controller."""

from typing import Any

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from drake_linefoot.lab.simulation.recording import Run
from studies.common import runs
from studies.common.drawing import BLUE, GREY, ORANGE, array, blank, fallen
from studies.common.types import Array, Data
from studies.paper.figure import Claim, shown

TITLE = "Force and torque errors between MPC and whole-body controller"
SMALL = 1e-4  # [-] of the weight; an error below it counts as zero
ZERO_SHARE = 0.95  # [-] of the updates after which the error must be zero, for the claim to hold
WINDOW = 0.25  # [s] that is shown tick by tick
FLOOR = 1e-5  # [N, N m] lower end of logarithmic axes


def compute(quick: bool) -> Data:
    """Simulate the walk and take the corrections of (49)."""
    return measure(runs.simulated(runs.paper_scenario(quick)))


def error_norms(run: Run) -> tuple[Array, Array]:
    """Return the norms of force [N] and torque [N m] corrections of both feet, shapes (n,)."""
    n = len(run.time)
    force = np.linalg.norm(run.wrench_error[:, :, :3].reshape(n, -1), axis=1)
    torque = np.linalg.norm(run.wrench_error[:, :, 3:].reshape(n, -1), axis=1)
    return force, torque


def by_age(
    error: Array, updates: NDArray[np.intp], counted: NDArray[np.bool_]
) -> list[dict[str, Any]]:
    """Return how large an error is in each tick after an update of the MPC.

    Args:
        error: in each sample, shape (n,).
        updates: samples in which a new plan is used first, ascending.
        counted: which samples count, shape (n,).

    Returns:
        For each age of the plan, in ticks from 0, median, 95th percentile and maximum over
        all plans that lived so long.
    """
    ends = np.append(updates[1:], len(error))
    rows = []
    for age in range(int((ends - updates).max(initial=0))):
        at = updates[updates + age < ends] + age
        values = error[at[counted[at]]]
        if len(values):
            rows.append({"age": age, **_spread(values)})
    return rows


def measure(run: Run) -> Data:
    """Return the errors over time, by the age of the plan, and how often they are zero."""
    force, torque = error_norms(run)
    updates, walking = runs.updates(run), runs.walking(run)
    after = updates[walking[updates]]
    before = after[after > 0] - 1
    zero = SMALL * runs.weight(run)
    end, w = float(run.time[-1]), run.scenario.wbc
    part = (run.time > end - WINDOW - 0.5) & (run.time < end - 0.5)
    large = np.flatnonzero((force > zero) & walking)
    return {
        **runs.facts(run),
        "zero": zero,
        "weight": runs.weight(run),
        "time": runs.decimated(run.time, 1),
        "force": runs.decimated(force, 1),
        "torque": runs.decimated(torque, 1),
        "shown": [float(run.time[part][0]), float(run.time[part][-1])] if part.any() else None,
        "updates": runs.decimated(run.time[updates], 1),
        "force_by_age": by_age(force, updates, walking),
        "torque_by_age": by_age(torque, updates, walking),
        "after_update": _spread(force[after]),
        "before_update": _spread(force[before]),
        "all": _spread(force[walking]),
        "plans": len(after),
        "zero_after": _share_below(zero, force[after]),
        "zero_before": _share_below(zero, force[before]),
        "ticks_not_zero": len(large),
        "share_not_zero": len(large) / max(int(walking.sum()), 1),
        "gains": [w.com_position_gain, w.com_velocity_gain, w.angular_momentum_gain],
    }


def _share_below(bound: float, values: Array) -> float | None:
    return float(np.mean(values <= bound)) if len(values) else None


def _spread(values: Array) -> dict[str, float | None]:
    return runs.quantiles(values, median=50, p95=95, max=100)


def draw(data: Data) -> Figure:
    """Draw both errors: the whole run, a quarter of a second, and by the age of the plan."""
    figure, axes = blank(f"Figure 5. {TITLE}", 2, 3, (13.0, 7.0))
    time = array(data["time"])
    for row, (key, unit) in enumerate((("force", "N"), ("torque", "N m"))):
        whole, part, age = axes[3 * row : 3 * row + 3]
        error = np.maximum(array(data[key]), FLOOR)
        whole.semilogy(time, error, color=BLUE, lw=0.5)
        whole.set_ylabel(f"{key} error [{unit}]")
        whole.set_title("whole run", fontsize=10)
        part.semilogy(time, error, color=BLUE, marker=".", ms=3, lw=0.8)
        part.set_title("in detail; dotted: a new plan", fontsize=10)
        if data["shown"]:
            part.set_xlim(*data["shown"])
        for t in data["updates"]:
            part.axvline(t, color=ORANGE, lw=1.0, ls=":")
        rows = data[f"{key}_by_age"]
        for name, style in (("median", "-"), ("p95", "--"), ("max", ":")):
            values = np.maximum([r[name] for r in rows], FLOOR)
            age.semilogy([r["age"] for r in rows], values, color=BLUE, ls=style, label=name)
        if key == "force":
            for ax in (whole, part, age):
                ax.axhline(data["zero"], color=GREY, lw=1.0, label="counts as zero")
        age.set_title("by age of the plan", fontsize=10)
        age.set_xlabel("age of the plan [ticks of 1 ms]")
        age.legend(loc="best", fontsize=8)
        for ax in (whole, part):
            ax.set_xlabel("time [s]")
    if data["fell"]:
        fallen(figure, [axes[0], axes[3]], data["fall_time"], data["fall_reason"])
    return figure


def table(data: Data) -> list[list[str]]:
    """Return the force error after and before an update, and over all ticks."""
    rows = [["force error [N]", "median", "95 %", "largest"]]
    for key, name in (
        ("after_update", "first tick of a new plan"),
        ("before_update", "last tick of the old one"),
        ("all", "every tick"),
    ):
        rows.append([name, *(shown(data[key][k], ".4f") for k in ("median", "p95", "max"))])
    return rows


def claims(data: Data) -> list[Claim]:
    """Return: the error vanishes with every update, and it is small altogether."""
    share, middle = data["zero_after"], data["all"]["median"]
    before, after = data["before_update"]["p95"], data["after_update"]["p95"]
    gains = "zero" if not any(data["gains"]) else "NOT zero"
    zero = f"{data['zero']:.3f} N, {100 * SMALL:g} % of the weight"
    rare = f"{data['ticks_not_zero']} ticks of walking ({100 * data['share_not_zero']:.1f} %)"
    return [
        Claim(
            "Each time the MPC computes a trajectory, the WBC's error vanishes to zero",
            "vanishes to zero (a picture)",
            "no update while walking"
            if share is None
            else f"{100 * share:.1f} % of {data['plans']} updates, and of the ticks before them "
            f"{100 * data['zero_before']:.1f} %; 95th percentile {before:.3f} N before, "
            f"{after:.3f} N after",
            share is not None and share >= ZERO_SHARE,
            f"Gains of (52), (53) {gains}. Zero means below {zero}; holds when it is so after "
            f"{100 * ZERO_SHARE:g} % of the updates. It is above it in {rare}, at most "
            f"{data['all']['max'] or 0.0:.1f} N.",
        ),
        Claim(
            "The WBC solves the problem almost perfectly",
            "almost perfectly (a picture)",
            "no tick while walking" if middle is None else f"median error {middle:.3f} N",
            middle is not None and middle <= data["zero"],
            f"Median over all ticks of walking; holds below {zero}.",
        ),
    ]
