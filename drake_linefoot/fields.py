"""What a field of a scenario, scene, robot or sweep may hold, declared beside it.

    swing_height: Annotated[Positive, Unit("m")] = 0.06
    \"\"\"Apex of the swing foot.\"\"\"

`drake_linefoot.checks` holds values against such declarations; tables and plots take units from
them (`unit_of`).
"""

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, is_dataclass
from functools import cache
from typing import Annotated, Any, get_args, get_origin, get_type_hints

import numpy as np
from annotated_types import Ge, Gt, Le, Len, Lt
from pydantic import (
    AfterValidator,
    AllowInfNan,
    BeforeValidator,
    GetCoreSchemaHandler,
    Strict,
    ValidationInfo,
    WrapValidator,
    model_validator,
)
from pydantic_core import PydanticCustomError, core_schema

RENAMED = {  # fields of scenarios by what they were called before
    "hurried_steps": "recovery_steps",
    "closing_tolerance": "final_step_tolerance",
    "stop_margin": "joint_limit_margin",
    "stop_rate": "joint_limit_rate",
}
NO_UNIT = "-"
MOST = {  # size of numbers by their unit, where nothing smaller is declared
    NO_UNIT: 1e3,
    **{"s": 10.0, "m": 10.0, "rad": 100.0, "kg": 1e3, "N": 1e5, "N m": 1e4, "N s": 1e4},
    **{"m/s": 50.0, "rad/s": 1e3, "m/s^2": 1e5, "rad/s^2": 1e5, "1/s": 1e5, "s/m": 1e4},
}
MOST_OTHERS = 1e9  # stiffness, weights
LEAST = 1e-12  # of a positive number
MISFIT = "misfit"
ALONE = "alone"  # context in which fields need not fit each other
_LARGEST_BITS = 63  # of a whole number
_WHOLE = 1e-6  # [-] so far from a whole number of steps


@dataclass(frozen=True)
class Unit:
    """The unit of a number, or of every number of a list, and how large these can sensibly be.

    A bound with a reason of its own is declared beside it; this one keeps numbers out that no
    robot, no ground and no run can have, and which end in overflow or without end.
    """

    name: str
    most: float | None = None
    """Largest size; None for that of `MOST`."""

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> core_schema.CoreSchema:
        """Check the size of what the type itself has accepted."""
        return core_schema.no_info_after_validator_function(self._bounded, handler(source))

    def _bounded(self, value: Any) -> Any:
        most = MOST.get(self.name, MOST_OTHERS) if self.most is None else self.most
        inner = list(value.values()) if isinstance(value, dict) else value
        if np.abs(inner).max(initial=0.0) > most:
            raise ValueError(f"must be at most {most:g} {self.name} in size".replace(" - ", " "))
        return value


@dataclass(frozen=True)
class Size:
    """What else a default goes by, besides its unit: a ratio of `robot.scaling.ratios`."""

    ratio: str


@dataclass(frozen=True)
class Fixed:
    """A number that a block is built with; others can be changed in its context."""


class ScaledDefault(float):
    """A default for the MIT Humanoid, which another robot takes in its own size.

    A number with the unit of its field, until `drake_linefoot.robot.scaling.scaled` makes it that
    of a robot; a number that a file or a caller gives is of this type no more.
    """

    __slots__ = ()


def _as_it_is(value: object, validate: Callable[[object], float]) -> float:
    """Check a number; a default stays what it is."""
    return value if isinstance(value, ScaledDefault) else validate(value)


def misfit(entry: str, value: object, allowed: str) -> PydanticCustomError:
    """Return the error of a field that does not fit another one, for a rule to raise.

    Args:
        entry: dotted path of the field inside what is validated.
        value: of the field.
        allowed: what would have been accepted, in words.
    """
    return PydanticCustomError(
        MISFIT, "{allowed}", {"entry": entry, "value": value, "allowed": allowed}
    )


def together(rule: Callable[[Any], None]) -> Any:
    """Declare a rule that fields of a dataclass keep together; it raises a `misfit`.

    `check(..., together=False)` leaves it out.
    """

    def check(self: Any, info: ValidationInfo) -> Any:
        if info.context != ALONE:
            rule(self)
        return self

    return model_validator(mode="after")(check)


def one_of(choices: Collection[str]) -> BeforeValidator:
    """Return the declaration of a text that must be one of a few, as of when it is checked."""

    def check(value: object) -> object:
        if not (isinstance(value, str) and value in choices):
            raise ValueError(f"must be one of {list(choices)}")
        return value

    return BeforeValidator(check)


