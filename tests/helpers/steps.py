"""Steps of a pendulum: constants of a gait with and without limits, and swings of any kind."""

import numpy as np
from hypothesis import strategies as st

from drake_linefoot.gait.constants import gait_constants
from drake_linefoot.gait.footsteps import StepCommand
from drake_linefoot.gait.parameters import GaitParameters
from drake_linefoot.gait.state import YAW, new_state
from drake_linefoot.gait.touchdown import update_foothold
from drake_linefoot.robot.description import StepLimits
from tests.helpers.pendulum_robot import ANKLES
from tests.helpers.phases import set_swing, swing_of

T, WIDTH = 0.23, 0.16
ACCELERATION = np.array([175.0, 114.0, 190.0])  # [m/s^2] of a swing foot
ONE, ZERO = np.ones(2), np.zeros(2)
SLOPE = np.array([0.12, -0.07])  # of the ground
ANYWHERE = np.empty((0, 3)), np.array([-np.inf, np.inf]), 0.0  # there is ground for a foot
SCALE, OFFSET = np.array([1.1, 1.3]), np.array([0.02, -0.05])  # learned of the speed


def constants(base, **changes):
    """Constants of a gait, changed."""
    c = base.copy()
    for name, value in changes.items():
        c[name] = value
    return c


def _steps():
    """Constants of a gait whose steps last T, with limits."""
    p = GaitParameters(single_support=T - 0.03, double_support=0.03, step_length=9.0)
    return gait_constants(
        p, StepLimits(0.5, 0.1, 0.45, 0.56, 0.68), (0.1, 0.0, 0.0), ACCELERATION, ANKLES
    )[0]


SHAPE = constants(_steps(), switch=0.015)
UNLIMITED = constants(
    SHAPE,
    step_limits=[9.0, -9.0, 9.0], reach_limits=[99.0, 99.0], swing_acceleration=[1e9] * 3,
    crossing_max=0.0,
)  # fmt: skip
LENGTH_MAX, WIDTH_MIN, WIDTH_MAX = SHAPE.step_limits
OMEGA = float(SHAPE.omega)

lengths = st.floats(-1.5, 1.5)
points = st.tuples(lengths, lengths).map(np.array)
angles = st.floats(-10.0, 10.0)
sides = st.sampled_from([0, 1])
commands = st.builds(
    lambda vx, vy, w: StepCommand(np.array([vx, vy]), w, T),
    st.floats(-1.5, 1.5), st.floats(-0.5, 0.5), st.floats(-2.0, 2.0),
)  # fmt: skip
cases = st.tuples(points, points, points, angles, sides, commands)


def swing_state(case, height=0.0, slope=SLOPE, scale=SCALE, offset=OFFSET):
    """A state at time 0 in which the foot `side` swings, at rest in the origin.

    Its touchdown is planned for time 0, too; the stance foot is at `height`.
    """
    com, velocity, stance, yaw, side, command = case
    s = new_state()
    s.clock.side, s.command.yaw, s.command.turn_rate = 1 - side, yaw, command.turn_rate
    set_swing(s, 0.0, 0.0)
    s.robot.com[:], s.robot.com_velocity[:] = [*com, 0.6], [*velocity, 0.1]
    s.robot.pendulum_com[:], s.robot.pendulum_velocity[:] = s.robot.com, s.robot.com_velocity
    s.robot.feet[1 - side] = [*stance, height, yaw]
    s.command.velocity[:], s.speed.scale[:], s.speed.offset[:] = command.velocity, scale, offset
    s.ground.slope[:], swing_of(s).reference[0, YAW] = slope, yaw
    s.swing.height[:] = SHAPE.swing_height
    return s


def aimed(state, remaining, c):
    """Where the swing foot of a state is to land in a time, and whether a limit moved it."""
    set_swing(state, remaining - c.single_support, remaining)
    moved = update_foothold(state, 1 - int(state.clock.side), c)
    return swing_of(state).target, moved
