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

    Raises:
        SignalError: a number in it is not finite; the message names port and index.
    """
    value = np.asarray(port.Eval(context), dtype=float)
    if not all_finite(value):
        bad = int(np.flatnonzero(~np.isfinite(value))[0])
        name = f"{system.get_name()}.{port.get_name()}"
        raise SignalError(name, f"element {bad} is {value[bad]}: must be finite")
    return value
