"""How the parts of a signal lie in one flat vector: declared once, opened by name.

A signal is a NamedTuple whose fields are `Part`s. On a port it travels as a vector; `Layout` opens
that in Python without a copy, and functions made by `opener` and `filler` in compiled code.
"""

from collections.abc import Callable, Mapping
from functools import cache, lru_cache
from typing import Any, Generic, NamedTuple, TypeVar, get_type_hints

import numba
import numpy as np

from drake_linefoot.types import Array

Axis = tuple[str, ...] | str | int
Sizes = Mapping[str, int]

_S = TypeVar("_S", bound=tuple[Any, ...])


class Part:
    """What one part of a signal is.

    Attributes:
        meaning: in words.
        units: of the numbers; with several, each belongs to one group of entries along the last
            axis, and "-" is none.
        axes: per axis the names of its entries, how many there are, or an expression of sizes that
            says it, as "nv" or "knots + 1".
        groups: how many entries along the last axis have the first unit, the second and so on, the
            last one taking the rest; empty: each unit has one entry.
        frame: the numbers are expressed in; empty for none.
        is_whole: whether all its numbers are whole: flags, counts, an index.
    """

    def __init__(
        self,
        meaning: str,
        units: str | tuple[str, ...],
        *axes: Axis,
        groups: tuple[int, ...] = (),
        frame: str = "",
        is_whole: bool = False,
    ) -> None:
        """Keep them."""
        self.meaning, self.axes, self.frame = meaning, axes, frame
        self.units = (units,) if isinstance(units, str) else units
        self.groups, self.is_whole = groups, is_whole

    @property
    def unit(self) -> str:
        """All its units, as one text."""
        return ", ".join(self.units)

    def shape(self, sizes: Sizes) -> tuple[int, ...]:
        """Return how many entries each axis has."""
        return tuple(_length(axis, sizes) for axis in self.axes)

    def names(self, named: Mapping[str, tuple[str, ...]]) -> list[tuple[str, ...]]:
        """Return the names of the entries along each axis; `named` has those of "nq", "na"..."""
        return [_entries(axis, named) for axis in self.axes]

    def entry_units(self, length: int) -> list[str]:
        """Return the unit of each of the `length` entries along the last axis."""
        *first, last = self.units
        counts = self.groups or (1,) * len(first)
        each = [unit for unit, n in zip(first, counts, strict=False) for _ in range(n)]
        return each + [last] * (length - len(each))


def parts_of(signal: type[Any]) -> Mapping[str, Part]:
    """Return the parts of a signal by name, in their order."""
    return _parts_of(signal)  # type: ignore[arg-type]  # a class can be hashed


@cache
def _parts_of(signal: type[Any]) -> Mapping[str, Part]:
    hints = get_type_hints(signal, include_extras=True)
    return {name: hint.__metadata__[0] for name, hint in hints.items()}


