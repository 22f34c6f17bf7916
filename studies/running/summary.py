"""What came of the trials, held against what is asked."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from drake_linefoot.lab.sweep.statistics import clears
from studies.common.types import Data
from studies.envelope.envelope import tracked
from studies.running.cases import EVERY, FAST, GROUPS, LADDERS, SPEED, WALKS

FLIGHT, TILT, LIMITED = 0.04, 0.25, 0.15  # [s] at least, [rad] and [-] at most
KEPT = 0.8  # [-] of its command that a run on other ground keeps
REACHED = 0.95  # [-] of the speed between two stands
ROBOTS = 6  # whose shares count


@dataclass(frozen=True)
class Bar:
    """What is asked of a figure."""

    bar: float
    unit: str
    what: str  # in words
    most: bool = False  # whether it is the largest that will do


BARS = {
    "walk_forward": Bar(
        1.8,
        "m/s",
        "walk, never without a foot on the ground, a torque at its limit in at most 15 % of the "
        "ticks",
    ),
    "run_forward": Bar(2.4, "m/s", "run, flights of at least 40 ms, tilt of at most 0.25 rad"),
    "run_back": Bar(1.2, "m/s", "run backward"),
    "run_aside": Bar(0.6, "m/s", "to the left at 1.5 m/s"),
    "run_turn": Bar(1.0, "rad/s", "turn at 1.5 m/s"),
    "stand_run_stand": Bar(20, "runs", "from a stand to 2 m/s and back to a stand, of 20"),
    "speed_error": Bar(
        5.0, "%", "of a command, mean of its seeds, the largest of the commands that hold", True
    ),
    "run_push": Bar(90.0, "%", "upright after 10 N s in any direction, at any phase, at 1.5 m/s"),
    "run_rough": Bar(85.0, "%", "tiles of 3 cm at 1.5 m/s, upright and at least 80 % as fast"),
    "run_slope_5": Bar(85.0, "%", "slope of 5 degrees, up or down, likewise"),
    "run_on_estimate": Bar(18, "runs", "at 1.5 m/s on the estimate of the state, of 20"),
    "zoo_share": Bar(0.75, "-", "speed by sqrt(g h), mean of the six robots that run fastest"),
    "walks": Bar(
        0, "walks", "flat, undisturbed, below 1.2 m/s, arms held, with other bits than before", True
    ),
    "walks_paired": Bar(
        0, "cases", "of the sweep of robustness with fewer upright runs than before", True
    ),
}
COUNTED = ("stand_run_stand", "run_on_estimate")  # the others of `GROUPS` are shares


def rungs(rows: Iterable[Data], name: str) -> list[Data]:
    """Return what came of each size of a ladder, over its seeds.

    Returns:
        `size`, `runs`, `upright`; `measured`: mean along its axis [m/s, rad/s]; `error`: of the
        size [-]; `flight`: smallest [s]; `tilt`: largest [rad]; `turns`: between which the
        torso yaws, largest [rad]; `limited`: largest share of ticks with a torque at its limit;
        `cost`: of transport, mean; `froude`, `duty`: means; and whether it `holds`. None stands
        for what is not known.
    """
    found = []
    for size in EVERY[name].sizes:
        some = [row for row in rows if row["case"] == name and float(row["label"]) == size]
        if some:
            found.append(_rung(name, size, some))
    return found


def _rung(name: str, size: float, rows: Sequence[Data]) -> Data:
    ladder = EVERY[name]
    axis, command = ladder.axis, ladder.command(size)
    gaits = [row["gait"] for row in rows if row["gait"]]
    along = [row["measured"][axis] for row in rows if row["measured"]]
    flights = [gait["flight_s"] for gait in gaits]
    known = len(gaits) == len(rows)
    flight = min(flights, default=0.0) if known and None not in flights else None
    tilt = _most([row["tilt"] for row in rows])
    limited = _most([gait["torque_at_limit"] for gait in gaits])
    holds = known and all(
        row["upright"] and tracked(command.tolist(), row["measured"]) for row in rows
    )
    if name == "walk_forward":
        holds = holds and not any(g["flights"] for g in gaits) and _within(limited, LIMITED)
    elif name == "run_forward":
        holds = holds and flight is not None and flight >= FLIGHT and _within(tilt, TILT)
    elif name in LADDERS:
        holds = holds and flight is not None
    return {
        "size": size,
        "runs": len(rows),
        "upright": sum(row["upright"] for row in rows),
        "measured": _mean(along),
        "error": abs(float(np.mean(along)) / size - 1.0) if along else None,
        "flight": flight,
        "tilt": tilt,
        "turns": _most([row.get("turns") for row in rows]),
        "limited": limited,
        "duty": _mean([gait["duty_factor"] for gait in gaits]),
        "froude": _mean([gait["froude_number"] for gait in gaits]),
        "cost": _mean([gait["cost_of_transport"] for gait in gaits]),
        "holds": bool(holds),
    }


def figures(rows: Sequence[Data], before: Mapping[str, Data]) -> dict[str, float | None]:
    """Return a value for each of `BARS`; None where nothing was tried.

    Args:
        rows: of `tried` and `ran`.
        before: by key, the rows of an older version.
    """
    found: dict[str, float | None] = dict.fromkeys(BARS)
    errors = []
    for name in LADDERS:
        steps = rungs(rows, name)
        held = [rung for rung in steps if rung["holds"]]
        errors += [rung["error"] for rung in held]
        if steps:
            found[name] = max((abs(rung["measured"]) for rung in held), default=0.0)
    errors += _walk_errors(rows)
    found["speed_error"] = 100.0 * max(errors) if errors else None
    for name in GROUPS:
        some = [row for row in rows if row["case"] == name]
        if some:
            good = sum(succeeded(row) for row in some)
            found[name] = good if name in COUNTED else 100.0 * good / len(some)
    shares = sorted((row["share"] for row in rows if row["case"] == "robot"), reverse=True)
    found["zoo_share"] = float(np.mean(shares[:ROBOTS])) if shares else None
    both = [(row, before[row["key"]]) for row in rows if row["key"] in before]
    changed = [now["state_hash"] != old["state_hash"] for now, old in both if now["case"] == "walk"]
    found["walks"] = sum(changed) if changed else None
    cases: dict[str, int] = {}
    for now, old in both:
        if now["case"] == "pair":
            better = int(now["upright"]) - int(old["upright"])
            cases[now["label"]] = cases.get(now["label"], 0) + better
    found["walks_paired"] = sum(n < 0 for n in cases.values()) if cases else None
    return found


def succeeded(row: Data) -> bool:
    """Return whether a run of `GROUPS` did what it was told."""
    if row["case"] == "stand_run_stand":
        fast = row["measured"] is not None and row["measured"][0] >= REACHED * FAST
        return bool(row["upright"] and row["stands"] and fast)
    if row["case"] in ("run_rough", "run_slope_5"):
        return bool(row["upright"] and row["measured"] and row["measured"][0] >= KEPT * SPEED)
    flies = row["gait"] is not None and row["gait"]["flight_s"] is not None
    return bool(row["upright"] and (flies or row["case"] != "run_on_estimate"))


def groups(rows: Sequence[Data]) -> dict[str, Data]:
    """Return of each of `GROUPS` its `runs`, how many `succeeded` and stayed `upright`, `speed`.

    That is the mean forward speed [m/s] of those that did not fall; `falls` says when it did.
    """
    found = {}
    for name in GROUPS:
        some = [row for row in rows if row["case"] == name]
        found[name] = {
            "runs": len(some),
            "succeeded": sum(map(succeeded, some)),
            "upright": sum(row["upright"] for row in some),
            "speed": _mean([row["measured"][0] for row in some if row["measured"]]),
            "falls": [[row["index"], row["reason"]] for row in some if not row["upright"]],
        }
    return found


def bars(
    values: Mapping[str, float | None], of: Mapping[str, Data], quick: bool = False
) -> dict[str, Data]:
    """Return `value`, `bar`, `unit`, and whether it `holds`, of each of `BARS`.

    It is None where it is not known: after a `quick` look, and of a share where so few runs cannot
    tell, see `clears`.

    Args:
        values: see `figures`.
        of: see `groups`.
        quick: whether this is a quick look.
    """
    result = {}
    for key, one in BARS.items():
        value = values[key]
        met: bool | None = None
        if value is not None and not quick:
            met = value <= one.bar if one.most else value >= one.bar
            if key in GROUPS and key not in COUNTED:
                met = clears(of[key]["succeeded"], of[key]["runs"], one.bar / 100.0)
        result[key] = {"value": value, "bar": one.bar, "unit": one.unit, "holds": met}
    return result


def _walk_errors(rows: Sequence[Data]) -> list[float]:
    errors = []
    for name, command in WALKS.items():
        some = [r["measured"] for r in rows if r["case"] == "walk" and r["label"] == name]
        if some and None not in some:
            axis = int(np.argmax(np.abs(command)))
            errors.append(abs(float(np.mean(some, axis=0)[axis]) / command[axis] - 1.0))
    return errors


def _mean(values: Sequence[float | None]) -> float | None:
    known = [value for value in values if value is not None]
    return float(np.mean(known)) if known else None


def _most(values: Sequence[float | None]) -> float | None:
    return max((value for value in values if value is not None), default=None)


def _within(value: float | None, most: float) -> bool:
    return value is not None and value <= most
