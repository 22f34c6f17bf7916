"""The wrench program (49), reduced to the corrections of the wrenches.

The six base rows of the dynamics determine the base acceleration error delta_f from the
wrench error delta_fr, so only the nw unknowns of each standing foot are left.
"""

from typing import NamedTuple

import numpy as np

from drake_linefoot.axes import TORQUE_AXES
from drake_linefoot.contact.cone_program import ConeProgram
from drake_linefoot.contact.contacts import Contact
from drake_linefoot.contact.wrench_cone import ground_frame, with_friction, world_cone
from drake_linefoot.estimation.external_wrench import on_base
from drake_linefoot.math.active_set import solve_few_active, violation
from drake_linefoot.math.compiled import compiled, inlined
from drake_linefoot.math.linear import solve_positive
from drake_linefoot.signals import RobotDynamics
from drake_linefoot.statuses import Solved
from drake_linefoot.types import Array, Indices
from drake_linefoot.wbc.parameters import WbcParameters

RHO = 3e-4  # [-] a few times the curvature that Q_1 gives the scaled cost
ACTIVE = 1e-9  # [-] of m g: a row this near to its bound counts as active
INSIDE = 1e-10  # [-] of m g: a wrench this far outside its cone counts as inside


class Weights(NamedTuple):
    """The constants of (49).

    Attributes:
        cone: rows of the contact's cone, of the unit of a force, shape (r, nw).
        ends: whose friction each has, shape (r,).
        friction: of it [-].
        Q1: weight of the corrections of one foot, diagonal, shape (nw,).
        Q2: weight of the base acceleration error, angular over linear, diagonal, shape (6,).
        slack: weight of a torque beyond its limit [1/(N m)^2].
        weight: m g [N], what tolerances are counted in.
    """

    cone: Array
    ends: Indices
    friction: float
    Q1: Array
    Q2: Array
    slack: float
    weight: float


class WrenchProgram(NamedTuple):
    """(49) without its base rows: ``min 1/2 d'H d + g'd``, ``W_i (u + d)_i <= 0``.

    The c unknowns of a standing foot are its wrench; n feet stand.

    Attributes:
        H, g: cost of the corrections d, shapes (n c, n c) and (n c,).
        W: cone of each foot, rows of the unit of a force, shape (n, r, c).
        u: where the corrections start from, the MPC's wrenches, shape (n, c).
        G, c: base acceleration error ``G d + c``, shapes (6, n c) and (6,).
    """

    H: Array
    g: Array
    W: Array
    u: Array
    G: Array
    c: Array


@compiled
def reduce_base(
    d: RobotDynamics, vdot: Array, J_b: Array, u: Array, Q1: Array, Q2: Array, external: Array
) -> tuple[Array, Array, Array, Array]:
    """Eliminate the six base rows of (49).

    ``M_b (vdot_b + delta_f) + ... = J_b' (u + delta_fr)`` gives ``delta_f = G delta_fr + c``.

    Args:
        d: present quantities; the mass matrix is positive definite.
        vdot: commanded acceleration, shape (nv,).
        J_b: base columns of the contact Jacobian, shape (m, 6).
        u: the MPC's wrenches, shape (m,).
        Q1: weight of the corrections, shape (m, m).
        Q2: weight of the base acceleration error, diagonal, shape (6,).
        external: what else acts on the torso, moment about the CoM over force in W, shape (6,).

    Returns:
        (H, g, G, c): cost of the corrections, shapes (m, m) and (m,), and the base acceleration
        error ``G d + c``, shapes (6, m) and (6,).
    """
    m = len(u)
    right = np.empty((6, m + 1))
    right[:, :m] = J_b.T
    right[:, m] = u @ J_b - (d.M[:6] @ vdot + d.Cv[:6] - d.tau_g[:6])
    right[:, m] += on_base(external, d.p_WG - d.q[4:7])
    solved, _ = solve_positive(d.M[:6, :6].copy(), right)
    G, c = solved[:, :m].copy(), solved[:, m].copy()
    weighted = 2.0 * Q2 * G.T
    return 2.0 * Q1 + weighted @ G, weighted @ c, G, c


@inlined
def wrench_program(
    d: RobotDynamics,
    vdot: Array,
    contact: tuple[bool, bool],
    wrench_mpc: Array,
    ground: tuple[Array, float, Array],
    external: Array,
    weights: Weights,
) -> WrenchProgram:
    """Return the program of a tick.

    Args:
        d: present quantities.
        vdot: commanded acceleration, shape (nv,).
        contact: whether the left and the right foot stand.
        wrench_mpc: the MPC's wrench of each foot, shape (2, nw).
        ground: its slope below each foot, rise per metre along x and y of W, (2, 2); friction, at
            most [-]; which share of it heel and toe of each foot have [-], shape (2, 2).
        external: what else acts on the torso, see `reduce_base`, shape (6,).
        weights: the constants.
    """
    slopes, friction, shares = ground
    share = min(friction / weights.friction, 1.0)
    n, nw, at = int(contact[0]) + int(contact[1]), len(weights.Q1), 0
    J_b, u, W = np.empty((nw * n, 6)), np.empty((n, nw)), np.empty((n, *weights.cone.shape))
    Q1 = np.zeros((nw * n, nw * n))
    for side in range(2):
        if contact[side]:
            J_b[nw * at : nw * at + nw] = d.J[side, :, :6]
            cone = with_friction(weights.cone, weights.ends, share * shares[side])
            u[at], W[at] = wrench_mpc[side], world_cone(cone, d.R_WC[side], slopes[side])
            for i in range(nw):
                Q1[nw * at + i, nw * at + i] = weights.Q1[i]
            at += 1
    H, g, G, c = reduce_base(d, vdot, J_b, u.reshape(nw * n), Q1, weights.Q2, external)
    return WrenchProgram(H, g, W, u, G, c)


