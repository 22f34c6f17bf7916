"""How fast the gait walks: as commanded, within limits, and as the ground allows; and why not."""

import math

import numpy as np

from drake_linefoot.gait.contacts import standing_still
from drake_linefoot.gait.learning import forget_speed
from drake_linefoot.gait.recovery import end_recovery
from drake_linefoot.gait.state import (
    CLIPPED,
    FREE,
    SLIPPERY,
    SLOPED,
    UNEVEN,
    GaitConstants,
    GaitState,
)
from drake_linefoot.math.compiled import compiled
from drake_linefoot.types import Array

_IN_A_RUN = 0.7  # [m/s^2] at most: one of 1 m/s^2 puts a foot 6 cm farther behind
_ON_A_FLOOR = 0.2  # [-] share of `unevenness_max` that changes nothing


@compiled
def speed_limit(
    slope: float, unevenness: float, friction: float, c: GaitConstants
) -> tuple[float, float]:
    """Return how fast ground is walked that is not flat and firm.

    Uphill the leg behind gets straight and its ankle to its stop, so that the speed times the slope
    is at most `climb_max`; and the speed goes down to `careful_speed` as unevenness and friction
    come to `unevenness_max` and `friction_careful`.

    Args:
        slope: rise per metre where it is steepest [-].
        unevenness: see `update_unevenness_estimate` [m].
        friction: that is believed, see `update_friction_estimate` [-].
        c: constants of the gait.

    Returns:
        (speed, reason): [m/s], and `SLOPED`, `UNEVEN` or `SLIPPERY`, what bounds it most.
    """
    uneven = max((unevenness / c.unevenness_max - _ON_A_FLOOR) / (1.0 - _ON_A_FLOOR), 0.0)
    slides = max((c.friction_firm - friction) / (c.friction_firm - c.friction_careful), 0.0)
    firm = max(1.0 - uneven - slides, 0.0)
    forward = c.command_max[0] if firm == 1.0 else min(c.command_max[0], c.walk_max)
    commanded = math.hypot(forward, c.command_max[1])
    fastest = c.careful_speed + firm * max(commanded - c.careful_speed, 0.0)
    climbing = c.climb_max / max(slope, 1e-9)
    if climbing < fastest:
        return climbing, SLOPED
    return fastest, UNEVEN if uneven > slides else SLIPPERY


@compiled
def allowed_command(s: GaitState, command: Array, c: GaitConstants) -> tuple[Array, float]:
    """Return the command within its limits, and slower where the ground is not flat and firm.

    Args:
        s: state of the gait.
        command: [v_x, v_y, turn rate, walk], heading frame [m/s, m/s, rad/s, 0 or 1], shape (4,).
        c: constants.

    Returns:
        (command, reason): [v_x, v_y, turn rate], shape (3,), and why it is another, a `Limit`.
    """
    allowed, reason = np.empty(3), FREE
    for i in range(3):
        allowed[i] = min(max(command[i], -c.command_max[i]), c.command_max[i])
        if allowed[i] != command[i]:
            reason = CLIPPED
    speed, slope = (
        math.hypot(allowed[0], allowed[1]),
        math.hypot(s.ground.slope[0], s.ground.slope[1]),
    )
    uneven = s.ground.unevenness
    if s.command.flight > 0.0:  # goes over tiles: what they raise between two feet is no slope
        slope = max(slope - uneven / max(speed * c.run_step, c.slope_baseline), 0.0)
        uneven = 0.0
    fastest, ground = speed_limit(slope, uneven, s.footing.friction, c)
    stairs = c.stairs_climb_max / max(s.terrain.steep, 1e-9)
    if stairs < fastest:
        fastest, ground = stairs, SLOPED
    if speed > fastest:
        allowed[:2] *= fastest / speed
        reason = ground
    return allowed, reason


@compiled
def follow_command(s: GaitState, command: Array, dt: float, c: GaitConstants) -> None:
    """Clip and rate-limit the command, and turn the desired heading with it over `dt` [s]."""
    now, walks = np.empty(3), not standing_still(s) and command[3] > 0.5
    allowed, s.command.limited = allowed_command(s, command, c)
    now[:2], now[2] = s.command.velocity, s.command.turn_rate
    for i in range(3):
        desired = allowed[i] if walks else 0.0
        rate = c.command_rate[i]
        if i < 2 and s.command.flight > 0.0:
            rate = min(rate, _IN_A_RUN)
        most = rate * dt
        now[i] += min(max(desired - now[i], -most), most)
    s.command.clipped += s.command.limited != FREE
    s.command.velocity[:], s.command.turn_rate = now[:2], now[2]
    if not standing_still(s):
        s.command.yaw += now[2] * dt


@compiled
def halt(s: GaitState) -> None:
    """Stand still from now on."""
    s.command.velocity[:], s.command.turn_rate = 0.0, 0.0


@compiled
def choose_gait(s: GaitState, walk: bool, c: GaitConstants) -> None:
    """Choose at a touchdown whether the steps to come are those of a run.

    A robot whose walk needs recovery steps to keep up with its command is to run all the more.
    """
    speed, runs = math.hypot(s.command.velocity[0], s.command.velocity[1]), s.command.flight > 0.0
    fast = speed > (c.walk_below if runs else c.run_above)
    flight = 0.0
    if c.flight >= 0.0 and (walk or fast):
        flight = c.flight
    elif c.flight < 0.0 and fast:
        flight = c.run_flight
    if (flight > 0.0) == runs:
        return
    s.command.flight = flight
    end_recovery(s)
    forget_speed(s, c)
