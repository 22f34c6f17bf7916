"""`python -m studies.estimation`: drift, consistency, robustness and cost of the estimate.

Every walk that is done is kept at once, one a line; a study that was broken off goes on with what
this code found, or finds the same.
"""

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

from drake_linefoot.centroidal import NO_WRENCH
from drake_linefoot.constants import GRAVITY
from drake_linefoot.estimation.state_estimator import StateEstimator
from drake_linefoot.estimation.wrench_estimate import half_the_weight
from drake_linefoot.lab.plants.scene import add_plant
from drake_linefoot.lab.results.page import render
from drake_linefoot.lab.results.tables import VERDICTS, wide_console
from drake_linefoot.lab.scenario import Scenario
from drake_linefoot.layout import flat
from drake_linefoot.robot.humanoid import load_humanoid
from drake_linefoot.signals import ContactEstimate
from studies.common.bars import HEAD, bar_rows
from studies.common.command import Fresh, PageOut, Processes, Quick, folder_of, run
from studies.common.drawing import BLUE, GREY, blank
from studies.common.files import write_json, write_picture, write_text
from studies.common.stamp import stamped
from studies.common.trials import FRESH, TRIALS, Trials, seconds_of
from studies.common.types import Data
from studies.estimation.summary import UPRIGHT, summarize
from studies.estimation.walks import LOSSES, SPEEDS, Walk, known, limit, lost, probe, walked

SUMMARY, PAGE, PICTURE = "summary.json", "index.md", "errors.png"
SEEDS, RUNS, WAY = 20, 200, 100.0  # of the long walks and those ahead, of each group; [m]
QUICK = 1, 1, 6.0  # likewise
TICKS, REPEATS = 100, 9  # of the timings; the fastest counts


def estimation(
    out: PageOut = None,
    seeds: Annotated[int, typer.Option(min=1, help="Of the long walks and those ahead.")] = SEEDS,
    runs: Annotated[int, typer.Option(min=1, help="Pairs of walks of each group.")] = RUNS,
    way: Annotated[float, typer.Option(min=1.0, help="Of the long walk [m].")] = WAY,
    quick: Quick = False,
    fresh: Fresh = False,
    workers: Processes = None,
) -> None:
    """Walk on the estimate and on the truth; write page, picture and summary.json."""
    screen = wide_console()
    seeds, runs, way = QUICK if quick else (seeds, runs, way)
    out = folder_of(out, "estimation", quick)
    walks = wanted(seeds, runs, way, SPEEDS[:1] if quick else SPEEDS)
    trials = Trials(out / TRIALS, walked, lost, limit, workers)
    rows = trials.begun(walks, fresh)
    rows |= {key: row for key, row in known(walks).items() if key not in rows}
    for count, row in trials.carried_out(walks, rows):
        said = "" if row["upright"] else f": {row['reason']}"
        screen.print(f"{count} of {len(walks)}: {row['key']}{said}", markup=False)
    found = [rows[walk.key] for walk in walks]
    made = stamped("estimation", seconds_of(found), None if quick else probe)
    command = f"python -m studies.estimation --seeds {seeds} --runs {runs} --way {way:g}"
    about = {"seeds": seeds, "runs": runs, "way_m": way, "command": command, **made}
    summary = {**summarize(found, tick_share()), **about}
    write_picture(out / PICTURE, draw(found))
    write_json(out / SUMMARY, summary)
    write_text(out / PAGE, page_of(summary, found))
    typer.echo(str(out / PAGE))


def wanted(seeds: int, runs: int, way: float, speeds: Sequence[float] = SPEEDS) -> list[Walk]:
    """Return what is to be walked, what takes longest first.

    Args:
        seeds: of the long walks, and of those ahead at each speed.
        runs: pairs of walks of each group.
        way: of the long walks [m].
        speeds: of the walks ahead [m/s].
    """
    walks = [Walk("drift", FRESH + i, True, way) for i in range(seeds)]
    walks += [Walk("forward", FRESH + i, True, speed) for i in range(seeds) for speed in speeds]
    return walks + [
        Walk(kind, i, on) for i in range(runs) for kind in LOSSES for on in (False, True)
    ]


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


def page_of(summary: Data, rows: Sequence[Mapping[str, Any]]) -> str:
    """Return the page."""
    falls = [row for row in rows if row["on_estimate"] and not row["upright"]]
    values = {"summary": summary, "falls": falls, "picture": PICTURE, "share": UPRIGHT}
    values |= {"head": HEAD, "bars": bar_rows(summary["bars"])}
    whole = {"seeds": SEEDS, "runs": RUNS, "way_m": WAY}
    quick = any(summary[name] < least for name, least in whole.items())
    values |= {"verdicts": VERDICTS, "whole": whole, "quick": quick}
    return render("index.md.j2", Path(__file__).parent, **values)


if __name__ == "__main__":
    sys.exit(run(estimation, "estimation"))
