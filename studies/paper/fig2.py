"""Figure 2 and section IV: time of the whole-body controller with a line and with two points.

Both controllers get the same recorded states one after the other, in turns, from the same solver,
with the step size rho of OSQP that suits each best (`Clock.tune`).
Five times are taken (see `STAGES`); the rigid-body quantities of the state, the Jacobians of line
and points among them, are in none of them. Every state goes through the solver, also where the
controller itself would have seen that no cone is touched.
"""

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from studies.common import runs
from studies.common.drawing import BLUE, ORANGE, blank
from studies.common.recorder import record, spread
from studies.common.types import Array, Data
from studies.paper.clock import RHOS, Clock
from studies.paper.figure import Claim

TITLE = "Solving time with a line contact and with two point contacts"
SEED = 0  # of the order of the states and of the bootstrap
STAGES = {
    "qp": "QP alone, the solver's own time",
    "clarabel": "QP alone, by Clarabel instead",
    "program": "QP alone, with Drake around it",
    "recursion": "QP and kinematics, pseudoinverses",
    "factorisation": "QP and kinematics, one QR",
}
SUPPORTS = {"single": "single support", "double": "double support"}
PAPER = {  # [%] faster with a line, section IV
    ("single", "qp"): 20.83,
    ("single", "recursion"): 6.37,
    ("double", "qp"): 21.2,
    ("double", "recursion"): 13.2,
}
RESAMPLES = 2000
TRIED = 60  # states on which step sizes are tried
LEVEL = 95.0  # [%] of the confidence interval


def compute(quick: bool) -> Data:
    """Record a walk, then time both controllers on its states."""
    states, repetitions = (40, 3) if quick else (200, 7)
    scenario = runs.paper_scenario(quick=True)
    walk = record(scenario, 1)
    fallen = [{"fall_reason": walk.fall_reason}] if walk.fall_reason else []
    clock = Clock(scenario)
    tuned = clock.tune([(t.before.x, t.targets, t.plan) for t in spread(list(walk.ticks), TRIED)])
    rng = np.random.default_rng(SEED)
    result: dict[str, Any] = {}
    for support, count in (("single", 1), ("double", 2)):
        ticks = spread([t for t in walk.ticks if sum(t.targets.contact) == count], states)
        rows = []
        for i in range(repetitions):
            order = rng.permutation(len(ticks))
            taken = np.empty((len(ticks), 2, len(STAGES) + 1))
            for j, index in enumerate(order):
                t = ticks[index]
                taken[index] = clock.both(
                    t.before.x, t.targets, t.plan, points_first=bool((i + j) % 2)
                )
            rows.append(taken)
        result[support] = summary(np.median(rows, axis=0))
    return {
        **runs.facts_of_rows(scenario, [scenario.seed], fallen),
        "solver": scenario.wbc.solver,
        "repetitions": repetitions,
        "rhos": list(RHOS),
        "tuned": dict(zip(("line", "points"), tuned, strict=True)),
        "supports": result,
    }


def summary(milliseconds: Array) -> Data:
    """Return median, quartiles and how much faster a line is, by stage.

    Args:
        milliseconds: of every state, and the iterations, shape (n, 2, stages + 1), the line
            before the points.

    Returns:
        "states": n; "iterations": quartiles and mean of both; for each of `STAGES` the quartiles
        of line and points, `faster`: percent by which the mean is smaller with a line (the
        paper's numbers are averages, and the times have two peaks: OSQP looks only every 10
        iterations whether it is done), `median_faster`: the same of medians, and `interval`: of
        `faster`, by a bootstrap over the states, which keeps both times of a state together.
    """
    from scipy.stats import bootstrap

    counts = dict(zip(("line", "points"), milliseconds[..., -1].T, strict=True))
    result: Data = {"states": len(milliseconds)}
    result["iterations"] = {
        form: {"quartiles": np.percentile(n, [25, 50, 75]).tolist(), "mean": float(np.mean(n))}
        for form, n in counts.items()
    }
    how = {"confidence_level": 0.01 * LEVEL, "n_resamples": RESAMPLES, "method": "percentile"}
    for k, stage in enumerate(STAGES):
        line, points = milliseconds[..., k].T
        interval = bootstrap((line, points), faster, paired=True, rng=SEED, **how)
        result[stage] = {
            "line": np.percentile(line, [25, 50, 75]).tolist(),
            "points": np.percentile(points, [25, 50, 75]).tolist(),
            "faster": float(faster(line, points)),
            "median_faster": float(100.0 * (1.0 - np.median(line) / np.median(points))),
            "interval": [float(bound) for bound in interval.confidence_interval],
        }
    return result


