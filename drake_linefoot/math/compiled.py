"""Functions compiled to machine code by Numba, for what a tick of the controller repeats.

Compiled functions live in the modules of their subjects. They are plain Python over
arrays and numbers; with ``NUMBA_DISABLE_JIT=1`` in the environment they run as such, for a
debugger. Each is compiled when it is first called with arrays of a kind, and kept on the disk.
"""

import hashlib
from collections.abc import Callable, Collection
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any, ParamSpec, TypeVar

import numba
from numba.core import config, event
from numba.core.dispatcher import Dispatcher
from numba.extending import overload
from numba.np import arrayobj

from drake_linefoot.math.machine_code import (
    Folders,
    complete,
    is_complete,
    kept_in,
    machine_code,
    shipped_in,
)

_WITH_CONSTANTS = (
    *("axes.py", "constants.py", "layout.py", "parts.py", "signals.py", "statuses.py"),
    "terrain.py",
)
PACKAGE = Path(__file__).resolve().parent.parent
_P = ParamSpec("_P")
_R = TypeVar("_R")
_FUNCTIONS: set[Callable[..., Any]] = set()  # all that are to be compiled


def _shapes_differ(given: tuple[int, ...], wanted: tuple[int, ...]) -> None:
    """Stand for what an assignment to a part of an array says when the shapes differ."""


# Numba writes both shapes into its message. What makes text of numbers is two fifths of all that
# is compiled, and a fifth of the machine code; the message of its other targets needs none of it.
if _message := getattr(arrayobj, "ol_raise_with_shape_context_generic", None):
    overload(_shapes_differ)(_message)
    arrayobj.raise_with_shape_context = _shapes_differ


class _Watch(event.Listener):
    """Says the name of each function of the package that is compiled."""

    def __init__(self, say: Callable[[str], None]) -> None:
        self._say = say

    def on_start(self, event: event.Event) -> None:
        """Do nothing."""

    def on_end(self, event: event.Event) -> None:
        """Say a function of the package."""
        function = event.data["dispatcher"].py_func
        if function in _FUNCTIONS:
            self._say(f"{function.__module__}.{function.__qualname__}")


def watched(say: Callable[[str], None]) -> AbstractContextManager[None]:
    """Say the name of each function that is compiled, once it is, inside a `with` block."""
    watch: AbstractContextManager[None] = event.install_listener("numba:compile", _Watch(say))
    return watch


def share_of_all(names: Collection[str]) -> float:
    """Return how many of the functions to be compiled a number of different names is [-]."""
    return len(names) / len(_FUNCTIONS)


def compiled(function: Callable[_P, _R], inline: str = "never") -> Callable[_P, _R]:
    """Return the function, compiled when it is first called.

    Numbers are those of the Python code but for rounding. Other threads of Python go on while it
    runs. Without a folder to keep it in, the machine code lasts as long as the process.
    """
    if inline == "never":
        _FUNCTIONS.add(function)
    made: Callable[_P, _R] = numba.njit(
        error_model="numpy", inline=inline, no_cfunc_wrapper=True, nogil=True
    )(function)
    folders = Folders(machine_code_folder(), _shipped())
    if any(folders) and isinstance(made, Dispatcher):  # else Python runs it
        made._cache = machine_code(function, folders)  # type: ignore[attr-defined]
    return made


def inlined(function: Callable[_P, _R]) -> Callable[_P, _R]:
    """Return the function, which becomes a part of each compiled function that calls it.

    For what is called at one place and puts compiled functions together: all that a compiled
    function calls is optimised and emitted again in it, and once more in each of its callers.
    """
    return compiled(function, inline="always")


def as_python(function: Callable[_P, _R]) -> Callable[_P, _R]:
    """Return a compiled function as the Python it is made of, which calls others as compiled."""
    python: Callable[_P, _R] = getattr(function, "py_func", function)
    return python


def machine_code_is_kept() -> bool:
    """Return whether nothing has to be compiled: a wheel brought it, or it was kept."""
    if config.DISABLE_JIT:
        return True
    return is_complete(_shipped()) or is_complete(machine_code_folder())


def keep_machine_code() -> None:
    """Note that all that a walk needs has been compiled, as far as it can be kept."""
    folder = machine_code_folder()
    if folder is not None:
        complete(folder)


def machine_code_folder() -> Path | None:
    """Return where machine code is kept; None for nowhere.

    Numba compiles a function anew when its own file has changed, but not when one that it
    calls has, in another file: the folder is named after the content of all of them.
    """
    return kept_in(PACKAGE / "__pycache__", config.CACHE_DIR, _DIGEST)


def _shipped() -> Path | None:
    """Return where machine code is that a wheel brought; None when there is none for this place."""
    return shipped_in(PACKAGE, _DIGEST, config.CPU_NAME, config.CPU_FEATURES)


def _digest() -> str:
    """Return a name for the content of every module that has compiled functions or constants."""
    content = hashlib.sha256()
    for path in sorted(PACKAGE.rglob("*.py")):
        source = path.read_bytes()
        if b"@compiled" in source or b"@inlined" in source or path.name in _WITH_CONSTANTS:
            content.update(source)
    return content.hexdigest()[:16]


_DIGEST = _digest()
