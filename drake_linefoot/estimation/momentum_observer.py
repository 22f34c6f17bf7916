"""The momentum-based disturbance observer, (19)-(21)."""

from drake_linefoot.math.compiled import inlined
from drake_linefoot.signals import RobotDynamics
from drake_linefoot.types import Array


@inlined
def follow_late(stages: Array, now: Array, theta: float) -> Array:
    """Return a signal as late as rates of joints that `track` of the state estimator makes.

    These are the true rates behind two filters of first order, one after the other.

    Args:
        stages: of the filters, shape (2, n); written.
        now: the signal, shape (n,).
        theta: what each keeps in a tick [-]; 0: nothing is late.
    """
    stages[0] = theta * stages[0] + (1.0 - theta) * now
    stages[1] = theta * stages[1] + (1.0 - theta) * stages[0]
    return stages[1].copy()


@inlined
def momentum_terms(d: RobotDynamics, v: Array) -> tuple[Array, Array]:
    """Return momentum and the part of its rate that is neither torque nor contact, (20).

    Args:
        d: quantities of the state.
        v: velocities that are equally late, shape (nv,).

    Returns:
        (p, known): ``M v`` and ``C'v + tau_g``, shapes (nv,).
    """
    return d.M @ v, d.CTv + d.tau_g


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
