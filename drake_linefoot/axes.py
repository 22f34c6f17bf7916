"""Names and units of numbers that come in rows: along the axes of signals and channels."""

from typing import Final

FEET: Final = ("left", "right")
ENDS: Final = ("heel", "toe")
CORNERS: Final = ("heel_left", "heel_right", "toe_left", "toe_right")  # of a sole
XYZ: Final = ("x", "y", "z")
RPY: Final = ("roll", "pitch", "yaw")
PLACE: Final = ("x", "y", "z", "yaw")
WRENCH: Final = ("f_x", "f_y", "f_z", "tau_y", "tau_z", "tau_x")  # a contact has a prefix of these
TAU_Y: Final = 3
TAU_Z: Final = 4
TAU_X: Final = 5
TORQUE_AXES: Final = (1, 2, 0)  # axis of C that each torque is about
ENDS_OF_FEET: Final = tuple(f"{foot}_{end}" for foot in FEET for end in ENDS)
LINE: Final = (*XYZ, "pitch", "yaw")
SWING_NUMBERS: Final = ("start", "end", "now", "height", "settle", "heel", "raised", "step")
SPATIAL: Final = ("angular_x", "angular_y", "angular_z", "x", "y", "z")
POSE: Final = ("w", "qx", "qy", "qz", *XYZ)
SIGMA: Final = (*RPY, "v_x", "v_y", "v_z", *XYZ)
IMU: Final = tuple(f"{sensor}_{axis}" for sensor in ("gyro", "accelerometer") for axis in XYZ)
STATES: Final = tuple(f"{part}_{axis}" for part in ("r", "v", "L", "eta") for axis in XYZ)
STATE_UNITS: Final = ("m", "m/s", "kg m^2/s", "rad")
COMMAND: Final = ("v_x", "v_y", "turn_rate")
COMMAND_UNITS: Final = ("m/s", "m/s", "rad/s")
PLACE_UNITS: Final = ("m", "m", "m", "rad")
PIECE: Final = ("begin", "end", "centre_x", "centre_y", "amplitude_x", "amplitude_y", "rate",
                "omega")  # fmt: skip
CUBIC: Final = ("0", "1", "2", "3")  # powers of the time
E_UNITS: Final = "1/(kg m^2), 1/(kg m)"
SWING: Final = ("p_WC", "v_WC", "a_WC", "d_W", "w_W", "alpha_W")


def points_of_foot(nc: int) -> tuple[str, ...]:
    """Return the names of the contact points of a foot: the ends of a line, a sole's corners."""
    return ENDS if nc == len(ENDS) else CORNERS
