"""Rigid-body and centroidal quantities of one state: the terms of (1), momentum, contact lines."""

from __future__ import annotations

import math
from functools import cache
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from drake_linefoot.constants import GRAVITY
from drake_linefoot.math.compiled import as_python, compiled, inlined
from drake_linefoot.math.linear import dot
from drake_linefoot.math.rotation import cross, from_quaternion
from drake_linefoot.robot.drake_terms import drake_terms
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.robot.tree import (
    Tree,
    move_links,
    new_links,
    place_feet,
    sum_links,
    weigh_links,
)
from drake_linefoot.types import Array

if TYPE_CHECKING:
    from pydrake.systems.framework import Context


class RobotDynamics(NamedTuple):
    """What the controller needs to know of one state; not to be changed.

    The equation of motion is ``M vdot + Cv = tau_g + S' tau + sum J_i' w_i``, (1). C is the middle
    of a foot's contact line; frame C has x along the line. Left before right.

    Attributes:
        q: positions, shape (nq,).
        v: velocities, shape (nv,).
        M: mass matrix with reflected inertias, shape (nv, nv).
        Cv: Coriolis and centrifugal forces, shape (nv,).
        tau_g: generalized gravity forces, shape (nv,).
        CTv: C' v with the transpose of a C of which M's rate is C + C', below (19), shape (nv,).
        R_WB: torso orientation, shape (3, 3).
        p_WG: centre of mass [m], shape (3,).
        v_WG: its velocity [m/s], shape (3,).
        A: centroidal momentum matrix, angular about G over linear, shape (6, nv).
        Adot_v: rate of that momentum at vdot = 0, shape (6,).
        p_WC: middle of each contact line [m], shape (2, 3).
        R_WC: contact frames: x along the line, y level, z up; for a flat foot on level ground z
            is the ground normal, whatever the roll of the leg about the line, shape (2, 3, 3).
        v_WC: velocity of the middles [m/s], shape (2, 3).
        w_WF: angular velocity of the feet [rad/s], shape (2, 3).
        J: line-contact Jacobians (51), rows (v_WC, [w_y, w_z] in C), shape (2, 5, nv).
        Jdot_v: bias of these five accelerations, shape (2, 5).
    """

    q: Array
    v: Array
    M: Array
    Cv: Array
    tau_g: Array
    CTv: Array
    R_WB: Array
    p_WG: Array
    v_WG: Array
    A: Array
    Adot_v: Array
    p_WC: Array
    R_WC: Array
    v_WC: Array
    w_WF: Array
    J: Array
    Jdot_v: Array

    @property
    def p_WB(self) -> Array:
        """Torso origin [m], shape (3,)."""
        return self.q[4:7]

    @property
    def L_G(self) -> Array:
        """Angular momentum about the CoM [kg m^2/s], shape (3,)."""
        return self.A[:3] @ self.v

    def __deepcopy__(self, memo: dict[int, object]) -> RobotDynamics:
        """Return self; Drake copies abstract values on every update."""
        return self


def robot_dynamics(humanoid: Humanoid, context: Context, x: Array) -> RobotDynamics:
    """Compute everything the controller needs from the state.

    In one compiled pass over its tree; Drake is asked where that cannot be, see `read_tree`.

    Args:
        humanoid: the robot.
        context: of `humanoid.plant`. Its masses count, as they are when it is here for the first
            time; its state may be overwritten.
        x: state [q, v], shape (nq + nv,).

    Returns:
        The quantities, views of one array of their own.

    Raises:
        ValueError: the line of a foot stands upright.
    """
    tree = humanoid.tree(context)
    if tree is None:
        return dynamics_by_drake(humanoid, context, x)
    flat = np.empty(size_of(humanoid.nv))
    dynamics_of_tree(flat, x, tuple(tree))
    return views(flat, humanoid.nv)


def dynamics_by_drake(humanoid: Humanoid, context: Context, x: Array) -> RobotDynamics:
    """Return what `robot_dynamics` does, by Drake's calls, with joints of any kind."""
    flat = np.empty(size_of(humanoid.nv))
    complete(flat, x, tuple(drake_terms(humanoid, context, x)))
    return views(flat, humanoid.nv)


