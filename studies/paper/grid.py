"""ECD against the single rigid body over commands, step times and leg masses.

At every point of the grid the same scenario, gait, gains and seeds go to every model of the MPC,
with the weights of the scenario and with those that the same search found for that model
(`tuning`). The legs' share of the mass is varied with the total mass kept. A point counts as a
fall of a controller that falls with any of the seeds.

The statistic was fixed before any walk with `SEEDS` was looked at. At each point where neither of
two models falls, the ratio of their RMS over all seeds; of these the geometric mean; its interval
by a bootstrap that draws the commands with replacement, with all points of each; beside it, for
comparison, the pooled ratio, of RMS over all points. See `statistic`. Neither commands nor seeds
are those that weights were tuned on.
"""

import tempfile
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from drake_linefoot.lab.scenario import Scenario
from drake_linefoot.lab.scenario.load import dump_scenario
from drake_linefoot.robot.humanoid import load_humanoid
from studies.common import runs
from studies.common.models import leg_mass_variant, leg_share, with_robot
from studies.common.trial import walk
from studies.common.trials import FRESH, SECONDS, seconds_of
from studies.common.types import Data
from studies.paper import grid_picture, statistic
from studies.paper.figure import BETTER, Claim, compared, fell_at, shown, steadier, survives
from studies.paper.grid_walks import DONE, Walk, walked
from studies.tuning import tuned

Command = tuple[float, float, float]  # forward, left [m/s], turn rate [rad/s]
Step = tuple[float, float]  # single and double support [s]

TITLE = "ECD against the single rigid body: commands, step times and leg masses"
COMMANDS: tuple[Command, ...] = (  # none is of the course of `tuning`
    (0.4, 0.0, 0.0),
    (0.7, 0.0, 0.0),
    (1.0, 0.0, 0.0),
    (1.1, 0.0, 0.0),
    (0.4, 0.0, 0.5),
    (0.3, 0.2, 0.0),
)
STEPS: tuple[Step, ...] = ((0.20, 0.03), (0.30, 0.05))
LEGS: tuple[float, ...] = (0.5, 1.0, 1.4)  # [-] of the legs' masses
ANY_LENGTH = 10.0  # [m] of a step: its time shall not follow the speed here
DURATION = 6.0  # [s] of a run
QUICK_COMMANDS, QUICK_STEPS, QUICK_LEGS, QUICK_DURATION = COMMANDS[1:2], STEPS[:1], (1.0, 1.4), 2.5
SEEDS = tuple(range(FRESH, FRESH + 10))
QUICK_SEEDS = (0,)
WEIGHTS = {"equal": "same weights", "tuned": "each model's weights tuned"}
ECD, BASE, MOMENTUM, BEYOND = MODELS = "ecd", "srbm", "srbm_momentum", "contact_consistent"
PAIRS = {
    "ecd_over_srbm": (ECD, BASE),
    "ecd_over_momentum": (ECD, MOMENTUM),
    "cc_over_ecd": (BEYOND, ECD),
}
CONTESTANTS = tuple(product(WEIGHTS, MODELS))  # weights, model
QUANTITIES = {
    "roll_rms": "rad",
    "pitch_rms": "rad",
    "roll_max": "rad",
    "pitch_max": "rad",
    "speed_error": "m/s",
}
MEASURED = {**QUANTITIES, "torque_limited": "-"}  # most often 0, so no ratio is made of it


@dataclass(frozen=True)
class Point:
    """A point of the grid; see `COMMANDS`, `STEPS`, `LEGS`."""

    command: Command
    step: Step
    legs: float


def compute(quick: bool) -> Data:
    """Simulate every point of the grid under every controller; what `DONE` has is kept."""
    commands, steps, legs, duration, seeds = COMMANDS, STEPS, LEGS, DURATION, SEEDS
    if quick:
        commands, steps, legs = QUICK_COMMANDS, QUICK_STEPS, QUICK_LEGS
        duration, seeds = QUICK_DURATION, QUICK_SEEDS
    points = [Point(*values) for values in product(commands, steps, legs)]
    base = runs.paper_scenario(quick=False)
    with tempfile.TemporaryDirectory() as folder:
        robots = {f: leg_mass_variant(base.robot, f, Path(folder)) for f in legs}
        shares = {f"{f:g}": leg_share(load_humanoid(file)) for f, file in robots.items()}
        jobs = []
        for (i, point), (weights, model) in product(enumerate(points), CONTESTANTS):
            one = contestant(base, point, robots, weights, model)
            for seed in seeds:
                text = dump_scenario(walk(replace(one, seed=seed), point.command, duration))
                key = f"{point} {weights} {model} {seed} {duration:g}"
                jobs.append(Walk(key, (i, weights, model), text))
        rows = walked(jobs, Path(folder) / DONE.name if quick else DONE)
    return {**assemble(points, rows, base, shares, duration, seeds), SECONDS: seconds_of(rows)}