def faster(line: Array, points: Array, axis: int = -1) -> Array:
    """Return by how many percent the mean of the first times is smaller."""
    result: Array = 100.0 * (1.0 - np.mean(line, axis) / np.mean(points, axis))
    return result


def draw(data: Data) -> Figure:
    """Draw the times as bars, one axes for each stage."""
    figure, axes = blank(f"Figure 2. {TITLE}", 1, len(STAGES), (15.0, 5.0))
    for ax, (stage, title) in zip(axes, STAGES.items(), strict=True):
        for i, support in enumerate(SUPPORTS):
            one = data["supports"][support][stage]
            for j, (contact, colour) in enumerate((("line", BLUE), ("points", ORANGE))):
                low, middle, high = one[contact]
                at = i + 0.36 * (j - 0.5)
                error = [[middle - low], [high - middle]]
                label = {"line": "line contact", "points": "two point contacts"}[contact]
                ax.bar(at, middle, 0.34, yerr=error, capsize=4, color=colour, label=label)
            text = f"{one['faster']:.1f} % faster\n[{_interval(one)}]"
            if (support, stage) in PAPER:
                text += f"\npaper {PAPER[support, stage]:.1f} %"
            top = max(one["line"][2], one["points"][2])
            ax.annotate(text, (i, top), (0, 4), "data", "offset points", ha="center", fontsize=8)
        ax.set_xticks(range(len(SUPPORTS)), list(SUPPORTS.values()))
        ax.set_title(title.replace(", ", ",\n"), fontsize=10)
        ax.set_ylim(0.0, 1.25 * ax.get_ylim()[1])
    axes[0].set_ylabel("median and quartiles [ms]; gain of the mean")
    handles, labels = axes[0].get_legend_handles_labels()
    figure.legend(handles[:2], labels[:2], loc="outside lower center", ncols=2)
    return figure


def _interval(one: Data) -> str:
    return " to ".join(f"{value:.1f}" for value in one["interval"])


def table(data: Data) -> list[list[str]]:
    """Return times, spread and gain of every stage."""
    header = ["support", "what", "states", "line [ms]", "two points [ms]", "line faster", "paper"]
    rows = [header]
    for support, name in SUPPORTS.items():
        for stage, title in STAGES.items():
            one = data["supports"][support][stage]
            times = [
                f"{middle:.4f} ({low:.4f} to {high:.4f})"
                for low, middle, high in (one["line"], one["points"])
            ]
            paper = PAPER.get((support, stage))
            rows.append(
                [
                    name,
                    title,
                    str(data["supports"][support]["states"]),
                    *times,
                    f"{one['faster']:.1f} % ({_interval(one)})",
                    "-" if paper is None else f"{paper:.1f} %",
                ]
            )
    return rows


def _iterations(data: Data, support: str) -> str:
    """Return how often the solver iterates in both forms, with which step size."""
    words = []
    for form, counts in data["supports"][support]["iterations"].items():
        rho = data["tuned"][form]["rho"]
        mean, middle = counts["mean"], counts["quartiles"][1]
        words.append(f"{form} {mean:.0f} (median {middle:.0f}, rho {rho:.2g})")
    return f"Iterations, each form with its best rho: {', '.join(words)}."


def claims(data: Data) -> list[Claim]:
    """Return: with a line the QP is faster, and so are QP and kinematics together."""
    result = []
    for (support, stage), paper in PAPER.items():
        one = data["supports"][support][stage]
        note = (
            f"{data['solver'].upper()}, {data['supports'][support]['states']} recorded states, "
            f"median of {data['repetitions']} rounds each, means compared; the interval is "
            f"{LEVEL:.0f} %. Of medians: {one['median_faster']:.1f} %. "
            f"{_iterations(data, support)} "
        )
        other = "program" if stage == "qp" else "factorisation"
        more = data["supports"][support][other]
        note += f"{STAGES[other]}: {more['faster']:.1f} % ({_interval(more)})."
        if stage == "qp":
            more = data["supports"][support]["clarabel"]
            note += f" {STAGES['clarabel']}: {more['faster']:.1f} % ({_interval(more)})."
        result.append(
            Claim(
                f"A line contact is solved faster than two points: {STAGES[stage].split(',')[0]}, "
                f"{SUPPORTS[support]}",
                f"{paper:.1f} % faster",
                f"{one['faster']:.1f} % faster ({_interval(one)})",
                one["interval"][0] > 0.0,
                note,
            )
        )
    return result
