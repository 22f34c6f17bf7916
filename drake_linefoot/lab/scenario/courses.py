"""Courses of a scenario: ground of pieces behind a pad, and what the controller knows of it."""

from dataclasses import dataclass, field
from typing import Annotated

import numpy as np
from annotated_types import Ge, Le, Len
from pydantic import Strict

from drake_linefoot.constants import PATCH_CORNERS
from drake_linefoot.fields import (
    NameOrPath,
    NotNegative,
    Number,
    Pair,
    Positive,
    Triple,
    Unit,
    Whole,
    misfit,
    one_of,
    together,
)
from drake_linefoot.parameters import Parameters
from drake_linefoot.types import Array

Count = Annotated[Whole, Ge(1), Le(200)]
Length = Annotated[Positive, Unit("m", 100.0)]
Turn = Annotated[Number, Ge(-1.5), Le(1.5), Unit("rad")]
LONGEST = 1e4  # [s] of a run
STEEPEST = 1.0  # [-] rise of a patch
_SHARPEST = 1e-6  # [-] sine of the least turn at a corner


@dataclass
class CourseParameters(Parameters):
    """Where a course begins, and how it lies."""

    at: Length = 0.6
    """Where the pad ends, in x on y = 0."""
    heading: Turn = 0.0
    """Of the course."""
    width: Length = 3.0
    """Of pad and course."""


@dataclass
class StairsParameters(CourseParameters):
    """Steps, up or down, between the pad and a landing."""

    rise: Annotated[Number, Ge(-0.5), Le(0.5), Unit("m")] = 0.12
    """Of each step; negative is down."""
    tread: Annotated[Pair, Unit("m")] = field(default_factory=lambda: [0.28, 0.28])
    """Least and greatest depth of a step, random between."""
    steps: Count = 6

    @together
    def _has_treads(self) -> None:
        if not 0.05 <= self.tread[0] <= self.tread[1]:
            raise misfit("tread", self.tread, "must be two depths of at least 0.05 m, in order")


@dataclass
class GapsParameters(CourseParameters):
    """Gaps without ground."""

    length: Length = 0.2
    """Of each gap."""
    land: Length = 0.5
    """Of the ground between two."""
    count: Count = 4


@dataclass
class StonesParameters(CourseParameters):
    """Level stones with gaps around them."""

    size: Length = 0.25
    """Edge of each."""
    gap: Length = 0.1
    """Between two."""
    rows: Count = 8
    """Along the course; its width says how many are beside each other."""


@dataclass
class BlocksParameters(CourseParameters):
    """Blocks side by side, each at a height and with a tilt of its own."""

    size: Length = 0.4
    """Edge of each."""
    height: Annotated[NotNegative, Unit("m", 0.5)] = 0.05
    """So far at most each is above or below the pad."""
    tilt: Annotated[Number, Ge(0), Le(0.5), Unit("rad")] = 0.17
    """Of each, in a random direction."""
    rows: Count = 8
    """Along the course; its width says how many are beside each other."""


@dataclass
class SpiralParameters(CourseParameters):
    """Steps that turn to the left, between the pad and a landing."""

    width: Length = 1.6
    """Of pad, steps and landing."""
    rise: Annotated[Number, Ge(-0.5), Le(0.5), Unit("m")] = 0.12
    """Of each step; negative is down."""
    tread: Annotated[Positive, Ge(0.05), Unit("m")] = 0.28
    """Depth of a step in its middle."""
    radius: Length = 2.0
    """From the axis to the middle of the steps."""
    steps: Count = 8

    @together
    def _turns_about_an_axis(self) -> None:
        if self.width >= 2.0 * self.radius:
            allowed = f"must be below {2.0 * self.radius:g}, twice the radius"
            raise misfit("width", self.width, allowed)
        if (self.steps - 1) * self.tread > 1.5 * np.pi * self.radius:
            raise misfit("steps", self.steps, "must make three quarters of a turn at most")


