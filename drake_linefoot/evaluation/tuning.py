"""A search for MPC weights, the same for both models: `python -m drake_linefoot.evaluation.tuning`.

From the defaults of `MpcWeights`, round after round, some candidates are drawn about the best
weights so far: each group of weights (`GROUPS`) is multiplied by ten to the power of a normal
random number. The best candidate takes the place of the best so far when its cost is lower, and
the spread grows; else the spread shrinks. With `--scan` the search begins at the best of a scan:
each group by itself a decade up and down. A candidate's cost is the mean over `COURSE` of
`cost_of`: upright, on speed, not fallen.

The weights found stand beside the robot they are for, in `mpc_weights.yaml`, with the command that
found them.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from numpy.typing import NDArray
from rich.console import Console

from drake_linefoot.evaluation.runs import paper_scenario
from drake_linefoot.evaluation.trial import Job, carry_out, walk, workers
from drake_linefoot.mpc.parameters import MODELS, MpcWeights
from drake_linefoot.resources import models_dir
from drake_linefoot.scenario_io import dump_scenario

Array = NDArray[np.float64]

FILE = models_dir() / "mit_humanoid" / "mpc_weights.yaml"
COURSE = (
    ((0.8, 0.0, 0.0), 3.5),
    ((1.2, 0.0, 0.0), 3.5),
    ((0.5, 0.0, 0.8), 3.5),
)  # command, duration [s]
GROUPS = ("height", "velocity", "angular_momentum", "orientation", "effort")
SPREAD = 0.4  # [decades] of the first candidates
GROWTH, SHRINKAGE = 1.3, 0.75  # [-] of the spread after a round with and without success
ANGLE = 0.02  # [rad] RMS of the tilt that costs 1
SPEED, ALLOWED = 0.05, 0.05  # [m/s] error beyond what is allowed that costs 1
HEAD = """# Weights of the MPC, found by the command that stands with each.
# See drake_linefoot/evaluation/tuning.py.
"""
FALL = 20.0  # cost of a fall, twice that when it comes at once


@dataclass(frozen=True)
class Found:
    """What a search found.

    Attributes:
        weights: the best.
        cost: of them.
        first: cost of the weights it began with.
    """

    weights: MpcWeights
    cost: float
    first: float


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
    """Return what a walk costs; `row` of `trial.judge`, `duration` that was asked for [s]."""
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
    tell: Callable[[int, float, float], None] = lambda i, best, spread: None,
) -> Found:
    """Search as the head of this file says.

    Args:
        cost: of several weights.
        rounds: number of them.
        candidates: in a round.
        seed: of the candidates.
        scan: try a decade up and down in each group first.
        tell: called after each round with its number, the lowest cost and the spread.
    """
    rng = np.random.default_rng(seed)
    base, at, spread = MpcWeights(), np.zeros(len(GROUPS)), SPREAD
    (first,) = cost([base])
    best = first
    if scan:
        decades = np.concatenate([np.eye(len(GROUPS)), -np.eye(len(GROUPS))])
        costs = cost([scaled(base, row) for row in decades])
        k = int(np.argmin(costs))
        if costs[k] < best:
            at, best = decades[k], costs[k]
    tell(0, best, spread)
    for i in range(rounds):
        drawn = at + spread * rng.normal(size=(candidates, len(GROUPS)))
        costs = cost([scaled(base, row) for row in drawn])
        k = int(np.argmin(costs))
        better = costs[k] < best
        if better:
            at, best = drawn[k], costs[k]
        spread *= GROWTH if better else SHRINKAGE
        tell(i + 1, best, spread)
    return Found(scaled(base, at), best, first)


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
    file.write_text(HEAD + yaml.safe_dump(entries, sort_keys=False, width=110), encoding="utf-8")


def _short(value: float | list[float]) -> float | list[float]:
    """Return numbers with four digits."""
    if isinstance(value, list):
        return [float(f"{entry:.4g}") for entry in value]
    return float(f"{value:.4g}")


def main(arguments: Sequence[str] | None = None) -> None:
    """Search weights for one model and store them."""
    parser = argparse.ArgumentParser(description="Search weights of the MPC for a model.")
    parser.add_argument("--model", choices=MODELS, required=True)
    parser.add_argument("--rounds", type=int, default=10)
    parser.add_argument("--candidates", type=int, default=2)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--scan", action="store_true", help="begin with one group at a time")
    parser.add_argument("--processes", type=int, default=2, help="does not change the result")
    given = parser.parse_args(arguments)
    console = Console(highlight=False)
    scenario = paper_scenario(quick=False, model=given.model)
    with workers(given.processes) as pool:

        def cost(candidates: Sequence[MpcWeights]) -> list[float]:
            jobs = []
            for i, weights in enumerate(candidates):
                tried = replace(scenario, mpc=replace(scenario.mpc, weights=weights))
                jobs += [Job(i, dump_scenario(walk(tried, c, length))) for c, length in COURSE]
            rows = list(pool.map(carry_out, jobs))
            lengths = [length for _, length in COURSE] * len(candidates)
            costs = [cost_of(row, T) for row, T in zip(rows, lengths, strict=True)]
            return [float(np.mean(part)) for part in np.split(np.array(costs), len(candidates))]

        found = search(
            cost,
            given.rounds,
            given.candidates,
            given.seed,
            given.scan,
            lambda i, best, spread: console.print(f"round {i}: {best:.3f}, spread {spread:.2f}"),
        )
    command = (
        f"python -m drake_linefoot.evaluation.tuning --model {given.model} --rounds {given.rounds}"
        f" --candidates {given.candidates} --seed {given.seed}" + " --scan" * given.scan
    )
    store(given.model, found, command)
    console.print(f"{given.model}: {found.first:.3f} -> {found.cost:.3f}, written to {FILE.name}")


if __name__ == "__main__":
    main()
