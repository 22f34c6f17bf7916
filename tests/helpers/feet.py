"""The contact lines of `RobotDynamics`, one foot after the other."""

from types import SimpleNamespace

_OF_A_FOOT = ("p_WC", "R_WC", "v_WC", "w_WF", "J", "Jdot_v")


def feet_of(dynamics):
    """Return left and right with the attributes of `RobotDynamics` that are of one foot."""
    return tuple(
        SimpleNamespace(**{name: getattr(dynamics, name)[side] for name in _OF_A_FOOT})
        for side in (0, 1)
    )
