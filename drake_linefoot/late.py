"""Names of modules that stand later in the package's order than who asks for them.

An object of the controller can be shown, which the laboratory does: `humanoid.show()`.
"""

from importlib import import_module
from typing import Any

from drake_linefoot import _environment
from drake_linefoot.errors import MissingPackageError


def late(home: str, name: str) -> Any:
    """Return a name of a module of the package, loaded now.

    Args:
        home: the module, below the package.
        name: what is in it.

    Raises:
        MissingPackageError: it needs a package that the laboratory brings.
        ImportError: Drake cannot be loaded; it says what to do, where that is known.
    """
    try:
        return getattr(import_module(f"drake_linefoot.{home}"), name)
    except ModuleNotFoundError as error:
        raise MissingPackageError(f"drake_linefoot.{name}", str(error.name)) from error
    except ImportError as error:
        if _environment.is_without_utf8():
            raise ImportError(f"the locale of the environment {_environment.LOCALE}") from error
        raise
