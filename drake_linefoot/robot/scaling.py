"""Parameters in the size of a robot: what walks one walks another that is built alike.

Two robots of the same shape move alike when lengths go by the height of the CoM, times by that of
its pendulum, sqrt(h / g), and forces by the weight. So the unit of a number says how it goes from
the robot that it was found on to another. Some go by what makes robots of one size unlike, see
`ratios`.
"""

import ast
import math
import operator
from collections.abc import Callable, Mapping
from copy import copy
from dataclasses import is_dataclass
from functools import cache, partial
from typing import Any, TypeVar

import numpy as np

from drake_linefoot.fields import ScaledDefault, Size, declared_at, unit_of
from drake_linefoot.robot.dynamics import robot_dynamics
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.signals import RobotDynamics
from drake_linefoot.types import Array

MASS, COM_HEIGHT = 24.86855, 0.6522556253  # [kg], [m] of the MIT Humanoid, whose the defaults are
SWING_MOMENTUM = 0.2571091091  # [-] of it, see `swing_momentum`
TORSO_INERTIA = (0.6342336756, 0.4895555600, 0.8549868215)  # [-] of it, see `torso_inertia`
_LONGEST_SWING = 1.6  # [-] of the pendulum's time; a longer one diverges too far
INSIDE = 1.02  # [-] how far within the limits of a robot
_SAME = 1e-6  # [-] a robot that differs by less is that one
_TIMES = 0.002  # [s] times are multiples of it, so that phases end at a tick
_OPERATORS: Mapping[type, Callable[[float, float], float]] = {
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.Pow: operator.pow,
}
Kind = TypeVar("Kind")
ONE = np.ones(1)


def scaled(parameters: Kind, humanoid: Humanoid) -> Kind:
    """Return parameters with the defaults in the size of a robot.

    Args:
        parameters: a dataclass, or a list of such; it stays as it is. Numbers of type
            `ScaledDefault` are replaced, in the dataclasses inside as well, by such as the robot's
            limits allow.
        humanoid: the robot.

    Returns:
        A copy without a number of that type.
    """
    base, limits = units_of(humanoid), vars(humanoid.description.limits)
    ratio_of = cache(partial(ratios, humanoid))  # looked up only where a number goes by one

    def made(value: Any, unit: str = "-", ratio: Array = ONE) -> Any:
        if isinstance(value, list):
            shares = np.broadcast_to(ratio, len(value))
            return [made(v, unit, r) for v, r in zip(value, shares, strict=True)]
        if isinstance(value, ScaledDefault):
            factor = unit_value(unit, base) * float(np.ravel(ratio)[0])
            number = factor * float(value)
            in_ticks = unit == "s" and factor != 1.0
            return max(round(number / _TIMES), 1) * _TIMES if in_ticks else number
        if not is_dataclass(value):
            return value
        fields = copy(value)
        for name, inner in vars(value).items():
            notes = declared_at(type(value), [name])[1]
            by_ratio = [ratio_of()[note.ratio] for note in notes if isinstance(note, Size)]
            number = made(inner, unit_of(type(value), [name]), by_ratio[0] if by_ratio else ONE)
            if isinstance(inner, ScaledDefault):
                number = within(number, limits.get(f"{name}_min"), highest(limits, name))
            setattr(fields, name, number)
        return fields

    return made(parameters)


def highest(limits: Mapping[str, float | None], name: str) -> float | None:
    """Return the largest value that the limits of a robot let a number have, if any does."""
    return limits.get(f"{name}_max", limits.get(name))


def within(number: float, low: float | None, high: float | None) -> float:
    """Return a number well inside its bounds: in their middle, where they are near each other."""
    if low is not None and high is not None and INSIDE * low > high / INSIDE:
        return 0.5 * (low + high)
    number = number if low is None else max(number, INSIDE * low)
    return number if high is None else min(number, high / INSIDE)


def units_of(humanoid: Humanoid) -> dict[str, float]:
    """Return what a metre, a second, a kilogram and a newton of the MIT Humanoid are to a robot."""
    m, kg = _ratio(humanoid.com_height, COM_HEIGHT), _ratio(humanoid.mass, MASS)
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


def round_number(value: float) -> float:
    """Return which of ..., 0.1, 0.2, 0.5, 1, 2, 5, ... is nearest to a positive number by ratio."""
    decade = math.floor(math.log10(value))
    near = [float(f"{digits}e{decade}") for digits in (1, 2, 5, 10)]
    return min(near, key=lambda number: abs(math.log(number / value)))


def _value(node: ast.expr, base: Mapping[str, float]) -> float:
    if isinstance(node, ast.BinOp):
        return _OPERATORS[type(node.op)](_value(node.left, base), _value(node.right, base))
    return base[node.id] if isinstance(node, ast.Name) else float(ast.literal_eval(node))


def ratios(humanoid: Humanoid) -> dict[str, Array]:
    """Return by what else than its size a robot differs from the MIT Humanoid.

    Returns:
        "swing_time": of a swing, in the time of the pendulum. Legs that are heavy for the foot
        that stands are swung more slowly: the rate of their angular momentum, which goes with
        the inverse square of the time, has to come from that foot. "torso_inertia": of a turn of
        the torso on its feet, about x, y and z, shape (3,). The less of the robot takes part in
        it, the farther a momentum turns it, and the less is one given for a turn. Numbers that
        go by one are multiplied by it.
    """
    d = robot_dynamics(humanoid, humanoid.scratch, humanoid.x_nominal)
    swing = swing_momentum(humanoid, d) / SWING_MOMENTUM
    torso = np.minimum(torso_inertia(humanoid, d) / np.array(TORSO_INERTIA), 1.0)
    time = np.clip(np.sqrt(swing), 1.0, _LONGEST_SWING)
    both = {"swing_time": np.atleast_1d(time), "torso_inertia": torso}
    return {name: np.where(np.abs(ratio - 1.0) < _SAME, 1.0, ratio) for name, ratio in both.items()}


def swing_momentum(humanoid: Humanoid, d: RobotDynamics) -> float:
    """Return the pitch momentum of a leg that swings past the CoM, in the nominal posture.

    Returns:
        L_y of a foot at unit speed along x, over ``m X`` [-].
    """
    v, leg = np.zeros(humanoid.nv), humanoid.leg_v[0]
    v[leg] = np.linalg.lstsq(d.J[0][:, leg], np.eye(humanoid.contact.size)[0], rcond=None)[0]
    return abs(float(d.A[1] @ v)) / (humanoid.mass * humanoid.half_length)


def torso_inertia(humanoid: Humanoid, d: RobotDynamics) -> Array:
    """Return the inertia of a torso that turns over fixed feet, in the nominal posture.

    Returns:
        Angular momentum of a turn about x, y and z with feet and CoM at rest and arms held, over
        that of the robot that turns as one body [-], shape (3,).
    """
    held = np.vstack([d.J.reshape(-1, humanoid.nv), d.A[3:], np.eye(humanoid.nv)[humanoid.arm_v]])
    turn = np.zeros((humanoid.nv, 3))
    turn[:3] = np.eye(3)
    turn[3:] = -np.linalg.lstsq(held[:, 3:], held @ turn, rcond=None)[0]
    return np.diagonal(d.A[:3] @ turn) / np.diagonal(d.A[:3, :3])


def _ratio(value: float, own: float) -> float:
    return 1.0 if abs(value / own - 1.0) < _SAME else value / own
