"""Every error this package raises on purpose, each carrying its evidence.

One base class, so that a caller can catch all of them; each subclass also derives from
the built-in error it specialises, so that code that knows nothing of this package can
catch it too.
"""

from pathlib import Path
from typing import Any

LONGEST = 200  # characters of an entry or a value in a message
_LONGEST_PATH, _LONGEST_ALLOWED = 300, 1200  # of a file, of what would be accepted


class LinefootError(Exception):
    """Base class of the errors raised on purpose by this package."""

    def __reduce__(self) -> tuple[Any, ...]:
        """Let an error go from one process to another, though it is made of other arguments."""
        return _again, (type(self), self.args, self.__dict__)


def _again(kind: type[LinefootError], args: tuple[Any, ...], values: dict[str, Any]) -> Any:
    """Return an error with the message and the evidence of another one."""
    error = kind.__new__(kind)
    error.args = args
    error.__dict__.update(values)
    return error


class InputError(LinefootError, ValueError):
    """A value from outside (file, parameter, command line) that cannot be used.

    Attributes:
        where: file, or the name of what was read (for instance ``"--vx"``).
        entry: dotted path of the field inside `where`; empty when it is the whole.
        value: the offending value; of a whole file, what it should hold ("recorded run").
        allowed: what would have been accepted, in words.
    """

    def __init__(self, where: str | Path, entry: str, value: object, allowed: str) -> None:
        """Store the evidence and compose the one-line message."""
        self.where = str(where)
        self.entry = entry
        self.value = value
        self.allowed = allowed
        place, allowed = legible(self.where, _LONGEST_PATH), legible(allowed, _LONGEST_ALLOWED)
        at = f"{place}: {legible(entry)}" if entry else place
        if isinstance(where, Path) and isinstance(value, str) and not entry:
            super().__init__(f"{at}: the {legible(value)} {allowed}")
        else:
            super().__init__(f"{at} = {legible(repr(value))}: {allowed}")


def legible(text: str, longest: int = LONGEST) -> str:
    """Return a text from outside as one line of a terminal can show it.

    Spaces and ends of lines become one space; what moves the cursor, rings, hides or has no sign
    is shown as Python escapes it. After `longest` characters stands what says that there were more.
    """
    words = " ".join(text[: 8 * longest].split())  # the rest of a very long one is not looked at
    if not words.isprintable():
        words = "".join(c if c.isprintable() else ascii(c)[1:-1] for c in words[: longest + 1])
    whole = len(words) <= longest and len(text) <= 8 * longest
    return words if whole else words[:longest] + "..."


class ScenarioError(InputError):
    """A scenario file, or one of its fields, is not usable."""


class ModelError(InputError):
    """A robot description, or one of its entries, is not usable."""


class SignalError(LinefootError, ValueError):
    """A signal on a port is not usable (wrong size, non-finite).

    Attributes:
        port: name of the port, as `system.port`.
    """

    def __init__(self, port: str, message: str) -> None:
        """Store the port and compose the message."""
        self.port = port
        super().__init__(f"port {port}: {message}")


class SolverError(LinefootError, RuntimeError):
    """A quadratic program has no usable solution.

    Attributes:
        program: which program ("mpc", "wbc", "contact").
        status: the solver's own word for what happened.
    """

    def __init__(self, program: str, status: str) -> None:
        """Store the evidence and compose the message."""
        self.program = program
        self.status = status
        super().__init__(f"{program} program not solved: {status}")


class EstimateError(LinefootError, RuntimeError):
    """The state estimator does not know any more where the robot is."""


class RemoteError(LinefootError, ConnectionError):
    """A controller in another process does not answer."""


class MissingPackageError(LinefootError, ImportError):
    """A package is not installed that an extra brings, mostly that of the laboratory.

    Attributes:
        package: its name.
    """

    def __init__(self, what: str, package: str, extra: str = "lab") -> None:
        """Store the package and compose the message: `what` needs it, and `extra` brings it."""
        self.package = package
        install = f"pip install 'drake_linefoot[{extra}]'"
        super().__init__(f"{what} needs {package}, which is not installed: {install}")


class OutputError(LinefootError, OSError):
    """An output folder or file cannot be written."""

    def __init__(self, path: str | Path, reason: str) -> None:
        """Store the path and compose the message."""
        self.path = Path(path)
        super().__init__(f"{path}: cannot be written: {reason}")
