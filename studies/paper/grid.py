"""ECD against the single rigid body over commands, step times and leg masses.

At every point of the grid the same scenario, gait, gains and seed go to five controllers: both
models with the default weights of the MPC, each with the weights that the same search found
for it (`tuning`), and the contact-consistent model with the default weights. The legs' share of
the mass is varied with the total mass kept.
"""

import tempfile
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from drake_linefoot.robot.humanoid import load_humanoid
from drake_linefoot.scenario import Scenario
from drake_linefoot.scenario.load import dump_scenario
from studies.common import runs
from studies.common.models import leg_mass_variant, leg_share, with_robot
from studies.common.pool import carry_out
from studies.common.trial import tried, walk
from studies.common.types import Data, Progress
from studies.paper import grid_picture
from studies.paper.figure import Claim, fell_at, shown, steadier
from studies.tuning.tuning import tuned

Command = tuple[float, float, float]  # forward, left [m/s], turn rate [rad/s]
Step = tuple[float, float]  # single and double support [s]

NAME = "grid"
TITLE = "ECD against the single rigid body: commands, step times and leg masses"
COMMANDS: tuple[Command, ...] = (
    (0.4, 0.0, 0.0),
    (0.8, 0.0, 0.0),
    (1.2, 0.0, 0.0),
    (0.5, 0.0, 0.8),
)
STEPS: tuple[Step, ...] = ((0.20, 0.03), (0.30, 0.05))
LEGS: tuple[float, ...] = (0.5, 1.0, 1.4)  # [-] of the legs' masses
ANY_LENGTH = 10.0  # [m] of a step: its time shall not follow the speed here
DURATION = 6.0  # [s] of a run
QUICK_COMMANDS, QUICK_STEPS, QUICK_LEGS, QUICK_DURATION = COMMANDS[1:2], STEPS[:1], (1.0, 1.4), 2.5
MODELS = ("ecd", "srbm")
PAIRS = {"equal": "same weights", "tuned": "each model's weights tuned"}
BEYOND = "contact_consistent"
BETTER = 0.9  # [-] of the ECD's RMS that the contact-consistent model is to have at most
CONTESTANTS = (*product(("equal", "tuned"), MODELS), ("equal", BEYOND))  # weights, model
QUANTITIES = {
    "roll_rms": "rad",
    "pitch_rms": "rad",
    "roll_max": "rad",
    "pitch_max": "rad",
    "speed_error": "m/s",
}


@dataclass(frozen=True)
class Point:
    """A point of the grid; see `COMMANDS`, `STEPS`, `LEGS`."""

    command: Command
    step: Step
    legs: float


def compute(quick: bool, progress: Progress) -> Data:
    """Simulate every point of the grid under every controller."""
    commands, steps, legs, duration = COMMANDS, STEPS, LEGS, DURATION
    if quick:
        commands, steps, legs = QUICK_COMMANDS, QUICK_STEPS, QUICK_LEGS
        duration = QUICK_DURATION
    points = [Point(*values) for values in product(commands, steps, legs)]
    base = runs.paper_scenario(quick=False)
    with tempfile.TemporaryDirectory() as folder:
        robots = {f: leg_mass_variant(base.robot, f, Path(folder)) for f in legs}
        shares = {f"{f:g}": leg_share(load_humanoid(file)) for f, file in robots.items()}
        jobs = []
        for (i, point), (weights, model) in product(enumerate(points), CONTESTANTS):
            one = contestant(base, point, robots, weights, model)
            text = dump_scenario(walk(one, point.command, duration))
            jobs.append(([i, weights, model], text))
        rows = carry_out(tried, jobs, progress)
    return assemble(points, rows, base, shares, duration)


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
) -> Data:
    """Return the data of the figure.

    Args:
        points: of the grid.
        rows: of `trial.judge`, labelled with point, weights and model.
        base: what all of them have in common.
        shares: the legs' share of the mass by factor.
        duration: of each walk [s].

    Returns:
        `points` with one row for each controller; `ratios`: of each quantity, ECD over single
        body, pooled (root of the mean square) over the points where both stand;
        `roll_rms_ecd_over_srbm` and `pitch_rms_ecd_over_srbm`: those at the same weights;
        `roll_rms_cc_over_ecd` and alike of the contact-consistent model, `falls_cc` its falls.
    """
    table_of: list[Data] = [
        {"command": list(p.command), "step": list(p.step), "legs": p.legs, "runs": {}}
        for p in points
    ]
    for row in rows:
        index, weights, model = row["label"]
        one = {key: value for key, value in row.items() if key != "label"}
        table_of[index]["runs"].setdefault(weights, {})[model] = one
    ratios = {
        weights: {quantity: ratio(table_of, weights, quantity) for quantity in QUANTITIES}
        for weights in PAIRS
    }
    fallen = [row for row in rows if row["fell"] and row["label"][2] == "ecd"]
    return {
        "scenario": dump_scenario(base),
        "seeds": [base.seed],
        "duration": duration,
        "fell": bool(fallen),
        "fall_time": fallen[0]["fall_time"] if fallen else None,
        "fall_reason": "; ".join(sorted({row["fall_reason"] for row in fallen})),
        "shares": shares,
        "points": table_of,
        "pooled": ratios,
        "falls": {
            w: {m: sum(bool(p["runs"][w][m]["fell"]) for p in table_of) for m in MODELS}
            for w in PAIRS
        },
        "roll_rms_ecd_over_srbm": ratios["equal"]["roll_rms"],
        "pitch_rms_ecd_over_srbm": ratios["equal"]["pitch_rms"],
        "roll_rms_cc_over_ecd": ratio(table_of, "equal", "roll_rms", (BEYOND, MODELS[0])),
        "pitch_rms_cc_over_ecd": ratio(table_of, "equal", "pitch_rms", (BEYOND, MODELS[0])),
        "falls_cc": sum(bool(p["runs"]["equal"][BEYOND]["fell"]) for p in table_of),
    }


