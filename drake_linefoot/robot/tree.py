"""Rigid-body dynamics of a tree of links on a floating base, in one pass.

Everything is in axes of W and about one fixed point O, where the origin of the base is now: sums
over a subtree need no transform from link to link. A velocity is (w, u), u that of the body's point
at O; a momentum is (k, p), k about O; a force likewise. Composite inertias give the mass matrix,
forces summed up from the feet to the base the bias (Featherstone, Rigid Body Dynamics Algorithms,
2008, chapters 5 and 6). A joint of rate 1 gives what hangs on it the velocity S = (s, t).
"""

import math
from typing import NamedTuple

import numpy as np

from drake_linefoot.math.compiled import compiled, inlined
from drake_linefoot.math.vectors import (
    Vector,
    column,
    crossed,
    inner,
    plus,
    times,
    turned,
    vector,
    write,
    write_column,
)
from drake_linefoot.types import Array, Indices

PARENT, SLIDES, IN_Q, IN_V = range(4)  # columns of `Tree.joints`
BASE_VELOCITIES = 6  # w_WB_W, v_WBo_W


class Tree(NamedTuple):
    """The links of a robot, the base first, each after the one that it hangs on.

    What is welded to a link is part of it. Its frame L lies in the joint that moves it, which turns
    about z or slides along it. As a plain tuple it is quick to hand to compiled code.

    Attributes:
        joints: for each link: the one it hangs on, whether it slides (0 or 1), and where its joint
            stands in q and in v; for the base -1, 0, 0, 0; shape (n, 4).
        X_PL: frame L in that of the link it hangs on, with the joint at 0, rotation beside
            origin [m], shape (n, 3, 4).
        mass: of the link [kg]; reflected inertia of its joint's motor [kg m^2, kg], shape (n, 2).
        inertia: about the centre of mass [kg m^2], in L, beside that centre [m], shape (n, 3, 4).
        feet: the links of the feet, left before right, shape (2,).
        X_LF: axes of the foot beside C, the middle of its contact line [m], in L, shape (2, 3, 4).
    """

    joints: Indices
    X_PL: Array
    mass: Array
    inertia: Array
    feet: Indices
    X_LF: Array


class Links(NamedTuple):
    """What is computed of each link; places are from O.

    Attributes:
        R: axes of L, shape (n, 3, 3).
        p: origin of L [m], shape (n, 3).
        S: velocity for a rate of 1 of the joint, shape (n, 6).
        V: velocity, shape (n, 6).
        A: its rate at vdot = 0, shape (n, 6).
        mass: of the link beside its product with the centre of mass [kg, kg m]; later of all that
            hangs on it as well, shape (n, 4).
        inertia: about O, likewise [kg m^2], shape (n, 3, 3).
        h: momentum, likewise, shape (n, 6).
        f: its rate at vdot = 0, likewise, shape (n, 6).
    """

    R: Array
    p: Array
    S: Array
    V: Array
    A: Array
    mass: Array
    inertia: Array
    h: Array
    f: Array


@inlined
def new_links(n: int) -> Links:
    """Return room for what is computed of n links."""
    R, p, six = np.empty((n, 3, 3)), np.empty((n, 3)), np.empty((5, n, 6))
    mass, inertia = np.empty((n, 4)), np.zeros((n, 3, 3))
    return Links(R, p, six[0], six[1], six[2], mass, inertia, six[3], six[4])


