"""The last resort of the command line: an error that nobody foresaw, in one line."""

import contextlib
import tempfile
import traceback
from collections.abc import Iterator
from pathlib import Path

from drake_linefoot.errors import cut


def is_interrupt(error: BaseException) -> bool:
    """Whether an error is a Ctrl-C: inside compiled code it comes out as a SystemError."""
    return any(isinstance(each, KeyboardInterrupt) for each in _with_causes(error))


def nobody_reads(error: BaseException) -> bool:
    """Whether an error is that the reader of what is printed has gone, as `head` does.

    Rich makes a SystemExit of it.
    """
    return any(isinstance(each, BrokenPipeError) for each in _with_causes(error))


def report_of(error: BaseException) -> str:
    """Keep the traceback of an error in a file; return one line that names both."""
    said = cut(f"{type(error).__name__}: {error}" if str(error) else type(error).__name__)
    where = "the traceback could not be kept"
    with contextlib.suppress(OSError):
        where = f"its traceback is in {_keep(error)}"
    return f"unexpected error, {said} ({where})"


def _keep(error: BaseException) -> Path:
    with tempfile.NamedTemporaryFile(
        "w", prefix="linefoot-", suffix=".txt", encoding="utf-8", errors="replace", delete=False
    ) as file:
        file.writelines(traceback.format_exception(error))
    return Path(file.name)


def _with_causes(error: BaseException) -> Iterator[BaseException]:
    """Yield an error and what it came of."""
    seen: set[int] = set()
    left: list[BaseException | None] = [error]
    while left:
        each = left.pop()
        if each is not None and id(each) not in seen:
            seen.add(id(each))
            yield each
            left += [each.__cause__, each.__context__]
