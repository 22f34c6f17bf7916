"""Walks on the estimate: how far it is from the truth, and which walks go on."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from functools import cache
from typing import Any

import numpy as np
from pydrake.systems.framework import Context
from scipy.spatial.transform import Rotation

from drake_linefoot.estimation.estimate import deviations
from drake_linefoot.estimation.filter_state import PLACE, TURN, VELOCITY, filter_of
from drake_linefoot.lab.results.judge import judge, upright
from drake_linefoot.lab.results.metrics import segment_velocity
from drake_linefoot.lab.scenario import Scenario, Segment
from drake_linefoot.lab.simulation.closed_loop import ClosedLoop
from drake_linefoot.lab.simulation.run import simulate
from drake_linefoot.lab.sweep.jobs import scenario_of
from drake_linefoot.lab.wiring.closed_loop import build_closed_loop
from studies.common.command import SWEEPS
from studies.common.published import published_rows
from studies.common.runs import decimated
from studies.common.stamp import Probed
from studies.common.sweeps import sweep_of
from studies.common.types import Array

EVERY = 200  # ticks from one look to the next
STAND = 1.0  # [s] before the walk
SETTLED = 0.5  # [s] after which errors count: the level is found
SEEN = [TURN, TURN + 1, *range(VELOCITY, PLACE)]  # errors that can be observed
SPEED, TURN_RATE, BEND = 0.6, 0.2, 10.0  # [m/s], [rad/s], [s] of the long walk's turns
LOSSES = {  # its groups of walks that are made on the truth and on the estimate
    "wide": "wide",
    "push_10": "wide_push_10",
    "tiles": "wide_rough",
    "slope_10": "wide_slope_10",
}
SPEEDS = (1.2, 1.3, 1.4)  # [m/s] of the walks ahead
LIMIT = 4.0 * 3600.0  # [s] of wall time of a walk


@dataclass(frozen=True)
class Walk:
    """A walk of the study."""

    kind: str  # "drift", "forward" or one of `LOSSES`
    index: int  # of the seed, of one of `LOSSES` in its group of the sweep
    on_estimate: bool
    size: float = 0.0  # length of the way [m], or speed [m/s]

    @property
    def key(self) -> str:
        """What makes it one walk."""
        return (
            f"{self.kind} {self.size:g} {self.index} {'estimate' if self.on_estimate else 'truth'}"
        )

    def scenario(self) -> Scenario:
        """Return what is simulated."""
        if self.kind in LOSSES:
            found = scenario_of(sweep_of(SWEEPS[0]), LOSSES[self.kind], self.index)
        else:
            found = Scenario(seed=self.index, segments=[Segment("stand", STAND), *self._segments()])
            if self.kind == "forward":
                gait = replace(found.gait, forward_max=max(self.size, 1.0))
                found = replace(found, gait=gait)
        return replace(found, estimation=self.on_estimate)

    def _segments(self) -> list[Segment]:
        if self.kind == "forward":
            return [Segment("walk", 8.0, True, [self.size, 0.0])]
        bends = max(round(self.size / SPEED / BEND), 1)
        turns = [TURN_RATE * (1.0 if i % 4 in (0, 3) else -1.0) for i in range(bends)]
        return [Segment(f"bend {i}", BEND, True, [SPEED, 0.0], t) for i, t in enumerate(turns)]


class Errors:
    """Keeps the errors of an estimate during a simulation."""

    def __init__(self, loop: ClosedLoop) -> None:
        """Look at `loop`."""
        self.rows: list[Array] = []  # time, 9 errors in W, 9 sigmas, 3 of the CoM, NEES
        self._loop, self._ticks = loop, 0
        self._scratch = loop.humanoid.plant.CreateDefaultContext()

    def __call__(self, root: Context) -> None:
        """Compare the estimate after a step with the truth; `root` is the diagram's context."""
        self._ticks += 1
        if self._ticks % EVERY or (estimator := self._loop.estimator) is None:
            return
        h, mine = self._loop.humanoid, estimator.GetMyContextFromRoot(root)
        found = estimator.GetOutputPort("state").Eval(mine)
        true = self._loop.plant.state(root)
        turn = Rotation.from_quat(found[:4], scalar_first=True)
        turn *= Rotation.from_quat(true[:4], scalar_first=True).inv()
        v = slice(h.nq + 3, h.nq + 6)
        error = np.concatenate([turn.as_rotvec(), found[v] - true[v], found[4:7] - true[4:7]])
        s = filter_of(mine.get_discrete_state(0).value().copy())
        # The filter's own error of velocity: without what a wrong heading, unseen, makes of it.
        seen = np.concatenate([error[:2], found[v] - turn.apply(true[v])])
        nees = seen @ np.linalg.solve(s.P[np.ix_(SEEN, SEEN)], seen)
        com = self._com_velocity(found) - self._com_velocity(true)
        row = [root.get_time()], error, deviations(s), com, [nees]
        self.rows.append(np.concatenate(row))

    def _com_velocity(self, x: Array) -> Array:
        humanoid = self._loop.humanoid
        humanoid.plant.SetPositionsAndVelocities(self._scratch, x)
        velocity: Array = humanoid.floating.com_velocity(self._scratch)
        return velocity


