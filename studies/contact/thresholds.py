"""Filter constant and thresholds of the contact estimator: a grid over recorded walks."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from drake_linefoot.estimation.contact_parameters import EstimatorParameters
from drake_linefoot.robot.humanoid import Humanoid
from studies.contact.replayed import Observed, Score, estimate, figures, score
from studies.contact.walks import Walk

GAMMAS = (0.0, 0.5, 0.7, 0.8, 0.9)  # [-]
TOUCHES = (15.0, 30.0, 50.0, 80.0, 120.0)  # [N]
RELEASE_SHARE = 0.4  # [-] of the touch force at which a contact ends, as the default has it
WRONG_MOST = 0.005  # [-] false or missed contacts per swing in every kind of walk: a false one
# may end a step in the air, which costs more than some milliseconds, so half of what is allowed
PUSHED = "pushed"  # the kind of walk whose wrong contacts do not count
BETTER = 1.0  # [ms] by which another choice must be faster to be called better


def grid(
    humanoid: Humanoid,
    walks: Sequence[tuple[Walk, Observed]],
    default: EstimatorParameters,
    gammas: Sequence[float] = GAMMAS,
    touches: Sequence[float] = TOUCHES,
) -> list[dict[str, Any]]:
    """Return a cell for each pair of filter constant [-] and touch force [N], one for the default.

    It has `filter_constant`, `touch_force`, `release_force`, `default`, whether it is the present
    choice, and under `kinds` the `figures` for each kind of walk.
    """
    pairs = [(g, t, RELEASE_SHARE * t) for g in gammas for t in touches]
    present = (default.filter_constant, default.touch_force, default.release_force)
    cells = []
    for gamma, touch, release in dict.fromkeys([*pairs, present]):
        p = replace(default, filter_constant=gamma, touch_force=touch, release_force=release)
        scores: dict[str, list[Score]] = {}
        for walk, seen in walks:
            period = walk.run.scenario.plant.time_step
            flags = estimate(humanoid, seen, p, period)[2]
            scores.setdefault(walk.kind, []).extend(score(walk.run, flags))
        cells.append(
            {
                "filter_constant": gamma,
                "touch_force": touch,
                "release_force": release,
                "default": (gamma, touch, release) == present,
                "kinds": {kind: figures(found) for kind, found in scores.items()},
            }
        )
    return cells


def choice(cells: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Return what the grid says of the default.

    Fit is a cell with at most `WRONG_MOST` false contacts per swing and missed ones per touchdown
    in every kind of walk but `PUSHED`: an observer of momentum feels a push on the torso as a
    force on a foot, whatever its threshold. The best of them has the smallest 95th percentile of
    the latency in the worst kind; where that is within `BETTER` of the default's, the default
    stays.

    Returns:
        `best`: its place in `cells`, None when no cell is fit; `fit`: places of all; `stays`:
        whether the default stays.
    """
    fit = [i for i, cell in enumerate(cells) if wrong(cell) <= WRONG_MOST]
    present = next(i for i, cell in enumerate(cells) if cell["default"])
    best = min(fit, key=lambda i: (slowest(cells[i]), wrong(cells[i])), default=None)
    stays = best is not None and present in fit
    stays = stays and slowest(cells[present]) <= slowest(cells[best or 0]) + BETTER
    return {"fit": fit, "best": present if stays else best, "stays": stays}


def wrong(cell: Mapping[str, Any]) -> float:
    """Return the largest rate of false or missed contacts of the kinds but `PUSHED` [-]."""
    kinds = [found for kind, found in cell["kinds"].items() if kind != PUSHED]
    return max(found[name] or 0.0 for found in kinds for name in RATES)


def slowest(cell: Mapping[str, Any]) -> float:
    """Return the largest 95th percentile of the latency of the kinds of walks [ms]."""
    found = [kind["latency_p95_ms"] for kind in cell["kinds"].values()]
    return max((float("inf") if value is None else value for value in found), default=float("inf"))


RATES = ("false_contact_rate", "missed_contact_rate")
