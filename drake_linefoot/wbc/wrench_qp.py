"""The wrench program (49), reduced to the corrections of the wrenches.

The six base rows of the dynamics determine the base acceleration error delta_f from the
wrench error delta_fr, so only 5 unknowns for each standing foot are left.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drake_linefoot.contact.cone_kernels import LEVEL, ground_frame
from drake_linefoot.contact.cone_program import ConeProgram
from drake_linefoot.contact.wrench_cone import line_cone
from drake_linefoot.math.active_set import STEPS, solve_few_active
from drake_linefoot.math.linear import solve_positive
from drake_linefoot.mpc.condensed_qp import wrench_units
from drake_linefoot.robot.dynamics import RobotDynamics
from drake_linefoot.wbc.kernels import cone_rows, line_blocks, reduced
from drake_linefoot.wbc.parameters import WbcParameters
from drake_linefoot.wbc.tick_kernels import Program, line_corrections

Array = NDArray[np.float64]

RHO = 3e-4  # [-] a few times the curvature that Q_1 gives the scaled cost

BASE = 6
ACTIVE = 1e-9  # [-] of m g: a row this near to its bound counts as active
_FEET: dict[tuple[int, ...], NDArray[np.int64]] = {
    sides: np.array(sides) for sides in ((0,), (1,), (0, 1))
}
INSIDE = 1e-10  # [-] of m g: a wrench this far outside its cone counts as inside


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


@dataclass(frozen=True)
class ReducedProgram:
    """(49) without its base rows: ``min 1/2 d'H d + g'd``, ``W_i (u + d)_i <= 0``.

    The c unknowns of a standing foot are its wrench, or the forces at its two points.

    Attributes:
        H, g: cost of the corrections d, shapes (n c, n c) and (n c,).
        W: cone of each foot, rows of the unit of a force, shape (n, r, c).
        u: where the corrections start from, shape (n, c).
        G, c: base acceleration error ``G d + c``, shapes (6, n c) and (6,).
    """

    H: Array
    g: Array
    W: Array
    u: Array
    G: Array
    c: Array

    def scaled(self, units: Array) -> tuple[Array, Array, Array, Array]:
        """Return H, g, W and right-hand sides in variables of order one.

        Args:
            units: of one foot's unknowns, a force first, shape (c,).
        """
        scale = np.tile(units, len(self.u))
        Hs, gs = self.H * np.outer(scale, scale), self.g * scale
        cost_scale = max(float(np.abs(np.diagonal(Hs)).max()), 1e-12)
        room = -np.einsum("nij,nj->ni", self.W, self.u)
        Ws = self.W * units / units[0]
        return Hs / cost_scale, gs / cost_scale, Ws, room / units[0]


def base_error(dynamics: RobotDynamics, vdot_cmd: Array) -> Array:
    """Return the base force that `vdot_cmd` needs beside the contacts, shape (6,)."""
    d = dynamics
    return d.M[:BASE] @ vdot_cmd + d.Cv[:BASE] - d.tau_g[:BASE]


def reduce_program(
    dynamics: RobotDynamics,
    vdot_cmd: Array,
    J_b: Array,
    u: Array,
    Q1: Array,
    Q2: float,
    W: Array,
) -> ReducedProgram:
    """Eliminate the six base rows of (49).

    Args:
        dynamics: present quantities.
        vdot_cmd: commanded acceleration, shape (nv,).
        J_b: base columns of the contact Jacobian, shape (n c, 6).
        u: the MPC's wish, shape (n, c).
        Q1: weight of the corrections, shape (n c, n c).
        Q2: weight of the base acceleration error.
        W: cones, shape (n, r, c).

    Raises:
        numpy.linalg.LinAlgError: the mass matrix is not positive definite.
    """
    d = dynamics
    H, g, G, c, positive = reduced(d.M, vdot_cmd, d.Cv, d.tau_g, J_b, u.ravel(), Q1, Q2)
    if not positive:
        raise np.linalg.LinAlgError("the mass matrix of the base is not positive definite")
    return ReducedProgram(H=H, g=g, W=W, u=u, G=G, c=c)


def minimise(program: ReducedProgram, solver: ConeProgram, units: Array) -> tuple[Array, bool, str]:
    """Solve without the cones first, then with few of their rows, at last by the solver.

    Args:
        program: what to solve.
        solver: of the program with its cones.
        units: of one foot's unknowns, a force first, shape (c,).

    Returns:
        (d, success, status): corrections, shape (n c,).
    """
    A, room = cone_rows(program.W, program.u)
    exact = solve_few_active(program.H, program.g, A, room, INSIDE * units[0])
    if exact is not None:
        active = int(np.count_nonzero(A.dot(exact) >= room - ACTIVE * units[0]))
        return exact, True, active_rows(active)
    return by_solver(program, solver, units)


def active_rows(count: int) -> str:
    """Return in words how many rows of the cones a solution touches."""
    return f"{count} active rows" if count else "unconstrained"


def by_solver(
    program: ReducedProgram, solver: ConeProgram, units: Array
) -> tuple[Array, bool, str]:
    """Solve with the cones by the solver, from the minimum without them; as `minimise`."""
    free = -solve_positive(program.H, program.g)
    scale = np.tile(units, len(program.u))
    solution = solver.solve(*program.scaled(units), free / scale)
    return solution.z * scale, solution.success, solution.status


def falling(dynamics: RobotDynamics, vdot_cmd: Array) -> WrenchSolution:
    """Return the solution when no foot stands: the base falls."""
    delta_f = -solve_positive(dynamics.M[:BASE, :BASE], base_error(dynamics, vdot_cmd))
    return WrenchSolution(np.zeros((0, 5)), np.zeros((0, 5)), delta_f, True, "flight")


def inside_cones(
    wrench: Array,
    dynamics: RobotDynamics,
    sides: Sequence[int],
    mu: float,
    half_length: float,
    slope: Array = LEVEL,
) -> Array:
    """Return the wrenches of standing feet moved into their cones (`into_cone`), (n, 5)."""
    out = wrench.copy()
    for row, side in zip(out, sides, strict=True):
        R_WC = dynamics.feet[side].R_WC
        R = ground_frame(R_WC, slope)
        turn = (R.T @ R_WC)[1:, 1:]  # torques from C to the frame of the ground
        local = into_cone(np.concatenate([R.T @ row[:3], turn @ row[3:]]), mu, half_length)
        row[:3], row[3:] = R @ local[:3], turn.T @ local[3:]
    return out


class WrenchQp:
    """The wrench program of one robot.

    Attributes:
        units: of one foot's unknowns, m g and m g X, shape (5,).
        program_terms: what compiled code needs of the program.
    """

    def __init__(self, parameters: WbcParameters, mass: float, half_length: float) -> None:
        """Keep the constants; `mass` [kg], `half_length` X [m].

        Raises:
            InputError: the parameters name an unknown solver.
        """
        p = parameters
        self._mu, self._X = p.friction, half_length
        self.units = wrench_units(mass, half_length)
        self._weights = np.array([p.force_error_weight] * 3 + [p.torque_error_weight] * 2)
        Q1, Q2 = np.diag(np.tile(self._weights, 2)), float(p.acceleration_error_weight)
        cone, unit = line_cone(self._mu, self._X), float(self.units[0])
        cone[2:] /= self._X  # rows of one unit: force
        self.program_terms = Program(cone, Q1, Q2, INSIDE * unit, ACTIVE * unit)
        self._solver = ConeProgram(p.solver, p.tolerance, p.max_iterations, RHO)

    def solve(
        self,
        dynamics: RobotDynamics,
        vdot_cmd: Array,
        sides: Sequence[int],
        wrench_mpc: Array,
        slope: Array = LEVEL,
    ) -> WrenchSolution:
        """Return the wrenches closest to the MPC's that the base dynamics can use.

        Args:
            dynamics: present quantities.
            vdot_cmd: commanded acceleration, shape (nv,).
            sides: standing feet.
            wrench_mpc: the MPC's wrench of each standing foot, shape (n, 5).
            slope: of the ground, rise per metre along x and y of the world, shape (2,).

        Returns:
            The solution; on failure the MPC's wrench, moved into its cone.
        """
        if not sides:
            return falling(dynamics, vdot_cmd)
        d, p = dynamics, self.program_terms
        delta, G, c, active, success, positive = line_corrections(
            d.M, vdot_cmd, d.Cv, d.tau_g, d.J, d.R_WC, _FEET[tuple(sides)], p.cone,
            slope, wrench_mpc, p.Q1, p.Q2, p.inside, p.active, STEPS,
        )  # fmt: skip
        if not positive:
            raise np.linalg.LinAlgError("the mass matrix or the cost is not positive definite")
        status = active_rows(active)
        if not success:
            program = self.program(dynamics, vdot_cmd, sides, wrench_mpc, slope)
            delta, success, status = by_solver(program, self._solver, self.units)
        if not success:
            moved = inside_cones(wrench_mpc, dynamics, sides, self._mu, self._X, slope)
            delta = (moved - wrench_mpc).ravel()
        delta_fr = delta.reshape(wrench_mpc.shape)
        return WrenchSolution(wrench_mpc + delta_fr, delta_fr, c + G @ delta, success, status)

    def program(
        self,
        dynamics: RobotDynamics,
        vdot_cmd: Array,
        sides: Sequence[int],
        wrench_mpc: Array,
        slope: Array = LEVEL,
    ) -> ReducedProgram:
        """Return what `solve` solves, for at least one standing foot; arguments as there."""
        d, p = dynamics, self.program_terms
        J_b, W = line_blocks(d.J, d.R_WC, _FEET[tuple(sides)], p.cone, slope)
        Q1 = p.Q1[: len(J_b), : len(J_b)]
        return reduce_program(d, vdot_cmd, J_b, wrench_mpc, Q1, p.Q2, W)
