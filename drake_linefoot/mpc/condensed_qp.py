"""The condensed quadratic program of the MPC, (44)-(48), in scaled variables."""

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from drake_linefoot.constants import STANDARD_GRAVITY
from drake_linefoot.contact.contacts import Contact
from drake_linefoot.contact.wrench_cone import with_friction, world_cones
from drake_linefoot.math.compiled import compiled, inlined
from drake_linefoot.math.discretisation import (
    condense,
    condensed_cost,
    times_vector,
    zero_order_hold,
)
from drake_linefoot.mpc.ecd import (
    STATES,
    Linearisation,
    centroidal_state,
    input_matrices,
    system_matrices,
)
from drake_linefoot.mpc.parameters import MpcParameters
from drake_linefoot.signals import Reference
from drake_linefoot.types import Array, Indices

# [-] of the cost over a scaled force by its weight alone: the smallest curvature there is. Fixed,
# so that a solver's step size fits every horizon; the linear cost is of order one in a walk.
CURVATURE = 3e-4
ORDER = 6  # of the discretisation (43): an error of 1e-8 in eta, see `zero_order_hold`


@dataclass(frozen=True)
class CondensedQp:
    """``min 1/2 z'H z + g'z`` subject to ``W_i z_i <= 0`` for each standing foot.

    The unknowns are the wrenches of standing feet only, scaled: ``U = scale * z``.

    Attributes:
        H: shape (nw n, nw n), symmetric, divided by `cost_scale`.
        g: shape (nw n,), likewise.
        W: cone of each wrench in scaled variables, shape (n, r, nw).
        scale: unit of each unknown [N, N m], shape (nw n,).
        cost_scale: what the cost was divided by, see `CURVATURE`.
        active: which wrench each unknown block is, rows (interval, foot), shape (n, 2).
        A_qp, B_qp, C_qp: condensed dynamics for standing feet, (12 K, 12), (12 K, nw n),
            (12 K,).
        x0: initial state, shape (12,).
        target: desired states, stacked, shape (12 K,).
        L: weights of the stacked states, shape (12 K,).
        K: weights of the stacked inputs, shape (nw n,).
    """

    H: Array
    g: Array
    W: Array
    scale: Array
    cost_scale: float
    active: Indices
    A_qp: Array
    B_qp: Array
    C_qp: Array
    x0: Array
    target: Array
    L: Array
    K: Array

    def rows(self) -> Array:
        """Return the cones as one matrix, ``rows() @ z <= 0``, shape (r n, nw n)."""
        n, rows, columns = self.W.shape
        A = np.zeros((n, rows, n, columns))
        np.einsum("irij->irj", A)[:] = self.W  # a view of the blocks on the diagonal
        return A.reshape(n * rows, n * columns)

    def states(self, U: Array) -> Array:
        """Return the predicted states for unscaled wrenches `U`, shape (K + 1, 12)."""
        X = np.empty((len(self.C_qp) // STATES + 1, STATES))
        X[0], X[1:].reshape(-1)[:] = self.x0, self.A_qp @ self.x0 + self.B_qp @ U + self.C_qp
        return X

    def cost(self, U: Array) -> float:
        """Return the cost (45) of unscaled wrenches `U`."""
        e = self.A_qp @ self.x0 + self.B_qp @ U + self.C_qp - self.target
        return float(e @ (self.L * e) + U @ (self.K * U))

    def wrenches(self, U: Array) -> Array:
        """Return `U` by interval and foot, zero where a foot is in the air, (K, 2, nw)."""
        nw = self.W.shape[2]
        out = np.zeros((len(self.C_qp) // STATES, 2, nw))
        out[self.active[:, 0], self.active[:, 1]] = U.reshape(-1, nw)
        return out


@inlined
def scaled_cones(cone: Array, ends: Indices, mu: float, R_WC: Array, slopes: Array) -> Array:
    """Return cones in scaled variables, in which they do not depend on the length of the contacts.

    Args:
        cone: rows for friction 1, shape (r, nw).
        ends: see `with_friction`, shape (r,).
        mu: friction coefficient [-].
        R_WC: contact frames, shape (n, 3, 3).
        slopes: of the ground, rise per metre along x and y of the world, shape (n, 2).

    Returns:
        Rows of order one, shape (n, r, nw).
    """
    return world_cones(with_friction(cone, ends, np.array((mu, mu))), R_WC, slopes)


@inlined
def standing_feet(contact: Array) -> Indices:
    """Return which feet stand in which interval, rows (interval, foot), shape (n, 2).

    Args:
        contact: 1 for a foot that stands, else 0, shape (K, 2).
    """
    active, count = np.empty((2 * len(contact), 2), dtype=np.int64), 0
    for k in range(len(contact)):
        for foot in range(2):
            if contact[k, foot] != 0.0:
                active[count, 0], active[count, 1] = k, foot
                count += 1
    return active[:count]


class Constants(NamedTuple):
    """What does not change from update to update.

    Attributes:
        mass: [kg].
        scale: units of a wrench, see `Contact.units`, shape (nw,).
        states: weights of a state in an interval of full length, shape (12,).
        inputs: weights of a wrench, likewise, shape (nw,).
        knot_step: full length of an interval [s].
        friction: coefficient [-]; where the ground is known to have less, that counts.
        cost_scale: see `CURVATURE`.
        cone: rows of the cone of a scaled wrench for friction 1, shape (r, nw).
        ends: whose friction each has, shape (r,).
    """

    mass: float
    scale: Array
    states: Array
    inputs: Array
    knot_step: float
    friction: float
    cost_scale: float
    cone: Array
    ends: Indices


class Planned(NamedTuple):
    """What the program takes of a `Reference`; see there."""

    times: Array
    r: Array
    v: Array
    L: Array
    contact: Array
    p_WC: Array
    R_WC: Array
    slope: Array
    external: Array


def constants_of(p: MpcParameters, mass: float, contact: Contact) -> Constants:
    """Return the constants of a robot's programs; `mass` [kg], `contact` of its feet."""
    w = p.weights
    return Constants(
        mass=mass,
        scale=contact.units(mass),
        states=np.array([*w.position, *w.velocity, *w.angular_momentum, *w.orientation], float),
        inputs=np.array([w.force] * 3 + [w.torque] * (contact.size - 3), float)
        + contact.pressure_weights(w.centre_of_pressure),
        knot_step=p.knot_step,
        friction=p.friction,
        cost_scale=2.0 * w.force * (mass * STANDARD_GRAVITY) ** 2 / CURVATURE,
        cone=contact.scaled().cone(1.0),
        ends=contact.ends,
    )


def build_qp(
    constants: Constants, reference: Reference, about: Linearisation, x0: Array, r_G: Array
) -> CondensedQp:
    """Build the program of one MPC update.

    The cost of an interval counts in proportion to its length, as the integral in (40).

    Args:
        constants: weights and friction, see `constants_of`.
        reference: desired motion and contacts over K intervals.
        about: what the model linearises about.
        x0: measured state, shape (12,).
        r_G: fixed point of L_G [m], shape (3,).

    Returns:
        The program.
    """
    planned = [getattr(reference, name) for name in Planned._fields]
    parts = condensed(
        tuple(map(np.ascontiguousarray, about)),
        tuple(map(np.ascontiguousarray, planned)),
        reference.friction,
        x0,
        r_G,
        tuple(constants),
    )
    return CondensedQp(*parts)


@compiled
def condensed(
    about: tuple[Array, ...],
    planned: tuple[Array, ...],
    friction: float,
    x0: Array,
    r_G: Array,
    constants: tuple[Any, ...],
) -> tuple[Any, ...]:
    """Return the parts of `CondensedQp`, for `build_qp`.

    Args:
        about: `Linearisation` as a plain tuple, which Numba takes over faster.
        planned: `Planned`, likewise.
        friction: of the ground, at most [-].
        x0: see `build_qp`.
        r_G: likewise.
        constants: `Constants` as a plain tuple.
    """
    c, ref = Constants(*constants), Planned(*planned)
    active, K, nw = standing_feet(ref.contact), len(ref.contact), len(c.scale)
    A, C = system_matrices(Linearisation(*about), r_G, c.mass, ref.external)
    B = input_matrices(ref.p_WC, ref.R_WC, r_G, c.mass, nw)
    dt, eta = np.empty(K), np.zeros(3)
    for k in range(K):
        dt[k] = ref.times[k + 1] - ref.times[k]
    Ad, Bd, cd = zero_order_hold(A, B, C, dt, ORDER)
    A_qp, B_qp, C_qp = condense(Ad, Bd, cd, active, nw)
    target, error, L = np.empty((K, STATES)), np.empty((K, STATES)), np.empty((K, STATES))
    for k in range(K):  # to the ends of the intervals: x_H* of (40)
        r, v = ref.r[k + 1], ref.v[k + 1]
        wanted = centroidal_state(r, v, ref.L[k + 1], eta, r_G, c.mass)
        times_vector(A_qp[k], x0, error[k])
        for i in range(STATES):
            target[k, i] = wanted[i]
            error[k, i] += C_qp[k, i] - wanted[i]
            L[k, i] = dt[k] / c.knot_step * c.states[i]
    H, g = condensed_cost(Ad, B_qp, error, L, active, nw)
    K_u, scale = np.empty(len(g)), np.empty(len(g))
    for i in range(len(g)):
        part = i % nw
        K_u[i] = dt[active[i // nw, 0]] / c.knot_step * c.inputs[part]
        scale[i] = c.scale[part]
        H[i, i] += 2.0 * K_u[i]
    for i in range(len(g)):
        g[i] *= scale[i] / c.cost_scale
        for j in range(len(g)):
            H[i, j] *= scale[i] * scale[j] / c.cost_scale
    frames, slopes = np.empty((len(active), 3, 3)), np.empty((len(active), 2))
    for i in range(len(active)):
        for j in range(2):
            slopes[i, j] = ref.slope[active[i, 0], active[i, 1], j]
        for j in range(3):
            for k in range(3):
                frames[i, j, k] = ref.R_WC[active[i, 0], active[i, 1], j, k]
    W = scaled_cones(c.cone, c.ends, min(c.friction, friction), frames, slopes)
    states = (
        A_qp.reshape(K * STATES, STATES), B_qp.reshape(K * STATES, len(g)),
        C_qp.reshape(K * STATES), x0, target.reshape(K * STATES), L.reshape(K * STATES),
    )  # fmt: skip
    return (H, g, W, scale, c.cost_scale, active, *states, K_u)
