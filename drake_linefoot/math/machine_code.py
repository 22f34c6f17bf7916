"""Machine code on the disk: where it is kept, and what becomes of it when it is damaged or old.

Numba's own cache, with four differences. Its folder is named after a digest of the sources,
wherever they are. What cannot be read is compiled anew, and what cannot be written is not kept;
either is said once. A checksum finds the damage that would be run otherwise. And there may be a
second folder, that a wheel brought, with code for any processor that has what x86-64-v3 has.
"""

import hashlib
import io
import logging
import os
import shutil
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import cache, partial
from pathlib import Path
from typing import Any, NamedTuple

import numba
from numba.core.caching import (
    CompileResultCacheImpl,
    FunctionCache,
    IndexDataCacheFile,
    NullCache,
)
from numba.core.codegen import get_host_cpu_features
from numba.misc.appdirs import AppDirs

from drake_linefoot.math.claims import claims

PREFIX = "kernels-"
COMPLETE = "complete"  # a file beside the machine code of all that a walk needs
# The third level of x86-64 as its psABI lists it: for NUMBA_CPU_NAME and NUMBA_CPU_FEATURES.
SHIPPED_CPU = "x86-64-v3"
SHIPPED_FEATURES = ",".join(
    f"+{feature}"
    for feature in (
        *("64bit", "cmov", "cx8", "fxsr", "mmx", "sse", "sse2"),
        *("cx16", "popcnt", "sahf", "sse3", "sse4.1", "sse4.2", "ssse3"),
        *("avx", "avx2", "bmi", "bmi2", "f16c", "fma", "lzcnt", "movbe", "xsave"),
    )
)
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


class Folders(NamedTuple):
    """Where machine code is."""

    own: Path | None  # what was compiled here; None where nothing can be kept
    shipped: Path | None  # what the wheel brought, when it can run here


@cache
def shipped_in(package: Path, digest: str, cpu: str | None, features: str | None) -> Path | None:
    """Return the folder of the machine code that a wheel brought; None when it cannot run here.

    It runs on a processor that has all its features, unless the user asks Numba for another one.
    What another release of Python or Numba made is in it, but not found: its files say so.

    Args:
        package: the folder of the sources.
        digest: of the sources.
        cpu: the processor that NUMBA_CPU_NAME names, if any.
        features: of it that NUMBA_CPU_FEATURES names, if any.
    """
    folder = package / f"{PREFIX}{digest}"
    if (cpu, features) not in ((None, None), (SHIPPED_CPU, SHIPPED_FEATURES)):
        return None
    fits = set(SHIPPED_FEATURES.split(",")) <= set(get_host_cpu_features().split(","))
    return folder if fits and folder.is_dir() else None


def made_by() -> str:
    """Return what machine code depends on beside the sources and the processor."""
    release = f"{sys.version_info[0]}.{sys.version_info[1]}{sys.abiflags}"
    return f"Python {release}, Numba {numba.__version__}"


def is_complete(folder: Path | None) -> bool:
    """Return whether a folder has all that a walk needs, made by this Python and Numba."""
    with suppress(OSError):
        return folder is not None and (folder / COMPLETE).read_text() == made_by()
    return False


def complete(folder: Path) -> None:
    """Note that a folder has all that a walk needs, if it can be written."""
    with suppress(OSError):
        (folder / COMPLETE).write_text(made_by())


def machine_code(function: Callable[..., Any], folders: Folders) -> Any:
    """Return the machine code of a function that is kept in folders, as Numba wants it."""
    try:
        return _MachineCode(function, folders)
    except OSError:  # its source is not in a file, or the folder cannot be written any more
        return NullCache()


class _Place:
    """Where the files of one function are, as Numba asks for it; independent of its own place."""

    def __init__(self, function: Callable[..., Any], folder: Path) -> None:
        self._stamp = _stamp(function.__code__.co_filename)
        self._line = function.__code__.co_firstlineno
        self._folder = folder / function.__module__

    def ensure_cache_path(self) -> None:
        self._folder.mkdir(parents=True, exist_ok=True)

    def get_cache_path(self) -> str:
        return str(self._folder)

    def get_source_stamp(self) -> str:
        """The content of its file."""
        return self._stamp

    def get_disambiguator(self) -> str:
        return str(self._line)


class _Results(CompileResultCacheImpl):
    """How Numba packs and unpacks machine code, whose files are in a folder."""

    def __init__(self, function: Callable[..., Any], folder: Path) -> None:
        self._lineno = function.__code__.co_firstlineno
        self._locator = _Place(function, folder)
        name = f"{function.__module__.rpartition('.')[2]}.{function.__qualname__}"
        self._filename_base = self.get_filename_base(name, sys.abiflags)

    def files(self) -> "_Files":
        """Return the files."""
        place = self._locator
        return _Files(place.get_cache_path(), self._filename_base, place.get_source_stamp())


@cache
def _stamp(file: str) -> str:
    return hashlib.sha256(Path(file).read_bytes()).hexdigest()


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

    def __init__(self, function: Callable[..., Any], folders: Folders) -> None:
        """Look for it in folders, of which there is one at least."""
        self._impl_class = partial(_Results, folder=folders.own or folders.shipped or Path())
        super().__init__(function)
        self._cache_file = self._impl.files()
        self._is_kept = folders.own is not None
        self._shipped: _Files | None = None
        if folders.shipped is not None:
            self._shipped = _Results(function, folders.shipped).files()

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Return what is kept for a signature, or None.

        Raises:
            TakenError: another process compiles it, see `Claims`.
        """
        found, claimed = self._load(sig, target_context), claims()
        if found is None and claimed is not None and claimed.take(self._claim(sig)):
            found = self._load(sig, target_context)
            if found is not None:
                claimed.free(self._claim(sig))
        return found

    def _claim(self, sig: Any) -> str:
        return f"{self._cache_path} {self._impl.filename_base} {sig}"

    def _load(self, sig: Any, target_context: Any) -> Any:
        try:
            found = super().load_overload(sig, target_context) if self._is_kept else None
            return found or self._load_shipped(sig, target_context)
        except Exception as error:  # unpickling what is damaged raises all kinds
            _say_once("machine code on the disk is damaged and made anew", error)
            if self._is_kept:
                with suppress(OSError):
                    self.flush()
            return None

    def _load_shipped(self, sig: Any, target_context: Any) -> Any:
        if self._shipped is None:
            return None
        target_context.refresh()
        sig, (triple, *_), code = self._index_key(sig, target_context.codegen())
        found = self._shipped.load((sig, (triple, SHIPPED_CPU, SHIPPED_FEATURES), code))
        return found and self._impl.rebuild(target_context, found)

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep what was compiled for a signature, as far as the disk lets it."""
        if not self._is_kept:
            return
        try:
            super().save_overload(sig, data)
        except (OSError, ValueError) as error:
            _say_once("machine code cannot be kept", error)
        if (claimed := claims()) is not None:
            claimed.free(self._claim(sig))


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