def ratio(
    points: Sequence[Data], weights: str, quantity: str, pair: tuple[str, str] = MODELS
) -> float | None:
    """Return one model over the other, pooled over the points where both stand; None without."""
    pairs = [
        [point["runs"][weights][model][quantity] for model in pair]
        for point in points
        if not any(point["runs"][weights][model]["fell"] for model in pair)
    ]
    pairs = [values for values in pairs if None not in values]
    if not pairs:
        return None
    return runs.ratio(*zip(*pairs, strict=True))


def draw(data: Data) -> Figure:
    """Draw the maps: where which controller falls, and the ratios where both stand."""
    return grid_picture.draw(data, TITLE, PAIRS)


def table(data: Data) -> list[list[str]]:
    """Return every point under every controller, then the pooled ratios."""
    head = ["command [m/s, m/s, rad/s]", "support [s]", "legs x (share)", "weights", "model"]
    head += [f"{name.replace('_', ' ')} [{unit}]" for name, unit in QUANTITIES.items()]
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
            numbers = [shown(one[q], ".4f") for q in QUANTITIES]
            rows.append([*where, weights, model, *numbers, fell_at(one)])
    for weights, title in PAIRS.items():
        pooled = data["pooled"][weights]
        numbers = [shown(pooled[q], ".2f") for q in QUANTITIES]
        fell = ", ".join(f"{m} {data['falls'][weights][m]}" for m in MODELS)
        rows.append(
            ["all where both stand", "", "", title, "ecd / srbm", *numbers, f"{fell} falls"]
        )
    numbers = [
        shown(ratio(data["points"], "equal", q, (BEYOND, MODELS[0])), ".2f") for q in QUANTITIES
    ]
    fell = f"{BEYOND} {data['falls_cc']} falls"
    return [*rows, ["all where both stand", "", "", PAIRS["equal"], "cc / ecd", *numbers, fell]]


def claims(data: Data) -> list[Claim]:
    """Return: ECD is steadier, and walks where the single rigid body falls."""
    result = []
    count = len(data["points"])
    both = f"pooled over the points of {count} where both stand, {data['duration']:g} s each, seed "
    both += f"{data['seeds'][0]}; total mass kept"
    for weights, title in PAIRS.items():
        for name in ("roll", "pitch"):
            value = data["pooled"][weights][f"{name}_rms"]
            result.append(
                steadier(
                    NAME,
                    f"The ECD keeps the {name} closer to the command over the grid ({title})",
                    value,
                    "the single body's",
                    both,
                )
            )
        only = {
            model: sum(
                bool(p["runs"][weights][model]["fell"] and not p["runs"][weights][other]["fell"])
                for p in data["points"]
            )
            for model, other in (MODELS, MODELS[::-1])
        }
        number = data["falls"][weights]
        result.append(
            Claim(
                NAME,
                f"The ECD walks where the single rigid body falls ({title})",
                "the base MPC breaks the safe limits",
                f"{only['srbm']} points only the single body falls, {only['ecd']} only the ECD",
                only["srbm"] > only["ecd"],
                f"of {count} points the ECD falls at {number['ecd']}, the single body at "
                f"{number['srbm']}",
            )
        )
    return [*result, *_beyond_claims(data, both)]


def _beyond_claims(data: Data, both: str) -> list[Claim]:
    """Return: legs that follow the torso make it steadier still."""
    return [
        Claim(
            NAME,
            f"The contact-consistent model keeps the {name} closer than the ECD",
            "beyond the paper",
            f"{shown(value, '.2f')} of the ECD's",
            value is not None and value <= BETTER,
            f"at most {BETTER:g}; {both}",
        )
        for name in ("roll", "pitch")
        for value in (data[f"{name}_rms_cc_over_ecd"],)
    ]
