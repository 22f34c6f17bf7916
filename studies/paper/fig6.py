"""Figure 6: the normal force the MPC desires, the one the WBC settles on, and the true one."""

from typing import Any

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from drake_linefoot.lab.simulation.recording import Run
from studies.common import runs
from studies.common.drawing import BLUE, GREEN, ORANGE, array, legend, over
from studies.common.types import Array, Data
from studies.paper.figure import Claim, shown

TITLE = "Normal force of each foot: desired, resulting, true"
FEET = ("left foot", "right foot")
WINDOW = 1.2  # [s] at the end of the run that is shown
LANDING = 0.02  # [s] after touchdown that is counted apart
CLOSE = 0.01, 0.05  # [-] of the weight: the WBC's error and the true force's, as RMS
STEP = 2  # ticks between two points of the curves


def compute(quick: bool) -> Data:
    """Simulate the walk and compare the normal forces."""
    return measure(runs.simulated(runs.paper_scenario(quick)))


def landing(planned: Array, ticks: int) -> NDArray[np.bool_]:
    """Return which samples are among the first `ticks` after a foot begins to stand.

    `planned` is whether it stands for the controller, 0 or 1, shape (n,).
    """
    begins = np.flatnonzero(np.diff(planned) > 0.5) + 1
    flags = np.zeros(len(planned), dtype=bool)
    for begin in begins:
        flags[begin : begin + ticks] = True
    return flags


def measure(run: Run) -> Data:
    """Return curves of the end of the run, and RMS differences of the feet that stand."""
    walking = runs.walking(run)
    rows = []
    ticks = round(LANDING / runs.CONTROL_PERIOD)
    # the true force of a row belongs to the step that ended there, the torque that made it to
    # the row before
    mpc, wbc, true = run.mpc_wrench[:-1, :, 2], run.wbc_wrench[:-1, :, 2], run.true_force[1:, :, 2]
    for side, foot in enumerate(FEET):
        stands = (run.planned_contact[:-1, side] > 0.5) & walking[:-1]
        lands = landing(run.planned_contact[:-1, side], ticks)
        for part, chosen in (("standing", stands & ~lands), ("landing", stands & lands)):
            rows.append(
                {
                    "foot": foot,
                    "part": part,
                    "ticks": int(chosen.sum()),
                    "wbc_mpc": runs.jsonable(runs.rms((wbc - mpc)[chosen, side])),
                    "true_wbc": runs.jsonable(runs.rms((true - wbc)[chosen, side])),
                    "true_mpc": runs.jsonable(runs.rms((true - mpc)[chosen, side])),
                }
            )
    late, span = runs.at_the_end(run, WINDOW)
    return {
        **runs.facts(run),
        "weight": runs.weight(run),
        "shown": span,
        "time": runs.decimated(run.time[late], STEP),
        "mpc": runs.decimated(run.mpc_wrench[late, :, 2], STEP),
        "wbc": runs.decimated(run.wbc_wrench[late, :, 2], STEP),
        "true": runs.decimated(run.true_force[late, :, 2], STEP),
        "rows": rows,
    }


def draw(data: Data) -> Figure:
    """Draw the three forces of both feet over the end of the run."""
    figure, axes = over(f"Figure 6. {TITLE}", data, 2, span=data["shown"])
    time = array(data["time"])
    for side, ax in enumerate(axes):
        for key, colour, width, label in (
            ("mpc", ORANGE, 5.0, "desired, MPC"),
            ("true", GREEN, 1.6, "true, of the simulator"),
            ("wbc", BLUE, 0.9, "resulting, whole-body controller"),
        ):
            values = array(data[key])[:, side]
            alpha = 0.45 if key == "mpc" else 1.0
            ax.plot(time, values, color=colour, lw=width, alpha=alpha, label=label)
        top = max(float(np.nanmax(array(data["mpc"])[:, side])), 10.0)
        ax.set_ylim(-0.08 * top, 2.0 * top)
        ax.set_ylabel(f"{FEET[side]} [N]")
    return legend(figure, axes[0])


def table(data: Data) -> list[list[str]]:
    """Return RMS differences for each foot, standing and landing."""
    rows = [["foot", "ticks", "WBC - MPC [N]", "true - WBC [N]", "true - MPC [N]"]]
    for row in data["rows"]:
        numbers = (shown(row[key], ".2f") for key in ("wbc_mpc", "true_wbc", "true_mpc"))
        rows.append([f"{row['foot']}, {row['part']}", str(row["ticks"]), *numbers])
    return rows


def claims(data: Data) -> list[Claim]:
    """Return: the WBC's normal force is the MPC's, and so is the true one."""
    weight = data["weight"]
    result = []
    for key, share, part, claim in (
        ("wbc_mpc", CLOSE[0], "", "The resulting normal force (WBC) is the desired one (MPC)"),
        ("true_mpc", CLOSE[1], "", "The true normal force is the desired one"),
        ("true_mpc", CLOSE[1], "standing", "The same, once the foot stands"),
    ):
        rows = [r for r in data["rows"] if part in r["part"] and r[key] is not None]
        value = _pooled(rows, key)
        landing_rms = _pooled([r for r in data["rows"] if r["part"] == "landing"], key)
        note = (
            f"RMS over both feet while they stand; holds below {100 * share:g} % of the weight "
            f"({weight * share:.1f} N). In the {1e3 * LANDING:g} ms after touchdown "
            f"it is {'-' if landing_rms is None else f'{landing_rms:.1f} N'}"
            + (", which is left out here." if part else ", which is counted.")
        )
        ours = "never stood" if value is None else f"RMS {value:.2f} N"
        holds = value is not None and value <= share * weight
        result.append(Claim(claim, "performs pretty well (a picture)", ours, holds, note))
    return result


def _pooled(rows: list[dict[str, Any]], key: str) -> float | None:
    """Return the RMS over the ticks of several rows."""
    rows = [row for row in rows if row[key] is not None]
    ticks = sum(row["ticks"] for row in rows)
    if not ticks:
        return None
    return float(np.sqrt(sum(row["ticks"] * row[key] ** 2 for row in rows) / ticks))
