"""Torque limits in the program (49), as inequalities with a slack.

Every torque is affine in the corrections of the wrenches. A limit ``|tau_k| <= limit_k + s_k``
costs ``w s_k^2``, so a row that its limit does not bind costs nothing, and one that it does
adds a square to the cost: the program keeps its unknowns and its cones.
"""

from typing import NamedTuple

import numpy as np

from drake_linefoot.math.compiled import compiled, inlined
from drake_linefoot.signals import RobotDynamics
from drake_linefoot.statuses import Solved
from drake_linefoot.types import Array, Indices
from drake_linefoot.wbc.wrench_qp import WrenchProgram, WrenchSolver, solve_program

LIMIT_STEPS = 10  # guesses of which limits bind; mostly two are made


class TorqueRows(NamedTuple):
    """Torques ``tau = T d + t`` as a function of the corrections d.

    Attributes:
        T: shape (na, n c).
        t: torques without corrections [N m], shape (na,).
    """

    T: Array
    t: Array


@compiled
def torque_rows(
    d: RobotDynamics,
    vdot: Array,
    program: WrenchProgram,
    contact: tuple[bool, bool],
    actuated_v: Indices,
) -> TorqueRows:
    """Return the torques of ``M vdot + Cv - tau_g - sum J_i' w_i`` by the corrections.

    Args:
        d: present quantities.
        vdot: commanded acceleration, shape (nv,).
        program: (49), of which the wrenches and the base acceleration error count.
        contact: whether the left and the right foot stand.
        actuated_v: index in v of each actuator, shape (na,).
    """
    n, nw = program.u.shape
    J, at = np.empty((nw * n, len(vdot))), 0
    for side in range(2):
        if contact[side]:
            J[at : at + nw] = d.J[side]
            at += nw
    M_b = np.ascontiguousarray(d.M[:, :6])
    by_correction = M_b @ program.G - J.T
    needed = d.M @ vdot + M_b @ program.c + d.Cv - d.tau_g - program.u.reshape(nw * n) @ J
    return TorqueRows(by_correction[actuated_v], needed[actuated_v])


@compiled
def excess(rows: TorqueRows, delta: Array, limits: Array) -> Array:
    """Return by how much torques exceed their limits, with sign; 0 within.

    Args:
        rows: torques by the corrections.
        delta: corrections, shape (n c,).
        limits: symmetric [N m], shape (na,).

    Returns:
        [N m], shape (na,).
    """
    tau = rows.T @ delta + rows.t
    return tau - np.minimum(np.maximum(tau, -limits), limits)


@compiled
def limited_program(
    program: WrenchProgram, rows: TorqueRows, signs: Array, limits: Array, weight: float
) -> WrenchProgram:
    """Return the program with the cost of the limits that bind, ``w (tau_k - limit_k)^2``.

    Args:
        program: (49).
        rows: torques by the corrections.
        signs: 1 or -1 for a torque at its upper or lower limit, 0 for the others, shape (na,).
        limits: symmetric [N m], shape (na,).
        weight: w [1/(N m)^2].
    """
    H, g = program.H.copy(), program.g.copy()
    for k in range(len(signs)):
        if signs[k] != 0.0:
            row = rows.T[k]
            H += 2.0 * weight * np.outer(row, row)
            g += 2.0 * weight * (rows.t[k] - signs[k] * limits[k]) * row
    return WrenchProgram(H, g, program.W, program.u, program.G, program.c)


@inlined
def solve_limited(
    program: WrenchProgram,
    rows: TorqueRows,
    delta: Array,
    limits: Array,
    weight: float,
    tolerance: float,
) -> tuple[Array, int, bool]:
    """Solve the program with torque limits, from its solution without them.

    Args:
        program: (49).
        rows: torques by the corrections.
        delta: corrections that solve the program without limits, shape (n c,).
        limits: symmetric [N m], shape (na,).
        weight: of the slack [1/(N m)^2].
        tolerance: m g [N], of `solve_program`.

    Returns:
        (d, active, found) as of `solve_program`; not found as well when the limits that bind are
        not settled after `LIMIT_STEPS` guesses.
    """
    signs, active = np.sign(excess(rows, delta, limits)), 0
    for _ in range(LIMIT_STEPS):
        now = limited_program(program, rows, signs, limits, weight)
        delta, active, found = solve_program(now, tolerance)
        if not found:
            return delta, active, False
        before, signs = signs, np.sign(excess(rows, delta, limits))
        if np.all(signs == before):
            return delta, active, True
    return delta, active, False


def solve_by(
    solver: WrenchSolver, program: WrenchProgram, rows: TorqueRows, limits: Array, weight: float
) -> tuple[Array, Solved]:
    """Solve the program with torque limits where `solve_limited` does not finish.

    Args:
        solver: Drake's.
        program: (49).
        rows: torques by the corrections.
        limits: symmetric [N m], shape (na,).
        weight: of the slack [1/(N m)^2].

    Returns:
        (d, status) as of `WrenchSolver.solve`, with the limits that bound last.
    """
    bound = np.zeros(len(limits))
    for _ in range(LIMIT_STEPS):
        now = limited_program(program, rows, bound, limits, weight)
        delta, status = solver.solve(now)
        before, bound = bound, np.sign(excess(rows, delta, limits))
        if not status.success or np.array_equal(bound, before):
            break
    return delta, status
