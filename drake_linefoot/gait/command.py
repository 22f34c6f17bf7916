"""How fast the gait walks: as commanded, within limits, and as the ground allows.

`s` is the gait's state, see `state.GAIT`, and `c` are its constants, see `gait_constants`.
"""

import math

import numpy as np

from drake_linefoot.gait.footing import present_slip
from drake_linefoot.gait.state import STAND
from drake_linefoot.math.compiled import compiled
from drake_linefoot.types import Array

_ON_A_FLOOR = 0.2  # [-] share of `unevenness_max` and `slip_max` that changes nothing


@compiled
def speed_limit(slope: float, unevenness: float, slip: float, c: np.record) -> float:
    """Return how fast ground is walked that is not flat and firm [m/s].

    Uphill the leg behind gets straight and its ankle to its stop, so that the speed times the slope
    is at most `climb_max`; and the speed goes down to `careful_speed` as unevenness and slip come
    to `unevenness_max` and `slip_max`.

    Args:
        slope: rise per metre where it is steepest [-].
        unevenness: see `learn_unevenness` [m].
        slip: see `learn_slip` [m].
        c: constants of the gait.
    """
    doubt = (unevenness / c.unevenness_max + slip / c.slip_max - _ON_A_FLOOR) / (1.0 - _ON_A_FLOOR)
    firm = min(max(1.0 - doubt, 0.0), 1.0)
    commanded = math.hypot(c.command_max[0], c.command_max[1])
    fastest = c.careful_speed + firm * max(commanded - c.careful_speed, 0.0)
    return min(fastest, c.climb_max / max(slope, 1e-9))


@compiled
def allowed_command(s: np.record, command: Array, c: np.record) -> Array:
    """Return the command within its limits, and slower where the ground is not flat and firm.

    Args:
        s: state of the gait.
        command: [v_x, v_y, turn rate, walk], heading frame [m/s, m/s, rad/s, 0 or 1], shape (4,).
        c: constants.

    Returns:
        [v_x, v_y, turn rate], shape (3,).
    """
    allowed = np.empty(3)
    for i in range(3):
        allowed[i] = min(max(command[i], -c.command_max[i]), c.command_max[i])
    speed, slope = math.hypot(allowed[0], allowed[1]), math.hypot(s.slope[0], s.slope[1])
    fastest = speed_limit(slope, s.unevenness, max(s.slip, present_slip(s)), c)
    if speed > fastest:
        allowed[:2] *= fastest / speed
    return allowed


@compiled
def follow_command(s: np.record, command: Array, dt: float, c: np.record) -> None:
    """Clip and rate-limit the command, and turn the desired heading with it over `dt` [s]."""
    now, allowed, clipped = np.empty(3), allowed_command(s, command, c), False
    now[:2], now[2] = s.velocity, s.turn_rate
    for i in range(3):
        clipped = clipped or allowed[i] != command[i]
        desired = allowed[i] if s.mode != STAND and command[3] > 0.5 else 0.0
        most = c.command_rate[i] * dt
        now[i] += min(max(desired - now[i], -most), most)
    s.clipped_commands += clipped
    s.velocity[:], s.turn_rate = now[:2], now[2]
    if s.mode != STAND:
        s.yaw += now[2] * dt
