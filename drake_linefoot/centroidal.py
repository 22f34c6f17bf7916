"""Centroidal motion under wrenches that are constant for a while: (2), (3) in closed form."""

from typing import NamedTuple

import numpy as np

from drake_linefoot.axes import TORQUE_AXES
from drake_linefoot.constants import GRAVITY
from drake_linefoot.math.compiled import compiled
from drake_linefoot.math.rotation import cross, crosses
from drake_linefoot.signals import CentroidalPlan, RobotDynamics
from drake_linefoot.types import Array, Indices

TIME_EPSILON = 1e-9  # [s] a time this little before a knot is at the knot
NO_WRENCH = np.zeros(6)  # nothing but the ground acts on the robot


class PlanSample(NamedTuple):
    """The centroidal plan at one time.

    Attributes:
        r, v, a: CoM position, velocity, acceleration [m, s], shape (3,).
        L, L_dot: angular momentum about the CoM and its rate, shape (3,).
        wrench: wrench of each foot, shape (2, nw).
    """

    r: Array
    v: Array
    a: Array
    L: Array
    L_dot: Array
    wrench: Array


def resultants(wrench: Array, p_WC: Array, R_WC: Array, r_G: Array) -> tuple[Array, Array]:
    """Return the force and the moment about r_G of both feet, the sums of (2).

    Args:
        wrench: of each foot in each interval, forces in W, torques in C [N, N m], (K, 2, nw).
        p_WC: contact lines [m], shape (K, 2, 3).
        R_WC: contact frames, shape (K, 2, 3, 3).
        r_G: [m], shape (3,).

    Returns:
        (force, moment): [N] and [N m], shapes (K, 3).
    """
    f, moment = wrench[..., :3], crosses(p_WC - r_G, wrench[..., :3])
    for i, axis in zip(range(3, wrench.shape[-1]), TORQUE_AXES, strict=False):
        moment = moment + R_WC[..., axis] * wrench[..., i, None]
    return f.sum(axis=1), moment.sum(axis=1)


@compiled
def interval_at(times: Array, t: float) -> int:
    """Return the interval between knots that contains `t` [s]: the first before, the last after."""
    k = 0
    while k + 2 < len(times) and times[k + 1] <= t + TIME_EPSILON:
        k += 1
    return k


def intervals_at(times: Array, t: Array) -> Indices:
    """Return the intervals between knots that contain times [s], see `interval_at`, shape (n,)."""
    # The first knot bounds nothing, and the last neither.
    return times[1:-1].searchsorted(t + TIME_EPSILON, side="right")


@compiled
def sample_plan(plan: CentroidalPlan, t: float) -> PlanSample:
    """Return a plan at one time, held at its end.

    Force and moment about r_G are constant in an interval, so (2) and (3) integrate to
    polynomials of the time since its start.

    Args:
        plan: the plan.
        t: [s].
    """
    k = interval_at(plan.times, t)
    tau = min(t, plan.times[-1]) - plan.times[k]
    force, moment, m = plan.force[k], plan.moment[k], plan.mass
    r0, v0, L0 = plan.states[k, :3] - plan.r_G, plan.states[k, 3:6], plan.states[k, 6:9]
    turning, pull = plan.external[:3], m * GRAVITY + plan.external[3:]  # at the CoM
    a = (pull + force) / m
    v = v0 + tau * a
    r = r0 + tau * v0 + (0.5 * tau * tau) * a  # from r_G
    mean_r = r0 + (0.5 * tau) * v0 + (tau * tau / 6.0) * a
    L_G = L0 + tau * (moment + turning + cross(mean_r, pull))
    L, L_dot = L_G - m * cross(r, v), moment + turning - cross(r, force)
    return PlanSample(r + plan.r_G, v, a, L, L_dot, plan.wrench[k])


@compiled
def free_fall(plan: PlanSample, d: RobotDynamics, external: Array, mass: float) -> PlanSample:
    """Return what becomes of a plan with no foot on the ground: momentum goes as physics has it.

    Args:
        plan: as it was meant.
        d: present quantities.
        external: what else acts on the robot, moment about the CoM over force in W, shape (6,).
        mass: [kg].
    """
    a, L = GRAVITY + external[3:] / mass, d.A[:3] @ d.v
    return PlanSample(d.p_WG, d.v_WG, a, L, external[:3].copy(), np.zeros_like(plan.wrench))
