"""How fast joints of the legs may accelerate for their limits of position and of torque."""

from typing import NamedTuple

import numpy as np

from drake_linefoot.math.compiled import compiled
from drake_linefoot.signals import RobotDynamics
from drake_linefoot.types import Array, Flags, Indices

WEAK_PASSES = 8  # corrections of the accelerations of joints at their torque limits
_AT_LIMIT = 1e-3  # [-] of its limit by which a torque may exceed it


class JointLimits(NamedTuple):
    """The limits of both legs, less the margin.

    Attributes:
        index_q: of the joints of each leg in q, shape (2, n).
        index_v: of them in v, shape (2, n).
        lower: [rad], shape (2, n).
        upper: [rad], shape (2, n).
        rate: of the spring that a joint may not be faster than, its natural frequency [1/s].
        pitch_length: for which a radian of a foot is given up [m].
        knee: its place in a leg.
        ankle: that of the joint that pitches the foot.
        roll: that of the joint that rolls a sole; -1 where there is none.
        effort: torque limits, symmetric [N m], shape (2, n).
    """

    index_q: Indices
    index_v: Indices
    lower: Array
    upper: Array
    rate: float
    pitch_length: float
    knee: int
    ankle: int
    roll: int
    effort: Array


@compiled
def limited_acceleration(
    q: Array, v: Array, a: Array, lower: Array, upper: Array, rate: float
) -> tuple[Array, Flags]:
    """Return the accelerations nearest to desired ones that keep joints off their limits.

    A joint comes no nearer to a limit than a critically damped spring at the limit lets it.

    Args:
        q: angles [rad], shape (n,).
        v: their rates [rad/s], shape (n,).
        a: desired accelerations [rad/s^2], shape (n,).
        lower: limits [rad], shape (n,).
        upper: limits [rad], shape (n,).
        rate: of the spring [1/s].

    Returns:
        (allowed, changed): accelerations [rad/s^2], shape (n,), and which differ from what is
        desired, shape (n,).
    """
    allowed, changed = np.empty(len(a)), np.zeros(len(a), dtype=np.bool_)
    for i in range(len(a)):
        low = rate * (rate * (lower[i] - q[i]) - 2.0 * v[i])
        high = rate * (rate * (upper[i] - q[i]) - 2.0 * v[i])
        allowed[i] = min(max(a[i], low), high)
        changed[i] = allowed[i] != a[i]
    return allowed, changed


@compiled
def hold_weak_joints(
    d: RobotDynamics,
    vdot: Array,
    swings: tuple[bool, bool],
    limits: JointLimits,
    held: tuple[Flags, Flags, Array],
) -> bool:
    """Let joints of swinging legs accelerate as their torques allow; return whether one changes.

    What a swing asks beyond them would be clipped, and before that the program (49) would move the
    torso by the wrench of the other foot to spare the joint: the robot jumps. A joint at its limit
    gets the acceleration that its own inertia allows, the others then move the foot as they can;
    what that changes of its torque is corrected in the next pass, mostly to 2 % of the limit, and
    what is left of it is clipped. A limit of position comes first.

    Args:
        d: present quantities.
        vdot: desired accelerations, shape (nv,).
        swings: whether the left and the right foot have a task in the air.
        limits: of both legs.
        held: joints of both legs that are held, those of them that are held for their torque, and
            their accelerations [rad/s^2], shape (2, n) each; changed in place.
    """
    active, weak, a = held
    changed = False
    for side in range(2):
        for j in range(active.shape[1]):
            if not swings[side] or (active[side, j] and not weak[side, j]):
                continue
            i, effort = limits.index_v[side, j], limits.effort[side, j]
            tau = d.M[i] @ vdot + d.Cv[i] - d.tau_g[i]
            beyond = tau - min(max(tau, -effort), effort)
            if abs(beyond) > _AT_LIMIT * effort:
                q, wanted = d.q[limits.index_q[side, j]], vdot[i] - beyond / d.M[i, i]
                allowed, _ = limited_acceleration(
                    np.array((q,)), np.array((d.v[i],)), np.array((wanted,)),
                    limits.lower[side, j : j + 1], limits.upper[side, j : j + 1], limits.rate,
                )  # fmt: skip
                active[side, j], weak[side, j], a[side, j], changed = True, True, allowed[0], True
    return changed
