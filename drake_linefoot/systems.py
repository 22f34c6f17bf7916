"""Helpers for LeafSystems: callbacks that do not leak, inputs that are checked."""

from __future__ import annotations

import weakref
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydrake.systems.framework import Context, InputPort, LeafSystem

from drake_linefoot.errors import SignalError
from drake_linefoot.math.kernels import all_finite

Array = NDArray[np.float64]


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


def read_finite(
    system: LeafSystem,
    port: InputPort,
    context: Context,
    known: Callable[[Array], bool] | None = None,
) -> Array:
    """Return the value of a vector input port.

    Args:
        system: that has the port.
        port: to be read.
        context: of the system.
        known: tells of which value it is known that it is finite.

    Raises:
        SignalError: a number in it is not finite; the message names port and index.
    """
    value: Array = port.Eval(context)
    if not (known is not None and known(value)) and not all_finite(value):
        bad = int(np.flatnonzero(~np.isfinite(value))[0])
        name = f"{system.get_name()}.{port.get_name()}"
        raise SignalError(name, f"element {bad} is {value[bad]}: must be finite")
    return value
