"""What the gait remembers from one tick to the next, and what it knows: records with named parts.

Each part of the state is written by the functions of one module, which its docstring names, and
read by all. Compiled code takes an array of a record as ``s.robot.com[:]``, a plain array; without
the brackets it is another type to Numba, for which every function that it is given to is compiled
once more.
"""

from typing import Annotated

import numpy as np
from numpy.typing import NDArray

from drake_linefoot.axes import COMMAND, ENDS, FEET, LINE, PLACE_UNITS, XYZ
from drake_linefoot.axes import PLACE as PLACE_AXIS
from drake_linefoot.gait.parameters import GaitParameters
from drake_linefoot.layout import Part, record_of
from drake_linefoot.math.compiled import compiled
from drake_linefoot.parts import EXTERNAL, FRICTION, SLOPE, in_world, whole
from drake_linefoot.statuses import Limit, Mode
from drake_linefoot.types import Array

Records = NDArray[np.void]  # arrays of one `GaitState` or one `GaitConstants`, shape (1,)

SIZE = 5  # coordinates of a contact line: x, y, z, pitch, yaw
Z, PITCH, YAW = 2, 3, 4  # where they are
PLACE = np.array([0, 1, 2, YAW])  # where those of a foothold are
XY = ("x", "y")


class Clock:
    """Which phase of the gait it is, and for how long; written by `clock`."""

    time: Annotated[float, Part("at which the state holds", "s")]
    begun: Annotated[float, whole("1 once it was measured at the beginning of a simulation")]
    mode: Annotated[float, whole("a `Mode`")]
    side: Annotated[float, whole("stance foot; in double support the one the weight goes to")]
    phase_start: Annotated[float, Part("of the present phase", "s")]
    phase_end: Annotated[float, Part("of it, as planned", "s")]
    due: Annotated[float, Part("planned touchdown; a late foot moves `phase_end` alone", "s")]
    closing: Annotated[float, whole("1 while the swing foot is put beside the other to stand")]
    steps: Annotated[float, whole("taken so far")]


class Command:
    """What the robot is told, as far as it does it; written by `command`."""

    velocity: Annotated[Array, Part("after rate limits, heading frame", "m/s", XY)]
    turn_rate: Annotated[float, Part("likewise", "rad/s")]
    yaw: Annotated[float, Part("desired heading", "rad")]
    limited: Annotated[float, whole("why the command is another: a `Limit`")]
    clipped: Annotated[float, whole("ticks in which it was, so far")]


class Robot:
    """What is measured of the robot; written by `measurement`."""

    com: Annotated[Array, in_world("CoM", "m", XYZ)]
    com_velocity: Annotated[Array, in_world("its velocity", "m/s", XYZ)]
    external: Annotated[Array, EXTERNAL]
    lean: Annotated[Array, in_world("see `lean_into`", "m", XY)]
    pendulum_com: Annotated[Array, in_world("CoM moved by it", "m", XYZ)]
    pendulum_velocity: Annotated[Array, in_world("see there", "m/s", XYZ)]
    feet: Annotated[Array, Part("lines while they stand", PLACE_UNITS, FEET, PLACE_AXIS, frame="W")]


class SwingFoot:
    """Where the swing foot is to be and to go; written by `swing_foot`."""

    target: Annotated[Array, Part("where it will land", "m, rad", LINE, frame="W")]
    reference: Annotated[Array, Part("its motion without the bump", "m, rad, s", 3, LINE)]
    height: Annotated[float, Part("apex of the swing, or of the next", "m")]


class Ground:
    """What feet have felt of the ground; written by `ground`."""

    slope: Annotated[Array, SLOPE]
    unevenness: Annotated[float, Part("how far off the last steps met the ground", "m")]


