"""Courses: the boxes that stairs, gaps, stones and blocks are made of, behind a pad."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from drake_linefoot.lab.scenario.courses import (
    BlocksParameters,
    CourseParameters,
    GapsParameters,
    PatchParameters,
    SpiralParameters,
    StairsParameters,
    StonesParameters,
)
from drake_linefoot.types import Array

DEPTH = 1.0  # [m] of boxes
PAD = 5.0  # [m] of the pad, and of what is behind the course
_COURSE = 2  # stream of random numbers, beside those of the initial state and of the tiles


class Block(NamedTuple):
    """A box of ground."""

    R_WB: Array  # its axes, shape (3, 3)
    p_WB: Array  # its centre [m], shape (3,)
    size: Array  # its edges [m], shape (3,)

    @property
    def corners(self) -> Array:
        """Corners of its upper side, counter-clockwise from above [m], shape (4, 3)."""
        half = 0.5 * self.size
        signs = np.array([[-1.0, -1.0, 1.0], [1.0, -1.0, 1.0], [1.0, 1.0, 1.0], [-1.0, 1.0, 1.0]])
        corners: Array = self.p_WB + (signs * half) @ self.R_WB.T
        return corners


Rectangle = tuple[float, float, float, float, float]  # from, to along; from, to across; height [m]


def course_blocks(course: CourseParameters, seed: int) -> list[Block]:
    """Return the boxes of a course, pad first."""
    random = np.random.default_rng([seed, _COURSE])
    c, s = np.cos(course.heading), np.sin(course.heading)
    turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    origin, blocks = np.array([course.at, 0.0, 0.0]), list[Block]()
    for (a, b, left, right, top), tilt in _rectangles(course, random):
        size = np.array([b - a, right - left, DEPTH])
        above = np.array([0.5 * (a + b), 0.5 * (left + right), top])
        R = turn @ tilt
        blocks.append(Block(R, origin + turn @ above - 0.5 * DEPTH * R[:, 2], size))
    return blocks


def _rectangles(
    course: CourseParameters, random: np.random.Generator
) -> Iterator[tuple[Rectangle, Array]]:
    """Yield where the upper sides of boxes are, along and across the course, and their tilt."""
    half, level, end, top = 0.5 * course.width, np.eye(3), 0.0, 0.0
    yield (-PAD, 0.0, -half, half, 0.0), level
    if isinstance(course, StairsParameters):
        for _ in range(course.steps - 1):
            tread = random.uniform(course.tread[0], course.tread[1])
            begin, end, top = end, end + tread, top + course.rise
            yield (begin, end, -half, half, top), level
        top += course.rise
    elif isinstance(course, GapsParameters):
        for _ in range(course.count - 1):
            begin, end = end + course.length, end + course.length + course.land
            yield (begin, end, -half, half, 0.0), level
        end += course.length
    elif isinstance(course, StonesParameters):
        pitch = course.size + course.gap
        for i in range(course.rows):
            for a in _across(course.width, pitch):
                begin = course.gap + i * pitch
                yield (begin, begin + course.size, a, a + course.size, 0.0), level
        end = course.rows * pitch + course.gap
    elif isinstance(course, BlocksParameters):
        for i in range(course.rows):
            for a in _across(course.width, course.size):
                height = random.uniform(-course.height, course.height)
                tilt = _tilted(course.tilt, random.uniform(0.0, 2.0 * np.pi))
                yield (i * course.size, (i + 1) * course.size, a, a + course.size, height), tilt
        end = course.rows * course.size
    yield (end, end + PAD, -half, half, top), level


def spiral_patches(course: SpiralParameters) -> list[PatchParameters]:
    """Return the patches of a spiral stair, pad first."""
    half, turn = 0.5 * course.width, course.tread / course.radius
    found = [([-PAD, 0.0], [0.0, 0.0], 0.0)]  # from and to, each as way ahead and turn; height
    for k in range(course.steps - 1):
        found.append(([0.0, k * turn], [0.0, (k + 1) * turn], (k + 1) * course.rise))
    end = (course.steps - 1) * turn
    found.append(([0.0, end], [PAD, end], course.steps * course.rise))

    def edge(place: list[float]) -> Array:
        """Return the ends of a line across the stair, right one first, shape (2, 2)."""
        ahead, yaw = place[0], course.heading + place[1]
        way, left = np.array([np.cos(yaw), np.sin(yaw)]), np.array([-np.sin(yaw), np.cos(yaw)])
        first = np.array([-np.sin(course.heading), np.cos(course.heading)])
        middle = [course.at, 0.0] + course.radius * (first - left) + ahead * way
        return np.array([middle - half * left, middle + half * left])

    return [
        PatchParameters(np.vstack([edge(a), edge(b)[::-1]]).tolist(), [height, 0.0, 0.0])
        for a, b, height in found
    ]


def _across(width: float, pitch: float) -> Array:
    """Return where pieces begin that lie side by side within a width, about its middle [m]."""
    count = max(int(width / pitch), 1)
    begins: Array = (np.arange(float(count)) - 0.5 * count) * pitch
    return begins


def _tilted(angle: float, towards: float) -> Array:
    """Return axes that are tilted about a level axis, shape (3, 3)."""
    c, s = np.cos(towards), np.sin(towards)
    axis = np.array([[0.0, 0.0, s], [0.0, 0.0, -c], [-s, c, 0.0]])
    tilted: Array = np.eye(3) + float(np.sin(angle)) * axis
    tilted += float(1.0 - np.cos(angle)) * (axis @ axis)
    return tilted
