"""What dataclasses of parameters share: mappings for their parts, and help that can be read.

Scenario(mpc={"model": "srbm", "weights": {"force": 1e-5}})
help(GaitParameters)  # every field with its unit, its default and what it means
"""

import ast
import inspect
import re
from collections.abc import Callable, Iterable, Mapping
from copy import copy
from dataclasses import MISSING, Field, fields, is_dataclass
from functools import cache
from itertools import islice, pairwise
from pathlib import Path
from typing import Any, TypeVar, get_type_hints

from drake_linefoot.checks import check, plain
from drake_linefoot.fields import NO_UNIT, declared_at, tunable, unit_of

Kind = TypeVar("Kind")


class _OfClass:
    """An attribute of a class that is made when somebody asks for it."""

    def __init__(self, make: Callable[[type], Any]) -> None:
        """Keep what makes it of the class."""
        self._make = cache(make)

    def __get__(self, instance: object, owner: type) -> Any:
        """Return it."""
        return self._make(owner)


class Parameters:
    """Base of a dataclass of parameters.

    A part of it, or of a list in it, may be given as a mapping, as files have them. Its signature
    has plain types; its docstring ends with every field.
    """

    def __init_subclass__(cls) -> None:
        """Let signature and docstring be made when they are asked for."""
        text = inspect.cleandoc(cls.__dict__.get("__doc__") or "")
        cls.__signature__ = _OfClass(_signature)  # type: ignore[attr-defined]
        cls.__doc__ = _OfClass(lambda kind: f"{text}\n\nFields:\n{_lines(kind)}")  # type: ignore[assignment]

    def __post_init__(self) -> None:
        """Make parts that are given as mappings what they are declared as.

        Raises:
            ScenarioError: they have unknown fields or values that are not allowed.
        """
        name, kind = type(self).__name__, type(self)

        def made(value: Any, at: list[str | int]) -> Any:
            part = declared_at(kind, at)[0] if isinstance(value, Mapping) else None
            if not is_dataclass(part):
                return value
            shown = "".join(f"[{i}]" if isinstance(i, int) else i for i in at)
            return check(plain(value), part, name, [shown], together=False)  # type: ignore[arg-type]

        for field, value in vars(self).items():
            if isinstance(value, list | tuple) and any(isinstance(v, Mapping) for v in value):
                setattr(self, field, [made(v, [field, i]) for i, v in enumerate(value)])
            elif isinstance(value, Mapping):
                setattr(self, field, made(value, [field]))


def numbers_of(parameters: Any, at: str = "") -> dict[str, float]:
    """Return the numbers of a dataclass that are `tunable`, as "weights.position[0]": 0.0.

    Args:
        parameters: the dataclass.
        at: what stands before the names.
    """
    found: dict[str, float] = {}
    for name in tunable(type(parameters)):
        value, path = getattr(parameters, name), at + name
        if is_dataclass(value):
            found |= numbers_of(value, f"{path}.")
        elif isinstance(value, float | int):
            found[path] = float(value)
        else:
            found |= {f"{path}[{i}]": float(number) for i, number in enumerate(value)}
    return found


def with_numbers(parameters: Kind, numbers: Iterable[float]) -> Kind:
    """Return a copy of a dataclass with other numbers, in the order of `numbers_of`."""
    left, made = iter(numbers), copy(parameters)
    for name in tunable(type(parameters)):
        value: Any = getattr(parameters, name)
        if is_dataclass(value):
            value = with_numbers(value, left)
        elif isinstance(value, float | int):
            value = float(next(left))
        else:
            value = [float(number) for number in islice(left, len(value))]
        setattr(made, name, value)
    return made


class _Shown:
    """A type or a default as a signature shows it."""

    def __init__(self, text: str) -> None:
        """Keep the text."""
        self.text = text

    def __repr__(self) -> str:
        """Return the text."""
        return self.text


def _default(field: Field[Any]) -> Any:
    """Return the default of a field as it is shown; `Parameter.empty` without."""
    if field.default_factory is not MISSING:
        value = field.default_factory()
        return _Shown(f"{type(value).__name__}()") if is_dataclass(value) else value
    return inspect.Parameter.empty if field.default is MISSING else field.default


def _type(hint: Any) -> _Shown:
    """Return a type as it is shown, without the modules of its classes."""
    return _Shown(re.sub(r"(\w+\.)+", "", inspect.formatannotation(hint)))


def _signature(kind: Any) -> inspect.Signature:
    """Return the signature of a dataclass without what its fields must satisfy."""
    hints, place = get_type_hints(kind), inspect.Parameter.POSITIONAL_OR_KEYWORD
    return inspect.Signature(
        [
            inspect.Parameter(f.name, place, default=_default(f), annotation=_type(hints[f.name]))
            for f in fields(kind)
        ]
    )


def _lines(kind: Any) -> str:
    """Return a line for each field of a dataclass: unit, default, what it means."""
    said, lines = _said(kind), []
    for field in fields(kind):
        unit, default = unit_of(kind, [field.name]), _default(field)
        unit = "" if unit == NO_UNIT else f" [{unit}]"
        value = "" if default is inspect.Parameter.empty else f" = {default!r}"
        text = said.get(field.name, "")
        lines.append(f"    {field.name}{unit}{value}" + (f": {text}" if text else ""))
    return "\n".join(lines)


def _said(kind: type) -> dict[str, str]:
    """Return the texts below the fields of a class in its source; none without the source."""
    try:
        source = Path(inspect.getfile(kind)).read_text(encoding="utf-8")
    except (OSError, TypeError):
        return {}
    classes = [n for n in ast.parse(source).body if isinstance(n, ast.ClassDef)]
    body = next((node.body for node in classes if node.name == kind.__name__), [])
    found = {}
    for node, after in pairwise(body):
        match node, after:
            case ast.AnnAssign(target=ast.Name(id=name)), ast.Expr(value=ast.Constant(value=text)):
                if isinstance(text, str):
                    found[name] = " ".join(text.split())
    return found