class Footing:
    """How standing feet hold; written by `footing`."""

    bearing: Annotated[Array, Part("shares of the load on heel and toe of `side`", "-", ENDS)]
    grip: Annotated[Array, Part("share of the friction that each end has", "-", FEET, ENDS)]
    friction: Annotated[float, FRICTION]
    planted: Annotated[Array, in_world("stance foot when the other was lifted", "m", XY)]
    slides: Annotated[float, whole("1 once the stance foot has slid and told the friction")]


class Speed:
    """What was learned of the speed; written by `learning`."""

    scale: Annotated[Array, Part("of the velocity that footholds are made for", "-", XY)]
    offset: Annotated[Array, Part("added to it", "m/s", XY)]
    marks: Annotated[Array, Part("when and where the CoM was at touchdowns, newest first; a time "
                                 "below 0: none", "s, m", 2, ("time", *XY))]  # fmt: skip


class Recovery:
    """How the gait takes pushes; written by `recovery`."""

    hurried: Annotated[float, whole("steps until one is no longer")]
    again: Annotated[float, whole("1 in a double support after which the same foot swings again")]
    moved_footholds: Annotated[float, whole("ticks in which a limit moved the foothold")]


class GaitState:
    """All that the gait remembers."""

    clock: Clock
    command: Command
    robot: Robot
    swing: SwingFoot
    ground: Ground
    footing: Footing
    speed: Speed
    recovery: Recovery


class GaitConstants(GaitParameters):
    """What the gait knows: the numbers of its parameters in a robot's size, and what follows.

    `double_support_min` is at most `double_support`.
    """

    speed_scale: Annotated[Array, Part("see there", "-", XY)]  # type: ignore[assignment]
    first_stance: Annotated[float, whole("the foot that stands in the first step")]
    half_length: Annotated[float, Part("X of the contact lines", "m")]
    strides_ahead: Annotated[float, whole("see `nominal_strides`")]
    omega: Annotated[float, Part("natural frequency of the pendulum", "1/s")]
    switch: Annotated[float, Part("see `switch_time`", "s")]
    switch_min: Annotated[float, Part("likewise, hurried", "s")]
    settle_time_min: Annotated[float, Part("see `settle_time`", "s")]
    command_max: Annotated[Array, Part("bounds of its size", "m/s, rad/s", COMMAND)]
    command_rate: Annotated[Array, Part("bounds of its rate", "m/s^2, rad/s^2", COMMAND)]
    step_limits: Annotated[Array, Part("see `clip_foothold`", "m", 3)]
    reach_limits: Annotated[Array, Part("of a landing foot from the CoM", "m", 2)]
    offset_limits: Annotated[Array, Part("see there", "m", 2, 2)]
    swing_acceleration: Annotated[Array, Part("see there", "m/s^2", XYZ)]
    swing_time_min: Annotated[float, Part("of the quickest swing", "s")]
    ankle_q: Annotated[Array, whole("places of the ankles in q", FEET)]
    ankle_limits: Annotated[Array, Part("their least and greatest angle", "rad", FEET, 2)]


GAIT, CONSTANTS = record_of(GaitState), record_of(GaitConstants)

STAND, SHIFT, SWING, DOUBLE = (float(mode) for mode in Mode)  # as compiled code takes them
FREE, CLIPPED, SLOPED, UNEVEN, SLIPPERY = (float(limit) for limit in Limit)


def gait_state(vector: Array) -> GaitState:
    """Return the state of the gait that a vector is, without a copy."""
    state: GaitState = np.frombuffer(vector, GAIT)[0]
    return state


def vector_of(state: GaitState) -> Array:
    """Return a state of the gait as a vector of its own."""
    return np.frombuffer(state).copy()  # type: ignore[call-overload]  # a record


def new_state() -> GaitState:
    """Return a state of the gait that is zero all over."""
    return gait_state(np.zeros(GAIT.itemsize // 8))


@compiled
def contact_of(s: GaitState) -> tuple[bool, bool]:
    """Return whether the left and the right foot stand in a state of the gait."""
    return (
        s.clock.mode != SWING or s.clock.side == 0.0,
        s.clock.mode != SWING or s.clock.side == 1.0,
    )
