"""Names of modules that stand later in the package's order than who asks for them.

An object of the controller can be shown, which the laboratory does: `humanoid.show()`.
"""

from importlib import import_module
from typing import Any

from drake_linefoot.errors import MissingPackageError


def late(home: str, name: str) -> Any:
    """Return a name of a module of the package, loaded now.

    Args:
        home: the module, below the package.
        name: what is in it.

    Raises:
        MissingPackageError: it needs a package that the laboratory brings.
    """
    try:
        return getattr(import_module(f"drake_linefoot.{home}"), name)
    except ModuleNotFoundError as error:
        raise MissingPackageError(f"drake_linefoot.{name}", str(error.name)) from error
