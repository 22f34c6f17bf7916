"""The same walks in MuJoCo and in Drake: `python -m studies.transfer` writes docs/transfer/."""

import math
import sys
import time
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console

from drake_linefoot.lab.pool import Pool
from drake_linefoot.lab.results.judge import judge, upright
from drake_linefoot.lab.results.provenance import made_with
from drake_linefoot.lab.results.tables import number
from drake_linefoot.lab.scenario import PlantParameters, Scenario
from drake_linefoot.lab.scenario.disturbances import ActuatorParameters, PushParameters
from drake_linefoot.lab.scenario.load import dump_scenario, parse_scenario
from drake_linefoot.lab.scenario.schema import MujocoParameters
from drake_linefoot.lab.simulation.run import simulate
from drake_linefoot.lab.wiring.closed_loop import build_closed_loop
from studies.common import paired
from studies.common.command import Fresh, Out, Processes, Quick, run
from studies.common.files import prepare, write_json, write_text
from studies.common.pool import carry_out
from studies.common.stamp import Probed, cpu_seconds, stamped
from studies.common.trial import walk
from studies.common.trials import carried_out, kept, seconds_of
from studies.common.types import Data

OUT = Path("docs/transfer")
LENGTH, SHORT = 5.0, 3.0  # [s] of a walk
PUSH = PushParameters(time=2.0, impulse=10.0, direction=1.57)  # to the left, 10 N s
ESTIMATE, LATE = "0.8 m/s, on the estimate", "0.8 m/s, torques 5 ms late"
# What a run is told, forward, left [m/s] and turn rate [rad/s], and what else is changed.
CASES: dict[str, tuple[tuple[float, float, float], dict[str, Any]]] = {
    "0.4 m/s": ((0.4, 0.0, 0.0), {}),
    "0.8 m/s": ((0.8, 0.0, 0.0), {}),
    "1.2 m/s": ((1.2, 0.0, 0.0), {}),
    "0.3 m/s, turn 0.5 rad/s": ((0.3, 0.0, 0.5), {}),
    "0.2 m/s to the left": ((0.0, 0.2, 0.0), {}),
    "0.4 m/s, pushed with 10 N s": ((0.4, 0.0, 0.0), {"pushes": [PUSH]}),
    ESTIMATE: ((0.8, 0.0, 0.0), {"estimation": True}),
    LATE: ((0.8, 0.0, 0.0), {"actuators": ActuatorParameters(delay=0.005)}),
}
MUJOCO, OWN, DRAKE = "MuJoCo", "MuJoCo, its own contacts", "Drake"
MUJOCO_2, DRAKE_2 = "MuJoCo, 2 ms", "Drake, 2 ms"
ITS_OWN = MujocoParameters("pyramidal", 1.0, [0.02, 1.0], [0.9, 0.95, 0.001, 0.5, 2.0])
PLANTS = {
    MUJOCO: PlantParameters(simulator="mujoco"),
    OWN: PlantParameters(simulator="mujoco", mujoco=ITS_OWN),
    MUJOCO_2: PlantParameters(simulator="mujoco", time_step=0.002),
    DRAKE: PlantParameters(),
    DRAKE_2: PlantParameters(time_step=0.002),
}
SPEED, ITS_OWN_SPEED, LATENCY, RATE = 0.03, 0.05, 5.0, 2.5  # [m/s], [m/s], [ms], [-] to keep to
RUNS, LESS = 100, 5.0  # of each group of the sweep; [%] fewer upright ones than in Drake at most


def scenario_of(case: str, plant: str, length: float) -> Scenario:
    """Return what a case is in a plant, with a length [s]."""
    command, changes = CASES[case]
    made = replace(walk(Scenario(), command, length), plant=PLANTS[plant], **changes)
    delay, step = made.actuators.delay, made.plant.time_step
    steps = math.ceil(delay / step - 1e-9)  # whole ones: 6 ms at steps of 2
    return replace(made, actuators=replace(made.actuators, delay=steps * step))


