"""What every LeafSystem of this package shares: callbacks that do not leak, checked inputs."""

import weakref
from collections.abc import Callable
from typing import Any, TypeVar

import numpy as np
from pydrake.systems.framework import Context, InputPort, LeafSystem, OutputPort

from drake_linefoot.errors import SignalError
from drake_linefoot.math.linear import all_finite
from drake_linefoot.types import Array

_T = TypeVar("_T")


class Block(LeafSystem):
    """A LeafSystem whose discontinuities are its events: it has no witness functions."""

    # After each step Drake asks every system in Python for its witness functions. With
    # pybind11, which its newer releases are not made with, that there are none is looked up
    # anew each time, by way of an exception, unless the name leads to a function of C++.
    if type(LeafSystem).__name__ == "pybind11_type":
        DoGetWitnessFunctions = LeafSystem.get_name


def weak(system: LeafSystem, method: Callable[..., Any]) -> Callable[..., Any]:
    """Return `method` bound weakly to its system, for Drake's callbacks.

    Drake keeps callbacks as long as the system; a bound method would keep the system
    alive in turn, and neither would ever be freed.
    """
    reference = weakref.ref(system)
    function = method.__func__  # type: ignore[attr-defined]

    def call(*args: Any) -> Any:
        return function(reference(), *args)

    return call


def read_finite(system: LeafSystem, port: InputPort, context: Context) -> Array:
    """Return the value of a vector input port.

    Args:
        system: that has the port.
        port: to be read.
        context: of the system.

    Raises:
        SignalError: a number in it is not finite; the message names port and index.
    """
    value: Array = port.Eval(context)
    check_finite(system, port, value)
    return value


def read_signal(system: LeafSystem, port: InputPort, context: Context, kind: type[_T]) -> _T:
    """Return the value of an abstract input port.

    To Drake every Python object is of one type, so it lets any be connected.

    Args:
        system: that has the port.
        port: to be read.
        context: of the system.
        kind: what the port takes.

    Raises:
        SignalError: the value is of another type; the message names port and both types.
    """
    value = port.Eval(context)
    if not isinstance(value, kind):
        found = type(value).__name__
        raise SignalError(_name(system, port), f"got a {found}: must be a {kind.__name__}")
    return value


def check_finite(
    system: LeafSystem, port: InputPort | OutputPort, value: Array, what: str = "element"
) -> None:
    """Check that every number that comes or goes through a port is finite.

    Args:
        system: that has the port.
        port: where it comes from or goes to.
        value: shape (n,).
        what: the numbers are, for the message.

    Raises:
        SignalError: one is not; the message names port and index.
    """
    if not all_finite(value):
        bad = int(np.flatnonzero(~np.isfinite(value))[0])
        raise SignalError(_name(system, port), f"{what} {bad} is {value[bad]}: must be finite")


def _name(system: LeafSystem, port: InputPort | OutputPort) -> str:
    return f"{system.get_name()}.{port.get_name()}"