class Layout(Generic[_S]):
    """The vector of a signal for given sizes.

    Attributes:
        signal: the NamedTuple.
        sizes: by name.
        parts: see `parts_of`.
        dtype: of the vector as a record of numpy, with a field for each part.
        size: of the vector.
    """

    def __init__(self, signal: type[_S], sizes: Sizes) -> None:
        """Lay the parts out one behind the other."""
        self.signal, self.sizes, self.parts = signal, dict(sizes), parts_of(signal)
        formats = [(name, np.float64, part.shape(sizes)) for name, part in self.parts.items()]
        self.dtype = np.dtype(formats)
        self.size = self.dtype.itemsize // 8
        self._make: Callable[[tuple[Any, ...]], _S] = signal._make  # type: ignore[attr-defined]

    def open(self, vector: Array) -> _S:
        """Return the signal that a vector holds: arrays are views, single numbers are floats."""
        return self._make(np.ndarray((), self.dtype, vector).item())

    def vector(self, signal: _S) -> Array:
        """Return a signal as a vector of its own.

        Raises:
            ValueError: a part has another shape.
        """
        flat = np.empty(self.size)
        record = np.ndarray((), self.dtype, flat)
        for part, value in zip((record[name] for name in self.parts), signal, strict=True):
            if np.shape(value) != part.shape:
                raise ValueError(f"of shape {np.shape(value)}: must have {part.shape}")
            part[...] = value
        return flat

    def place(self, name: str) -> slice:
        """Return where a part lies in the vector."""
        kind, offset = self.dtype.fields[name][:2]  # type: ignore[index]
        return slice(offset // 8, (offset + kind.itemsize) // 8)

    def name_of(self, index: int) -> str:
        """Return what a number of the vector is, as "wrench[1, 2]"."""
        for name, part in self.parts.items():
            there, shape = self.place(name), part.shape(self.sizes)
            if there.start <= index < there.stop:
                at = np.unravel_index(index - there.start, shape) if shape else ()
                return name + (f"[{', '.join(map(str, at))}]" if shape else "")
        raise IndexError(f"{index} of {self.size}")


def record_of(kind: type[Any]) -> np.dtype[Any]:
    """Return the dtype of a record of numpy that a class declares, for compiled code to write.

    Args:
        kind: its annotations are `Part`s of fixed sizes, numbers, or classes like itself; what is
            none of these is left out.
    """
    fields: list[tuple[Any, ...]] = []
    for name, hint in get_type_hints(kind, include_extras=True).items():
        parts = [note for note in getattr(hint, "__metadata__", ()) if isinstance(note, Part)]
        if parts:
            fields.append((name, np.float64, parts[0].shape({})))
        elif issubclass(number := getattr(hint, "__origin__", hint), int | float):
            fields.append((name, np.float64))
        elif number is not str:
            fields.append((name, record_of(number)))
    return np.dtype((np.record, fields))


def flat(signal: tuple[Any, ...]) -> Array:
    """Return the vector of a signal, whatever the sizes: its parts one behind the other."""
    return np.concatenate([np.ravel(part) for part in signal], dtype=np.float64)


def _length(axis: Axis, sizes: Sizes) -> int:
    if isinstance(axis, int):
        return axis
    return len(axis) if isinstance(axis, tuple) else int(_evaluated(axis, tuple(sizes.items())))


@lru_cache
def _evaluated(expression: str, sizes: tuple[tuple[str, int], ...]) -> int:
    length: int = eval(expression, {"__builtins__": {}}, dict(sizes))
    return length


def _entries(axis: Axis, named: Mapping[str, tuple[str, ...]]) -> tuple[str, ...]:
    if isinstance(axis, tuple):
        return axis
    if isinstance(axis, str) and axis in named:
        return named[axis]
    sizes = {name: len(entries) for name, entries in named.items()}
    return tuple(map(str, range(_length(axis, sizes))))


class _Place(NamedTuple):
    """Where a part begins and ends in a vector, and its shape, as text of Python."""

    name: str
    begin: str
    end: str
    shape: str  # empty for a single number


def _places(signal: type[Any]) -> list[_Place]:
    places, begin = [], "0"
    for name, part in parts_of(signal).items():
        lengths = [
            f"({axis})" if isinstance(axis, str) else str(_length(axis, {})) for axis in part.axes
        ]
        end = f"{begin} + {' * '.join(lengths) or '1'}"
        places.append(_Place(name, begin, end, ", ".join(lengths)))
        begin = f"{name}_end"
    return places


def _compiled(signal: type[Any], sizes: tuple[str, ...], head: str, lines: list[str]) -> Any:
    """Return a function made of its lines, for compiled code to call.

    Its name is its own, and that of its module the signal's: by these the linker knows it where
    machine code of several processes comes together.
    """
    head = f"{head}_{signal.__name__}"
    ends = [f"{p.name}_end = {p.end}" for p in _places(signal)]
    text = "\n    ".join([f"def {head}({', '.join(('flat', *sizes))}):", *ends, *lines])
    space = {"Signal": signal, "np": np, "__name__": signal.__module__}
    exec(compile(text, f"<{head}>", "exec"), space)
    return numba.njit(error_model="numpy", no_cfunc_wrapper=True)(space[head])


def opener(signal: type[_S], *sizes: str) -> Callable[..., _S]:
    """Return a compiled function that opens a vector as `Layout.open` does.

    Args:
        signal: the NamedTuple.
        sizes: names of the sizes that its shapes are made of: arguments behind the vector.
    """
    opened = [
        f"flat[{p.begin}:{p.name}_end].reshape(({p.shape},))" if p.shape else f"flat[{p.begin}]"
        for p in _places(signal)
    ]
    function: Callable[..., _S] = _compiled(
        signal, sizes, "opened", [f"return Signal({', '.join(opened)})"]
    )
    return function


def filler(signal: type[_S], *sizes: str) -> Callable[..., None]:
    """Return a compiled function that writes a signal into a vector.

    Args:
        signal: the NamedTuple.
        sizes: names of the sizes that its shapes are made of: arguments behind vector and signal.
    """
    lines = [
        f"flat[{p.begin}:{p.name}_end].reshape(({p.shape},))[:] = signal.{p.name}"
        if p.shape
        else f"flat[{p.begin}] = signal.{p.name}"
        for p in _places(signal)
    ]
    function: Callable[..., None] = _compiled(signal, ("signal", *sizes), "filled", lines)
    return function