def walked(job: tuple[str, str, str]) -> Data:
    """Simulate and judge a case in a plant; the third of a job is the scenario as YAML."""
    loop = build_closed_loop(parse_scenario(job[2]))
    start = time.process_time()
    done = simulate(loop)
    seconds = time.process_time() - start
    outcome = judge(done)
    names = "speed_error", "contact_latency", "false_contacts", "missed_contacts", "fall_reason"
    kept = {name: outcome[name] for name in names}
    rate = float(done.time[-1]) / seconds
    return {"case": job[0], "plant": job[1], "upright": upright(outcome), **kept, "rate": rate}


def lost(job: tuple[str, str, str], error: str) -> Data:
    """Return what stands for `walked` of a run whose process crashed or took too long."""
    nothing = dict.fromkeys(("speed_error", "contact_latency", "false_contacts", "missed_contacts"))
    row = {"case": job[0], "plant": job[1], "upright": False, "fall_reason": error}
    return {**row, **nothing, "rate": None}


def probe() -> dict[str, Probed]:
    """Return a quick form of the study: a short walk in MuJoCo."""
    case = "0.8 m/s"
    row = walked((case, MUJOCO, dump_scenario(scenario_of(case, MUJOCO, SHORT))))
    found = {"upright": Probed(float(row["upright"]), 0.0)}
    if row["speed_error"] is not None:
        found["speed_error_m_s"] = Probed(row["speed_error"], 0.5 * SPEED)
    return found


def bars_of(rows: Sequence[Mapping[str, Any]], pairs: Mapping[str, Data]) -> list[Data]:
    """Return what is asked: `what`, `value`, `bar`, and whether it `holds`.

    Args:
        rows: of `walked`.
        pairs: see `shares`.
    """

    def of(plant: str, name: str, cases: Sequence[str] = tuple(CASES)) -> list[float]:
        mine = [row[name] for row in rows if row["plant"] == plant and row["case"] in cases]
        return [value for value in mine if value is not None]

    fell = sum(not row["upright"] for row in rows)
    ours = [name for name in CASES if name not in (ESTIMATE, LATE) and "push" not in name]
    rates = [of(plant, "rate") for plant in (MUJOCO_2, DRAKE)]
    ratio = [sum(rate) / len(rate) for rate in rates if rate]
    asked = (
        ("runs that are not upright", fell, 0.0),
        ("speed in MuJoCo: largest error [m/s]", max(of(MUJOCO, "speed_error", ours)), SPEED),
        ("likewise with its own contacts", max(of(OWN, "speed_error", ours)), ITS_OWN_SPEED),
        ("likewise on the estimate", max(of(MUJOCO, "speed_error", [ESTIMATE])), ITS_OWN_SPEED),
        ("likewise with 5 ms of delay", max(of(MUJOCO, "speed_error", [LATE])), ITS_OWN_SPEED),
        ("false contacts in MuJoCo, without pushes", sum(of(MUJOCO, "false_contacts", ours)), 0.0),
        ("latency of contacts in MuJoCo [ms]", max(of(MUJOCO, "contact_latency", ours)), LATENCY),
    )
    found: list[Data] = [
        {"what": what, "value": value, "bar": bar, "holds": value <= bar + 1e-9}
        for what, value, bar in asked
    ]
    share = ratio[0] / ratio[1]
    quick = "simulated seconds a CPU second: MuJoCo at 2 ms over Drake at 1 ms"
    found.append({"what": quick, "value": share, "bar": RATE, "holds": share >= RATE})
    fewer = [100.0 * (one["drake"] - one["mujoco"]) / one["runs"] for one in pairs.values()]
    what, most = "group with the most runs fewer upright in MuJoCo [%]", max(fewer, default=0.0)
    return [*found, {"what": what, "value": most, "bar": LESS, "holds": most <= LESS}]


