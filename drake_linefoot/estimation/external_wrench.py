"""What else than the ground acts on the robot: a cable, a payload's pull, wind.

The joints of a leg tell the wrench of its foot, whatever acts on the torso: as many of each. What
the six rows of the floating base have beyond both wrenches is neither torque nor ground.
"""

from typing import NamedTuple

import numpy as np

from drake_linefoot.estimation.contact_parameters import EstimatorParameters
from drake_linefoot.math.compiled import compiled, inlined
from drake_linefoot.math.linear import solve_square
from drake_linefoot.math.rotation import cross
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.types import Array, Indices

_SINGULAR = 0.02  # [-] of the pivots: a straight leg does not tell the force along itself


@compiled
def on_base(external: Array, lever: Array) -> Array:
    """Return the generalized force of a wrench on the torso, of the base alone, shape (6,).

    Args:
        external: moment about the CoM over force in W [N m, N], shape (6,).
        lever: of the CoM from the base origin in W [m], shape (3,).
    """
    out = external.copy()
    out[:3] += cross(lever, external[3:])
    return out


class ExternalConstants(NamedTuple):
    """What does not change from tick to tick.

    Attributes:
        leg_v: places of the legs' joints in v, left before right, shape (2, n).
        share: of what a tick tells in the estimate [-].
        change: most that the estimate changes in a tick, of each number [N m, N], shape (6,).
        largest: bound of each number [N m, N], shape (6,).
    """

    leg_v: Indices
    share: float
    change: Array
    largest: Array


def external_constants(
    parameters: EstimatorParameters, humanoid: Humanoid, period: float
) -> ExternalConstants:
    """Return the constants of a robot for ticks of `period` [s].

    Moments are bounded like forces at the height of its CoM.
    """
    p, h = parameters, humanoid.com_height
    of_force = np.array([h, h, h, 1.0, 1.0, 1.0])
    share = min(period / p.external_time, 1.0) if p.external_time else 0.0
    change, largest = p.external_rate * period * of_force, p.external_max * of_force
    return ExternalConstants(humanoid.leg_v, share, change, largest)


@inlined
def external_wrench(force: Array, J: Array, lever: Array, leg_v: Indices) -> tuple[Array, bool]:
    """Return what acts on the robot beside its feet in a tick.

    Args:
        force: generalized force of all that is neither torque nor gravity, shape (nv,).
        J: contact Jacobians of both feet, shape (2, n, nv).
        lever: of the CoM from the base origin in W [m], shape (3,).
        leg_v: places of the legs' joints in v, shape (2, n).

    Returns:
        (wrench, told): moment about the CoM over force in W [N m, N], shape (6,); whether the legs
        tell it.
    """
    wrench = force[:6].copy()
    n = leg_v.shape[1]
    E = np.empty((n, n))
    for side in range(2):
        f = np.empty(n)
        for i in range(n):
            f[i] = force[leg_v[side, i]]
            for j in range(n):
                E[i, j] = J[side, j, leg_v[side, i]]
        f, regular = solve_square(E, f, _SINGULAR)
        if not regular:
            return wrench, False
        for i in range(6):
            for j in range(n):
                wrench[i] -= J[side, j, i] * f[j]
    wrench[:3] -= cross(lever, wrench[3:])
    return wrench, True


@compiled
def without_external(residual: Array, external: Array, lever: Array) -> Array:
    """Return the generalized force of the feet alone, shape (nv,).

    Args:
        residual: generalized force of all that is neither torque nor gravity, shape (nv,).
        external: what acts beside the feet, see `external_wrench`, shape (6,).
        lever: of the CoM from the base origin in W [m], shape (3,).
    """
    out = residual.copy()
    out[:6] -= on_base(external, lever)
    return out


@inlined
def update_external_estimate(
    estimate: Array, force: Array, J: Array, lever: Array, c: ExternalConstants
) -> Array:
    """Return the estimate a tick later; it stays where the legs tell nothing.

    Args:
        estimate: before, shape (6,).
        force: of the tick, unfiltered, as of `external_wrench`, like the two after it.
        J: Jacobians.
        lever: of the CoM.
        c: constants.

    Returns:
        Shape (6,).
    """
    found, told = external_wrench(force, J, lever, c.leg_v)
    return follow_wrench(estimate, found, c) if told else estimate.copy()


@inlined
def follow_wrench(estimate: Array, wrench: Array, c: ExternalConstants) -> Array:
    """Return the estimate a tick later: it follows what lasts, and little of what soon ends.

    Args:
        estimate: before, shape (6,).
        wrench: of this tick, shape (6,).
        c: constants.

    Returns:
        Shape (6,).
    """
    out = np.empty(6)
    for i in range(6):
        change = c.share * (wrench[i] - estimate[i])
        after = estimate[i] + min(max(change, -c.change[i]), c.change[i])
        out[i] = min(max(after, -c.largest[i]), c.largest[i])
    return out
