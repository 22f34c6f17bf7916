"""What the gait remembers from one tick to the next, as a record with named places.

Compiled code takes an array of it as ``s.com[:]``, a plain array; without the brackets it is
another type to Numba, for which every function that it is given to is compiled once more.
"""

from types import SimpleNamespace

import numpy as np
from numpy.typing import NDArray

from drake_linefoot.math.compiled import compiled
from drake_linefoot.statuses import Limit, Mode
from drake_linefoot.types import Array

Records = NDArray[np.void]

SIZE = 5  # coordinates of a contact line: x, y, z, pitch, yaw
Z, PITCH, YAW = 2, 3, 4  # where they are
PLACE = np.array([0, 1, 2, YAW])  # where those of a foothold are

GAIT = np.dtype(
    (
        np.record,
        [
            ("time", "f8"),  # at which everything below holds [s]
            ("mode", "f8"),  # a `Mode`
            ("side", "f8"),  # stance foot, or in double support the foot the weight goes to
            ("closing", "f8"),  # 1 when the swing foot is being put beside the other to stand
            ("again", "f8"),  # 1 in a double support after which the foot that landed swings again
            ("hurried", "f8"),  # steps until one is no longer
            ("phase_start", "f8"),  # of the present phase [s]
            ("phase_end", "f8"),  # [s]
            ("due", "f8"),  # when the swing foot is, or was, to land; a late one moves phase_end
            ("yaw", "f8"),  # desired heading [rad]
            ("turn_rate", "f8"),  # commanded, after rate limits [rad/s]
            ("steps", "f8"),  # taken so far
            ("moved_footholds", "f8"),  # ticks in which a limit moved the foothold
            ("clipped_commands", "f8"),  # commands that were outside their limits so far
            ("limited", "f8"),  # a `Limit`: why the present command is not the one that was given
            ("begun", "f8"),  # 1 once the state was measured at the beginning of a simulation
            ("velocity", "f8", 2),  # commanded, after rate limits, heading frame [m/s]
            ("speed_scale", "f8", 2),  # learned, of the velocity that footholds are made for [-]
            ("speed_offset", "f8", 2),  # learned, added to it [m/s]
            ("marks", "f8", (2, 3)),  # time, x, y of the CoM at the last two touchdowns, newest
            # first; the time is negative where there is none
            ("com", "f8", 3),  # measured [m]
            ("external", "f8", 6),  # what else than the ground acts on the robot [N m, N]
            ("lean", "f8", 2),  # see `measurement.lean_into` [m]
            ("pendulum_com", "f8", 3),  # the CoM moved by `lean` [m]
            ("com_velocity", "f8", 3),  # measured [m/s]
            ("pendulum_velocity", "f8", 3),  # see `measurement.pendulum_velocity` [m/s]
            ("feet", "f8", (2, 4)),  # contact lines x, y, z, yaw, measured while they stand
            ("target", "f8", SIZE),  # where the swing foot will land
            ("reference", "f8", (3, SIZE)),  # its motion now without the bump, two derivatives
            ("swing_height", "f8"),  # apex of the present swing, or else of the next [m]
            ("unevenness", "f8"),  # how far the last steps met the ground from where expected [m]
            ("friction", "f8"),  # of the ground, at most; learned from feet that slide [-]
            ("bearing", "f8", 2),  # shares of the load on heel and toe of foot `side` [-]
            ("grip", "f8", (2, 2)),  # share of the friction that heel and toe of each foot have [-]
            ("slides", "f8"),  # 1 once the stance foot of this step has slid and told the friction
            ("planted", "f8", 2),  # x, y of the stance foot when the other was lifted [m]
            ("slope", "f8", 2),  # of the ground, learned: rise per metre along x and y of W
        ],
    )
)


STAND, SHIFT, SWING, DOUBLE = (float(mode) for mode in Mode)  # as compiled code takes them
FREE, CLIPPED, SLOPED, UNEVEN, SLIPPERY = (float(limit) for limit in Limit)


def gait_record(vector: Array) -> np.record:
    """Return the state of the gait that a vector is, without a copy."""
    record: np.record = np.frombuffer(vector, GAIT)[0]
    return record


def fields_of(record: np.record) -> SimpleNamespace:
    """Return the fields of a record, arrays as views, for Python to read: ten times as fast."""
    return SimpleNamespace(**dict(zip(record.dtype.names or (), record.item(), strict=True)))


@compiled
def contact_of(s: np.record) -> tuple[bool, bool]:
    """Return whether the left and the right foot stand in a state of the gait."""
    return s.mode != SWING or s.side == 0.0, s.mode != SWING or s.side == 1.0
