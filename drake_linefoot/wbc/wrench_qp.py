"""The wrench program (49), reduced to the corrections of the wrenches.

The six base rows of the dynamics determine the base acceleration error delta_f from the
wrench error delta_fr, so only 5 unknowns for each standing foot are left.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drake_linefoot.contact.cone_program import ConeProgram
from drake_linefoot.contact.wrench_cone import line_cone, world_cone
from drake_linefoot.math.linear import solve
from drake_linefoot.mpc.condensed_qp import wrench_units
from drake_linefoot.robot.dynamics import RobotDynamics
from drake_linefoot.wbc.parameters import WbcParameters

Array = NDArray[np.float64]

_RHO = 1e-4  # [-] the curvature that Q_1 gives the scaled cost

_BASE = 6
_INSIDE = 1e-10  # [-] of m g: a wrench this far outside its cone counts as inside


@dataclass(frozen=True)
class WrenchSolution:
    """What the program decided.

    Attributes:
        wrench: wrench of each standing foot, shape (n, 5).
        delta_fr: its difference from the MPC's, shape (n, 5).
        delta_f: base acceleration error, shape (6,).
        success: solved; otherwise the MPC's wrench was moved into the cone.
        status: how.
    """

    wrench: Array
    delta_fr: Array
    delta_f: Array
    success: bool
    status: str


def into_cone(wrench: Array, mu: float, half_length: float) -> Array:
    """Return a wrench inside (18), in foot coordinates, near a given one.

    The normal force is kept (at least 0), then the others are scaled down together until
    all rows hold: a safe answer that needs no solver.

    Args:
        wrench: [f_x, f_y, f_z, tau_y, tau_z], shape (5,).
        mu: friction coefficient [-].
        half_length: X [m].

    Returns:
        Shape (5,).
    """
    f_z = max(float(wrench[2]), 0.0)
    normal = np.array([0.0, 0.0, f_z, 0.0, 0.0])
    rest = np.array([wrench[0], wrench[1], 0.0, wrench[3], wrench[4]])
    W = line_cone(mu, half_length)
    room, demand = -(W @ normal), W @ rest
    tight = demand > room
    scale = float(np.min(room[tight] / demand[tight])) if np.any(tight) else 1.0
    return normal + scale * rest


class WrenchQp:
    """The wrench program of one robot."""

    def __init__(self, parameters: WbcParameters, mass: float, half_length: float) -> None:
        """Keep the constants; `mass` [kg], `half_length` X [m].

        Raises:
            InputError: the parameters name an unknown solver.
        """
        p = parameters
        self._mu, self._X = p.friction, half_length
        self._units = wrench_units(mass, half_length)
        self._Q1 = np.array([p.force_error_weight] * 3 + [p.torque_error_weight] * 2)
        self._Q2 = p.acceleration_error_weight
        self._program = ConeProgram(p.solver, p.tolerance, p.max_iterations, _RHO)

    def solve(
        self, dynamics: RobotDynamics, vdot_cmd: Array, sides: Sequence[int], wrench_mpc: Array
    ) -> WrenchSolution:
        """Return the wrenches closest to the MPC's that the base dynamics can use.

        Args:
            dynamics: present quantities.
            vdot_cmd: commanded acceleration, shape (nv,).
            sides: standing feet.
            wrench_mpc: the MPC's wrench of each standing foot, shape (n, 5).

        Returns:
            The solution; on failure the MPC's wrench, moved into its cone.
        """
        d, n = dynamics, len(sides)
        missing = d.M[:_BASE] @ vdot_cmd + d.Cv[:_BASE] - d.tau_g[:_BASE]
        M_bb = d.M[:_BASE, :_BASE]
        if n == 0:
            falling = -solve(M_bb, missing)
            return WrenchSolution(np.zeros((0, 5)), np.zeros((0, 5)), falling, True, "flight")
        J_b = np.hstack([d.feet[i].J[:, :_BASE].T for i in sides])  # (6, 5 n)
        f_mpc = wrench_mpc.ravel()
        right = np.column_stack([J_b, J_b @ f_mpc - missing])
        solved = solve(M_bb, right)
        G, c = solved[:, :-1], solved[:, -1]  # delta_f = G delta_fr + c
        Q1 = np.tile(self._Q1, n)
        H = 2.0 * (np.diag(Q1) + self._Q2 * (G.T @ G))
        g = 2.0 * self._Q2 * (G.T @ c)
        W = np.stack([world_cone(self._mu, self._X, d.feet[i].R_WC) for i in sides])
        W[:, 2:] /= self._X  # rows of one unit: force
        delta, success, status = self._minimise(H, g, W, f_mpc.reshape(n, 5))
        if not success:
            delta = self._inside(f_mpc.reshape(n, 5), dynamics, sides).ravel() - f_mpc
        return WrenchSolution(
            wrench=(f_mpc + delta).reshape(n, 5),
            delta_fr=delta.reshape(n, 5),
            delta_f=c + G @ delta,
            success=success,
            status=status,
        )

    def _minimise(self, H: Array, g: Array, W: Array, f_mpc: Array) -> tuple[Array, bool, str]:
        """Solve without the cones first; only when one is left is the program needed."""
        free = -solve(H, g)
        room = -np.einsum("nij,nj->ni", W, f_mpc)
        used = np.einsum("nij,nj->ni", W, free.reshape(f_mpc.shape))
        if np.all(used <= room + _INSIDE * self._units[0]):
            return free, True, "unconstrained"
        scale = np.tile(self._units, len(f_mpc))
        Hs, gs = H * np.outer(scale, scale), g * scale
        cost_scale = max(float(np.abs(np.diagonal(Hs)).max()), 1e-12)
        Ws = W * self._units / self._units[0]
        solution = self._program.solve(
            Hs / cost_scale, gs / cost_scale, Ws, room / self._units[0], free / scale
        )
        return solution.z * scale, solution.success, solution.status

    def _inside(self, f_mpc: Array, dynamics: RobotDynamics, sides: Sequence[int]) -> Array:
        """Return the MPC's wrenches moved into their cones, shape (n, 5)."""
        out = f_mpc.copy()
        for row, side in zip(out, sides, strict=True):
            R = dynamics.feet[side].R_WC
            local = into_cone(np.concatenate([R.T @ row[:3], row[3:]]), self._mu, self._X)
            row[:3], row[3:] = R @ local[:3], local[3:]
        return out
