"""What a recorded channel is: a part of a signal, or what the recorder makes of one."""

from collections.abc import Callable
from functools import lru_cache
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from drake_linefoot.axes import PLACE
from drake_linefoot.lab.plants.contact_forces import FootContacts
from drake_linefoot.lab.simulation.plan_samples import SampledPlan
from drake_linefoot.layout import Axis, Part, parts_of
from drake_linefoot.signals import SIGNALS, SwingTarget
from drake_linefoot.statuses import Mode, Solved
from drake_linefoot.types import Array

MODES: Final = tuple(mode.name.lower() for mode in Mode)
LIMITS: Final = ("", "beyond its limits", "slope", "uneven ground", "feet slide")  # see `Limit`
FORESEEN: Final = tuple("012")  # footholds of the plan that are recorded
HORIZON: Final = tuple("01234567")  # places of the CoM over the horizon that are recorded

RECORDED: Final = SIGNALS | {"foot_contacts": FootContacts, "plan_sample": SampledPlan}
_PLACE = SwingTarget._fields.index("p_WC")


class Channel(Part):
    """One sample of a recorded array, and where the recorder reads it.

    Attributes:
        signal: the recorder's input port, `time`, or `plan_sample`, which it computes of `plan`.
            It is the first part of `source`, as in `report.wrench`.
        attribute: part of that signal, the rest of `source`; empty for the signal itself.
        convert: makes of the values of n samples what is recorded; None when it is those.
    """

    def __init__(
        self,
        source: str,
        units: str | tuple[str, ...],
        *axes: Axis,
        groups: tuple[int, ...] = (),
        is_whole: bool = False,
        convert: Callable[[Any], Array] | None = None,
    ) -> None:
        """Keep them; units, axes, groups and whether all are whole as of a `Part`."""
        super().__init__("", units, *axes, groups=groups, is_whole=is_whole)
        self.signal, _, self.attribute = source.partition(".")
        self.convert = convert

    def read(self, signal: NDArray[np.void]) -> Array:
        """Return what is recorded of a signal in n samples, given as records of its layout."""
        value: Any = signal[self.attribute] if self.attribute else signal
        read: Array = value if self.convert is None else self.convert(value)
        return read


def part(source: str, convert: Callable[[Any], Array] | None = None) -> Channel:
    """Return the channel of a part of a signal, with its units and axes."""
    signal, _, name = source.partition(".")
    of = parts_of(RECORDED[signal])[name]
    return Channel(
        source, of.units, *of.axes, groups=of.groups, is_whole=of.is_whole, convert=convert
    )


# --- what is recorded of n samples ---------------------------------------------------------------


def success(status: Array) -> Array:
    """Return 1 where a program was solved, else 0; see `Solved`."""
    return (status < Solved.ITERATION_LIMIT).astype(float)


def mode(targets: NDArray[np.void]) -> Array:
    """Return the `Mode` of n samples, shape (n,)."""
    standing, waits = (
        targets["contact"].sum(axis=1),
        targets["touchdown"] > targets["time"][:, None],
    )
    both = np.where(waits.any(axis=1), float(Mode.SHIFT), float(Mode.DOUBLE))
    both[targets["queued"] == 0.0] = Mode.STAND
    return np.select([standing == 2.0, standing == 1.0], [both, Mode.SWING], Mode.FLIGHT)


def swing_position(targets: NDArray[np.void]) -> Array:
    """Return where swing feet should be [m], NaN for one that stands, shape (n, 2, 3)."""
    return np.where(targets["swings"][..., None] > 0.0, targets["swing"][:, :, _PLACE], np.nan)


def foothold(targets: NDArray[np.void]) -> Array:
    """Return where they will land, NaN for one that stands, shape (n, 2, 4)."""
    return np.where(targets["swings"][..., None] > 0.0, targets["foothold"], np.nan)


def nis(estimates: NDArray[np.void]) -> Array:
    """Return the squared Mahalanobis distances of the innovations, NaN where none, (n, 4)."""
    return np.where(estimates["measured"] > 0.0, estimates["nis"], np.nan)


def first_places(plans: NDArray[np.void]) -> Array:
    """Return the first footholds that are recorded, NaN where there are fewer, (n, 3, 4)."""
    places, there = np.full((len(plans), len(FORESEEN), len(PLACE)), np.nan), plans["footholds"]
    count = min(there.shape[1], len(FORESEEN))
    known = np.arange(count) < plans["coming"][:, None]
    places[:, :count] = np.where(known[..., None], there[:, :count], np.nan)
    return places


def mean_velocity(plans: NDArray[np.void]) -> Array:
    """Return the mean velocity of the centre of mass over the horizon [m/s], shape (n, 3)."""
    states, times = plans["states"], plans["times"]
    way: Array = states[:, -1, :3] - states[:, 0, :3]
    return way / (times[:, -1:] - times[:, :1])


def com_ahead(plans: NDArray[np.void]) -> Array:
    """Return where plans predict the centre of mass, evenly over their horizons [m].

    Returns:
        From the first knot to the last, shape (n, 8, 3).
    """
    states: Array = plans["states"]
    return states[:, _evenly(states.shape[1]), :3]


@lru_cache
def _evenly(count: int) -> NDArray[np.int64]:
    """Return which of `count` knots are shown, from the first to the last."""
    return np.round(np.linspace(0.0, count - 1.0, len(HORIZON))).astype(int)
