"""What the compiled functions of the gait know of its parameters and of the robot."""

import numpy as np

from drake_linefoot.gait.parameters import GaitParameters
from drake_linefoot.gait.pendulum import natural_frequency, switch_time
from drake_linefoot.gait.state import Records
from drake_linefoot.robot.description import StepLimits

_STRIDES_AHEAD = 6  # exp(-6 w T) is below 0.5 % for w T = 0.9


def gait_constants(parameters: GaitParameters, limits: StepLimits, half_length: float) -> Records:
    """Return the constants of a gait as an array of one record, shape (1,).

    Args:
        parameters: every number of it becomes a field of the same name.
        limits: of a step of the robot.
        half_length: X of its contact lines [m], a field, too.

    Returns:
        The record has further fields: `first_stance`, the foot that stands in the first step;
        `strides_ahead`, see `nominal_strides`; `omega` [1/s] and `switch` [s], see `pendulum`;
        `command_max` and `command_rate` of forward, left and turn; `step_limits` and
        `reach_limits`, see `clip_foothold`.
    """
    p = parameters
    omega = natural_frequency(p.com_height)
    values = {name: value for name, value in vars(p).items() if not isinstance(value, str)}
    values |= {
        "first_stance": 0 if p.first_swing == "right" else 1,
        "half_length": half_length,
        "strides_ahead": _STRIDES_AHEAD,
        "omega": omega,
        "switch": switch_time(p.double_support, omega),
        "command_max": [p.forward_max, p.lateral_max, p.turn_max],
        "command_rate": [p.linear_acceleration, p.linear_acceleration, p.angular_acceleration],
        "step_limits": [limits.step_length, limits.step_width_min, limits.step_width_max],
        "reach_limits": [p.reach_forward, -np.inf, p.reach_outward],
    }
    fields = [(name, "f8", np.shape(value)) for name, value in values.items()]
    constants = np.zeros(1, np.dtype((np.record, fields)))
    for name, value in values.items():
        constants[name] = value
    return constants
