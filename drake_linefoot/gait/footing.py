"""How a standing foot holds on the ground: which ends bear, whether it slides, on what friction."""

import math

import numpy as np

from drake_linefoot.contact.wrench_cone import forces_at_ends, ground_frame
from drake_linefoot.gait.contacts import in_double_support
from drake_linefoot.gait.known_ground import slope_at
from drake_linefoot.gait.state import GaitConstants, GaitState
from drake_linefoot.math.compiled import compiled
from drake_linefoot.math.linear import dot
from drake_linefoot.math.rotation import cross
from drake_linefoot.signals import RobotDynamics
from drake_linefoot.types import Array

_OF_SLIDING = 0.05  # [-] share of what a tick tells in the friction
_AGAINST = 0.9  # [-] cosine of the angle between friction and what it is against
_OF_THE_LOAD = 0.3  # [-] an end that bears less of it tells nothing
_LOAD_TIME = 0.008  # [s] of the filter of what an end bears
_BEARS, _BEARS_AGAIN = 0.05, 0.06  # [-] an end that bears less of the load bears nothing
_AT_STOP = 0.02  # [rad] of an ankle from its stop, which bears what then looks like load
_HANGS = 0.1  # [-] above 0, see `with_friction`
_LEAST_FRICTION = 0.3  # [-] less is not believed
_REGAINED = 1.01  # [-] by a step that tells of none


@compiled
def present_slip(s: GaitState) -> float:
    """Return how far the stance foot of a swing has slid since it began [m]; else 0."""
    if in_double_support(s):
        return 0.0
    foot = s.robot.feet[int(s.clock.side)]
    return math.hypot(foot[0] - s.footing.anchor[0], foot[1] - s.footing.anchor[1])


@compiled
def is_at_stop(ankle: float, side: int, c: GaitConstants) -> bool:
    """Return whether an ankle [rad] is at a stop, so that its torque is not that of the ground."""
    low, high = c.ankle_limits[side]
    return bool(min(ankle - low, high - ankle) < _AT_STOP)


@compiled
def forces_on_ground(wrench: Array, R_WC: Array, R_WS: Array, c: GaitConstants) -> Array:
    """Return the forces at heel and toe in the frame of the ground [N], shape (2, 3).

    A sole as well is taken for its heel and its toe, each with the sum of its corners: tau_x, which
    moves load between left and right, says nothing of these, and four corners would be unknown
    up to a number that the wrench does not have. Its edges to the side hang where the ground falls
    off sideways, which the gait does not look for.

    Args:
        wrench: on the foot, forces in W and torques in C [N, N m], shape (nw,).
        R_WC: contact frame, shape (3, 3).
        R_WS: frame of the ground, see `ground_frame`, shape (3, 3).
        c: constants of the gait.
    """
    tau, in_ground = wrench[3] * R_WC[:, 1] + wrench[4] * R_WC[:, 2], np.empty(5)
    for i in range(3):
        in_ground[i] = dot(R_WS[:, i], wrench)
    in_ground[3], in_ground[4] = dot(R_WS[:, 1], tau), dot(R_WS[:, 2], tau)
    return forces_at_ends(in_ground, c.half_length)


@compiled
def present_load_shares(before: Array, forces: Array) -> Array:
    """Return which shares of the load on a foot its heel and its toe bear now [-].

    Forces that do not press tell nothing: then it is what they have borne of late.

    Args:
        before: that, see `update_load_share_estimate`, shape (2,).
        forces: at heel and toe, normal last [N], shape (2, 3).

    Returns:
        Shape (2,).
    """
    load, out = forces[0, 2] + forces[1, 2], before.copy()
    if load > 0.0:
        for i in range(2):
            out[i] = min(max(forces[i, 2] / load, 0.0), 1.0)
    return out


@compiled
def update_load_share_estimate(before: Array, now: Array, dt: float) -> Array:
    """Return which shares of the load on a foot its heel and its toe have borne of late [-].

    Args:
        before: shape (2,).
        now: see `present_load_shares`, shape (2,).
        dt: since [s].

    Returns:
        Shape (2,).
    """
    return before + min(dt / _LOAD_TIME, 1.0) * (now - before)