def contestant(
    base: Scenario, point: Point, robots: dict[float, Path], weights: str, model: str
) -> Scenario:
    """Return the scenario of one controller at one point, without its command."""
    scenario = with_robot(base, robots[point.legs])
    single, double = point.step
    mpc = replace(base.mpc, model=model)
    if weights == "tuned":
        mpc = replace(mpc, weights=tuned(model))
    gait = replace(
        scenario.gait, single_support=single, double_support=double, step_length=ANY_LENGTH
    )
    return replace(scenario, gait=gait, mpc=mpc)


def assemble(
    points: Sequence[Point],
    rows: Sequence[dict[str, Any]],
    base: Scenario,
    shares: dict[str, float],
    duration: float,
    seeds: Sequence[int] = SEEDS,
) -> Data:
    """Return the data of the figure.

    Args:
        points: of the grid.
        rows: of `judge_walk`, labelled with point, weights and model; one for each seed.
        base: what all of them have in common.
        shares: the legs' share of the mass by factor.
        duration: of each walk [s].
        seeds: of the walks.

    Returns:
        `points` with one row for each controller, see `over_seeds`; `over_points`: by weights, pair
        of models and quantity what `compared_by_cluster` says, a command being a cluster, and
        `statistic`, that in words; `falls` of each controller; the ratios of roll and pitch of each
        pair at the same weights, as `roll_rms_ecd_over_srbm`, and `falls_cc`.
    """
    table_of: list[Data] = [
        {"command": list(p.command), "step": list(p.step), "legs": p.legs, "runs": {}}
        for p in points
    ]
    for (i, point), (weights, model) in product(enumerate(table_of), CONTESTANTS):
        own = [row for row in rows if tuple(row["label"]) == (i, weights, model)]
        point["runs"].setdefault(weights, {})[model] = over_seeds(own)
    over: Data = {weights: {words: {} for words in PAIRS} for weights in WEIGHTS}
    for weights, (words, (one, other)), quantity in product(WEIGHTS, PAIRS.items(), QUANTITIES):
        pairs = [
            (tuple(p["command"]), p["runs"][weights][one], p["runs"][weights][other])
            for p in table_of
        ]
        over[weights][words][quantity] = statistic.compared_by_cluster(pairs, quantity)
    commands = {point.command for point in points}
    fallen = [row for row in rows if row["fell"] and row["label"][2] == ECD]
    falls = {
        w: {m: sum(bool(p["runs"][w][m]["fell"]) for p in table_of) for m in MODELS}
        for w in WEIGHTS
    }
    return {
        **runs.facts_of_rows(base, seeds, fallen),
        "duration": duration,
        "shares": shares,
        "points": table_of,
        "over_points": over,
        "statistic": statistic.over(
            f"the points where neither falls, {len(points)} at most,", "commands", len(commands)
        ),
        "falls": falls,
        "falls_cc": falls["equal"][BEYOND],
        **_ratios(over["equal"]),
    }


def _ratios(over: Data) -> Data:
    return {
        f"{angle}_rms_{words}{key}": found[f"{angle}_rms"][of]
        for words, found in over.items()
        for angle in ("roll", "pitch")
        for key, of in statistic.KEYS.items()
    }


def over_seeds(rows: Sequence[dict[str, Any]]) -> Data:
    """Return what a controller did at a point: the first fall, the worst of what did not fall.

    Of the RMS it is that of all seeds together, of the rest the largest.
    """
    fallen = sorted((row for row in rows if row["fell"]), key=lambda row: row["fall_time"])
    found: Data = {key: fallen[0][key] if fallen else None for key in ("fall_time", "fall_reason")}
    found["fell"] = bool(fallen)
    for quantity in MEASURED:
        values = [row[quantity] for row in rows if row[quantity] is not None]
        together = runs.rms if quantity.endswith("_rms") else max
        found[quantity] = together(values) if values else None  # type: ignore[arg-type]
    return found


def draw(data: Data) -> Figure:
    """Draw the maps: where which controller falls, and the ratios where both stand."""
    return grid_picture.draw(data, TITLE, WEIGHTS)


