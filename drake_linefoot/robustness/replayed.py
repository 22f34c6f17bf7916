"""The contact estimator over a recorded walk, again and with other parameters.

It sees what it saw in the loop: the states of the record, measured by the sensors of its
scenario, and the torque that was applied. What it says has no effect.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drake_linefoot.contact.kernels import next_estimate
from drake_linefoot.contact.momentum_observer import momentum_terms
from drake_linefoot.contact.parameters import EstimatorParameters
from drake_linefoot.contact.wrench_estimate import RANK_TOLERANCE, initial_state
from drake_linefoot.robot.dynamics import robot_dynamics
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.simulation.contact_events import (
    FORCE_THRESHOLD,
    Detection,
    detection,
    standing,
    touchdowns,
)
from drake_linefoot.simulation.recording import Run
from drake_linefoot.simulation.sensors import BASE_NOISE, measured_state

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]


@dataclass(frozen=True)
class Observed:
    """What the observer needs of each sample of a run.

    Attributes:
        momentum: M v, shape (n, nv).
        known: part of its rate that is neither torque nor contact, shape (n, nv).
        J: line-contact Jacobians of both feet, shape (n, 2, 5, nv).
        R_WC: contact frames, shape (n, 2, 3, 3).
        torque: that was applied over the step before [N m], shape (n, na).
    """

    momentum: Array
    known: Array
    J: Array
    R_WC: Array
    torque: Array


def observe(humanoid: Humanoid, run: Run, end: int) -> Observed:
    """Compute what the observer needs.

    Args:
        humanoid: the robot as the controller knows it.
        run: what was recorded; its scenario's sensors measure it, with noise of its seed.
        end: samples to take.
    """
    context, scratch = (humanoid.plant.CreateDefaultContext() for _ in range(2))
    states = np.hstack([run.q, run.v])[:end]
    sensors, random = run.scenario.sensors, np.random.default_rng(run.scenario.seed)
    nv = humanoid.nv
    momentum, known = np.empty((2, end, nv))
    J, R_WC = np.empty((end, 2, 5, nv)), np.empty((end, 2, 3, 3))
    for i, x in enumerate(states):
        noise = random.standard_normal(2 * humanoid.na + BASE_NOISE)
        d = robot_dynamics(humanoid, context, measured_state(humanoid, sensors, x, noise))
        terms = momentum_terms(humanoid, scratch, d)
        momentum[i], known[i], J[i], R_WC[i] = terms.momentum, terms.known, d.J, d.R_WC
    return Observed(momentum, known, J, R_WC, run.applied_torque[:end])


def estimate(
    humanoid: Humanoid, seen: Observed, parameters: EstimatorParameters, period: float
) -> tuple[Array, Array, Flags]:
    """Return residuals (n, nv), wrenches (n, 2, 5) and flags (n, 2) by the pseudoinverse.

    Args:
        humanoid: the robot.
        seen: of `observe`.
        parameters: filter and thresholds.
        period: of the samples [s].
    """
    n, nv = seen.momentum.shape
    state = initial_state(seen.momentum[0], seen.J[0], humanoid.mass)
    states = np.empty((n, len(state)))
    states[0] = state
    p = parameters
    for i in range(1, n):
        states[i], _ = next_estimate(
            states[i - 1], seen.momentum[i], seen.known[i], seen.torque[i], humanoid.actuated_v,
            period, p.filter_constant, seen.J[i], RANK_TOLERANCE, p.touch_force, p.release_force,
        )  # fmt: skip
    wrenches = states[:, 2 * nv : -2].reshape(n, 2, 5)
    return states[:, nv : 2 * nv], wrenches, states[:, -2:] > 0.5


@dataclass(frozen=True)
class Score:
    """How the estimator did over some walks.

    Attributes:
        latencies: of the touchdowns it detected [s].
        swings: touchdowns there were.
        false_contacts: see `contact_events.Detection`.
        missed: touchdowns.
    """

    latencies: tuple[float, ...] = ()
    swings: int = 0
    false_contacts: int = 0
    missed: int = 0

    def __add__(self, other: Score) -> Score:
        """Return the score of both."""
        return Score(
            self.latencies + other.latencies,
            self.swings + other.swings,
            self.false_contacts + other.false_contacts,
            self.missed + other.missed,
        )

    def figures(self) -> dict[str, float | int | None]:
        """Return median and 95th percentile of the latency [ms], and rates per swing [-]."""
        some = len(self.latencies) > 0
        return {
            "latency_ms": 1e3 * float(np.median(self.latencies)) if some else None,
            "latency_p95_ms": 1e3 * float(np.percentile(self.latencies, 95)) if some else None,
            "false_contact_rate": self.false_contacts / self.swings if self.swings else None,
            "missed_contact_rate": self.missed / self.swings if self.swings else None,
            "swings": self.swings,
        }


def score(run: Run, flags: Flags) -> Score:
    """Hold the flags of the first samples of a run against the truth."""
    end = len(flags)
    time, normal = run.time[:end], run.true_normal[:end].sum(axis=2)
    total = Score()
    for side in (0, 1):
        stands = standing(time, normal[:, side])
        loaded: Flags = normal[:, side] > FORCE_THRESHOLD
        found: Detection = detection(time, stands, flags[:, side], loaded)
        total += Score(
            tuple(found.latencies.tolist()),
            len(touchdowns(stands)),
            found.false_positives,
            found.missed,
        )
    return total
