"""Parameters in the size of a robot: what walks one walks another that is built alike.

Two robots of the same shape move alike when lengths go by the height of the CoM, times by that of
its pendulum, sqrt(h / g), and forces by the weight. So the unit of a number says how it goes from
the robot that it was found on to another.
"""

import ast
from collections.abc import Callable, Mapping
from copy import copy
from dataclasses import is_dataclass
from typing import Any, TypeVar

from drake_linefoot.fields import OfRobot, unit_of
from drake_linefoot.robot.humanoid import Humanoid

MASS, COM_HEIGHT = 24.86855, 0.6522556253  # [kg], [m] of the MIT Humanoid, whose the defaults are
_SAME = 1e-6  # [-] a robot that differs by less is that one
_TIMES = 0.002  # [s] times are multiples of it, so that phases end at a tick
_OPERATORS: Mapping[type, Callable[[float, float], float]] = {
    ast.Mult: lambda a, b: a * b,
    ast.Div: lambda a, b: a / b,
    ast.Pow: lambda a, b: a**b,
}
Kind = TypeVar("Kind")


def sized(parameters: Kind, humanoid: Humanoid) -> Kind:
    """Return parameters with the defaults in the size of a robot.

    Args:
        parameters: a dataclass, or a list of such; it stays as it is. Numbers of type `OfRobot`
            are replaced, in the dataclasses inside as well.
        humanoid: the robot.

    Returns:
        A copy without a number of that type; what was given is as it was.
    """
    return _sized(parameters, base_units(humanoid.mass, humanoid.com_height), "-")


def base_units(mass: float, com_height: float) -> dict[str, float]:
    """Return what a metre, a second, a kilogram and a newton of the MIT Humanoid are to a robot.

    Args:
        mass: of the robot [kg].
        com_height: of its CoM in the nominal posture [m].
    """
    m, kg = (_ratio(value, own) for value, own in ((com_height, COM_HEIGHT), (mass, MASS)))
    return {"m": m, "s": m**0.5, "kg": kg, "N": kg, "rad": 1.0}  # g is the same to both


def unit_value(unit: str, base: Mapping[str, float]) -> float:
    """Return the product of powers that a unit is, such as "1/(kg m^2/s)^2".

    Args:
        unit: symbols, with a space for a product; "-" for a pure number.
        base: value of each symbol.

    Raises:
        KeyError: a symbol has no value.
    """
    if unit == "-":
        return 1.0
    return _value(ast.parse(unit.replace("^", "**").replace(" ", "*"), mode="eval").body, base)


def _value(node: ast.expr, base: Mapping[str, float]) -> float:
    if isinstance(node, ast.BinOp):
        return _OPERATORS[type(node.op)](_value(node.left, base), _value(node.right, base))
    return base[node.id] if isinstance(node, ast.Name) else float(ast.literal_eval(node))


def _ratio(value: float, own: float) -> float:
    return 1.0 if abs(value / own - 1.0) < _SAME else value / own


def _sized(value: Any, base: Mapping[str, float], unit: str) -> Any:
    if isinstance(value, list):
        return [_sized(item, base, unit) for item in value]
    if isinstance(value, OfRobot):
        factor, number = unit_value(unit, base), float(value)
        if unit == "s" and factor != 1.0:
            return max(round(factor * number / _TIMES), 1) * _TIMES
        return factor * number
    if not is_dataclass(value):
        return value
    made = copy(value)
    for name, inner in vars(value).items():
        setattr(made, name, _sized(inner, base, unit_of(type(value), [name])))
    return made
