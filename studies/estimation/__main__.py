"""`python -m studies.estimation`: drift, consistency, robustness and cost of the estimate."""

import sys
import time as clock
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from matplotlib.figure import Figure
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from scipy.stats import chi2

from drake_linefoot.centroidal import NO_WRENCH
from drake_linefoot.constants import GRAVITY
from drake_linefoot.estimation.state_estimator import StateEstimator
from drake_linefoot.estimation.wrench_estimate import half_the_weight
from drake_linefoot.lab.plants.scene import add_plant
from drake_linefoot.lab.pool import Pool
from drake_linefoot.lab.results.page import render
from drake_linefoot.lab.results.tables import wide_console
from drake_linefoot.lab.scenario import Scenario
from drake_linefoot.layout import flat
from drake_linefoot.robot.humanoid import load_humanoid
from drake_linefoot.signals import ContactEstimate
from studies.common.command import Processes, Quick, run
from studies.common.drawing import BLUE, GREY, blank
from studies.common.files import prepare, write_json, write_picture, write_text
from studies.common.pool import carry_out
from studies.common.stamp import cpu_seconds, stamped
from studies.estimation.walks import LOSSES, SEEN, SETTLED, SPEEDS, Walk, lost, probe, walked

SUMMARY, PAGE, PICTURE = "summary.json", "index.md", "errors.png"
BARS = {  # key: bar, unit, whether less is better
    "drift_xy_percent": (1.0, "% of the way", True),
    "drift_z_m": (0.03, "m", True),
    "drift_yaw_deg": (2.0, "deg", True),
    "velocity_rmse": (0.03, "m/s", True),
    "tilt_rmse_deg": (0.3, "deg", True),
    "nees_inside": (0.9, "of the time", False),
    **{f"loss_{name}": (2.0, "points", True) for name in LOSSES},
    "estimator_tick_over_plant_step": (0.5, "-", True),
    "forward_on_estimate": (1.3, "m/s", False),
}
TICKS, REPEATS = 100, 9  # of the timings; the fastest counts


def estimation(
    out: Annotated[Path, typer.Option(help="Folder of the page.")] = Path("docs/estimation"),
    seeds: Annotated[int, typer.Option(min=1, help="Of every number.")] = 20,
    way: Annotated[float, typer.Option(min=1.0, help="Of the long walk [m].")] = 100.0,
    quick: Quick = False,
    workers: Processes = None,
) -> None:
    """Walk on the estimate and on the truth; write page, picture and summary.json."""
    seeds, way = (1, 6.0) if quick else (seeds, way)
    words = f"python -m studies.estimation --seeds {seeds} --way {way:g}"
    prepare(out)
    walks = [Walk("drift", seed, True, way) for seed in range(seeds)]
    walks += [Walk("forward", seed, True, speed) for seed in range(seeds) for speed in SPEEDS]
    walks += [Walk(kind, i, on) for kind in LOSSES for i in range(seeds) for on in (False, True)]
    with Pool(workers) as pool:
        rows = carry_out(walked, walks, lost, pool, wide_console())
    summary = {**summarize(rows), "estimator_tick_over_plant_step": tick_share()}
    made = stamped("estimation", cpu_seconds(), None if quick else probe)
    about = {"seeds": seeds, "way_m": way, "command": words, **made}
    write_picture(out / PICTURE, draw(rows))
    write_json(out / SUMMARY, {**summary, **about})
    write_text(out / PAGE, page_of(summary, about, rows))
    typer.echo(str(out / PAGE))


def summarize(rows: Sequence[Mapping[str, Any]]) -> dict[str, float]:
    """Return the numbers of `BARS`, but for the time, of the rows of `walked`."""
    long = [row for row in rows if row["errors"]]
    errors = [np.array(row["errors"]) for row in long]
    last = np.array([e[-1] for e in errors])
    ways = np.array([row["way"] for row in long])
    settled = np.concatenate([e[e[:, 0] > SETTLED] for e in errors])
    result = {
        "drift_xy_percent": 100.0 * _rms(np.linalg.norm(last[:, 7:9], axis=1) / ways),
        "drift_z_m": _rms(last[:, 9]),
        "drift_yaw_deg": float(np.degrees(_rms(last[:, 3]))),
        "velocity_rmse": _rms(np.linalg.norm(settled[:, 19:22], axis=1)),
        "tilt_rmse_deg": float(np.degrees(_rms(settled[:, 1:3]))),
        "nees_inside": nees_inside(errors),
    }
    for kind in LOSSES:
        fallen = [
            np.mean(
                [
                    not row["upright"]
                    for row in rows
                    if (row["kind"], row["on_estimate"]) == (kind, on)
                ]
            )
            for on in (True, False)
        ]
        result[f"loss_{kind}"] = 100.0 * float(fallen[0] - fallen[1])
    walks = [row for row in rows if row["kind"] == "forward"]
    held = [v for v in SPEEDS if all(row["upright"] for row in walks if row["size"] == v)]
    result["forward_on_estimate"] = max(held, default=0.0)
    return result


