"""Compiled: a tick of the whole-body controller with line contacts, in few calls."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_linefoot.math.active_set_kernels import few_active, rest
from drake_linefoot.math.compiled import compiled
from drake_linefoot.math.kernels import dot, planned
from drake_linefoot.wbc.kernels import (
    cone_rows,
    joint_torque,
    line_blocks,
    momentum_wish,
    reduced,
    swing_wish,
)
from drake_linefoot.wbc.stop_kernels import Stops, kept_off_stops

Array = NDArray[np.float64]
Numbers = NDArray[np.int64]


@compiled
def damp(J: Array, v: Array, gain: float, b: Array) -> None:
    """Take ``gain J v`` off b; shapes (m, nv), (nv,) and (m,)."""
    if gain != 0.0:
        for i in range(len(b)):
            b[i] -= gain * dot(J[i], v)


@compiled
def line_acceleration(
    M: Array,
    q: Array,
    v: Array,
    momentum: tuple[Array, Array, Array],
    feet: tuple[Array, Array, Array],
    contact: tuple[bool, bool],
    plan: Array,
    swing: Array,
    mass: float,
    gains: tuple[float, float, float, float, float, float, float, float],
    arms: tuple[Numbers, Numbers, Array],
    stops: Stops,
    tolerance: float,
) -> tuple[Array, int, bool]:
    """Return the acceleration that meets the tasks of `tasks` in strict order.

    Args:
        M: mass matrix, shape (nv, nv).
        q: positions, shape (nq,).
        v: velocities, shape (nv,).
        momentum: `A`, `base` and `p_WG` of `RobotDynamics`.
        feet: `J`, `lines` and `R_WC` of it.
        contact: whether the left and the right foot stand.
        plan: see `momentum_wish`, shape (5, 3).
        swing: see `swing_wish`, shape (6, 3); shape (0, 3) when no foot swings.
        mass: [kg].
        gains: of the CoM's position and velocity and of angular momentum; of the swing foot's
            position and velocity; of the arms' position and velocity; damping of standing feet.
        arms: places of the joints in q and in v, and angles they should have [rad], shapes (m,).
        stops: of the legs, see `kept_off_stops`.
        tolerance: see `prioritised`.

    Returns:
        (vdot, dropped, positive) of `prioritised`.
    """
    (A, base, p_WG), (J_lines, lines, R_WC), (arm_q, arm_v, goal) = momentum, feet, arms
    swings, standing = len(swing) > 0, int(contact[0]) + int(contact[1])
    size = 5 * standing + 6 + (5 if swings else 0) + len(goal)
    J, b, at = np.zeros((size, len(v))), np.empty(size), 0
    for side in range(2):
        if contact[side]:
            J[at : at + 5], b[at : at + 5] = J_lines[side], -lines[side, 9:]
            damp(J_lines[side], v, gains[7], b[at : at + 5])
            at += 5
    J[at : at + 6] = A
    b[at : at + 6] = momentum_wish(mass, gains[:3], plan, p_WG, base[6:], A, v, base[:6])
    at += 6
    if swings:
        side = 1 if contact[0] else 0
        J[at : at + 5] = J_lines[side]
        b[at : at + 5] = swing_wish(gains[3], gains[4], swing, lines[side], R_WC[side])
        at += 5
    for i in range(len(goal)):
        J[at + i, arm_v[i]] = 1.0
        b[at + i] = gains[5] * (goal[i] - q[arm_q[i]]) - gains[6] * v[arm_v[i]]
    return kept_off_stops(M, q, v, J, b, contact, swings, stops, tolerance)


@compiled
def line_corrections(
    M: Array,
    vdot: Array,
    Cv: Array,
    tau_g: Array,
    J: Array,
    R_WC: Array,
    sides: Numbers,
    cone: Array,
    slope: Array,
    wish: Array,
    Q1: Array,
    Q2: float,
    inside: float,
    active: float,
    steps: int,
) -> tuple[Array, Array, Array, int, bool, bool]:
    """Solve (49) for line contacts, without a solver.

    Args:
        M: mass matrix, shape (nv, nv).
        vdot: commanded acceleration, shape (nv,).
        Cv: Coriolis and centrifugal forces, shape (nv,).
        tau_g: gravity forces, shape (nv,).
        J: line-contact Jacobians of both feet, shape (2, 5, nv).
        R_WC: contact frames, shape (2, 3, 3).
        sides: standing feet, shape (n,).
        cone: rows of (18) in the frame of the ground, shape (6, 5).
        slope: of the ground, rise per metre along x and y of the world, shape (2,).
        wish: the MPC's wrench of each standing foot, shape (n, 5).
        Q1: weight of the corrections of two feet, shape (10, 10).
        Q2: weight of the base acceleration error.
        inside: by which a row may be violated [N].
        active: a row so near to its bound counts as active [N].
        steps: guesses of the active rows.

    Returns:
        (d, G, c, rows, found, positive): corrections, shape (5 n,), base acceleration error
        ``G d + c``, number of active rows, whether d is the solution, and whether the program
        is one: whether the mass matrix and the cost are positive definite.
    """
    n = 5 * len(sides)
    J_b, W = line_blocks(J, R_WC, sides, cone, slope)
    H, g, G, c, positive = reduced(M, vdot, Cv, tau_g, J_b, wish.copy().reshape(n), Q1[:n, :n], Q2)
    if not positive:
        return g, G, c, 0, False, False
    rows, room = cone_rows(W, wish)
    d, found, positive = few_active(H, g, rows, room, inside, steps)
    count = 0
    for value in rest(rows, d, room):
        count += value >= -active
    return d, G, c, count, found, positive


class Program(NamedTuple):
    """The constants of (49), see `line_corrections`.

    Attributes:
        cone: shape (6, 5).
        Q1: shape (10, 10).
        Q2: [-].
        inside: [N].
        active: [N].
    """

    cone: Array
    Q1: Array
    Q2: float
    inside: float
    active: float


class LineConstants(NamedTuple):
    """What does not change from tick to tick.

    Attributes:
        gains: as in `line_acceleration`.
        arms: as there.
        stops: as there.
        tolerance: as there.
        program: of (49).
        actuators: index in v and torque limit [N m] of each, shapes (na,).
        gravity: [m/s^2], shape (3,).
    """

    gains: tuple[float, float, float, float, float, float, float, float]
    arms: tuple[Numbers, Numbers, Array]
    stops: Stops
    tolerance: float
    program: Program
    actuators: tuple[Numbers, Array]
    gravity: Array


@compiled
def line_tick(
    state: tuple[Array, Array, Array, Array, Array],
    momentum: tuple[Array, Array, Array],
    feet: tuple[Array, Array, Array],
    contact: tuple[bool, bool],
    time: float,
    plan: tuple[Array, Array, Array, Array, Array, Array, float],
    swing: Array,
    slope: Array,
    c: LineConstants,
    steps: int,
) -> tuple[Array, Array, Array, Array, Array, tuple[int, int, int], bool]:
    """Compute a tick with line contacts as a whole; a foot stands, or both.

    Args:
        state: M, q, v, Cv and tau_g of `RobotDynamics`.
        momentum: as in `line_acceleration`.
        feet: as there.
        contact: as there.
        time: [s].
        plan: `CentroidalPlan.for_ticks`.
        swing: as in `line_acceleration`.
        slope: as in `line_corrections`.
        c: constants.
        steps: as in `line_corrections`.

    Returns:
        (torque, wrench, error, delta_f, vdot, (dropped, active, clipped), found): shapes (na,),
        (2, 5), (2, 5), (6,) and (nv,), counts, and whether all of it was found this way.
    """
    (M, q, v, Cv, tau_g), (J, _, R_WC), p = state, feet, c.program
    motion, wish = planned(plan, c.gravity, time)
    vdot, dropped, able = line_acceleration(
        M, q, v, momentum, feet, contact, motion, swing, plan[6], c.gains, c.arms, c.stops,
        c.tolerance,
    )  # fmt: skip
    sides = np.array([side for side in range(2) if contact[side]])
    d, G, delta_f, active, found, positive = line_corrections(
        M, vdot, Cv, tau_g, J, R_WC, sides, p.cone, slope, wish[sides], p.Q1, p.Q2, p.inside,
        p.active, steps,
    )  # fmt: skip
    wrench, error = np.zeros((2, 5)), np.zeros((2, 5))
    for k in range(len(sides)):
        error[sides[k]] = d[5 * k : 5 * k + 5]
        wrench[sides[k]] = wish[sides[k]] + error[sides[k]]
    for i in range(6):
        delta_f[i] += dot(G[i], d)
    torque, clipped = joint_torque(M, vdot, delta_f, Cv, tau_g, J, wrench, *c.actuators)
    counts, found = (dropped, active, clipped), able and positive and found
    return torque, wrench, error, delta_f, vdot, counts, found
