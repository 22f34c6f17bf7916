"""Filter constant and thresholds of the contact estimator: a grid over recorded walks."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from drake_linefoot.estimation.contact_parameters import EstimatorParameters
from drake_linefoot.robot.humanoid import Humanoid
from studies.common.bars import Asked, rate
from studies.contact.replayed import Observed, Score, estimate, figures, score
from studies.contact.walks import PUSHED, Walk

GAMMAS = (0.0, 0.5, 0.7, 0.8, 0.9)  # [-]
TOUCHES = (15.0, 30.0, 50.0, 80.0, 120.0)  # [N]
RELEASE_SHARE = 0.4  # [-] of the touch force at which a contact ends, as the default has it
WRONG_MOST = 0.5  # [%] false or missed contacts per swing in every kind of walk: a false one
# may end a step in the air, which costs more than some milliseconds, so half of what is allowed
BETTER = 1.0  # [ms] by which another choice must be faster to be called better
WRONG = ("false", "missed")  # contacts that are
_ASKED = Asked("wrong contacts per swing", WRONG_MOST, "%", most=True)


def choices(
    default: EstimatorParameters,
    gammas: Sequence[float] = GAMMAS,
    touches: Sequence[float] = TOUCHES,
) -> list[EstimatorParameters]:
    """Return all pairs of filter constant [-] and touch force [N], and the default."""
    found = [
        replace(
            default, filter_constant=gamma, touch_force=touch, release_force=RELEASE_SHARE * touch
        )
        for gamma in gammas
        for touch in touches
    ]
    return found if default in found else [*found, default]


def scored(
    humanoid: Humanoid, walk: Walk, seen: Observed, tried: Sequence[EstimatorParameters]
) -> list[list[Score]]:
    """Return the `Score` of both feet of a walk with each of some parameters."""
    period = walk.run.scenario.plant.time_step
    return [score(walk.run, estimate(humanoid, seen, p, period)[2]) for p in tried]


def grid(
    tried: Sequence[EstimatorParameters],
    default: EstimatorParameters,
    walks: Sequence[tuple[str, list[list[Score]]]],
) -> list[dict[str, Any]]:
    """Return a cell for each of the parameters that were tried.

    It has `filter_constant`, `touch_force`, `release_force`, `default`, whether it is the present
    choice, and under `kinds` the `figures` for each kind of walk.

    Args:
        tried: see `choices`.
        default: the present choice.
        walks: the kind of each and its `scored`.
    """
    cells = []
    for number, p in enumerate(tried):
        scores: dict[str, list[Score]] = {}
        for kind, found in walks:
            scores.setdefault(kind, []).extend(found[number])
        cells.append(
            {
                "filter_constant": p.filter_constant,
                "touch_force": p.touch_force,
                "release_force": p.release_force,
                "default": p == default,
                "kinds": {kind: figures(found) for kind, found in scores.items()},
            }
        )
    return cells


def choice(cells: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Return what the grid says of the default.

    The best is the cell with the smallest 95th percentile of the latency in the worst kind, of
    those that are not unfit, see `is_fit`; where that is within `BETTER` of the default's, the
    default stays.

    Returns:
        `fit`: of each cell, see `is_fit`; `best`: its place in `cells`, None when all are unfit;
        `stays`: whether the default stays.
    """
    fit = [is_fit(cell) for cell in cells]
    left = [i for i, one in enumerate(fit) if one is not False]
    best = min(left, key=lambda i: (slowest(cells[i]), wrong(cells[i])), default=None)
    present = next(i for i, cell in enumerate(cells) if cell["default"])
    stays = best is not None and present in left
    stays = stays and slowest(cells[present]) <= slowest(cells[best or 0]) + BETTER
    return {"fit": fit, "best": present if stays else best, "stays": stays}


def is_fit(cell: Mapping[str, Any]) -> bool | None:
    """Return whether a cell has few wrong contacts; None where its walks do not decide it.

    Few are at most `WRONG_MOST` of the swings, false ones and missed ones, in every kind of walk
    but `PUSHED`: an observer of momentum feels a push on the torso as a force on a foot, whatever
    its threshold. A rate is judged by Wilson's interval; a swing counts once.
    """
    met = [
        rate(_ASKED, min(kind[f"{name}_contacts"], kind["swings"]), kind["swings"])["met"]
        for kind in _not_pushed(cell)
        for name in WRONG
    ]
    return False if False in met else None if None in met else True


def wrong(cell: Mapping[str, Any]) -> float:
    """Return the largest rate of false or missed contacts of the kinds but `PUSHED` [-]."""
    rates = [kind[f"{name}_contact_rate"] for kind in _not_pushed(cell) for name in WRONG]
    return max((one or 0.0 for one in rates), default=0.0)


def slowest(cell: Mapping[str, Any]) -> float:
    """Return the largest 95th percentile of the latency of the kinds but `PUSHED` [ms]."""
    found = [kind["latency_p95_ms"] for kind in _not_pushed(cell)]
    return max((float("inf") if value is None else value for value in found), default=float("inf"))


def _not_pushed(cell: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    return [found for kind, found in cell["kinds"].items() if kind != PUSHED]
