"""Courses of a scenario: ground of pieces behind a pad, and what the controller knows of it."""

from dataclasses import dataclass, field
from typing import Annotated

from annotated_types import Ge, Le

from drake_linefoot.fields import (
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

Count = Annotated[Whole, Ge(1), Le(200)]
Length = Annotated[Positive, Unit("m", 100.0)]
Turn = Annotated[Number, Ge(-1.5), Le(1.5), Unit("rad")]


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
class TerrainParameters(Parameters):
    """What the controller knows of the ground, and how wrong that is."""

    source: Annotated[str, one_of(("scene", "felt"))] = "felt"
    """`scene`: patches of the scene near the robot; `felt`: nothing but what feet feel."""
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
