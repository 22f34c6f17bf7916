"""Machine code on the disk: where it is kept, and what becomes of it when it is damaged or old.

Numba's own cache, with three differences. Its folder is named after a digest of the sources,
wherever it is. What cannot be read is compiled anew, and what cannot be written is not kept;
either is said once. A checksum finds the damage that would be run otherwise.
"""

import hashlib
import io
import logging
import os
import shutil
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path
from typing import Any

from numba.core import config
from numba.core.caching import (
    CompileResultCacheImpl,
    FunctionCache,
    IndexDataCacheFile,
    NullCache,
    UserProvidedCacheLocator,
)
from numba.misc.appdirs import AppDirs

PREFIX = "kernels-"
KEPT = 3  # folders of other sources: another checkout's, or of before a change that is undone
_SIZE = hashlib.sha256().digest_size
_SAID = set[str]()
_LOG = logging.getLogger(__name__)


@cache
def kept_in(beside: Path, users: str, digest: str) -> Path | None:
    """Return the folder of the machine code, made and used just now; None when none can be.

    It lies where the user wants it; else beside the sources; else, when these cannot be written
    to, in the user's cache. Folders of other sources are removed, but for those used last.

    Args:
        beside: the sources.
        users: the folder that NUMBA_CACHE_DIR names, or nothing.
        digest: of the sources.
    """
    own = Path(AppDirs("drake_linefoot", appauthor=False).user_cache_dir)
    for parent in [Path(users)] if users else [beside, own]:
        folder = parent / f"{PREFIX}{digest}"
        with suppress(OSError):
            folder.mkdir(parents=True, exist_ok=True)
            tempfile.TemporaryFile(dir=folder).close()
            os.utime(folder)
            _remove_old(folder)
            return folder
    return None


def machine_code(function: Callable[..., Any], folder: Path) -> Any:
    """Return the machine code of a function that is kept in a folder, as Numba wants it."""
    before = config.CACHE_DIR
    config.CACHE_DIR = str(folder)
    try:
        return _MachineCode(function)
    except (OSError, RuntimeError):  # it cannot be written any more
        return NullCache()
    finally:
        config.CACHE_DIR = before


class _Place(CompileResultCacheImpl):
    """Where the files are: in `config.CACHE_DIR`, or nowhere."""

    _locator_classes = [UserProvidedCacheLocator]  # noqa: RUF012  # as Numba declares it


class _Files(IndexDataCacheFile):
    """The files of one function, each with a checksum at its end, which unpickling leaves out."""

    @contextmanager
    def _open_for_write(self, filepath: str) -> Iterator[io.BytesIO]:
        content = io.BytesIO()
        yield content
        with super()._open_for_write(filepath) as file:
            file.write(content.getvalue() + _checksum(content.getvalue()))

    def _load_index(self) -> Any:
        _verify(Path(self._index_path))
        return super()._load_index()

    def _load_data(self, name: str) -> Any:
        _verify(Path(self._data_path(name)))
        return super()._load_data(name)


class _MachineCode(FunctionCache):
    """The machine code of one function, for each kind of its arguments."""

    _impl_class = _Place

    def __init__(self, function: Callable[..., Any]) -> None:
        """Keep it in `config.CACHE_DIR`."""
        super().__init__(function)
        place = self._impl.locator
        stamp = place.get_source_stamp()
        self._cache_file = _Files(place.get_cache_path(), self._impl.filename_base, stamp)

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Return what is kept for a signature, or None."""
        try:
            return super().load_overload(sig, target_context)
        except Exception as error:  # unpickling what is damaged raises all kinds
            _say_once("machine code on the disk is damaged and made anew", error)
            with suppress(OSError):
                self.flush()
            return None

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep what was compiled for a signature, as far as the disk lets it."""
        try:
            super().save_overload(sig, data)
        except (OSError, ValueError) as error:
            _say_once("machine code cannot be kept", error)


def _checksum(content: bytes) -> bytes:
    return hashlib.sha256(content).digest()


def _verify(file: Path) -> None:
    """Raise ValueError when a file that is there is damaged or cannot be read."""
    try:
        content = file.read_bytes()
    except FileNotFoundError:
        return
    except OSError as error:
        raise ValueError(f"{file.name}: {error.strerror}") from error
    if _checksum(content[:-_SIZE]) != content[-_SIZE:]:
        raise ValueError(f"{file.name}: wrong checksum")


def _remove_old(folder: Path) -> None:
    """Remove folders beside one, but for those used last.

    A process that uses a removed one compiles what it still needs, and keeps it again.
    """
    others = [other for other in folder.parent.glob(f"{PREFIX}*") if other != folder]
    with suppress(OSError):  # another process has removed one meanwhile
        others.sort(key=lambda other: other.stat().st_mtime, reverse=True)
        for other in others[KEPT:]:
            shutil.rmtree(other, ignore_errors=True)


def _say_once(what: str, error: Exception) -> None:
    """Log the first time in this process that something happens."""
    if what not in _SAID:
        _SAID.add(what)
        _LOG.warning("%s: %s", what, error)