@compiled
def opened(flat: Array, nv: int) -> RobotDynamics:
    """Return the quantities that an array holds, as views: here each has its place.

    Args:
        flat: see `size_of`.
        nv: number of velocities.
    """
    rows, rest = flat[: nv * (nv + 20)].reshape(nv + 20, nv), flat[nv * (nv + 20) :]
    return RobotDynamics(
        q=rest[67:],
        v=rows[nv],
        M=rows[:nv],
        Cv=rows[nv + 1],
        tau_g=rows[nv + 2],
        CTv=rows[nv + 3],
        R_WB=rest[:9].reshape(3, 3),
        p_WG=rest[9:12],
        v_WG=rest[12:15],
        A=rows[nv + 4 : nv + 10],
        Adot_v=rest[15:21],
        p_WC=rest[21:27].reshape(2, 3),
        R_WC=rest[27:45].reshape(2, 3, 3),
        v_WC=rest[45:51].reshape(2, 3),
        w_WF=rest[51:57].reshape(2, 3),
        J=rows[nv + 10 :].reshape(2, 5, nv),
        Jdot_v=rest[57:67].reshape(2, 5),
    )


def size_of(nv: int) -> int:
    """Return how many numbers the quantities of a robot with nv velocities are."""
    return nv * (nv + 20) + 67 + nv + 1


@cache
def _layout(nv: int) -> np.dtype[np.void]:
    """Return the places of `opened` for numpy, which opens an array in a third of the time."""
    places = as_python(opened)(np.arange(float(size_of(nv))), nv)
    return np.dtype(
        {
            "names": list(RobotDynamics._fields),
            "formats": [(float, part.shape) for part in places],
            "offsets": [8 * int(part.flat[0]) for part in places],
        }
    )


def views(flat: Array, nv: int) -> RobotDynamics:
    """Return the quantities that an array holds, as views, as `opened` does."""
    return RobotDynamics._make(np.ndarray((), _layout(nv), flat).item())


@compiled
def dynamics_of_tree(flat: Array, x: Array, tree: tuple[Any, ...]) -> None:
    """Compute all quantities of a state.

    Args:
        flat: they are written here, see `opened`.
        x: state [q, v], shape (2 nv + 1,).
        tree: `Tree`, as a plain tuple, which Numba takes over faster.
    """
    robot, nv = Tree(*tree), len(x) // 2
    d, links = opened(flat, nv), new_links(len(robot.joints))
    d.q[:], d.v[:] = x[: nv + 1], x[nv + 1 :]
    move_links(robot, d.q, d.v, from_quaternion(d.q), links)
    weigh_links(robot, links)
    sum_links(robot, links, d.M, d.Cv, d.CTv)
    X_WF, J_V, bias = np.empty((2, 3, 4)), np.empty((2, 6, nv)), np.empty((2, 6))
    place_feet(robot, links, X_WF, J_V, bias)
    X_WF[:, 0, 3] += d.q[4]
    X_WF[:, 1, 3] += d.q[5]
    X_WF[:, 2, 3] += d.q[6]
    fill_in(d, X_WF, J_V, bias)


@compiled
def complete(flat: Array, x: Array, terms: tuple[Array, ...]) -> None:
    """Compute all quantities of a state from some.

    Args:
        flat: they are written here, see `opened`.
        x: state [q, v], shape (nq + nv,).
        terms: `Terms`, as a plain tuple.
    """
    M, Cv, CTv, X_WF, J_V, bias = terms
    d, nq = opened(flat, len(Cv)), len(x) - len(Cv)
    d.q[:], d.v[:], d.M[:], d.Cv[:], d.CTv[:] = x[:nq], x[nq:], M, Cv, CTv
    fill_in(d, X_WF, J_V, bias)


@compiled
def fill_in(d: RobotDynamics, X_WF: Array, J_V: Array, bias: Array) -> None:
    """Fill in what follows from q, v, M, Cv and the motion of the feet, see `Terms`.

    Raises:
        ValueError: the line of a foot stands upright.
    """
    d.R_WB[:] = from_quaternion(d.q)
    centroidal_terms(d)
    for side in range(2):
        line_motion(d, side, X_WF[side], J_V[side], bias[side])