def table(data: Data) -> list[list[str]]:
    """Return every point under every controller, then the geometric means and pooled ratios."""
    head = ["command [m/s, m/s, rad/s]", "support [s]", "legs x (share)", "weights", "model"]
    head += [f"{name.replace('_', ' ')} [{unit}]" for name, unit in MEASURED.items()]
    rows = [[*head, "fell"]]
    for point in data["points"]:
        share = data["shares"][f"{point['legs']:g}"]
        where = [
            ", ".join(f"{value:g}" for value in point["command"]),
            " + ".join(f"{value:g}" for value in point["step"]),
            f"{point['legs']:g} ({100.0 * share:.0f} %)",
        ]
        for weights, model in CONTESTANTS:
            one = point["runs"][weights][model]
            numbers = [shown(one[q], ".4f") for q in MEASURED]
            rows.append([*where, weights, model, *numbers, fell_at(one)])
    for (weights, title), (words, pair) in product(WEIGHTS.items(), PAIRS.items()):
        fell = ", ".join(f"{m} {data['falls'][weights][m]}" for m in pair)
        found = data["over_points"][weights][words]
        means = [statistic.mean(found[q]) for q in QUANTITIES]
        pooled = [shown(found[q]["pooled"], ".2f") for q in QUANTITIES]
        for kind, numbers in (("geometric mean", means), ("pooled", pooled)):
            about = ["where both stand", kind, "", title, " / ".join(pair)]
            rows.append([*about, *numbers, "-", f"{fell} falls"])
    return rows


def claims(data: Data) -> list[Claim]:
    """Return: ECD is steadier, and walks where the single rigid body falls; what is beyond it."""
    count = len(data["points"])
    both = (
        f"{data['statistic']}. {data['duration']:g} s each, seeds {data['seeds']}; total mass kept"
    )
    result = []
    for (weights, title), angle in product(WEIGHTS.items(), ("roll", "pitch")):
        found = data["over_points"][weights]["ecd_over_srbm"][f"{angle}_rms"]
        claim = f"The ECD keeps the {angle} closer to the command over the grid ({title})"
        result.append(steadier(claim, found, "the single body's", both))
    result.append(
        survives(
            "The ECD walks where the single rigid body falls",
            "the base MPC breaks the safe limits",
            _falls_of(data, "equal", ECD, BASE),
            f"Same weights, {count} points, each a fall when any seed falls. {_falls(data)}",
        )
    )
    for (weights, title), angle in product(WEIGHTS.items(), ("roll", "pitch")):
        found = data["over_points"][weights]["cc_over_ecd"][f"{angle}_rms"]
        claim = f"The contact-consistent model keeps the {angle} closer than the ECD ({title})"
        note = both + _torques(data, weights, f"{angle}_rms")
        result.append(compared(claim, found, "the ECD's", BETTER, "beyond the paper", note))
    return [
        *result,
        survives(
            "The contact-consistent model walks where the ECD falls",
            "beyond the paper",
            _falls_of(data, "equal", BEYOND, ECD),
            f"As above. {_falls(data)}",
        ),
    ]


def _falls_of(data: Data, weights: str, one: str, other: str) -> list[tuple[bool, bool]]:
    rows = [point["runs"][weights] for point in data["points"]]
    return [(bool(row[one]["fell"]), bool(row[other]["fell"])) for row in rows]


def _torques(data: Data, weights: str, quantity: str) -> str:
    """Return how often torques are at their limits where the contact-consistent model is worse."""
    words = ""
    pairs = [(row[BEYOND], row[ECD]) for row in (p["runs"][weights] for p in data["points"])]
    stand = runs.where_both_stand(pairs)
    for where, worse in (("higher", True), ("lower", False)):
        rows = [pair for pair in stand if (pair[0][quantity] > pair[1][quantity]) is worse]
        if rows:
            shares = [
                np.mean([row["torque_limited"] for row in side]) for side in zip(*rows, strict=True)
            ]
            one, other = (f"{100.0 * share:.1f} %" for share in shares)
            words += f". Torques are at a limit in {one} of the ticks ({other} with the ECD)"
            words += f" where it is {where}"
    return words


def _falls(data: Data) -> str:
    """Return how often each controller falls, in words."""
    return "Falls: " + "; ".join(
        f"{title}: " + ", ".join(f"{model} {n}" for model, n in data["falls"][weights].items())
        for weights, title in WEIGHTS.items()
    )
