"""What the gait remembers from one tick to the next, and what it knows: records with named parts.

Each part of the state is written by the functions of one module, which its docstring names, and
read by all. Compiled code takes an array of a record as ``s.robot.com[:]``, a plain array; without
the brackets it is another type to Numba, for which every function that it is given to is compiled
once more.
"""

from typing import Annotated, Final

import numpy as np
from numpy.typing import NDArray

from drake_linefoot.axes import COMMAND, ENDS, FEET, LINE, PLACE_UNITS, XYZ
from drake_linefoot.axes import PLACE as PLACE_AXIS
from drake_linefoot.gait.parameters import GaitParameters
from drake_linefoot.layout import Part, record_of
from drake_linefoot.parts import EXTERNAL, FOREVER, FRICTION, SLOPE, in_world, whole
from drake_linefoot.statuses import Limit
from drake_linefoot.terrain import CORNERS, PATCHES
from drake_linefoot.types import Array

Records = NDArray[np.void]  # arrays of one `GaitState` or one `GaitConstants`, shape (1,)

SIZE = 5  # coordinates of a contact line: x, y, z, pitch, yaw
Z, PITCH, YAW = 2, 3, 4  # where they are
PLACE = np.array([0, 1, 2, YAW])  # where those of a foothold are
XY = ("x", "y")


class Clock:
    """When which foot is in contact; written by `clock`.

    A foot is in contact from its touchdown t_k to the next one's plus d, t_(k+1) + d.
    """

    time: Annotated[float, Part("at which the state holds", "s")]
    initialized: Annotated[float, whole("1 once it was measured when a simulation began")]
    side: Annotated[float, whole("stance foot, or the one the weight goes to")]
    touchdown: Annotated[
        Array, Part("of each foot: expected while it swings, else last", "s", FEET)
    ]
    planned_touchdown: Annotated[Array, Part("likewise, had it not come late", "s", FEET)]
    lift_off: Annotated[Array, Part("of each foot: last while it swings, else next", "s", FEET)]
    overlap: Annotated[float, Part("d, of both feet on the ground; below 0 of none", "s")]
    queued: Annotated[float, whole("steps to follow; `ENDLESS` while it walks, 0: stands")]
    steps: Annotated[float, whole("taken so far")]


class Command:
    """What the robot is told, as far as it does it; written by `command`."""

    velocity: Annotated[Array, Part("after rate limits, heading frame", "m/s", XY)]
    turn_rate: Annotated[float, Part("likewise", "rad/s")]
    flight: Annotated[float, Part("T_f of a run, in which d is less than 0 by it; 0: walks", "s")]
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


class SwingFeet:
    """Where feet that swing are to be and to go; written by `swing_foot`."""

    target: Annotated[Array, Part("where each will land", "m, rad", FEET, LINE, frame="W")]
    reference: Annotated[Array, Part("motion without the bump", "m, rad, s", FEET, 3, LINE)]
    height: Annotated[Array, Part("apex of its swing, or of the next", "m", FEET)]
    heel: Annotated[Array, Part("see `Swing`", "rad, m", FEET, ("pitch", "raised"))]
    step: Annotated[Array, Part("likewise", "-", FEET)]
    lifted: Annotated[Array, in_world("where each was lifted from the ground", "m", FEET, XYZ)]
    aim: Annotated[
        Array, in_world("DCM that is wanted when the weight comes onto it", "m", FEET, XY)
    ]


class Ground:
    """What feet have felt of the ground; written by `ground`."""

    slope: Annotated[Array, SLOPE]
    unevenness: Annotated[float, Part("how far off the last steps met the ground", "m")]


class KnownGround:
    """The ground that is known, see `Terrain`; written by `told_ground`."""

    count: Annotated[float, whole("how many patches there are")]
    sides: Annotated[Array, whole("of each; 0: without an edge", PATCHES)]
    edges: Annotated[Array, Part("n . p <= b, n outwards", ("-", "-", "m"), PATCHES, CORNERS, 3)]
    rises: Annotated[Array, Part("of the ground beyond each edge", "m", PATCHES, CORNERS)]
    plane: Annotated[Array, Part("height at 0, rise along x and y", ("m", "-", "-"), PATCHES, 3)]
    sigma: Annotated[Array, Part("how far off they may be", "m", PATCHES)]
    under: Annotated[Array, whole("patch on which each foot stands, or is to land", FEET)]
    offset: Annotated[float, Part("how far it is above what is said, as feet have felt", "m")]
    steep: Annotated[float, Part("rise or fall per metre of steps ahead", "-")]
    level: Annotated[float, Part("of the CoM above its height, when a foot touched down", "m")]


class Footing:
    """How standing feet hold; written by `footing`."""

    load_shares: Annotated[Array, Part("shares of the load on heel and toe of `side`", "-", ENDS)]
    friction_shares: Annotated[
        Array, Part("share of the friction that each end has", "-", FEET, ENDS)
    ]
    friction: Annotated[float, FRICTION]
    anchor: Annotated[Array, in_world("stance foot when the other was lifted", "m", XY)]
    slides: Annotated[float, whole("1 once the stance foot has slid and told the friction")]


class Speed:
    """What was learned of the speed; written by `learning`."""

    scale: Annotated[Array, Part("of the velocity that footholds are made for", "-", XY)]
    offset: Annotated[Array, Part("added to it", "m/s", XY)]
    history: Annotated[Array, Part("when and where the CoM was at touchdowns, newest first; a time "
                                 "below 0: none", "s, m", 2, ("time", *XY))]  # fmt: skip


class Recovery:
    """How the gait takes pushes; written by `recovery`."""

    steps: Annotated[float, whole("recovery steps to come")]
    moved_footholds: Annotated[float, whole("ticks in which a limit moved the foothold")]


class GaitState:
    """All that the gait remembers."""

    clock: Clock
    command: Command
    robot: Robot
    swing: SwingFeet
    ground: Ground
    terrain: KnownGround
    footing: Footing
    speed: Speed
    recovery: Recovery


class GaitConstants(GaitParameters):
    """What the gait knows: the numbers of its parameters in a robot's size, and what follows.

    `double_support_min` is at most `double_support`.
    """

    speed_scale: Annotated[Array, Part("see there", "-", XY)]  # type: ignore[assignment]
    flight: Annotated[float, Part("T_f that is asked for; below 0: none is", "s")]
    first_stance: Annotated[float, whole("the foot that stands in the first step")]
    half_length: Annotated[float, Part("X of the contacts", "m")]
    half_width: Annotated[float, Part("Y of the contacts, 0 of lines", "m")]
    contact_margin: Annotated[float, Part("of X and Y, where no pressure is wanted", "m")]
    strides_ahead: Annotated[float, whole("see `nominal_strides`")]
    omega: Annotated[float, Part("natural frequency of the pendulum", "1/s")]
    switch: Annotated[float, Part("see `switch_time`", "s")]
    switch_min: Annotated[float, Part("likewise, of a recovery step", "s")]
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
    toe: Annotated[Array, Part("how far it is ahead of the ankle, and below it", "m", 2)]


GAIT, CONSTANTS = record_of(GaitState), record_of(GaitConstants)

FREE, CLIPPED, SLOPED, UNEVEN, SLIPPERY = (
    float(limit) for limit in Limit
)  # as compiled code takes them
ENDLESS: Final = FOREVER  # steps


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
