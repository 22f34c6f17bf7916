"""What Drake says of a model that it does not take, as one error of one line."""

import logging
import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from drake_linefoot.errors import ModelError, cut

_PLACE = re.compile(r"^(?:\S*/|<literal-string>\.)\S*?(?::\d+)?: ")  # file and line


def shortened(text: object) -> str:
    """Return a message on one line and of limited length, without the file that Drake names."""
    return cut(_PLACE.sub("", " ".join(str(text).split())).removeprefix("error: "))


@contextmanager
def refusing(file: Path, entry: str, value: object) -> Iterator[None]:
    """Raise whatever Drake throws inside the `with` block as a ModelError of a description.

    Drake's own conditions end as SystemExit, which no `except Exception` catches.
    """
    try:
        yield
    except ModelError:
        raise
    except (Exception, SystemExit) as error:
        raise ModelError(file, entry, value, f"Drake refuses it: {shortened(error)}") from error


@contextmanager
def remarks() -> Iterator[list[str]]:
    """Collect Drake's warnings, which are not shown meanwhile."""
    found: list[str] = []

    class Collect(logging.Handler):
        def emit(self, record: logging.LogRecord) -> None:
            found.append(shortened(record.getMessage()).removeprefix("warning: "))

    logger, handler = logging.getLogger("drake"), Collect(logging.WARNING)
    level, shown = logger.level, logger.propagate
    logger.addHandler(handler)
    logger.setLevel(logging.WARNING)
    logger.propagate = False
    try:
        yield found
    finally:
        logger.removeHandler(handler)
        logger.setLevel(level)
        logger.propagate = shown
