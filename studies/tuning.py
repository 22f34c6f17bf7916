"""A search for MPC weights, the same for both models: `python -m studies.tuning`.

CMA-ES (the library cma) searches from the defaults of `MpcWeights`, in decades by which each group
of weights (`GROUPS`) is multiplied; with `--scan` from the best of a scan, each group by itself a
decade up and down. The cost of weights is the mean over `COURSE` of `cost_of`: upright, on speed,
not fallen.

The weights found stand beside the robot they are for, in `mpc_weights.yaml`, with the command that
found them.
"""

import sys
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
import yaml

from drake_linefoot.lab.pool import Pool
from drake_linefoot.lab.results.tables import wide_console
from drake_linefoot.lab.scenario.load import dump_scenario
from drake_linefoot.mpc.models.registry import MODELS
from drake_linefoot.mpc.parameters import MpcWeights
from drake_linefoot.resources import models_dir
from studies.common.command import run
from studies.common.files import write_text
from studies.common.pool import PROCESSES, carry_out
from studies.common.runs import paper_scenario
from studies.common.trial import lost, tried, walk
from studies.common.types import Array

FILE = models_dir() / "mit_humanoid" / "mpc_weights.yaml"
COURSE = (
    ((0.8, 0.0, 0.0), 3.5),
    ((1.2, 0.0, 0.0), 3.5),
    ((0.5, 0.0, 0.8), 3.5),
)  # command, duration [s]
GROUPS = ("height", "velocity", "angular_momentum", "orientation", "effort")
SPREAD = 0.4  # [decades] of the first candidates
ANGLE = 0.02  # [rad] RMS of the tilt that costs 1
SPEED, ALLOWED = 0.05, 0.05  # [m/s] error beyond what is allowed that costs 1
HEAD = """# Weights of the MPC, found by the command that stands with each.
# See studies/tuning.py.
"""
FALL = 20.0  # cost of a fall, twice that when it comes at once


@dataclass(frozen=True)
class Found:
    """What a search found."""

    weights: MpcWeights  # the best
    cost: float  # of them
    first: float  # cost of the weights it began with


def scaled(weights: MpcWeights, decades: Array) -> MpcWeights:
    """Return weights whose groups are multiplied by ten to the power of `decades`, shape (5,)."""
    height, velocity, momentum, orientation, effort = 10.0**decades
    w = weights
    return MpcWeights(
        position=[float(height * value) for value in w.position],
        velocity=[float(velocity * value) for value in w.velocity],
        angular_momentum=[float(momentum * value) for value in w.angular_momentum],
        orientation=[float(orientation * value) for value in w.orientation],
        force=float(effort * w.force),
        torque=float(effort * w.torque),
    )


def cost_of(row: dict[str, Any], duration: float) -> float:
    """Return what a walk costs; `row` of `judge_walk`, `duration` that was asked for [s]."""
    if row["fell"]:
        return float(FALL * (2.0 - row["fall_time"] / duration))
    tilt = float(np.hypot(row["roll_rms"], row["pitch_rms"]))
    return tilt / ANGLE + max(row["speed_error"] - ALLOWED, 0.0) / SPEED


def search(
    cost: Callable[[Sequence[MpcWeights]], list[float]],
    rounds: int,
    candidates: int,
    seed: int,
    scan: bool = False,
    report: Callable[[int, float, float], None] = lambda i, best, spread: None,
) -> Found:
    """Search as the head of this file says.

    Args:
        cost: of several weights.
        rounds: number of them.
        candidates: in a round.
        seed: of the candidates.
        scan: try a decade up and down in each group first.
        report: called after each round with its number, the lowest cost and the spread.
    """
    import cma

    base = MpcWeights()
    points = [np.zeros(len(GROUPS))]
    costs = cost([base])
    if scan:
        points += [*np.eye(len(GROUPS)), *-np.eye(len(GROUPS))]
        costs += cost([scaled(base, row) for row in points[1:]])
    report(0, min(costs), SPREAD)
    options = {"popsize": candidates, "seed": seed + 1, "verbose": -9}  # 0 is the time of day
    strategy = cma.CMAEvolutionStrategy(points[int(np.argmin(costs))], SPREAD, options)
    for i in range(rounds):
        sampled = strategy.ask()
        found = cost([scaled(base, row) for row in sampled])
        strategy.tell(sampled, found)
        points, costs = points + sampled, costs + found
        report(i + 1, min(costs), strategy.sigma)
    best = int(np.argmin(costs))
    return Found(scaled(base, points[best]), costs[best], costs[0])


def tuned(model: str) -> MpcWeights:
    """Return the weights that were found for a model."""
    entry = yaml.safe_load(FILE.read_text(encoding="utf-8"))[model]
    return MpcWeights(**entry["weights"])


def store(model: str, found: Found, command: str, file: Path = FILE) -> None:
    """Write what was found for a model, and leave the others as they are."""
    entries = yaml.safe_load(file.read_text(encoding="utf-8")) if file.exists() else None
    entries = dict(entries or {})
    numbers = {name: _short(value) for name, value in asdict(found.weights).items()}
    entries[model] = {
        "command": command,
        "cost": round(found.cost, 4),
        "cost_of_the_defaults": round(found.first, 4),
        "weights": numbers,
    }
    write_text(file, HEAD + yaml.safe_dump(entries, sort_keys=False, width=110))


def _short(value: float | list[float]) -> float | list[float]:
    """Return numbers with four digits."""
    if isinstance(value, list):
        return [float(f"{entry:.4g}") for entry in value]
    return float(f"{value:.4g}")


def tuning(
    model: Annotated[str, typer.Option(help=f"Whose weights: {' or '.join(MODELS)}.")],
    rounds: int = 10,
    candidates: Annotated[int, typer.Option(help="In a round.")] = 4,
    seed: int = 0,
    scan: Annotated[bool, typer.Option("--scan", help="Begin with one group at a time.")] = False,
    processes: Annotated[int, typer.Option(help="Do not change the result.")] = PROCESSES,
) -> None:
    """Search weights of the MPC for a model, and store them."""
    if model not in MODELS:
        raise typer.BadParameter(f"{model!r} must be one of {list(MODELS)}", param_hint="'--model'")
    screen = wide_console()
    scenario = paper_scenario(quick=False, model=model)
    lengths = np.array([length for _, length in COURSE])
    with Pool(processes) as pool:

        def cost(candidates: Sequence[MpcWeights]) -> list[float]:
            jobs = []
            for i, weights in enumerate(candidates):
                changed = replace(scenario, mpc=replace(scenario.mpc, weights=weights))
                jobs += [(i, dump_scenario(walk(changed, c, length))) for c, length in COURSE]
            rows = carry_out(tried, jobs, lost, pool)
            costs = [
                cost_of(row, T)
                for row, T in zip(rows, np.tile(lengths, len(candidates)), strict=True)
            ]
            return [float(np.mean(part)) for part in np.split(np.array(costs), len(candidates))]

        def report(i: int, best: float, spread: float) -> None:
            screen.print(f"round {i}: {best:.3f}, spread {spread:.2f}")

        found = search(cost, rounds, candidates, seed, scan, report)
    words = f"--model {model} --rounds {rounds} --candidates {candidates} --seed {seed}"
    store(model, found, f"python -m studies.tuning {words}" + " --scan" * scan)
    screen.print(f"{model}: {found.first:.3f} -> {found.cost:.3f}, written to {FILE.name}")


if __name__ == "__main__":
    sys.exit(run(tuning, "tuning"))