@compiled
def cone_rows(W: Array, u: Array) -> tuple[Array, Array]:
    """Return the rows ``A d <= b`` that say ``W_i (u + d)_i <= 0``.

    Args:
        W: cone of each foot, shape (n, r, c).
        u: where the corrections d start from, shape (n, c).

    Returns:
        (A, b): shapes (n r, n c) and (n r,).
    """
    n, r, c = W.shape
    A, b = np.zeros((n * r, n * c)), np.empty(n * r)
    for k in range(n):
        A[r * k : r * k + r, c * k : c * k + c] = W[k]
        b[r * k : r * k + r] = -(W[k] @ u[k])
    return A, b


@inlined
def solve_program(program: WrenchProgram, weight: float) -> tuple[Array, int, bool]:
    """Solve a program whose solution touches few rows of the cones.

    Args:
        program: what to solve.
        weight: m g [N], what tolerances are counted in.

    Returns:
        (d, active, found): corrections, shape (n c,), the number of rows that they touch, and
        whether they are the solution.
    """
    A, b = cone_rows(program.W, program.u)
    d, found = solve_few_active(program.H, program.g, A, b, INSIDE * weight)
    return d, int(np.sum(violation(A, d, b) >= -ACTIVE * weight)), found


def into_cone(wrench: Array, cone: Array) -> Array:
    """Return a wrench inside its cone, in the frame of the ground, near a given one.

    The normal force is kept (at least 0), then the others are scaled down together until
    all rows hold: a safe answer that needs no solver.

    Args:
        wrench: f_x, f_y, f_z and torques, shape (nw,).
        cone: rows, shape (r, nw).

    Returns:
        Shape (nw,).
    """
    normal, rest = np.zeros(len(wrench)), np.array(wrench)
    normal[2], rest[2] = max(float(wrench[2]), 0.0), 0.0
    room, demand = -(cone @ normal), cone @ rest
    tight = demand > room
    scale = float(np.min(room[tight] / demand[tight])) if np.any(tight) else 1.0
    return normal + scale * rest


def scaled_program(program: WrenchProgram, units: Array) -> tuple[Array, Array, Array, Array]:
    """Return H, g, W and the right-hand sides of a program in variables of order one.

    Args:
        program: what to solve.
        units: of one foot's unknowns, a force first, shape (c,).
    """
    p, scale = program, np.tile(units, len(program.u))
    H, g = p.H * np.outer(scale, scale), p.g * scale
    cost_scale = max(float(np.abs(np.diagonal(H)).max()), 1e-12)
    room = -np.einsum("nij,nj->ni", p.W, p.u) / units[0]
    return H / cost_scale, g / cost_scale, p.W * units / units[0], room


class WrenchSolver:
    """What is used where the active-set method does not finish: Drake's solver, or no solver."""

    def __init__(self, parameters: WbcParameters, mass: float, contact: Contact) -> None:
        """Keep the constants; `mass` [kg], `contact` of the feet.

        Raises:
            InputError: the parameters name an unknown solver.
        """
        p = parameters
        self._contact = contact
        self._units = contact.units(mass)
        self._program = ConeProgram(p.solver, p.tolerance, p.max_iterations, RHO)

    def solve(self, program: WrenchProgram, units: Array | None = None) -> tuple[Array, Solved]:
        """Solve a program by the solver of the parameters, in variables of order one.

        Args:
            program: what to solve.
            units: of one foot's unknowns, a force first, shape (c,); those of a wrench without.

        Returns:
            (d, status): corrections, shape (n c,).
        """
        units = self._units if units is None else units
        scale = np.tile(units, len(program.u))
        free, _ = solve_positive(program.H, -program.g[:, None])
        solution = self._program.solve(*scaled_program(program, units), free[:, 0] / scale)
        return solution.z * scale, solution.status

    def inside_cones(
        self, wrench: Array, R_WC: Array, slopes: Array, friction: float, shares: Array
    ) -> Array:
        """Return wrenches moved into their cones (`into_cone`).

        Args:
            wrench: of each standing foot, forces in W and torques in C, shape (n, nw).
            R_WC: contact frames of these feet, shape (n, 3, 3).
            slopes: of the ground, rise per metre along x and y of the world, shape (n, 2).
            friction: in the cones [-].
            shares: of it that heel and toe of these feet have [-], shape (n, 2).

        Returns:
            Shape (n, nw).
        """
        out, whole = wrench.copy(), self._contact.cone(friction)
        for row, R, slope, of_foot in zip(out, R_WC, slopes, shares, strict=True):
            cone = with_friction(whole, self._contact.ends, of_foot)
            R_WS = ground_frame(R, slope)
            axes = list(TORQUE_AXES[: len(row) - 3])
            turn = (R_WS.T @ R)[np.ix_(axes, axes)]  # torques from C to the frame of the ground
            local = into_cone(np.concatenate([R_WS.T @ row[:3], turn @ row[3:]]), cone)
            row[:3], row[3:] = R_WS @ local[:3], turn.T @ local[3:]
        return out


def wrench_weights(parameters: WbcParameters, mass: float, contact: Contact) -> Weights:
    """Return the constants of (49); `mass` [kg], `contact` of the feet."""
    p, cone = parameters, contact.cone(parameters.friction)
    Q1 = np.array([p.force_error_weight] * 3 + [p.torque_error_weight] * (contact.size - 3))
    weight = float(contact.units(mass)[0])
    Q2 = np.repeat([p.angular_acceleration_error_weight, p.acceleration_error_weight], 3)
    slack = float(p.torque_limit_weight)
    return Weights(cone, contact.ends, float(p.friction), Q1, Q2, slack, weight)
