"""Rigid-body and centroidal quantities of one state: the terms of (1), momentum, contact lines."""

from __future__ import annotations

import math
from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np

from drake_linefoot.axes import TORQUE_AXES, WRENCH
from drake_linefoot.constants import GRAVITY
from drake_linefoot.layout import Layout
from drake_linefoot.math.compiled import compiled, inlined
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
from drake_linefoot.signals import RobotDynamics, open_dynamics
from drake_linefoot.types import Array

if TYPE_CHECKING:
    from pydrake.systems.framework import Context


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
    return dynamics_layout(humanoid).open(dynamics_vector(humanoid, context, x))


def dynamics_vector(humanoid: Humanoid, context: Context, x: Array) -> Array:
    """Return what `robot_dynamics` does as the vector that travels, see `dynamics_layout`."""
    flat, tree = np.empty(dynamics_layout(humanoid).size), humanoid.tree(context)
    nw = humanoid.contact.size
    if tree is None:
        complete(flat, x, nw, tuple(drake_terms(humanoid, context, x)))
    else:
        dynamics_of_tree(flat, x, nw, tuple(tree))
    return flat


def dynamics_by_drake(humanoid: Humanoid, context: Context, x: Array) -> RobotDynamics:
    """Return what `robot_dynamics` does, by Drake's calls, with joints of any kind."""
    layout = dynamics_layout(humanoid)
    flat = np.empty(layout.size)
    complete(flat, x, humanoid.contact.size, tuple(drake_terms(humanoid, context, x)))
    return layout.open(flat)


def dynamics_layout(humanoid: Humanoid) -> Layout[RobotDynamics]:
    """Return how the quantities of a robot lie in one vector."""
    return _layout(humanoid.nv, humanoid.contact.size)


@cache
def _layout(nv: int, nw: int) -> Layout[RobotDynamics]:
    return Layout(RobotDynamics, {"nv": nv, "nw": nw})


@compiled
def dynamics_of_tree(flat: Array, x: Array, nw: int, tree: tuple[Any, ...]) -> None:
    """Compute all quantities of a state.

    Args:
        flat: they are written here, see `dynamics_layout`.
        x: state [q, v], shape (2 nv + 1,).
        nw: how many numbers the wrench of a foot has.
        tree: `Tree`, as a plain tuple, which Numba takes over faster.
    """
    robot, nv = Tree(*tree), len(x) // 2
    d, links = open_dynamics(flat, nv, nw), new_links(len(robot.joints))
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
def complete(flat: Array, x: Array, nw: int, terms: tuple[Array, ...]) -> None:
    """Compute all quantities of a state from some.

    Args:
        flat: they are written here, see `dynamics_layout`.
        x: state [q, v], shape (nq + nv,).
        nw: how many numbers the wrench of a foot has.
        terms: `Terms`, as a plain tuple.
    """
    M, Cv, CTv, X_WF, J_V, bias = terms
    d, nq = open_dynamics(flat, len(Cv), nw), len(x) - len(Cv)
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
    if d.J.shape[1] == len(WRENCH):  # a sole has a roll of its own
        R_WC[:] = X_WF[:, :3]
    d.R_WC[side] = R_WC
    for i in range(3):
        d.p_WC[side, i] = X_WF[i, 3]
        d.w_WF[side, i], d.v_WC[side, i] = dot(J_V[i], d.v), dot(J_V[3 + i], d.v)
        d.J[side, i], d.Jdot_v[side, i] = J_V[3 + i], bias[3 + i]
    for i in range(d.J.shape[1] - 3):  # A_s' R_i of (51): y and z of the contact frame, then x
        axis = TORQUE_AXES[i]
        x, y, z = R_WC[0, axis], R_WC[1, axis], R_WC[2, axis]
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