@cache
def probe() -> dict[str, Probed]:
    """Return a quick form of the study: errors of the estimate on a short way."""
    row = walked(Walk("drift", 0, True, SPEED * BEND))
    errors = np.array(row["errors"])
    settled, way = errors[errors[:, 0] > SETTLED], row["way"]
    drift = float(np.linalg.norm(errors[-1, 7:9]) / way)
    return {
        "upright": Probed(float(row["upright"]), 0.0),
        "velocity_m_s": Probed(float(np.sqrt(np.mean(settled[:, 4:7] ** 2))), 0.01),
        "tilt_rad": Probed(float(np.sqrt(np.mean(settled[:, 1:3] ** 2))), 0.002),
        "drift_share": Probed(drift, 0.01),
    }


def walked(walk: Walk) -> dict[str, Any]:
    """Simulate a walk; return what came of it, as plain data.

    Returns:
        `key`; its fields; `upright`; `reason` why it was not; `way` [m]; `speed` ahead over the
        second half of a walk ahead [m/s], None of another or of one that fell; and of a long walk
        on the estimate `errors`: rows of `Errors`.
    """
    loop = build_closed_loop(walk.scenario())
    errors = Errors(loop)
    run = simulate(loop, look=errors if walk.on_estimate else None)
    way = float(np.linalg.norm(np.diff(run.com[::50, :2], axis=0), axis=1).sum())
    ahead = walk.kind == "forward"
    velocity = segment_velocity(run, STAND, run.scenario.duration) if ahead else None
    outcome = judge(run)
    loop.recorder.keep_last(0)
    return {
        "key": walk.key,
        **asdict(walk),
        "upright": upright(outcome),
        "reason": outcome["fall_reason"] or outcome["cause"],
        "way": way,
        "speed": None if velocity is None else float(velocity[0]),
        "errors": decimated(np.array(errors.rows), 1) if walk.kind == "drift" else [],
    }


def known(walks: Sequence[Walk]) -> dict[str, dict[str, Any]]:
    """Return what came of walks on the truth that the study of robustness has published, by key."""
    rows = published_rows(sweep_of(SWEEPS[0]))
    found = {}
    for walk in walks:
        row = rows.get((LOSSES.get(walk.kind, ""), walk.index))
        if row is not None and not walk.on_estimate:
            why = row["fall_reason"] or row["cause"]
            found[walk.key] = {**lost(walk, why), "upright": upright(row)}
    return found


def lost(walk: Walk, error: str) -> dict[str, Any]:
    """Return what stands for `walked` of a walk whose process crashed or took too long."""
    rest = {"upright": False, "reason": error, "way": 0.0, "speed": None, "errors": []}
    return {"key": walk.key, **asdict(walk), **rest}


def limit(_: Walk) -> float:
    """Return how long a walk may take [s]."""
    return LIMIT
