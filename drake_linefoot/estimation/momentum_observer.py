"""The momentum-based disturbance observer, (19)-(21)."""

from drake_linefoot.math.compiled import inlined
from drake_linefoot.signals import RobotDynamics
from drake_linefoot.types import Array


@inlined
def momentum_terms(d: RobotDynamics) -> tuple[Array, Array]:
    """Return momentum and the part of its rate that is neither torque nor contact, (20).

    Args:
        d: quantities of the state.

    Returns:
        (p, known): ``M v`` and ``C'v + tau_g``, shapes (nv,).
    """
    return d.M @ d.v, d.CTv + d.tau_g


@inlined
def update_residual(
    residual: Array, rate: Array, known: Array, actuation: Array, gamma: float
) -> Array:
    """Return tau_d of (21), the filtered generalized force of all contacts.

    Args:
        residual: the one of the last tick, shape (nv,).
        rate: of the momentum over the tick, shape (nv,).
        known: part of it that is neither torque nor contact, (20), shape (nv,).
        actuation: generalized force of the actuators over the tick, shape (nv,).
        gamma: filter constant, 0 <= gamma < 1.

    Returns:
        Shape (nv,).
    """
    return gamma * residual + (1.0 - gamma) * (rate - known - actuation)
