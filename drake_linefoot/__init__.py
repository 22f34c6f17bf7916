"""Line-foot biped walking on Drake: ECD MPC, whole-body control, contact estimation.

    from drake_linefoot import walk

    run = walk(vx=0.5, turn_rate=0.3)

Importing the package limits the linear-algebra library to one thread: the matrices of
a walking controller are small, and more threads make them several times slower. The names
below are loaded when they are asked for; `__init__.pyi` shows them to editors and type checkers.
"""

from typing import Any

from drake_linefoot import _environment as _environment
from drake_linefoot.late import late as _late

_HOMES = {  # name -> the module that it is from
    "Controller": "wiring.without_simulator",
    "ControllerParameters": "wiring.parameters",
    "Run": "lab.simulation.recording",
    "Scenario": "lab.scenario",
    "Segment": "lab.scenario",
    "build_closed_loop": "lab.wiring.closed_loop",
    "build_controller": "wiring.controller",
    "load_humanoid": "robot.humanoid",
    "simulate": "lab.simulation.run",
    "walk": "lab.walk",
}


def __getattr__(name: str) -> Any:
    """Load one of the names of `_HOMES`, or look up the version.

    Raises:
        AttributeError: there is no such name.
        MissingPackageError: it needs a package that the laboratory brings.
    """
    if name not in _HOMES and name != "__version__":
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    found = _late(_HOMES[name], name) if name in _HOMES else _version()
    globals()[name] = found  # asked for once
    return found


def _version() -> str:
    from importlib import metadata  # it takes three times as long as the rest of the package

    try:
        return metadata.version("drake_linefoot")  # from the tags of git, at installation
    except metadata.PackageNotFoundError:  # a folder on the path that was not installed
        return "0+unknown"


def __dir__() -> list[str]:
    """Return the names that are for users, those too that are not loaded yet."""
    return sorted({*_HOMES, "__doc__", "__file__", "__version__"})
