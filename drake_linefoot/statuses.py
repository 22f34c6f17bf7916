"""Numbers with names that travel in signals."""

from enum import IntEnum


class Mode(IntEnum):
    """What the feet are doing, in a word for people; the controller knows contacts and a queue."""

    STAND = 0  # both feet, no step is queued: the DCM is captured between them
    SHIFT = 1  # both feet, the DCM is taken to where the first step can start
    SWING = 2  # one foot stands, the other is in the air
    DOUBLE = 3  # both feet, the weight goes over to one
    FLIGHT = 4  # both are in the air


class Limit(IntEnum):
    """Why the gait follows another command than the one that was given."""

    FREE = 0  # it does not
    CLIPPED = 1  # outside the limits of commands
    SLOPED = 2  # a slope is climbed more slowly
    UNEVEN = 3  # so is uneven ground walked
    SLIPPERY = 4  # and where feet slide


class Solved(IntEnum):
    """How a quadratic program was solved; from `ITERATION_LIMIT` on it was not."""

    GIVEN = 0  # there was none: a plan to begin with
    NO_CONTACT = 1  # no foot stands: there is nothing to solve
    UNCONSTRAINED = 2  # exactly, no row of the cones is active
    ACTIVE_SET = 3  # exactly, with some that are
    SOLVER = 4  # to the tolerance of the solver
    ITERATION_LIMIT = 5
    INFEASIBLE = 6
    NOT_FINITE = 7
    ILL_POSED = 8
    FAILED = 9  # for another reason
    LATE = 10  # in a process of its own, which has not answered in time

    @property
    def success(self) -> bool:
        """Whether there is a solution."""
        return self < Solved.ITERATION_LIMIT

    @property
    def words(self) -> str:
        """The same for people."""
        return self.name.lower().replace("_", " ")
