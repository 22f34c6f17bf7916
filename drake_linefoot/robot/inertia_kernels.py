"""Compiled inertia and angular momentum of a robot whose legs move and whose torso is given."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_linefoot.math.compiled import compiled
from drake_linefoot.robot.chain_kernels import JOINTS, Legs, chain, new_links

Array = NDArray[np.float64]


class Masses(NamedTuple):
    """What is in the torso's frame and in those of the legs' links: 1 + n 5 rigid bodies.

    The torso is first, then the links leg by leg; arms count where they hang, as they are held.

    Attributes:
        mass: [kg], shape (1 + n 5,).
        com: CoM in the body's own frame [m], shape (1 + n 5, 3).
        inertia: about the CoM, in the body's own frame [kg m^2], shape (1 + n 5, 3, 3).
    """

    mass: Array
    com: Array
    inertia: Array


@compiled
def add_cross(factor: float, a: Array, b: Array, out: Array) -> None:
    """Add ``factor a x b`` to `out`, shapes (3,)."""
    out[0] += factor * (a[1] * b[2] - a[2] * b[1])
    out[1] += factor * (a[2] * b[0] - a[0] * b[2])
    out[2] += factor * (a[0] * b[1] - a[1] * b[0])


@compiled
def turned(R: Array, a: Array, out: Array) -> None:
    """Write ``R a``, shapes (3, 3) and (3,)."""
    for i in range(3):
        out[i] = R[i, 0] * a[0] + R[i, 1] * a[1] + R[i, 2] * a[2]


@compiled
def add_inertia(mass: float, c: Array, R: Array, inertia: Array, out: Array) -> None:
    """Add a body's inertia about the origin, ``R I R' + m (c'c 1 - c c')``, to `out`.

    Args:
        mass: [kg].
        c: its CoM [m], shape (3,).
        R: its orientation, shape (3, 3).
        inertia: about its CoM in its own frame [kg m^2], shape (3, 3).
        out: shape (3, 3).
    """
    square = c[0] * c[0] + c[1] * c[1] + c[2] * c[2]
    for i in range(3):
        x = R[i, 0] * inertia[0, 0] + R[i, 1] * inertia[1, 0] + R[i, 2] * inertia[2, 0]
        y = R[i, 0] * inertia[0, 1] + R[i, 1] * inertia[1, 1] + R[i, 2] * inertia[2, 1]
        z = R[i, 0] * inertia[0, 2] + R[i, 1] * inertia[1, 2] + R[i, 2] * inertia[2, 2]
        for j in range(3):
            out[i, j] += x * R[j, 0] + y * R[j, 1] + z * R[j, 2] - mass * c[i] * c[j]
        out[i, i] += mass * square


@compiled
def inertia_and_momentum(
    legs: Legs, masses: Masses, q: Array, rates: Array, Omega: Array
) -> tuple[Array, Array]:
    """Return locked inertia and angular momentum about the CoM, both in the torso frame B, (23).

    A moving origin does not count: the momentum about the CoM is that of motion relative to B
    (of the joints) and with B (of its turning).

    Args:
        legs: n legs.
        masses: of torso and links.
        q: joint angles [rad], shape (n, K, 5).
        rates: joint rates [rad/s], shape (n, K, 5).
        Omega: angular velocity of the torso in B [rad/s], shape (K, 3).

    Returns:
        (I_B, L_B): [kg m^2] shape (K, 3, 3), [kg m^2/s] shape (K, 3).
    """
    n, K, _ = q.shape
    I_B, L_B = np.zeros((K, 3, 3)), np.zeros((K, 3))
    links, upright, total = new_links(), np.eye(3), masses.mass.sum()
    c, v, w, moment, linear = np.empty(3), np.empty(3), np.empty(3), np.empty(3), np.empty(3)
    out, local = np.empty(3), np.empty(3)
    for k in range(K):
        moment[:] = masses.mass[0] * masses.com[0]  # first moment of mass about B
        linear[:] = 0.0  # momentum of the joints' motion
        add_inertia(masses.mass[0], masses.com[0], upright, masses.inertia[0], I_B[k])
        for leg in range(n):
            chain(legs, leg, q[leg, k], links)
            w[:], v[:] = 0.0, 0.0  # of the link's origin
            for i in range(JOINTS):
                body, R = 1 + leg * JOINTS + i, links.R[i + 1]
                origin = links.origins[i + 1]
                for r in range(3):
                    out[r] = origin[r] - links.origins[i, r]
                add_cross(1.0, w, out, v)  # of the first link nothing, for w is zero yet
                turned(R, masses.com[body], out)
                m = masses.mass[body]
                for r in range(3):
                    w[r] += rates[leg, k, i] * links.axes[i, r]
                    c[r] = origin[r] + out[r]
                    local[r] = v[r]
                add_cross(1.0, w, out, local)  # velocity of the link's CoM
                for r in range(3):
                    moment[r] += m * c[r]
                    linear[r] += m * local[r]
                add_cross(m, c, local, L_B[k])
                add_inertia(m, c, R, masses.inertia[body], I_B[k])
                for r in range(3):
                    out[r] = R[0, r] * w[0] + R[1, r] * w[1] + R[2, r] * w[2]
                turned(masses.inertia[body], out, local)
                turned(R, local, out)
                for r in range(3):
                    L_B[k, r] += out[r]
        c[:] = moment / total
        add_inertia(-total, c, upright, np.zeros((3, 3)), I_B[k])
        add_cross(-1.0, c, linear, L_B[k])
        turned(I_B[k], Omega[k], out)
        L_B[k] += out
    return I_B, L_B
