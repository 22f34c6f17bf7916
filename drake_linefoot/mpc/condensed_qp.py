"""The condensed quadratic program of the MPC, (44)-(48), in scaled variables."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drake_linefoot.contact.cone_kernels import LEVEL, turned_cones
from drake_linefoot.contact.wrench_cone import line_cone
from drake_linefoot.math.discretisation import zero_order_hold
from drake_linefoot.math.discretisation_kernels import condense
from drake_linefoot.mpc import ecd_model, kernels
from drake_linefoot.mpc.ecd_model import FOOT_INPUTS, STATES, Linearisation
from drake_linefoot.mpc.parameters import MpcParameters
from drake_linefoot.signals import Reference

Array = NDArray[np.float64]

# [-] of the cost over a scaled force by its weight alone: the smallest curvature there is. Fixed,
# so that a solver's step size fits every horizon; the linear cost is of order one in a walk.
CURVATURE = 3e-4


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
    active: NDArray[np.int64]
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


def wrench_units(mass: float, half_length: float) -> Array:
    """Return the units of one scaled wrench: m g for forces, m g X for torques, (5,)."""
    weight = mass * 9.81
    return np.array([weight, weight, weight, weight * half_length, weight * half_length])


def scaled_cone(mu: float, half_length: float, R_WC: Array, slope: Array = LEVEL) -> Array:
    """Return (18) in scaled variables for many contact frames.

    Args:
        mu: friction coefficient [-].
        half_length: X [m].
        R_WC: contact frames, shape (n, 3, 3).
        slope: of the ground, rise per metre along x and y of the world, shape (2,).

    Returns:
        Rows of order one, shape (n, 6, 5).
    """
    W = line_cone(mu, half_length)
    # The four torque rows have the unit of a torque: divide them by X.
    W[2:] /= half_length
    W[:, 3:] *= half_length
    return turned_cones(W, R_WC, slope)


def build_qp(
    parameters: MpcParameters,
    reference: Reference,
    x0: Array,
    r_G: Array,
    mass: float,
    half_length: float,
    gravity: Array,
) -> CondensedQp:
    """Build the program of one MPC update.

    The cost of an interval counts in proportion to its length, as the integral in (40).

    Args:
        parameters: weights and friction.
        reference: desired motion and contacts over K intervals.
        x0: measured state, shape (12,).
        r_G: fixed point of L_G [m], shape (3,).
        mass: [kg].
        half_length: X [m].
        gravity: [m/s^2], shape (3,).

    Returns:
        The program.
    """
    ref = reference
    active = np.argwhere(ref.contact)
    Ad, Bd, cd = _discrete_dynamics(ref, r_G, mass, gravity)
    A_qp, B_qp, C_qp = condense(Ad, Bd, cd, active, FOOT_INPUTS)
    zero = np.zeros_like(ref.r_mid)
    target = ecd_model.centroidal_state(ref.r[1:], ref.v[1:], ref.L[1:], zero, r_G, mass)
    L, K = _weights(parameters, ref.dt, active)

    scale = np.tile(wrench_units(mass, half_length), len(active))
    error = A_qp @ x0 + C_qp - target
    cost_scale = 2.0 * parameters.weights.force * (mass * 9.81) ** 2 / CURVATURE
    H, g = kernels.cost_matrices(
        Ad, B_qp, error, L.reshape(-1, STATES), K, active, scale, cost_scale
    )
    return CondensedQp(
        H=H,
        g=g,
        W=scaled_cone(
            parameters.friction, half_length, ref.R_WC[active[:, 0], active[:, 1]], ref.slope
        ),
        scale=scale,
        cost_scale=cost_scale,
        active=active,
        A_qp=A_qp.reshape(-1, STATES),
        B_qp=B_qp.reshape(C_qp.size, -1),
        C_qp=C_qp.ravel(),
        x0=x0,
        target=target.ravel(),
        L=L,
        K=K,
    )


def _discrete_dynamics(
    ref: Reference, r_G: Array, mass: float, gravity: Array
) -> tuple[Array, Array, Array]:
    """Return (43) for both feet in all intervals: (K, 12, 12), (K, 12, 10), (K, 12)."""
    about = Linearisation(ref.I_B, ref.R_mid, ref.Omega_mid, ref.L_mid, ref.r_mid, ref.v_mid)
    A, C = ecd_model.system_matrices(about, r_G, mass, gravity)
    B = ecd_model.input_matrices(ref.p_WC, ref.R_WC, r_G, mass)
    return zero_order_hold(A, B, C, ref.dt)


def _weights(
    parameters: MpcParameters, dt: Array, active: NDArray[np.int64]
) -> tuple[Array, Array]:
    """Return the diagonals of L and K over the horizon; an interval counts by its length."""
    share = dt / parameters.knot_step
    w = parameters.weights
    one_state = np.array([*w.position, *w.velocity, *w.angular_momentum, *w.orientation])
    one_foot = np.array([w.force, w.force, w.force, w.torque, w.torque])
    return (share[:, None] * one_state).ravel(), (share[active[:, 0], None] * one_foot).ravel()
