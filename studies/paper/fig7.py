"""Figure 7: the MPC's centroidal trajectories, and what the whole-body controller made of them."""

import numpy as np
from matplotlib.figure import Figure

from drake_linefoot.lab.simulation.recording import Run
from studies.common import runs
from studies.common.drawing import BLUE, ORANGE, array, legend, over
from studies.common.types import Array, Data
from studies.paper.figure import Claim, shown

TITLE = "Centroidal trajectories: planned by the MPC, and measured"
QUANTITIES = {"r": "CoM [m]", "v": "CoM velocity [m/s]", "L": "angular momentum [kg m^2/s]"}
GOOD = 0.2  # [-] median of the error at the end of a plan, of what changed while it was used
WINDOW = 1.2  # [s] at the end of the run that is shown
STEP = 2  # ticks between two points of the curves


def compute(quick: bool) -> Data:
    """Simulate the walk and compare plan and measurement at every tick."""
    run = runs.simulated(runs.paper_scenario(quick))
    return measure(run, runs.centroidal(run))


def measure(run: Run, measured: dict[str, Array]) -> Data:
    """Return curves of the end of the run, and how far plans are off when they are replaced.

    A plan begins at the measured state, so it is judged at the end of its use, 20 ms later:
    the error against what changed in that time. With zero gains in (52), (53) nothing pulls
    the robot back to the plan; it follows because the planned wrenches act.

    Args:
        run: what was recorded.
        measured: r, v and L of the robot, each of shape (n, 3).
    """
    planned = {"r": run.mpc_com, "v": run.mpc_velocity, "L": run.mpc_momentum}
    begins, ends = runs.uses_of_plans(run)
    rows = []
    for name in QUANTITIES:
        error = np.linalg.norm((planned[name] - measured[name])[ends], axis=1)
        moved = np.linalg.norm(measured[name][ends] - measured[name][begins], axis=1)
        change = runs.percentile(moved, 50)
        rows.append(
            {
                "name": name,
                **runs.quantiles(error, median=50, p95=95, max=100),
                "change": runs.jsonable(change),
                "share": runs.jsonable(runs.percentile(error, 50) / max(change, 1e-12)),
                "share_p95": runs.jsonable(runs.percentile(error, 95) / max(change, 1e-12)),
            }
        )
    late, span = runs.at_the_end(run, WINDOW)
    return {
        **runs.facts(run),
        "shown": span,
        "time": runs.decimated(run.time[late], STEP),
        "planned": {name: runs.decimated(planned[name][late], STEP) for name in QUANTITIES},
        "measured": {name: runs.decimated(measured[name][late], STEP) for name in QUANTITIES},
        "plans": len(begins),
        "period": run.scenario.mpc.period,
        "rows": rows,
    }


def draw(data: Data) -> Figure:
    """Draw r, r' and L in the world frame, planned and measured."""
    figure, axes = over(f"Figure 7. {TITLE}, world frame", data, 3, 3, data["shown"])
    time = array(data["time"])
    for row, (name, label) in enumerate(QUANTITIES.items()):
        for column, axis in enumerate("xyz"):
            ax = axes[3 * row + column]
            planned, measured = (array(data[k][name]) for k in ("planned", "measured"))
            ax.plot(time, planned[:, column], color=ORANGE, lw=4.0, alpha=0.5, label="MPC")
            ax.plot(time, measured[:, column], color=BLUE, lw=1.0, label="measured")
            ax.set_ylabel(f"{axis}: {label}", fontsize=9)
    return legend(figure, axes[0])


def table(data: Data) -> list[list[str]]:
    """Return the error at the end of each plan, and what changed while it was used."""
    used = f"{1e3 * data['period']:g} ms"
    rows = [
        [
            f"error after {used}",
            "median",
            "95 %",
            "largest",
            f"median change in {used}",
            "share",
            "95 %",
        ]
    ]
    for row in data["rows"]:
        numbers = (row[key] for key in ("median", "p95", "max", "change", "share", "share_p95"))
        rows.append([QUANTITIES[row["name"]], *(shown(value, ".3g") for value in numbers)])
    return rows


def claims(data: Data) -> list[Claim]:
    """Return: the WBC tracks the centroidal trajectories."""
    result = []
    for key, words in (("share", "median"), ("share_p95", "95th percentile of the")):
        shares = {row["name"]: row[key] for row in data["rows"]}
        known = all(share is not None for share in shares.values())
        ours = ", ".join(f"{name} {100 * share:.1f} %" for name, share in shares.items() if share)
        result.append(
            Claim(
                f"The WBC tracks the MPC's centroidal trajectories ({words} error)",
                "performs a good job (a picture)",
                ours if known else "no plan while walking",
                known and max(shares.values()) <= GOOD,
                f"Error at the end of each of {data['plans']} plans, as a share of the median "
                f"change while it was used ({1e3 * data['period']:g} ms); holds when r, v and L "
                f"are within {100 * GOOD:g} %. Nothing in the WBC pulls back to the plan (zero "
                "gains).",
            )
        )
    return result
