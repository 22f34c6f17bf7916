"""The condensed quadratic program of the MPC, (44)-(48), in scaled variables."""

from dataclasses import dataclass

import numpy as np

from drake_linefoot.constants import STANDARD_GRAVITY
from drake_linefoot.contact.wrench_cone import LEVEL, force_cone, world_cones, wrench_units
from drake_linefoot.math.discretisation import condense, zero_order_hold
from drake_linefoot.mpc.ecd import (
    FOOT_INPUTS,
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
        H: shape (5 n, 5 n), symmetric, divided by `cost_scale`.
        g: shape (5 n,), likewise.
        W: cone of each wrench in scaled variables, shape (n, 6, 5).
        scale: unit of each unknown [N, N m], shape (5 n,).
        cost_scale: what the cost was divided by, see `CURVATURE`.
        active: which wrench each unknown block is, rows (interval, foot), shape (n, 2).
        A_qp, B_qp, C_qp: condensed dynamics for standing feet, (12 K, 12), (12 K, 5 n),
            (12 K,).
        x0: initial state, shape (12,).
        target: desired states, stacked, shape (12 K,).
        L: weights of the stacked states, shape (12 K,).
        K: weights of the stacked inputs, shape (5 n,).
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
        """Return the cones as one matrix, ``rows() @ z <= 0``, shape (6 n, 5 n)."""
        n, rows, columns = self.W.shape
        A = np.zeros((n, rows, n, columns))
        A[range(n), :, range(n)] = self.W
        return A.reshape(n * rows, n * columns)

    def states(self, U: Array) -> Array:
        """Return the predicted states for unscaled wrenches `U`, shape (K + 1, 12)."""
        X = self.A_qp @ self.x0 + self.B_qp @ U + self.C_qp
        return np.vstack([self.x0, X.reshape(-1, STATES)])

    def cost(self, U: Array) -> float:
        """Return the cost (45) of unscaled wrenches `U`."""
        e = self.A_qp @ self.x0 + self.B_qp @ U + self.C_qp - self.target
        return float(e @ (self.L * e) + U @ (self.K * U))

    def wrenches(self, U: Array) -> Array:
        """Return `U` by interval and foot, zero where a foot is in the air, (K, 2, 5)."""
        out = np.zeros((len(self.C_qp) // STATES, 2, FOOT_INPUTS))
        out[self.active[:, 0], self.active[:, 1]] = U.reshape(-1, FOOT_INPUTS)
        return out


def scaled_cones(mu: float, half_length: float, R_WC: Array, slope: Array = LEVEL) -> Array:
    """Return (18) in scaled variables for many contact frames.

    Args:
        mu: friction coefficient [-].
        half_length: X [m].
        R_WC: contact frames, shape (n, 3, 3).
        slope: of the ground, rise per metre along x and y of the world, shape (2,).

    Returns:
        Rows of order one, shape (n, 6, 5).
    """
    cone = force_cone(mu, half_length)
    cone[:, 3:] *= half_length
    return world_cones(cone, R_WC, slope)


def build_qp(
    parameters: MpcParameters,
    reference: Reference,
    x0: Array,
    r_G: Array,
    mass: float,
    half_length: float,
) -> CondensedQp:
    """Build the program of one MPC update.

    The cost of an interval counts in proportion to its length, as the integral in (40).

    Args:
        parameters: weights and friction; where the ground is known to have less, that counts.
        reference: desired motion and contacts over K intervals.
        x0: measured state, shape (12,).
        r_G: fixed point of L_G [m], shape (3,).
        mass: [kg].
        half_length: X [m].

    Returns:
        The program.
    """
    ref, p = reference, parameters
    active = np.argwhere(ref.contact)
    A, C = system_matrices(Linearisation.of(ref), r_G, mass, ref.external)
    B = input_matrices(ref.p_WC, ref.R_WC, r_G, mass)
    A_qp, B_qp, C_qp = condense(*zero_order_hold(A, B, C, ref.dt, ORDER), active, FOOT_INPUTS)
    A_qp, C_qp = A_qp.reshape(-1, STATES), C_qp.ravel()
    B_qp = B_qp.reshape(len(C_qp), -1)
    ends = ref.r[1:], ref.v[1:], ref.L[1:]  # of the intervals: x_H* of (40)
    target = centroidal_state(*ends, np.zeros_like(ref.r[1:]), r_G, mass).ravel()
    L, K = _weights(p, ref.dt, active)
    scale = np.tile(wrench_units(mass, half_length), len(active))
    cost_scale = 2.0 * p.weights.force * (mass * STANDARD_GRAVITY) ** 2 / CURVATURE
    H, g = cost_matrices(B_qp * scale, A_qp @ x0 + C_qp - target, L, K * scale**2)
    frames = ref.R_WC[active[:, 0], active[:, 1]]
    return CondensedQp(
        H=H / cost_scale,
        g=g / cost_scale,
        W=scaled_cones(min(p.friction, ref.friction), half_length, frames, ref.slope),
        scale=scale,
        cost_scale=cost_scale,
        active=active,
        A_qp=A_qp,
        B_qp=B_qp,
        C_qp=C_qp,
        x0=x0,
        target=target,
        L=L,
        K=K,
    )


def cost_matrices(B_qp: Array, error: Array, L: Array, K: Array) -> tuple[Array, Array]:
    """Return the cost over the inputs, ``H = 2 (B'L B + K)`` (47) and ``g = 2 B'L error`` (48).

    Args:
        B_qp: condensed inputs, shape (12 K, m).
        error: of the states without inputs, ``A_qp x0 + C_qp - target``, shape (12 K,).
        L: weights of the states, shape (12 K,).
        K: weights of the inputs, shape (m,).

    Returns:
        (H, g) of shapes (m, m) and (m,).
    """
    root = np.sqrt(L)
    B = root[:, None] * B_qp  # B'B takes half the time of B'(L B)
    H: Array = 2.0 * (B.T @ B)
    H[np.diag_indices_from(H)] += 2.0 * K
    return H, 2.0 * ((root * error) @ B)


def _weights(parameters: MpcParameters, dt: Array, active: Indices) -> tuple[Array, Array]:
    """Return the diagonals of L and K over the horizon; an interval counts by its length."""
    share = dt / parameters.knot_step
    w = parameters.weights
    one_state = np.array([*w.position, *w.velocity, *w.angular_momentum, *w.orientation])
    one_foot = np.array([w.force, w.force, w.force, w.torque, w.torque])
    return (share[:, None] * one_state).ravel(), (share[active[:, 0], None] * one_foot).ravel()
