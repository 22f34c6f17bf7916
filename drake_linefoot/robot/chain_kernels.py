"""Compiled chains of legs: where the links are.

A leg is a chain of five revolute joints from the torso to a contact line. A joint's rotation by q
is ``turn = B0 + sin q B1 + (1 - cos q) B2``; beside it stand its axis and its place, both
constant in the frame before. Everything is expressed in the torso frame B, at its origin.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_linefoot.math.compiled import compiled

Array = NDArray[np.float64]

JOINTS = 5  # of a leg: as many as the line has coordinates


class Legs(NamedTuple):
    """What a chain is made of, for n legs.

    Attributes:
        turns: B0, B1, B2 of each joint, shape (n, 3, 5, 3, 3).
        axes: of each joint in the frame before, unit vectors, shape (n, 5, 3).
        places: of each joint in the frame before [m], shape (n, 5, 3).
        ends: middle of the contact line in the last frame [m], shape (n, 3).
        lower: joint limits [rad], shape (n, 5).
        upper: joint limits [rad], shape (n, 5).
    """

    turns: Array
    axes: Array
    places: Array
    ends: Array
    lower: Array
    upper: Array


class Links(NamedTuple):
    """The five links of one leg in the torso frame.

    Attributes:
        R: orientations, that of the torso before them, shape (6, 3, 3).
        axes: of the joints that carry them, shape (5, 3).
        origins: [m], that of the torso before them, shape (6, 3).
    """

    R: Array
    axes: Array
    origins: Array


@compiled
def new_links() -> Links:
    """Return memory for the links of a leg."""
    links = Links(np.zeros((JOINTS + 1, 3, 3)), np.zeros((JOINTS, 3)), np.zeros((JOINTS + 1, 3)))
    for i in range(3):
        links.R[0, i, i] = 1.0
    return links


@compiled
def chain(legs: Legs, leg: int, q: Array, links: Links) -> None:
    """Write the links of a leg at joint angles `q` [rad], shape (5,)."""
    turns, axes, places = legs.turns, legs.axes, legs.places
    R, a, o = links.R, links.axes, links.origins
    for i in range(JOINTS):
        sine, versine = math.sin(q[i]), 1.0 - math.cos(q[i])
        for r in range(3):
            x, y, z = R[i, r, 0], R[i, r, 1], R[i, r, 2]
            a[i, r] = x * axes[leg, i, 0] + y * axes[leg, i, 1] + z * axes[leg, i, 2]
            out = x * places[leg, i, 0] + y * places[leg, i, 1] + z * places[leg, i, 2]
            o[i + 1, r] = o[i, r] + out
            R[i + 1, r] = 0.0
        for k in range(3):
            for c in range(3):
                turn = turns[leg, 0, i, k, c] + sine * turns[leg, 1, i, k, c]
                turn += versine * turns[leg, 2, i, k, c]
                for r in range(3):
                    R[i + 1, r, c] += R[i, r, k] * turn
