"""Compile every kernel before a run, on two cores, and show how far it is."""

import gc
import os
import subprocess
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, nullcontext
from importlib.util import find_spec
from multiprocessing import parent_process
from pathlib import Path
from threading import Thread

from numba.core import config

from drake_linefoot.late import late
from drake_linefoot.math.claims import shared
from drake_linefoot.math.compiled import (
    keep_machine_code,
    machine_code_folder,
    machine_code_is_kept,
    share_of_all,
    watched,
)
from drake_linefoot.robot.humanoid import load_humanoid
from drake_linefoot.wiring.blocks import compile_blocks

MESSAGE = "Compiling, once after an installation or a change: about a minute ..."
ON_TWO = "Compiling on two cores, once after an installation or a change: less than a minute ..."
NOWHERE = (
    "Compiling, about a minute, and anew each time: neither the package nor the cache folder of "
    "this user can be written; NUMBA_CACHE_DIR names another one ..."
)
# Not `-m`: the second process has the modules of the first one, wherever they come from.
_HELPER = (
    "import sys; sys.path[:] = sys.argv[1:]; "
    "from drake_linefoot.wiring.blocks import compile_from_the_end; compile_from_the_end()"
)
_BEGUN = set[str]()  # whether this process compiles, or has; a set, for it changes


def compile_first(walk: Callable[[], object]) -> None:
    """Compile what a walk needs, and say so with a bar on stderr; do nothing when that is kept.

    A second process compiles as well, where there is a core for it and a folder to share.

    Args:
        walk: walks a few steps; what it builds calls this function in vain.
    """
    if _BEGUN or machine_code_is_kept():
        return
    _BEGUN.add("begun")
    folder = machine_code_folder()
    helper = _helper_command() if folder is not None else []
    message = (ON_TWO if helper else MESSAGE) if folder is not None else NOWHERE
    try:
        with _bar(message) as progress, _helped(helper, progress):
            if helper:
                compile_blocks(1)
            with shared(folder, waits=True):
                walk()
    except BaseException:
        _BEGUN.clear()
        raise
    keep_machine_code()


def compile_controller() -> None:
    """Compile what a controller alone needs, as `compile_first` does, when that says so by itself.

    The first `build_controller` of a process does it.
    """
    if says_by_itself():
        controller = late("wiring.without_simulator", "Controller")
        compile_first(lambda: controller(load_humanoid("mit_humanoid")).walk_on_the_spot())


def says_by_itself() -> bool:
    """Return whether the first build of this process is to compile and say so.

    Not in a worker of a pool, which would say it as often as there are workers, nor in a test.
    """
    return parent_process() is None and "PYTEST_CURRENT_TEST" not in os.environ


def _helper_command() -> list[str]:
    """Return what starts the second process; nothing where it would not help or there is none."""
    cores = len(os.sched_getaffinity(0)) if sys.platform == "linux" else os.cpu_count() or 1
    python = Path(sys.executable or "").name.startswith("python")  # not a program that embeds it
    return [sys.executable, "-c", _HELPER, *sys.path] if python and cores > 1 else []


@contextmanager
def _helped(command: list[str], progress: Callable[[float], None]) -> Iterator[None]:
    """Let a second process compile as well in the `with` block; report what both have done."""
    names = set[str]()

    def add(name: str) -> None:
        names.add(name)
        progress(share_of_all(names))

    with _listening(command, add) if command else nullcontext():
        with watched(add), _seldom_collected():
            yield


@contextmanager
def _listening(command: list[str], say: Callable[[str], None]) -> Iterator[None]:
    """Run a command in the `with` block, to end with it at the latest; say each line it prints."""
    users = {"NUMBA_CACHE_DIR": config.CACHE_DIR} if config.CACHE_DIR else {}
    with subprocess.Popen(
        command,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
        env=os.environ | users,
    ) as process:
        thread = Thread(target=_say_lines, args=[process.stdout, say], daemon=True)
        thread.start()
        try:
            yield
        finally:
            process.kill()  # what it still does nobody needs
            thread.join()


def _say_lines(lines: Iterable[str], say: Callable[[str], None]) -> None:
    for line in lines:
        say(line.strip())


@contextmanager
def _bar(message: str) -> Iterator[Callable[[float], None]]:
    """Say something on stderr, and show a bar below it in the `with` block where there can be one.

    Yields:
        What is told the share that is done.
    """
    print(message, file=sys.stderr, flush=True)
    if find_spec("rich") is None:  # it comes with the laboratory
        yield lambda share: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TimeElapsedColumn

    console = Console(stderr=True)
    if console.is_jupyter:  # Rich needs a package of widgets there
        from IPython.display import ProgressBar

        html = ProgressBar(100)
        html.display()
        yield lambda share: setattr(html, "progress", round(100 * share))
        return
    bar = Progress(BarColumn(bar_width=20), TimeElapsedColumn(), console=console, transient=True)
    bar.disable = not console.is_terminal
    with bar:
        task = bar.add_task("", total=1.0)
        yield lambda share: bar.update(task, completed=share)


@contextmanager
def _seldom_collected() -> Iterator[None]:
    """Collect garbage seldom in the `with` block: compiling leaves little, and takes 10 % less."""
    usual = gc.get_threshold()
    gc.set_threshold(100_000, 50, 100)
    try:
        yield
    finally:
        gc.set_threshold(*usual)
