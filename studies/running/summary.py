"""What came of the trials, held against what is asked."""

from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from studies.common.bars import Asked, judged, rate
from studies.common.types import Data
from studies.envelope.walks import tracked
from studies.running.cases import EVERY, FAST, GROUPS, LADDERS, SPEED, WALKS

FLIGHT, TILT, LIMITED = 0.04, 0.25, 0.15  # [s] at least, [rad] and [-] at most
KEPT = 0.8  # [-] of its command that a run on other ground keeps
REACHED = 0.95  # [-] of the speed between two stands
ROBOTS = 6  # whose shares count


BARS = {
    "walk_forward": Asked(
        "walk, never without a foot on the ground, a torque at its limit in at most 15 % of the "
        "ticks",
        1.8,
        "m/s",
    ),
    "run_forward": Asked("run, flights of at least 40 ms, tilt of at most 0.25 rad", 2.4, "m/s"),
    "run_back": Asked("run backward", 1.2, "m/s"),
    "run_aside": Asked("to the left at 1.5 m/s", 0.6, "m/s"),
    "run_turn": Asked("turn at 1.5 m/s", 1.0, "rad/s"),
    "stand_run_stand": Asked("from a stand to 2 m/s and back to a stand, of 20", 20, "runs"),
    "speed_error": Asked(
        "of a command, mean of its seeds, the largest of the commands that hold", 5.0, "%", True
    ),
    "run_push": Asked("upright after 10 N s in any direction, at any phase, at 1.5 m/s", 90.0, "%"),
    "run_rough": Asked("tiles of 3 cm at 1.5 m/s, upright and at least 80 % as fast", 85.0, "%"),
    "run_slope_5": Asked("slope of 5 degrees, up or down, likewise", 85.0, "%"),
    "run_on_estimate": Asked("at 1.5 m/s on the estimate of the state, of 20", 18, "runs"),
    "zoo_share": Asked("speed by sqrt(g h), mean of the six robots that run fastest", 0.75),
    "walks": Asked(
        "flat, undisturbed, below 1.2 m/s, arms held, other than before but for rounding",
        0,
        "walks",
        True,
    ),
    "walks_paired": Asked(
        "of the sweep of robustness with fewer upright runs than before", 0, "cases", True
    ),
}
ROUNDING = 1e-6  # of the figures of a walk: another kind of processor rounds otherwise
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
    """Return a value for each of `BARS` that is no share; None where nothing was tried.

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
    for name in COUNTED:
        some = [row for row in rows if row["case"] == name]
        found[name] = sum(map(succeeded, some)) if some else None
    shares = sorted((row["share"] for row in rows if row["case"] == "robot"), reverse=True)
    found["zoo_share"] = float(np.mean(shares[:ROBOTS])) if shares else None
    both = [(row, before[row["key"]]) for row in rows if row["key"] in before]
    changed = [not same(now, old) for now, old in both if now["case"] == "walk"]
    found["walks"] = sum(changed) if changed else None
    cases: dict[str, int] = {}
    for now, old in both:
        if now["case"] == "pair":
            better = int(now["upright"]) - int(old["upright"])
            cases[now["label"]] = cases.get(now["label"], 0) + better
    found["walks_paired"] = sum(n < 0 for n in cases.values()) if cases else None
    return found


def same(now: Data, old: Data) -> bool:
    """Return whether a run came out as another and has its figures, but for rounding."""
    these, those = _numbers(now), _numbers(old)
    return these.keys() == those.keys() and all(
        np.allclose(these[name], those[name], ROUNDING, ROUNDING) for name in these
    )


def _numbers(row: Data) -> Data:
    known = {name: row[name] for name in ("upright", "measured", "tilt")} | (row["gait"] or {})
    return {name: value for name, value in known.items() if value is not None}


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
    """Return what is asked: of each of `BARS`, see `judged`; after a `quick` look all is undecided.

    Args:
        values: see `figures`.
        of: see `groups`.
        quick: whether this is a quick look.
    """
    found = {}
    for key, one in BARS.items():
        if key in GROUPS and key not in COUNTED:
            group = of.get(key, {"succeeded": 0, "runs": 0})
            found[key] = rate(one, group["succeeded"], group["runs"])
        else:
            found[key] = judged(one, values[key])
        found[key] |= {"met": None} if quick else {}
    return found


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
