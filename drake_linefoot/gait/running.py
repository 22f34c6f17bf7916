"""A run: the CoM bounces on one foot and flies to the next.

In a stance of duration T_s its height is a cubic of time, from what it is to that from which a
flight of T_f ends as high as it began, z' = g T_f / 2; so the horizontal pendulum has an omega of
its own, ``omega^2 = (g + (v_LO - z') / T) / z``. In a flight it goes straight on, and falls.
"""

import math

import numpy as np

from drake_linefoot.constants import STANDARD_GRAVITY
from drake_linefoot.gait.contacts import in_contact
from drake_linefoot.gait.footsteps import (
    SIDE_SIGN,
    foot_heading,
    heading_vector,
    nearest_turn,
    seen_from_stance,
    step_command,
)
from drake_linefoot.gait.known_ground import snapped
from drake_linefoot.gait.patches import height_on
from drake_linefoot.gait.state import YAW, GaitConstants, GaitState
from drake_linefoot.gait.swing_foot import set_target
from drake_linefoot.math.compiled import compiled
from drake_linefoot.types import Array

_STIFFNESS = 0.5  # [-] share of what the CoM is off its height that a whole stance takes back
_SOFTEST, _HARDEST = 0.5, 4.0  # [-] of g, between which a mean vertical force over m is believed


@compiled
def com_above_ground(s: GaitState) -> Array:
    """Return the CoM, its height above the ground, and its velocity [m, m/s], shape (2, 3)."""
    com, slope = np.empty((2, 3)), s.ground.slope
    com[0], com[1] = s.robot.pendulum_com, s.robot.com_velocity
    com[0, 2] -= height_on(s.ground.slope[:], s.robot.feet[int(s.clock.side)], com[0])
    com[1, 2] -= slope[0] * com[1, 0] + slope[1] * com[1, 1]
    return com


@compiled
def bounce(com: Array, duration: float, flight: float, c: GaitConstants) -> tuple[Array, float]:
    """Return how the CoM bounces on a foot until that is lifted.

    With ``z_free = z + (z' + v_LO) T / 2``, where a constant force would take it, it ends a share
    of the way from there to `run_height`: `_STIFFNESS` in a whole stance, less in what is left
    of one, where it would take more force.

    Args:
        com: height above the ground last, over its rate, shape (2, 3).
        duration: T until the foot is lifted [s], positive.
        flight: T_f after it [s].
        c: constants.

    Returns:
        (cubic, omega): coefficients of the height by time [m, s], shape (4,), and the natural
        frequency of the pendulum [1/s].
    """
    T, z, rate, leaves = duration, com[0, 2], com[1, 2], 0.5 * STANDARD_GRAVITY * flight
    free = z + 0.5 * (rate + leaves) * T
    share = _STIFFNESS * min(T / (c.run_step - flight), 1.0) ** 2
    rise, faster = free + share * (c.run_height - free) - z - rate * T, leaves - rate
    cubic = np.array((z, rate, (3.0 * rise / T - faster) / T, (faster - 2.0 * rise / T) / (T * T)))
    force = STANDARD_GRAVITY + faster / T
    least, most = _SOFTEST * STANDARD_GRAVITY, _HARDEST * STANDARD_GRAVITY
    return cubic, math.sqrt(min(max(force, least), most) / z)


@compiled
def after_bounce(com: Array, cop: Array, duration: float, cubic: Array, omega: float) -> Array:
    """Return CoM and velocity after a `duration` [s] of a `bounce` on a CoP, shape (2, 3)."""
    t, C, S = duration, math.cosh(omega * duration), math.sinh(omega * duration)
    out = np.empty((2, 3))
    for i in range(2):
        away = com[0, i] - cop[i]
        out[0, i] = cop[i] + C * away + S / omega * com[1, i]
        out[1, i] = omega * S * away + C * com[1, i]
    out[0, 2] = cubic[0] + t * (cubic[1] + t * (cubic[2] + t * cubic[3]))
    out[1, 2] = cubic[1] + t * (2.0 * cubic[2] + t * 3.0 * cubic[3])
    return out


@compiled
def after_flight(com: Array, duration: float) -> Array:
    """Return CoM and velocity after a flight of a `duration` [s], shape (2, 3)."""
    out = com.copy()
    out[0] += duration * com[1]
    out[0, 2] -= 0.5 * STANDARD_GRAVITY * duration * duration
    out[1, 2] -= STANDARD_GRAVITY * duration
    return out


