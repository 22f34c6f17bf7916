"""What every LeafSystem of this package shares: callbacks that do not leak, checked inputs."""

import re
import weakref
from collections.abc import Callable
from functools import partial
from typing import Any, TypeVar

import numpy as np
from pydrake.systems.framework import (
    BasicVector,
    Context,
    DependencyTicket,
    InputPort,
    LeafSystem,
    OutputPort,
)

from drake_linefoot.errors import SignalError
from drake_linefoot.layout import Layout
from drake_linefoot.math.linear import all_finite
from drake_linefoot.types import Array

_S = TypeVar("_S", bound=tuple[Any, ...])
_GETTER = re.compile("get_(?P<name>[a-z_]+)_(?P<way>input|output)_port")


class Block(LeafSystem):
    """A LeafSystem with signals on its ports, whose discontinuities are its events.

    It has no witness functions. ``get_plan_input_port()`` and the like give each port by its name.

    Attributes:
        layouts: of the signals, by the names of their ports.
    """

    def __init__(self) -> None:
        """Begin without ports."""
        super().__init__()
        self.layouts: dict[str, Layout[Any]] = {}

    def signal_input(self, name: str, layout: Layout[Any]) -> InputPort:
        """Declare an input port that takes a signal."""
        self.layouts[name] = layout
        return self.DeclareVectorInputPort(name, layout.size)

    def signal_output(
        self,
        name: str,
        layout: Layout[Any],
        calc: Callable[[Context, BasicVector], None],
        prerequisites: set[DependencyTicket],
    ) -> OutputPort:
        """Declare an output port that gives a signal, computed by `calc` of what it names."""
        self.layouts[name] = layout
        calc = weak(self, calc)
        return self.DeclareVectorOutputPort(
            name, layout.size, calc, prerequisites_of_calc=prerequisites
        )

    def look(self, name: str, context: Context) -> Any:
        """Return the signal on a port, opened.

        Args:
            name: of the port, in or out.
            context: of this system.
        """
        ports = self.GetInputPort if self.HasInputPort(name) else self.GetOutputPort
        return self.layouts[name].open(ports(name).Eval(context))

    # After each step Drake asks every system in Python for its witness functions. With
    # pybind11, which its newer releases are not made with, that there are none is looked up
    # anew each time, by way of an exception, unless the name leads to a function of C++.
    if type(LeafSystem).__name__ == "pybind11_type":
        DoGetWitnessFunctions = LeafSystem.get_name

    def __getattr__(self, attribute: str) -> Any:
        if match := _GETTER.fullmatch(attribute):
            get = self.GetInputPort if match["way"] == "input" else self.GetOutputPort
            has = self.HasInputPort if match["way"] == "input" else self.HasOutputPort
            if has(match["name"]):
                return partial(get, match["name"])
        raise AttributeError(f"{type(self).__name__!r} object has no attribute {attribute!r}")


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


def read_signal(system: LeafSystem, port: InputPort, context: Context, layout: Layout[_S]) -> _S:
    """Return the signal at a vector input port, opened.

    Args:
        system: that has the port.
        port: to be read.
        context: of the system.
        layout: of the signal.

    Raises:
        SignalError: a number in it is not finite; the message names port and number.
    """
    return layout.open(read_vector(system, port, context, layout))


def read_vector(
    system: LeafSystem, port: InputPort, context: Context, layout: Layout[Any]
) -> Array:
    """Return the vector of a signal at an input port; otherwise as `read_signal`."""
    value: Array = port.Eval(context)
    if not all_finite(value):
        bad = int(np.flatnonzero(~np.isfinite(value))[0])
        text = f"{layout.name_of(bad)} is {value[bad]}: must be finite"
        raise SignalError(_name(system, port), text)
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