@dataclass
class PatchParameters(Parameters):
    """A convex piece of ground."""

    corners: Annotated[list[Annotated[Pair, Unit("m", 1e3)]], Strict(), Len(3, PATCH_CORNERS)] = (
        field(default_factory=lambda: [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    )
    """In plan, in turn, either way round."""
    plane: Annotated[Triple, Unit("m")] = field(default_factory=lambda: [0.0, 0.0, 0.0])
    """Height where x and y are 0, and rise along x and y."""

    @property
    def counter_clockwise(self) -> Array:
        """The corners, counter-clockwise from above [m], shape (n, 2)."""
        corners = np.array(self.corners, dtype=float)
        return corners if _turns(corners).sum() > 0.0 else corners[::-1]

    def height_at(self, x: float, y: float) -> float | None:
        """Return its height at a place [m]; None where it does not reach."""
        corners = self.counter_clockwise - [x, y]
        after = np.roll(corners, -1, axis=0)
        if (corners[:, 0] * after[:, 1] - corners[:, 1] * after[:, 0]).min() < 0.0:
            return None
        return float(self.plane[0] + self.plane[1] * x + self.plane[2] * y)

    @together
    def _is_convex(self) -> None:
        turns = _turns(self.counter_clockwise)
        if not (turns.min() > _SHARPEST and abs(turns.sum() - 2.0 * np.pi) < 1e-6):
            allowed = "must be convex, and turn at each corner"
            raise misfit("corners", self.corners, allowed)

    @together
    def _is_no_wall(self) -> None:
        if float(np.linalg.norm(self.plane[1:])) > STEEPEST:
            raise misfit("plane", self.plane, f"must rise by at most {STEEPEST:g} m per metre")


def _turns(corners: Array) -> Array:
    """Return by how much a way along corners turns at each [rad], shape (n,)."""
    x, y = (np.roll(corners, -1, axis=0) - corners).T
    before_x, before_y = np.roll(x, 1), np.roll(y, 1)
    return np.arctan2(before_x * y - before_y * x, before_x * x + before_y * y)


@dataclass
class TerrainParameters(Parameters):
    """What the controller knows of the ground, and how wrong that is."""

    source: Annotated[str, one_of(("scene", "file", "felt"))] = "felt"
    """`scene`: patches of the scene near the robot; `file`: those of a file; `felt`: nothing but
    what feet feel."""
    file: NameOrPath | None = None
    """Of patches (YAML) or of a grid of heights (.npz)."""
    noise: Annotated[NotNegative, Unit("m")] = 0.0
    """Each patch is moved by up to so much along x, y and z."""
    offset: Annotated[Triple, Unit("m")] = field(default_factory=lambda: [0.0, 0.0, 0.0])
    """By which all of them are moved."""
    error: Annotated[NotNegative, Unit("m")] = 0.0
    """Of edges and heights, as it is told to the controller."""
    range: Annotated[Positive, Unit("m", 100.0)] = 3.0
    """So far from the robot patches are known."""
    delay: Annotated[NotNegative, Unit("s")] = 0.0
    """Of what is known of where the robot is."""
    known: Annotated[list[Annotated[Pair, Unit("s", LONGEST)]], Strict(), Len(0, 100)] = field(
        default_factory=list
    )
    """From when to when the ground is known, and else felt; none: always."""

    @together
    def _is_known_for_a_while(self) -> None:
        for k, (begin, end) in enumerate(self.known):
            if begin >= end:
                raise misfit(f"known[{k}]", [begin, end], "must begin before it ends")

    def is_known(self, time: float) -> bool:
        """Return whether there is a map at a time [s]."""
        return not self.known or any(begin <= time < end for begin, end in self.known)

    @together
    def _has_its_file(self) -> None:
        if (self.source == "file") != (self.file is not None):
            raise misfit("file", self.file, "must be given where `source` is file, and only there")
