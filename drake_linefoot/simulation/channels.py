"""What a recorded channel is: units, shape, the name of every number, and where it is read."""

from array import array
from collections.abc import Callable, Mapping
from functools import lru_cache
from itertools import product
from operator import attrgetter
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from drake_linefoot.signals import CentroidalPlan, SwingTarget
from drake_linefoot.types import Array

FEET: Final = ("left", "right")
ENDS: Final = ("heel", "toe")
XYZ: Final = ("x", "y", "z")
RPY: Final = ("roll", "pitch", "yaw")
PLACE: Final = ("x", "y", "z", "yaw")
COMMAND: Final = ("v_x", "v_y", "turn_rate", "walk")
WRENCH: Final = ("f_x", "f_y", "f_z", "tau_y", "tau_z")
BASE: Final = ("angular_x", "angular_y", "angular_z", "x", "y", "z")
POSE: Final = ("w", "qx", "qy", "qz", *XYZ)
SIGMA: Final = (*RPY, "v_x", "v_y", "v_z", *XYZ)
CONTACTS: Final = tuple(f"{foot}_{end}" for foot in FEET for end in ENDS)
COMMAND_UNITS: Final = ("m/s", "m/s", "rad/s")
PLACE_UNITS: Final = ("m", "m", "m", "rad")
MODES: Final = ("stand", "shift", "swing", "double")
LIMITS: Final = ("", "beyond its limits", "slope", "uneven ground", "feet slide")  # of a command
FORESEEN: Final = tuple("012")  # footholds of the plan that are recorded
HORIZON: Final = tuple("01234567")  # places of the CoM over the horizon that are recorded

_NOWHERE: Final = np.full(3, np.nan)

Axis = tuple[str, ...] | str


class Channel:
    """Units and shape of one sample of a recorded array, and where the recorder reads it.

    Attributes:
        units: of the numbers; with several, each belongs to one group of entries along the last
            axis, and "-" is none.
        axes: per axis the names of its entries, or the name of how many there are when that
            depends on the robot ("nq").
        signal: the recorder's input port, or what it computes of one; empty without. It is the
            first part of `source`, as in `report.wrench`.
        attribute: of that signal, the rest of `source`, with dots where it is one of an
            attribute; empty for the signal itself.
        convert: makes of the attribute what is recorded; None when it is that.
    """

    def __init__(
        self,
        source: str,
        units: str | tuple[str, ...],
        *axes: Axis,
        groups: tuple[int, ...] = (),
        convert: Callable[[Any], Any] | None = None,
    ) -> None:
        """Keep them.

        `groups` says how many entries along the last axis have the first unit, the second and so
        on, the last one taking the rest; without, each unit has one entry.
        """
        self.units = (units,) if isinstance(units, str) else units
        self.axes, self._groups = axes, groups or (1,) * len(self.units)
        self.signal, _, self.attribute = source.partition(".")
        self.convert = convert

    @property
    def unit(self) -> str:
        """All its units, as one text."""
        return ", ".join(self.units)

    @property
    def is_whole(self) -> bool:
        """Whether all its numbers are whole: flags, counts, an index."""
        return self.units == ("-",)

    def shape(self, sizes: Mapping[str, int]) -> tuple[int, ...]:
        """Return how many entries each axis has; `sizes` has "nq", "nv" and "na"."""
        return tuple(sizes[axis] if isinstance(axis, str) else len(axis) for axis in self.axes)

    def names(self, sized: Mapping[str, tuple[str, ...]]) -> list[tuple[str, ...]]:
        """Return the names of the entries along each axis; `sized` has those of "nq", "na"..."""
        return [sized[axis] if isinstance(axis, str) else axis for axis in self.axes]

    def entry_units(self, length: int) -> list[str]:
        """Return the unit of each of the `length` entries along the last axis."""
        *first, last = self.units
        each = [
            unit for unit, count in zip(first, self._groups, strict=False) for _ in range(count)
        ]
        return each + [last] * (length - len(each))

    def read(self, signal: Any) -> Any:
        """Return what is recorded of a signal."""
        value = attrgetter(self.attribute)(signal) if self.attribute else signal
        return value if self.convert is None else self.convert(value)


# --- what is recorded of an attribute; of a tick's, a buffer of doubles ------------------------

mode: Final = {
    name: array("d", [i]).tobytes() for i, name in enumerate(MODES)
}.__getitem__  # its index
flags: Final = {
    pair: array("d", pair).tobytes() for pair in product((False, True), repeat=2)
}.__getitem__


def wrenches(source: str) -> Channel:
    """Return the channel of one wrench of each foot."""
    return Channel(source, ("N", "N m"), FEET, WRENCH, groups=(3, 2))


def position(swing: SwingTarget | None) -> Array:
    """Return where the swing foot should be [m], NaN while both feet stand, shape (3,)."""
    return _NOWHERE if swing is None else swing.p_WC


def first_places(footholds: Array) -> Array:
    """Return the first footholds that are recorded, NaN where there are fewer."""
    places = np.full((len(FORESEEN), len(PLACE)), np.nan)
    places[: len(footholds)] = footholds[: len(FORESEEN)]
    return places


def mean_velocity(plan: CentroidalPlan) -> Array:
    """Return the mean velocity of the centre of mass over the horizon [m/s], shape (3,)."""
    way: Array = plan.states[-1, :3] - plan.states[0, :3]
    return way / (plan.times[-1] - plan.times[0])


def com_ahead(plan: CentroidalPlan) -> Array:
    """Return where a plan predicts the centre of mass, evenly over its horizon [m].

    Returns:
        From the first knot to the last, shape (8, 3).
    """
    places: Array = plan.states[_evenly(len(plan.times)), :3]
    return places


@lru_cache
def _evenly(count: int) -> NDArray[np.int64]:
    """Return which of `count` knots are shown, from the first to the last."""
    return np.round(np.linspace(0.0, count - 1.0, len(HORIZON))).astype(int)