@compiled
def update_friction_share_estimate(before: Array, shares: Array, now: Array, turns: bool) -> Array:
    """Return the share of its friction that each end of a foot has [-].

    An end that bears nothing, as beyond the edge of a tile, does not keep the foot from turning
    about the other, and has hardly any from when it turns until it bears again. A foot that
    does not turn may roll over an end.

    Args:
        before: what it had, shape (2,).
        shares: see `update_load_share_estimate`, shape (2,).
        now: see `present_load_shares`, shape (2,).
        turns: whether it turns about one end.

    Returns:
        Shape (2,).
    """
    out = np.ones(2)
    for i in range(2):
        nothing = max(shares[i], now[i]) < _BEARS and turns
        hangs = now[i] < _BEARS_AGAIN if before[i] < 1.0 else nothing
        out[i] = _HANGS if hangs else 1.0
    return out


@compiled
def has_full_friction(shares: Array) -> bool:
    """Return whether no end of a foot hangs, so that its line is the ground's."""
    return bool(min(shares[0], shares[1]) == 1.0)


@compiled
def update_friction_estimate(
    friction: float,
    motion: tuple[Array, Array],
    forces: Array,
    R_WS: Array,
    c: GaitConstants,
) -> float:
    """Return the friction of the ground that the heel and the toe of a foot tell that slide [-].

    An end that slides is pulled against its motion by friction times its share of the normal force.
    Mostly the foot turns about the other end, so that its whole force tells nothing.

    Args:
        friction: believed before.
        motion: velocity of the middle of the line [m/s] and angular velocity of the foot [rad/s],
            shape (3,) each.
        forces: at heel and toe, see `forces_on_ground` [N], shape (2, 3).
        R_WS: frame of the ground, see `ground_frame`, shape (3, 3).
        c: constants of the gait.
    """
    v, w = motion
    f_z, turning = forces[0, 2] + forces[1, 2], c.half_length * cross(w, R_WS[:, 0])
    for i in (1, 0):  # toe, heel
        ahead, aside, normal = forces[i]
        if normal <= _OF_THE_LOAD * f_z or f_z <= 0.0:
            continue
        u = v + (2.0 * i - 1.0) * turning
        u_x, u_y = dot(R_WS[:, 0], u), dot(R_WS[:, 1], u)
        speed, pull = math.hypot(u_x, u_y), math.hypot(ahead, aside)
        if speed > c.contact_speed and -(ahead * u_x + aside * u_y) > _AGAINST * pull * speed:
            friction += _OF_SLIDING * (min(pull / normal, 1.0) - friction)
    return max(friction, _LEAST_FRICTION)


@compiled
def regain_friction(friction: float, told: bool) -> float:
    """Return the friction that is believed after a step: more if it `told` of none by sliding."""
    return friction if told else min(_REGAINED * friction, 1.0)


@compiled
def update_footing_estimate(
    s: GaitState, d: RobotDynamics, wrench: Array, dt: float, c: GaitConstants
) -> None:
    """Learn which ends of the stance foot bear load and hold, and the friction if it slides.

    Args:
        s: state of the gait.
        d: quantities of the state of the robot.
        wrench: of the contact estimator on that foot [N, N m], shape (nw,).
        dt: since the last tick [s].
        c: constants.
    """
    side = int(s.clock.side)
    R_WS = ground_frame(d.R_WC[side], slope_at(s, int(s.terrain.under[side])))
    forces = forces_on_ground(wrench, d.R_WC[side], R_WS, c)
    shares = s.footing.load_shares.copy()
    if not is_at_stop(d.q[int(c.ankle_q[side])], side, c):
        shares = present_load_shares(shares, forces)
        s.footing.load_shares[:] = update_load_share_estimate(s.footing.load_shares[:], shares, dt)
    turns = c.half_length * abs(d.w_WF[side, 2]) > c.contact_speed
    s.footing.friction_shares[side] = update_friction_share_estimate(
        s.footing.friction_shares[side], s.footing.load_shares[:], shares, turns
    )
    if s.command.flight == 0.0 and present_slip(s) > c.slip_min:
        motion, before = (d.v_WC[side], d.w_WF[side]), s.footing.friction
        s.footing.friction = update_friction_estimate(before, motion, forces, R_WS, c)
        if s.footing.friction != before:
            s.footing.slides = 1


@compiled
def forget_footing(s: GaitState) -> None:
    """Take it that both ends of both feet bear and have friction, as nothing is known of them."""
    s.footing.load_shares[:], s.footing.friction_shares[:] = 0.5, 1.0


@compiled
def set_stance_anchor(s: GaitState) -> None:
    """Keep where the stance foot stands as the other one is lifted."""
    s.footing.anchor[:] = s.robot.feet[int(s.clock.side), :2]


@compiled
def end_stance(s: GaitState) -> None:
    """Believe in more friction again after a stance that has not slid."""
    s.footing.friction = regain_friction(s.footing.friction, s.footing.slides > 0.0)
    s.footing.slides = 0.0
