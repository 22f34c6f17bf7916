"""What is recorded of a tick, in one row of numbers whose dtype names them.

The numbers of a tick go into one row as they come, in one call; written one by one into the
channels, each would cost a call of numpy, and kept as objects they would be long out of the
processor's caches when they are written.
"""

from array import array
from collections.abc import Callable, Iterable, Mapping
from operator import attrgetter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drake_linefoot.errors import SignalError
from drake_linefoot.simulation.channels import FEET, XYZ, Channel
from drake_linefoot.simulation.recording import CHANNELS
from drake_linefoot.types import Array

LINES = {  # the contact lines, of which the contact points follow
    "p_WC": Channel("dynamics.p_WC", "m", FEET, XYZ),
    "R_WC": Channel("dynamics.R_WC", "-", FEET, XYZ, XYZ),
}
Sizes = Mapping[str, int]  # "nq", "nv" and "na" of the robot
_Getter = Callable[[Any], tuple[Any, ...]]


def dtype_of(channels: Mapping[str, Channel], sizes: Sizes) -> np.dtype[np.void]:
    """Return the type of a row with a place for every channel."""
    return np.dtype([(name, np.float64, c.shape(sizes)) for name, c in channels.items()])


class TickLayout:
    """Reads ticks that all have the same signals into rows.

    Attributes:
        dtype: of a row; its names are those of channels, and of `LINES`.
    """

    def __init__(self, vectors: Iterable[str], signals: Mapping[str, Any], sizes: Sizes) -> None:
        """Lay out a row.

        Args:
            vectors: of a tick, by name: each has one channel of its own name.
            signals: of a tick, by name, each with several channels.
            sizes: of the robot.

        Raises:
            SignalError: an array of a signal does not hold floats of 64 bits.
        """
        every = CHANNELS | LINES
        numbers = {"time": CHANNELS["time"]}
        buffers = {name: every[name] for name in vectors}
        self._readers: list[tuple[_Getter | None, _Getter]] = []  # of its numbers, of its arrays
        for signal, value in signals.items():
            channels = {name: c for name, c in every.items() if c.signal == signal}
            plain = {name: c for name, c in channels.items() if not (c.axes or c.convert)}
            rest = {name: c for name, c in channels.items() if name not in plain}
            for name, channel in rest.items():
                values = channel.read(value)
                if isinstance(values, np.ndarray) and values.dtype != np.float64:
                    allowed = f"{name} is of {values.dtype}: must be of float64"
                    raise SignalError(f"recorder.{signal}", allowed)
            self._readers.append((_getter(plain) if plain else None, _getter(rest)))
            numbers |= plain
            buffers |= rest
        converted = [(i, c.convert) for i, c in enumerate(buffers.values())]
        self._converted = [(i, convert) for i, convert in converted if convert is not None]
        self.dtype = dtype_of(numbers | buffers, sizes)

    def row(self, time: float, vectors: Iterable[Array], signals: Iterable[Any]) -> bytes:
        """Return a tick as the bytes of a row: joining them is the fastest there is.

        Args:
            time: [s].
            vectors: of the tick, in the order of their names.
            signals: of the tick, in the order of their names.
        """
        numbers = [time]
        buffers: list[Any] = [*vectors]
        for (numbers_of, buffers_of), signal in zip(self._readers, signals, strict=True):
            if numbers_of is not None:
                numbers += numbers_of(signal)
            buffers += buffers_of(signal)
        for i, convert in self._converted:
            buffers[i] = convert(buffers[i])
        first = array("d", numbers)
        try:
            return b"".join((first, *buffers))
        except TypeError:  # one is not in the order of its rows
            return b"".join((first, *(bytes(part) for part in buffers)))


def write_ticks(ticks: NDArray[np.void], rows: NDArray[np.void], half_length: float) -> None:
    """Write ticks into their channels.

    Args:
        ticks: of one `TickLayout.dtype`, shape (n,).
        rows: of the channels, shape (n,).
        half_length: of the contact lines [m].
    """
    rows["push"] = 0.0
    for name in ticks.dtype.names or ():
        if name in CHANNELS:
            rows[name] = ticks[name]
    ends = np.array([[-half_length], [half_length]])
    middle, along = ticks["p_WC"][:, :, None], ticks["R_WC"][:, :, None, :, 0]
    rows["contact_points"] = middle + ends * along


def _getter(channels: Mapping[str, Channel]) -> _Getter:
    """Return what reads the attributes of two or more channels of a signal, as they are."""
    return attrgetter(*(channel.attribute for channel in channels.values()))