def _named(most: int) -> AfterValidator:
    """Return the declaration of a text of at most so many characters on one line."""

    def check(text: str) -> str:
        if not (text and text.isprintable() and len(text) <= most):
            raise ValueError(f"must be a name, on one line, of at most {most} characters")
        return text

    return AfterValidator(check)


def _line(most: int) -> AfterValidator:
    """Return the declaration of a text of at most so many characters on one line, or of none."""

    def check(text: str) -> str:
        if not (text.isprintable() and len(text) <= most):
            raise ValueError(f"must be one line of at most {most} characters that can be printed")
        return text

    return AfterValidator(check)


Number = Annotated[float, Strict(), AllowInfNan(False), WrapValidator(_as_it_is)]
Positive = Annotated[Number, Gt(0), Ge(LEAST)]
Share = Annotated[Positive, Unit(NO_UNIT)]
NotNegative = Annotated[Number, Ge(0)]
Fraction = Annotated[Number, Ge(0), Le(1)]
TickOrMore = Annotated[Number, Ge(0.001), Unit("s")]  # a time of at least the shortest tick
Whole = Annotated[int, Strict(), Gt(-(2**_LARGEST_BITS)), Lt(2**_LARGEST_BITS)]
Pair = Annotated[list[Number], Strict(), Len(2, 2)]
Triple = Annotated[list[Number], Strict(), Len(3, 3)]
Flag = Annotated[bool, Strict()]
Name = Annotated[str, Strict(), _named(100)]
Line = Annotated[str, Strict(), _line(1000)]
NameOrPath = Annotated[str, Strict(), _named(1000)]


def declared_at(kind: Any, path: Sequence[str | int]) -> tuple[Any, tuple[Any, ...]]:
    """Return the type of a place inside a dataclass, and what else is declared of it.

    Args:
        kind: the dataclass.
        path: names of fields and indices of lists, from the outermost.
    """
    notes: tuple[Any, ...] = ()
    for part in path:
        inner = get_args(kind)
        if is_dataclass(kind):
            kind = _declarations(kind).get(str(part))  # type: ignore[arg-type]  # it is a class
        elif get_origin(kind) is tuple and isinstance(part, int):
            kind = inner[min(part, len(inner) - 1)]
        else:
            kind = inner[-1] if inner else None  # of a list or a mapping
        if type(None) in get_args(kind):
            kind = next(option for option in get_args(kind) if option is not type(None))
        kind, *more = get_args(kind) if get_origin(kind) is Annotated else (kind,)
        units = [note for note in notes if isinstance(note, Unit) and isinstance(part, int)]
        notes = (*units, *more)  # a list's unit is that of its items
    return kind, notes


def tunable(kind: type[Any]) -> tuple[str, ...]:
    """Return the fields of a dataclass that a context can have another value of.

    Those are its floats, its lists of a fixed number of floats and dataclasses that have such.
    What is a choice (a text, a flag, None or a number), counts or is declared `Fixed` is not.
    """
    return _tunable(kind)  # type: ignore[arg-type]  # a class is hashable


@cache
def _tunable(kind: Any) -> tuple[str, ...]:
    names = []
    for name, hint in _declarations(kind).items():
        inner, notes = declared_at(kind, [name])
        is_list = any(isinstance(n, Len) and n.min_length == n.max_length for n in notes)
        number = declared_at(kind, [name, 0])[0] if is_list else inner
        chosen = type(None) in get_args(hint) or any(isinstance(n, Fixed) for n in notes)
        if not chosen and (number is float or (is_dataclass(inner) and _tunable(inner))):  # type: ignore[arg-type]
            names.append(name)
    return tuple(names)


def unit_of(kind: Any, path: Sequence[str | int]) -> str:
    """Return the unit of a place inside a dataclass; "-" where none is declared."""
    units = [note.name for note in declared_at(kind, path)[1] if isinstance(note, Unit)]
    return units[-1] if units else NO_UNIT


@cache
def _declarations(kind: type) -> dict[str, Any]:
    return get_type_hints(kind, include_extras=True)


def is_multiple(value: float, step: float) -> bool:
    """Return whether a value is a whole number of steps, but for what arithmetic leaves."""
    return abs(value / step - round(value / step)) <= _WHOLE