@compiled
def bounce_cop(foot: Array, c: GaitConstants) -> Array:
    """Return where the force on a foot [x, y, z, yaw] is planned to be in a run [m], shape (2,)."""
    return foot[:2] - heading_vector(foot[3], c.run_ahead, 0.0)


@compiled
def run_foothold(
    s: GaitState, com: Array, after: float, foot: int, c: GaitConstants
) -> tuple[float, Array]:
    """Return heading [rad] and place [m] of a foot that lands in a run.

    With C, S = cosh, sinh of omega T_s the CoM leaves the foothold p at ``omega S (r - p) + C v``.
    It is put where that is the velocity of a steady run: forward and aside as commanded, and away
    from the foot with sigma, ``w = sigma (2 (1 + C) / (omega S) + T_f)`` the width between feet.
    But not where the leg would stay too far behind.

    Args:
        s: state of the gait.
        com: CoM and velocity as it lands, shape (2, 3).
        after: from now until then [s].
        foot: 0 left, 1 right.
        c: constants.
    """
    command, flight = step_command(s, c), s.command.flight
    T = c.run_step - flight
    heading = foot_heading(s.command.yaw, s.command.turn_rate, after, T)
    _, omega = bounce(com, T, flight, c)
    C, S = math.cosh(omega * T), omega * math.sinh(omega * T)
    sigma = c.run_width / (2.0 * (1.0 + C) / S + flight)
    turned = heading + 0.5 * command.turn_rate * command.duration
    v = command.velocity
    leaves = heading_vector(turned, v[0], v[1] - SIDE_SIGN[foot] * sigma)
    cop = com[0, :2] - (leaves - C * com[1, :2]) / S
    away = heading_vector(-heading, cop[0] - com[0, 0], cop[1] - com[0, 1])
    passes = T * heading_vector(-heading, com[1, 0], com[1, 1])[0]
    nearest, farthest = passes - c.run_trail, passes + c.run_trail
    ahead = min(
        max(away[0] + c.run_ahead, nearest, -c.reach_limits[0]), farthest, c.reach_limits[0]
    )
    outward = min(max(SIDE_SIGN[foot] * away[1], 0.0), c.reach_limits[1])
    return heading, com[0, :2] + heading_vector(heading, ahead, SIDE_SIGN[foot] * outward)


@compiled
def com_at_landing(s: GaitState, foot: int, c: GaitConstants) -> Array:
    """Return CoM and velocity as they will be when a foot that swings lands, shape (2, 3)."""
    com, other, flight = com_above_ground(s), 1 - foot, s.command.flight
    now, land = s.clock.time, s.clock.touchdown[foot]
    place = np.empty(4)
    place[:] = s.robot.feet[other]
    if not in_contact(s, other) and s.clock.touchdown[other] < land:
        com = after_flight(com, s.clock.touchdown[other] - now)
        now = s.clock.touchdown[other]
        place[:2], place[3] = s.swing.target[other, :2], s.swing.target[other, YAW]
    stands = in_contact(s, other) or now > s.clock.time
    lift = land - flight
    if stands and lift > now:
        cubic, omega = bounce(com, lift - now, flight, c)
        com = after_bounce(com, bounce_cop(place, c), lift - now, cubic, omega)
        now = lift
    return after_flight(com, land - now)


@compiled
def too_near(s: GaitState, foot: int, place: Array, heading: float, c: GaitConstants) -> float:
    """Return how much farther outward than at a place a foot lands clear of the other leg [m].

    They pass each other half of the way between `crossing_gap` and `run_width` apart at least.
    """
    side, stands = 1 - foot, np.empty(2)
    stands[:] = s.robot.feet[side, :2]  # or has stood until now
    if not in_contact(s, side) and s.clock.touchdown[side] < s.clock.touchdown[foot]:
        stands[:] = s.swing.target[side, :2]
    apart = seen_from_stance(side, place - stands, heading)[1]
    return max(0.5 * (c.crossing_gap + c.run_width) - apart, 0.0)


@compiled
def update_run_foothold(s: GaitState, foot: int, c: GaitConstants) -> None:
    """Choose where a foot that swings in a run will land."""
    com, after = com_at_landing(s, foot, c), s.clock.touchdown[foot] - s.clock.time
    heading, place = run_foothold(s, com, after, foot, c)
    aside = SIDE_SIGN[foot] * too_near(s, foot, place, heading, c)
    place, patch = snapped(s, place + heading_vector(heading, 0.0, aside), heading, c)
    set_target(s, foot, place, nearest_turn(heading, s.swing.reference[foot, 0, YAW]), patch)
