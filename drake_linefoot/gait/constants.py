"""What the compiled functions of the gait know of its parameters and of the robot."""

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from drake_linefoot.gait.parameters import GaitParameters
from drake_linefoot.gait.pendulum import natural_frequency, switch_time
from drake_linefoot.gait.state import CONSTANTS, Records
from drake_linefoot.gait.step_program import PEAK
from drake_linefoot.gait.viability import offset_limits
from drake_linefoot.robot.description import StepLimits
from drake_linefoot.robot.dynamics import robot_dynamics
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.robot.legs import contact_from_ankle, leg_roles
from drake_linefoot.robot.scaling import scaled
from drake_linefoot.types import Array, Indices

_BETWEEN_SOLES = 0.2  # [-] of `crossing_gap`, which a wider sole leaves between the two
_LIFT = 32.0  # of the acceleration of a swing's bump at its ends, times T^2 over its height
_RECOVERY_SETTLE = 0.2  # [-] of `settle_time`
_RUN_SHARE = 0.6  # [-] of `swing_acceleration`; a G1 runs with 0.7 of it, with 0.8 it slips
_STRIDES_AHEAD = 6  # exp(-6 w T) is below 0.5 % for w T = 0.9


def swing_acceleration(humanoid: Humanoid) -> Array:
    """Return how fast the leg can accelerate its foot, in the nominal posture over a torso at rest.

    Returns:
        Forward, to the side and up, until a joint's torque is at its limit [m/s^2], shape (3,).
    """
    d, leg = robot_dynamics(humanoid, humanoid.scratch, humanoid.x_nominal), humanoid.leg_v[0]
    efforts = np.full(humanoid.nv, np.inf)
    efforts[humanoid.actuated_v] = humanoid.effort_limits
    room = efforts[leg] - np.abs(d.tau_g[leg])
    joints = np.linalg.lstsq(d.J[0][:, leg], np.eye(humanoid.contact.size)[:, :3], rcond=None)[0]
    torque = np.abs(d.M[np.ix_(leg, leg)] @ joints)  # of 1 m/s^2
    return np.min(room[:, None] / np.maximum(torque, 1e-9 * room[:, None]), axis=0)


def swing_time_min(swing_height: float, acceleration: Array) -> float:
    """Return the shortest swing that lifts the foot by `swing_height` [m] as the legs can [s]."""
    return math.sqrt(_LIFT * swing_height / float(acceleration[2]))


def run_speed_max(p: GaitParameters, acceleration: Array) -> float:
    """Return how fast a robot can run [m/s].

    A foot of a run goes two steps far in a swing, from rest to rest; that is to take a share of
    what the leg can, which lifts the foot and turns with the torso too.

    Args:
        p: step and flight of the run.
        acceleration: see `swing_acceleration`.
    """
    swing = p.run_step + (p.run_flight if p.flight is None else p.flight)
    return _RUN_SHARE * float(acceleration[0]) * swing**2 / (2.0 * PEAK * p.run_step)


class Ankles(NamedTuple):
    """The joints that pitch the feet, left before right.

    Attributes:
        ankle_q: places in q, shape (2,).
        ankle_limits: least and greatest angle of each [rad], shape (2, 2).
        toe: how far the toe is ahead of them, and below [m], shape (2,).
    """

    ankle_q: Indices
    ankle_limits: Array
    toe: Array


def ankles_of(humanoid: Humanoid) -> Ankles:
    """Return the ankles of a robot."""
    ankle = leg_roles(humanoid).ankle
    rows = humanoid.leg_joints[:, ankle]
    limits = np.column_stack([humanoid.position_lower[rows], humanoid.position_upper[rows]])
    middle = contact_from_ankle(humanoid, 0)
    toe = np.array([middle[0] + humanoid.half_length, -middle[2]])
    return Ankles(humanoid.leg_q[:, ankle], limits, toe)


def constants_of(parameters: GaitParameters, humanoid: Humanoid) -> Records:
    """Return the constants of a robot's gait, with defaults in its size, see `gait_constants`."""
    d, p = humanoid.description, scaled(parameters, humanoid)
    size = humanoid.half_length, humanoid.half_width, d.contact_margin
    of_robot = size, swing_acceleration(humanoid), ankles_of(humanoid)
    width = max(humanoid.sole_width, 2.0 * humanoid.half_width)
    wider = max(p.crossing_gap, width + _BETWEEN_SOLES * p.crossing_gap)
    return gait_constants(replace(p, crossing_gap=wider), d.limits, *of_robot)


def gait_constants(
    parameters: GaitParameters,
    limits: StepLimits,
    size: tuple[float, float, float],
    acceleration: Array,
    ankles: Ankles,
) -> Records:
    """Return the constants of a gait as an array of one record, shape (1,).

    Args:
        parameters: every number of it becomes one of the same name.
        limits: of a step of the robot.
        size: X and Y of its contacts, of lines 0, and what of them the cones leave [m].
        acceleration: see `swing_acceleration`.
        ankles: of the robot.

    Returns:
        `GaitConstants`.
    """
    p = parameters
    omega = natural_frequency(p.com_height)
    quickest = swing_time_min(p.swing_height, acceleration)
    steps = np.array([limits.step_length, limits.step_width_min, limits.step_width_max])
    shortest = min(p.double_support_min, p.double_support)
    both, settle = p.double_support, p.settle_time
    if p.recovery_steps:  # as those are that follow an insufficient one
        both, settle = shortest, _RECOVERY_SETTLE * settle
    fastest, run_above = min(p.forward_max, p.walk_max), p.run_above
    runs = run_speed_max(p, acceleration)
    if p.flight or (p.flight is None and runs > run_above):
        fastest = min(p.forward_max, runs)
    elif p.flight is None:  # the legs are too slow
        run_above = math.inf
    values = vars(p) | {
        "run_above": run_above,
        "flight": -1.0 if p.flight is None else p.flight,
        "first_stance": 0 if p.first_swing == "right" else 1,
        "half_length": size[0],
        "half_width": size[1],
        "contact_margin": size[2],
        "strides_ahead": _STRIDES_AHEAD,
        "omega": omega,
        "switch": switch_time(p.double_support, omega),
        "double_support_min": shortest,
        "settle_time_min": _RECOVERY_SETTLE * p.settle_time,
        "switch_min": switch_time(shortest, omega),
        "command_max": [fastest, p.lateral_max, p.turn_max],
        "command_rate": [p.linear_acceleration, p.linear_acceleration, p.angular_acceleration],
        "step_limits": steps,
        "offset_limits": offset_limits(quickest + both, both + settle, steps, acceleration, omega),
        "swing_acceleration": acceleration,
        "swing_time_min": quickest,
        "reach_limits": [p.reach_forward, p.reach_outward],
    }
    values |= ankles._asdict()
    constants = np.zeros(1, CONSTANTS)
    for name in CONSTANTS.names or ():
        constants[name] = values[name]
    return constants