@inlined
def move_links(tree: Tree, q: Array, v: Array, R_WB: Array, links: Links) -> None:
    """Write where every link is and how it moves: R, p, S, V and A, from the base outwards."""
    w_B, v_B, nothing = (v[0], v[1], v[2]), (v[3], v[4], v[5]), (0.0, 0.0, 0.0)
    links.R[0] = R_WB
    write(links.p, 0, 0, nothing)
    write(links.V, 0, 0, w_B)
    write(links.V, 0, 3, v_B)
    write(links.A, 0, 0, nothing)
    write(links.A, 0, 3, crossed(v_B, w_B))  # for the origin of the base leaves O
    for i in range(1, len(tree.joints)):
        on, at = tree.joints[i, PARENT], q[tree.joints[i, IN_Q]]
        slides, rate = tree.joints[i, SLIDES] == 1, v[tree.joints[i, IN_V]]
        p = plus(vector(links.p, on, 0), turned(links.R, on, column(tree.X_PL, i, 3)))
        x = turned(links.R, on, column(tree.X_PL, i, 0))
        y = turned(links.R, on, column(tree.X_PL, i, 1))
        axis = turned(links.R, on, column(tree.X_PL, i, 2))
        if slides:
            p, s, t, cosine, sine = plus(p, times(at, axis)), nothing, axis, 1.0, 0.0
        else:
            s, t, cosine, sine = axis, crossed(p, axis), math.cos(at), math.sin(at)
        write(links.p, i, 0, p)
        write_column(links.R, i, 0, plus(times(cosine, x), times(sine, y)))
        write_column(links.R, i, 1, plus(times(cosine, y), times(-sine, x)))
        write_column(links.R, i, 2, axis)
        write(links.S, i, 0, s)
        write(links.S, i, 3, t)
        w, u = vector(links.V, on, 0), vector(links.V, on, 3)
        write(links.V, i, 0, plus(w, times(rate, s)))
        write(links.V, i, 3, plus(u, times(rate, t)))
        s_rate, t_rate = turning_axis(w, u, s, t)
        write(links.A, i, 0, plus(vector(links.A, on, 0), times(rate, s_rate)))
        write(links.A, i, 3, plus(vector(links.A, on, 3), times(rate, t_rate)))


@compiled
def turning_axis(w: Vector, u: Vector, s: Vector, t: Vector) -> tuple[Vector, Vector]:
    """Return the rate V x S of a joint's S = (s, t) that moves with a link of V = (w, u)."""
    return crossed(w, s), plus(crossed(w, t), crossed(u, s))


@compiled
def momentum(links: Links, i: int, w: Vector, u: Vector) -> tuple[Vector, Vector]:
    """Return the momentum (k, p) that the mass of link `i` has with a velocity (w, u)."""
    m, mc = links.mass[i, 0], vector(links.mass, i, 1)
    return plus(turned(links.inertia, i, w), crossed(mc, u)), plus(times(m, u), crossed(w, mc))


@compiled
def add_inertia(mass: float, c: Vector | Array, R: Array, inertia: Array, out: Array) -> None:
    """Add a body's inertia about the origin, ``R I R' + m (c'c 1 - c c')``, to `out`.

    Args:
        mass: [kg].
        c: its CoM [m], shape (3,).
        R: its orientation, shape (3, 3).
        inertia: about its CoM in its own frame [kg m^2], shape (3, 3) or with more columns.
        out: shape (3, 3).
    """
    square = c[0] * c[0] + c[1] * c[1] + c[2] * c[2]
    for i in range(3):
        x = R[i, 0] * inertia[0, 0] + R[i, 1] * inertia[1, 0] + R[i, 2] * inertia[2, 0]
        y = R[i, 0] * inertia[0, 1] + R[i, 1] * inertia[1, 1] + R[i, 2] * inertia[2, 1]
        z = R[i, 0] * inertia[0, 2] + R[i, 1] * inertia[1, 2] + R[i, 2] * inertia[2, 2]
        for j in range(i):
            product = x * R[j, 0] + y * R[j, 1] + z * R[j, 2] - mass * c[i] * c[j]
            out[i, j] += product
            out[j, i] += product
        product = x * R[i, 0] + y * R[i, 1] + z * R[i, 2]
        out[i, i] += product + mass * (square - c[i] * c[i])


@inlined
def weigh_links(tree: Tree, links: Links) -> None:
    """Write mass, inertia, momentum and its rate of each link by itself."""
    for i in range(len(tree.mass)):
        m, w, u = tree.mass[i, 0], vector(links.V, i, 0), vector(links.V, i, 3)
        c = plus(vector(links.p, i, 0), turned(links.R, i, column(tree.inertia, i, 3)))
        links.mass[i, 0] = m
        write(links.mass, i, 1, times(m, c))
        add_inertia(m, c, links.R[i], tree.inertia[i], links.inertia[i])
        k, p = momentum(links, i, w, u)
        write(links.h, i, 0, k)
        write(links.h, i, 3, p)
        moment, force = momentum(links, i, vector(links.A, i, 0), vector(links.A, i, 3))
        write(links.f, i, 0, plus(moment, plus(crossed(w, k), crossed(u, p))))
        write(links.f, i, 3, plus(force, crossed(w, p)))