def page_of(
    rows: Sequence[Mapping[str, Any]], bars: Sequence[Mapping[str, Any]], pairs: Mapping[str, Data]
) -> str:
    """Return the page, as Markdown for the documentation."""
    lines = [
        "# The same walks in two simulators",
        "",
        f"**The speed in MuJoCo is off by {number(bars[1]['value'], '.2g')} m/s at most; "
        f"{sum(bar['holds'] for bar in bars)} of {len(bars)} bars hold.**",
        "",
        "The MIT Humanoid in Drake and in",
        "[MuJoCo](../simulators.md#mujoco), in the contacts that a scenario has by default and in",
        "those that MuJoCo has. Errors of the speed are the largest of a run's segments.",
        "",
        "| what is asked | found | bar | |",
        "|---|---|---|---|",
    ]
    for bar in bars:
        value, holds = number(bar["value"], ".3g"), "holds" if bar["holds"] else "**missed**"
        lines.append(f"| {bar['what']} | {value} | {bar['bar']:g} | {holds} |")
    for title, name, spec in (
        ("Error of the speed [m/s]", "speed_error", ".3f"),
        ("Latency of contacts, median [ms]", "contact_latency", ".0f"),
        ("False contacts", "false_contacts", "d"),
        ("Simulated seconds a CPU second", "rate", ".2f"),
    ):
        lines += ["", f"## {title}", "", "| |" + "".join(f" {plant} |" for plant in PLANTS)]
        lines.append("|---|" + "---|" * len(PLANTS))
        for case in CASES:
            at = {row["plant"]: row for row in rows if row["case"] == case}
            cells = [
                number(at[plant][name], spec) if at[plant]["upright"] else "fell"
                for plant in PLANTS
            ]
            lines.append(f"| {case} | " + " | ".join(cells) + " |")
    lines += ["", "## Robustness", "", "Runs of each group of"]
    lines += ["[the sweep](../sweeps.md) that stay upright, the same draws in both.", ""]
    lines += ["| | runs | Drake | MuJoCo |", "|---|---|---|---|"]
    for group, one in pairs.items():
        lines.append(f"| {group} | {one['runs']} | {one['drake']} | {one['mujoco']} |")
    lines += ["", "---", "", "Made by `make transfer`, by which it is changed."]
    return "\n".join(lines) + "\n"


def transfer(
    out: Out = OUT,
    done: Annotated[Path, typer.Option(help="Where runs of the sweep are kept.")] = Path(
        "out/transfer.jsonl"
    ),
    runs: Annotated[int, typer.Option(min=1, help="Of each group of the sweep.")] = RUNS,
    quick: Quick = False,
    fresh: Fresh = False,
    workers: Processes = None,
) -> None:
    """Walk each case in each plant, and the sweep of robustness in both; write page and numbers."""
    prepare(out)
    screen, length = Console(), SHORT if quick else LENGTH
    made = {} if fresh else kept(done, made_with())
    draws = list(paired.draws(1 if quick else runs))
    found = (draws, made, done, paired.drawn, paired.lost, paired.limit, workers)
    for count, row in carried_out(*found):
        screen.print(f"{count} of {len(draws)}: {row['key']} {row['reason']}", markup=False)
    pairs = paired.shares([made[draw.key] for draw in draws])
    jobs = [
        (case, plant, dump_scenario(scenario_of(case, plant, length)))
        for case in CASES
        for plant in PLANTS
    ]
    with Pool(1, most=len(jobs)) as pool:  # so that CPU times are those of a process by itself
        rows = carry_out(walked, jobs, lost, pool, screen)
    bars = bars_of(rows, pairs)
    seconds = seconds_of(made.values()) + cpu_seconds()
    made_by = stamped("transfer", seconds, None if quick else probe)
    data = {**made_by, "bars": bars, "runs": rows, "pairs": pairs}
    write_json(out / "summary.json", data)
    write_text(out / "index.md", page_of(rows, bars, pairs))


if __name__ == "__main__":
    sys.exit(run(transfer, "transfer"))