def nees_inside(errors: Sequence[np.ndarray[Any, np.dtype[np.float64]]]) -> float:
    """Return for which share of the time the mean NEES of all walks is inside its 95 % bounds."""
    length, n = min(map(len, errors)), len(errors)
    low, high = chi2.ppf([0.025, 0.975], n * len(SEEN)) / n
    mean = np.mean([e[:length, -1] for e in errors], axis=0)
    settled = errors[0][:length, 0] > SETTLED
    return float(np.mean((low < mean[settled]) & (mean[settled] < high)))


def tick_share() -> float:
    """Return the time of a tick of the estimator over that of a step of the plant alone."""
    scenario, humanoid = Scenario(), load_humanoid(Scenario().robot)
    builder = DiagramBuilder()
    plant, *_ = add_plant(builder, humanoid, scenario, drawn=False)
    bare = Simulator(builder.Build())
    context = plant.GetMyMutableContextFromRoot(bare.get_mutable_context())
    plant.get_actuation_input_port().FixValue(context, np.zeros(humanoid.na))
    parameters = scenario.onboard, scenario.state_estimator
    estimator = StateEstimator(humanoid, *parameters)
    alone = Simulator(estimator)
    weight, none = half_the_weight(humanoid.mass, humanoid.contact.size), np.zeros(humanoid.nv)
    contact = ContactEstimate(weight, np.ones(2), none, NO_WRENCH)
    for name, value in (
        ("imu", np.concatenate([np.zeros(3), -GRAVITY])),
        ("encoders", humanoid.q_nominal[humanoid.actuated_q]),
        ("contact", flat(contact)),
    ):
        estimator.GetInputPort(name).FixValue(alone.get_mutable_context(), value)
    times = []
    for _ in range(REPEATS):  # standing; let fall from there it has no contacts to solve
        plant.SetPositionsAndVelocities(context, humanoid.x_nominal)
        times.append([_time(simulator) for simulator in (alone, bare)])
    tick, step = np.min(times, axis=0)
    return float(tick / step)


def _time(simulator: Simulator) -> float:
    now = simulator.get_context().get_time()
    begin = clock.perf_counter()
    simulator.AdvanceTo(now + 1e-3 * TICKS)
    return clock.perf_counter() - begin


def draw(rows: Sequence[Mapping[str, Any]]) -> Figure:
    """Return the errors of the long walks over time with their 3 sigma."""
    panels = {"tilt [rad]": 1, "heading [rad]": 3, "velocity ahead [m/s]": 4, "height [m]": 9}
    figure, axes = blank("Error of the estimate, and 3 sigma", 2, 2, size=(12.0, 6.5))
    for ax, (label, column) in zip(axes, panels.items(), strict=True):
        for row in rows:
            if row["errors"]:
                e = np.array(row["errors"])
                ax.plot(e[:, 0], e[:, column], color=BLUE, lw=0.7)
                for sign in (-3.0, 3.0):
                    ax.plot(e[:, 0], sign * e[:, column + 9], color=GREY, lw=0.5)
        ax.set_ylabel(label)
        ax.set_xlabel("time [s]")
    return figure


def page_of(
    summary: Mapping[str, float], about: Mapping[str, Any], rows: Sequence[Mapping[str, Any]]
) -> str:
    """Return the page."""
    falls = [row for row in rows if row["on_estimate"] and not row["upright"]]
    values = {"summary": summary, "bars": BARS, "falls": falls, "picture": PICTURE, **about}
    return render("index.md.j2", Path(__file__).parent, **values)


def _rms(values: Any) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


if __name__ == "__main__":
    sys.exit(run(estimation, "estimation"))