@inlined
def centroidal_terms(d: RobotDynamics) -> None:
    """Fill in what the six base rows of the dynamics say: p_WG, v_WG, A, Adot_v and tau_g.

    The velocity of a floating base comes first in v, so these rows are the rates of momentum
    about the base origin.
    """
    nv, m = len(d.v), d.M[3, 3]
    x, y, z = d.M[2, 4] / m, d.M[0, 5] / m, d.M[1, 3] / m  # of the CoM from the base origin
    d.p_WG[0], d.p_WG[1], d.p_WG[2] = d.q[4] + x, d.q[5] + y, d.q[6] + z
    d.A[3:], d.Adot_v[3:], d.v_WG[:] = d.M[3:6], d.Cv[3:6], 0.0
    for j in range(nv):  # loops, not `@`: the BLAS would take twice the time of all the rest
        d.tau_g[j] = GRAVITY[2] * d.M[5, j]
        d.A[0, j] = d.M[0, j] - (y * d.M[5, j] - z * d.M[4, j])
        d.A[1, j] = d.M[1, j] - (z * d.M[3, j] - x * d.M[5, j])
        d.A[2, j] = d.M[2, j] - (x * d.M[4, j] - y * d.M[3, j])
        for i in range(3):
            d.v_WG[i] += d.M[3 + i, j] * d.v[j] / m
    d.Adot_v[0] = d.Cv[0] - (y * d.Cv[5] - z * d.Cv[4])
    d.Adot_v[1] = d.Cv[1] - (z * d.Cv[3] - x * d.Cv[5])
    d.Adot_v[2] = d.Cv[2] - (x * d.Cv[4] - y * d.Cv[3])


@inlined
def line_motion(d: RobotDynamics, side: int, X_WF: Array, J_V: Array, bias: Array) -> None:
    """Fill in the motion of one contact line, (51).

    Args:
        d: p_WC, R_WC, v_WC, w_WF, J and Jdot_v of the side are written.
        side: 0 left, 1 right.
        X_WF: axes of the foot beside the middle of the line [m], shape (3, 4).
        J_V: Jacobian of the foot's spatial velocity at C, angular over linear, shape (6, nv).
        bias: bias of that velocity's rate, shape (6,).

    Raises:
        ValueError: the line stands upright.
    """
    R_WC = contact_frame(X_WF)
    d.R_WC[side] = R_WC
    for i in range(3):
        d.p_WC[side, i] = X_WF[i, 3]
        d.w_WF[side, i], d.v_WC[side, i] = dot(J_V[i], d.v), dot(J_V[3 + i], d.v)
        d.J[side, i], d.Jdot_v[side, i] = J_V[3 + i], bias[3 + i]
    for i in range(2):  # A_s' R_i of (51): y and z of the contact frame
        x, y, z = R_WC[0, 1 + i], R_WC[1, 1 + i], R_WC[2, 1 + i]
        d.Jdot_v[side, 3 + i] = x * bias[0] + y * bias[1] + z * bias[2]
        for j in range(len(d.v)):
            d.J[side, 3 + i, j] = x * J_V[0, j] + y * J_V[1, j] + z * J_V[2, j]


@inlined
def contact_frame(R_WF: Array) -> Array:
    """Return R_WC: x along the foot's x axis, y level, z completing it.

    Args:
        R_WF: foot orientation, shape (3, 3) or, with the origin beside it, (3, 4).

    Returns:
        Shape (3, 3).

    Raises:
        ValueError: the foot's line stands upright, so that it has no heading.
    """
    R_WC = np.zeros((3, 3))
    x = R_WF[:, 0]
    norm = math.hypot(x[0], x[1])
    if norm < 1e-9:
        raise ValueError("the contact line stands upright: it has no heading")
    R_WC[:, 0] = x
    R_WC[0, 1], R_WC[1, 1] = -x[1] / norm, x[0] / norm
    R_WC[:, 2] = cross(x, R_WC[:, 1])
    return R_WC
