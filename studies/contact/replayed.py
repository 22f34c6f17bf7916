"""The contact estimator over a recorded walk, again and with other parameters.

It sees what it saw in the loop: the states of the record, measured by the sensors of its
scenario, and the torque that was applied. What it says has no effect.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from drake_linefoot.estimation.contact_parameters import EstimatorParameters
from drake_linefoot.estimation.external_wrench import (
    external_constants,
    update_external_estimate,
    without_external,
)
from drake_linefoot.estimation.momentum_observer import momentum_terms, update_residual
from drake_linefoot.estimation.wrench_estimate import (
    contact_flags,
    estimate_wrenches,
    half_the_weight,
)
from drake_linefoot.lab.results.contact_events import detection, standing, touchdowns
from drake_linefoot.lab.results.thresholds import thresholds_of
from drake_linefoot.lab.simulation.recording import Run
from drake_linefoot.lab.simulation.sensors import BASE_NOISE, measured_state
from drake_linefoot.robot.dynamics import robot_dynamics
from drake_linefoot.robot.humanoid import Humanoid
from studies.common.runs import jsonable, percentile
from studies.common.types import Array, Flags


@dataclass(frozen=True)
class Observed:
    """What the observer needs of each sample of a run."""

    momentum: Array  # M v, shape (n, nv)
    known: Array  # part of its rate that is neither torque nor contact, shape (n, nv)
    J: Array  # line-contact Jacobians of both feet, shape (n, 2, 5, nv)
    R_WC: Array  # contact frames, shape (n, 2, 3, 3)
    lever: Array  # of the CoM from the base origin [m], shape (n, 3)
    torque: Array  # that was applied over the step before [N m], shape (n, na)


def observe(humanoid: Humanoid, run: Run, end: int) -> Observed:
    """Compute what the observer needs of the samples of a run before `end`.

    The sensors of its scenario measure it, with noise of its seed; `humanoid` is the robot as the
    controller knows it.
    """
    context = humanoid.plant.CreateDefaultContext()
    states = np.hstack([run.q, run.v])[:end]
    sensors, random = run.scenario.sensors, np.random.default_rng(run.scenario.seed)
    nv = humanoid.nv
    momentum, known = np.empty((2, end, nv))
    J, R_WC, lever = np.empty((end, 2, 5, nv)), np.empty((end, 2, 3, 3)), np.empty((end, 3))
    for i, x in enumerate(states):
        noise = random.standard_normal(2 * humanoid.na + BASE_NOISE)
        d = robot_dynamics(humanoid, context, measured_state(humanoid, sensors, x, noise))
        momentum[i], known[i] = momentum_terms(d, d.v)
        J[i], R_WC[i], lever[i] = d.J, d.R_WC, d.p_WG - d.p_WB
    return Observed(momentum, known, J, R_WC, lever, run.applied_torque[:end])


def estimate(
    humanoid: Humanoid, seen: Observed, parameters: EstimatorParameters, period: float
) -> tuple[Array, Array, Flags]:
    """Return what is told of the feet's generalized force, wrenches and flags of them.

    Shapes (n, nv), (n, 2, 5) and (n, 2), by the pseudoinverse, with filter and thresholds of
    `parameters`, from samples every `period` [s].
    """
    n, nv = seen.momentum.shape
    p, gamma = parameters, float(parameters.filter_constant)
    residuals, wrenches, flags = np.empty((n, nv)), np.empty((n, 2, 5)), np.ones((n, 2))
    wrenches[0] = half_the_weight(humanoid.mass, humanoid.contact.size)
    residuals[0] = np.einsum("fij,fi->j", seen.J[0], wrenches[0])
    of_feet, actuation = residuals.copy(), np.zeros((n, nv))
    actuation[:, humanoid.actuated_v] = seen.torque
    rates = np.diff(seen.momentum, axis=0) / period
    external, of_external = np.zeros(6), external_constants(parameters, humanoid, period)
    for i in range(1, n):
        residuals[i] = update_residual(
            residuals[i - 1], rates[i - 1], seen.known[i], actuation[i], gamma
        )
        J, lever = seen.J[i], seen.lever[i]
        now = rates[i - 1] - seen.known[i] - actuation[i]
        external = update_external_estimate(external, now, J, lever, of_external)
        of_feet[i] = without_external(residuals[i], external, lever)
        wrenches[i] = estimate_wrenches(of_feet[i], J)
        thresholds = float(p.touch_force), float(p.release_force)
        flags[i] = contact_flags(wrenches[i, :, 2], flags[i - 1], *thresholds)
    return of_feet, wrenches, flags > 0.5


class Score(NamedTuple):
    """How the estimator did for a foot in a walk."""

    latencies: Sequence[float] = ()  # of the touchdowns it detected [s]
    swings: int = 0  # touchdowns there were
    false_contacts: int = 0  # see `contact_events.Detection`
    missed: int = 0  # touchdowns


def score(run: Run, flags: Flags) -> list[Score]:
    """Hold the flags of the first samples of a run against the truth, foot by foot."""
    end = len(flags)
    time, normal, limits = run.time[:end], run.true_normal[:end].sum(axis=2), thresholds_of(run)
    scores = []
    for side in (0, 1):
        stands = standing(time, normal[:, side], limits)
        loaded = normal[:, side] > limits.load
        found = detection(time, stands, flags[:, side], limits, loaded)
        counts = len(touchdowns(stands)), found.false_positives, found.missed
        scores.append(Score(found.latencies.tolist(), *counts))
    return scores


def figures(scores: Sequence[Score]) -> dict[str, float | int | None]:
    """Return median and 95th percentile of the latency [ms], counts, and rates per swing [-]."""
    late = 1e3 * np.concatenate([score.latencies for score in scores])
    swings = sum(score.swings for score in scores)
    false, missed = sum(s.false_contacts for s in scores), sum(s.missed for s in scores)
    return {
        "latency_ms": jsonable(percentile(late, 50)),
        "latency_p95_ms": jsonable(percentile(late, 95)),
        "false_contact_rate": false / swings if swings else None,
        "missed_contact_rate": missed / swings if swings else None,
        "false_contacts": false,
        "missed_contacts": missed,
        "swings": swings,
    }