@inlined
def sum_links(tree: Tree, links: Links, M: Array, Cv: Array, CTv: Array) -> None:
    """Sum up the links from the feet to the base; write mass matrix, Cv and C'v.

    C'v is what is left of the rate of the generalized momentum ``S_i' h_i`` when the forces are
    taken away, the rate of S_i times h_i; the base's own rows are about its origin, which moves
    against O. A reflected inertia is constant.

    Args:
        tree: the robot.
        links: of each by itself; become those of all that hangs on it as well.
        M: becomes the mass matrix, shape (nv, nv).
        Cv: becomes the Coriolis and centrifugal forces, shape (nv,).
        CTv: becomes the transpose's, below (19), shape (nv,).
    """
    M[:] = 0.0
    for i in range(len(tree.joints) - 1, 0, -1):
        on, at = tree.joints[i, PARENT], tree.joints[i, IN_V]
        s, t = vector(links.S, i, 0), vector(links.S, i, 3)
        k, p = momentum(links, i, s, t)
        for j in range(3):
            M[j, at] = M[at, j] = k[j]
            M[3 + j, at] = M[at, 3 + j] = p[j]
        M[at, at] = inner(s, k) + inner(t, p) + tree.mass[i, 1]
        j = on
        while j > 0:
            to = tree.joints[j, IN_V]
            product = inner(vector(links.S, j, 0), k) + inner(vector(links.S, j, 3), p)
            M[to, at] = M[at, to] = product
            j = tree.joints[j, PARENT]
        Cv[at] = inner(s, vector(links.f, i, 0)) + inner(t, vector(links.f, i, 3))
        s, t = turning_axis(vector(links.V, i, 0), vector(links.V, i, 3), s, t)
        CTv[at] = inner(s, vector(links.h, i, 0)) + inner(t, vector(links.h, i, 3))
        for j in range(4):
            links.mass[on, j] += links.mass[i, j]
        for j in range(6):
            links.h[on, j] += links.h[i, j]
            links.f[on, j] += links.f[i, j]
        for j in range(3):
            for m in range(3):
                links.inertia[on, j, m] += links.inertia[i, j, m]
    base_rows(links, M)
    Cv[:6], CTv[3:6] = links.f[0], 0.0
    CTv[0], CTv[1], CTv[2] = crossed(vector(links.h, 0, 3), vector(links.V, 0, 3))


@inlined
def base_rows(links: Links, M: Array) -> None:
    """Write what the base's six velocities have of the mass matrix: that of a rigid body."""
    m, (x, y, z) = links.mass[0, 0], vector(links.mass, 0, 1)
    M[:3, :3] = links.inertia[0]
    M[3, 3] = M[4, 4] = M[5, 5] = m
    M[1, 3] = M[3, 1] = z
    M[2, 4] = M[4, 2] = x
    M[0, 5] = M[5, 0] = y
    M[0, 4] = M[4, 0] = -z
    M[1, 5] = M[5, 1] = -x
    M[2, 3] = M[3, 2] = -y


@inlined
def place_feet(tree: Tree, links: Links, X_WF: Array, J_V: Array, bias: Array) -> None:
    """Write pose, Jacobian and bias of both feet at C, the middle of the contact line.

    Args:
        tree: the robot.
        links: where they are and how they move.
        X_WF: becomes the axes of each foot beside C, from O [m], shape (2, 3, 4).
        J_V: becomes the Jacobian of its velocity, angular over that of C, shape (2, 6, nv).
        bias: becomes the bias of that velocity's rate, shape (2, 6).
    """
    J_V[:] = 0.0
    for side in range(2):
        i = tree.feet[side]
        for j in range(4):
            write_column(X_WF, side, j, turned(links.R, i, column(tree.X_LF, side, j)))
        c = plus(vector(links.p, i, 0), column(X_WF, side, 3))
        write_column(X_WF, side, 3, c)
        for j in range(6):
            J_V[side, j, j] = 1.0
        J_V[side, 4, 0], J_V[side, 5, 0], J_V[side, 3, 1] = -c[2], c[1], c[2]
        J_V[side, 5, 1], J_V[side, 3, 2], J_V[side, 4, 2] = -c[0], -c[1], c[0]
        w, alpha = vector(links.V, i, 0), vector(links.A, i, 0)
        v_C = plus(vector(links.V, i, 3), crossed(w, c))
        write(bias, side, 0, alpha)
        write(bias, side, 3, plus(vector(links.A, i, 3), plus(crossed(alpha, c), crossed(w, v_C))))
        while i > 0:
            at, s = tree.joints[i, IN_V], vector(links.S, i, 0)
            u = plus(vector(links.S, i, 3), crossed(s, c))
            for j in range(3):
                J_V[side, j, at], J_V[side, 3 + j, at] = s[j], u[j]
            i = tree.joints[i, PARENT]
