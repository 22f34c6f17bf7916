"""Figures computed side by side, in processes of their own."""

from __future__ import annotations

import json
import multiprocessing
import queue
import signal
import time
from collections.abc import Sequence
from multiprocessing.context import SpawnProcess
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rich.console import Console
from rich.progress import BarColumn, TextColumn, TimeElapsedColumn
from rich.progress import Progress as Bar

from drake_linefoot.errors import LinefootError
from drake_linefoot.evaluation.figure import ALONE, Data, load_figure

if TYPE_CHECKING:
    from multiprocessing.queues import Queue

PROCESSES = 2
SHARED = ("fig3", "fig5", "fig6", "fig7", "feasibility")  # show the same simulated walk
LONGEST = ("grid", "fig4")  # begun first
POLL = 0.2  # [s] between two looks at the workers


def batches(names: Sequence[str]) -> tuple[list[list[str]], list[list[str]]]:
    """Return what may run side by side, and what must run alone after it.

    Figures of one batch are computed by one process, one after the other; those that show the
    same walk are one batch, so that it is simulated once.
    """
    shared = [name for name in names if name in SHARED]
    alone = [[name] for name in names if name in ALONE]
    rest = [name for name in names if name not in (*SHARED, *ALONE)]
    long = [[name] for name in LONGEST if name in rest]
    other = [[name] for name in rest if name not in LONGEST]
    return [*long, *([shared] if shared else []), *other], alone


def run(
    names: Sequence[str], quick: bool, out: Path, made_with: dict[str, Any], console: Console
) -> None:
    """Compute figures and write their JSON files, showing how far it is.

    Args:
        names: of the figures.
        quick: shorter runs.
        out: an existing folder.
        made_with: goes into each file.
        console: where the bar goes.

    Raises:
        LinefootError: a figure could not be computed; those that could are written.
    """
    bar = progress_bar(console)
    side_by_side, alone = batches(names)
    with bar:
        board = _Board(bar, names)
        for group, processes in ((side_by_side, PROCESSES), (alone, 1)):
            _run_group(group, processes, (quick, out, made_with), board)
    if board.failed:
        raise LinefootError("; ".join(f"{n}: {why}" for n, why in board.failed.items()))


def progress_bar(console: Console) -> Bar:
    """Return a bar that shows share, time and what is done now; nothing without a terminal."""
    return Bar(
        TextColumn("{task.percentage:3.0f} %"),
        BarColumn(bar_width=20),
        TimeElapsedColumn(),
        TextColumn("{task.description}"),
        console=console,
        transient=True,
        disable=not console.is_terminal,
    )


class _Board:
    """What the workers say, as one bar over all figures."""

    def __init__(self, bar: Bar, names: Sequence[str]) -> None:
        self.failed: dict[str, str] = {}  # name -> why
        self._done: set[str] = set()
        self._bar = bar
        self._shares = dict.fromkeys(names, 0.0)
        self._texts: dict[str, str] = {}
        self._task = bar.add_task("starting", total=float(len(names)))

    def hear(self, name: str, share: float, text: str) -> None:
        """Take note of what a worker says of a figure: the share that is done, and words."""
        self._shares[name], self._texts[name] = share, text
        if share >= 1.0 and not text:  # the last word of a figure, see `compute`
            self._texts.pop(name)
            self._done.add(name)
        going = "; ".join(f"{n}: {t}" for n, t in self._texts.items())
        self._bar.update(self._task, completed=sum(self._shares.values()), description=going)

    def end(self, batch: Sequence[str], status: int | None) -> None:
        """Count the figures that a process did not finish, which ended with `status`."""
        for name in batch:
            if name not in self._done:
                self.failed.setdefault(name, f"its process ended with status {status}")


def _run_group(
    group: list[list[str]], processes: int, how: tuple[bool, Path, dict[str, Any]], board: _Board
) -> None:
    """Run batches, at most `processes` at a time; what they say goes to the board."""
    context = multiprocessing.get_context("spawn")
    said: Queue[tuple[str, float | None, str]] = context.Queue()
    waiting, working = list(group), dict[SpawnProcess, list[str]]()
    try:
        while waiting or working:
            while waiting and len(working) < processes:
                batch = waiting.pop(0)
                process = context.Process(target=_work, args=(batch, *how, said), daemon=False)
                process.start()
                working[process] = batch
            _listen(said, board)
            for process in [p for p in working if not p.is_alive()]:
                _listen(said, board)
                batch = working.pop(process)
                board.end(batch, process.exitcode)
    finally:
        for process in working:
            process.terminate()
            process.join()


def _listen(said: Queue[tuple[str, float | None, str]], board: _Board) -> None:
    """Pass on what has been said, waiting a little for the first word."""
    wait = POLL
    while True:
        try:
            name, share, text = said.get(timeout=wait)
        except queue.Empty:
            return
        wait = 0.01
        if share is None:
            board.failed[name] = text
        else:
            board.hear(name, share, text)


def _work(
    batch: list[str],
    quick: bool,
    out: Path,
    made_with: dict[str, Any],
    said: Queue[tuple[str, float | None, str]],
) -> None:
    """Compute the figures of a batch; runs in a process of its own, which Ctrl-C leaves alone.

    The process that started it ends it.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    for name in batch:
        try:
            compute(name, quick, out, made_with, said)
        except Exception as error:  # one figure's failure is not the others'
            said.put((name, None, f"{type(error).__name__}: {error}"))


def compute(
    name: str,
    quick: bool,
    out: Path,
    made_with: dict[str, Any],
    said: Queue[tuple[str, float | None, str]],
) -> Data:
    """Compute one figure and write its JSON file, complete or not at all."""
    from drake_linefoot.evaluation.files import write_text

    parent = multiprocessing.parent_process()

    def tell(share: float, text: str) -> None:
        if parent is not None and not parent.is_alive():
            raise SystemExit(1)  # nobody listens any more
        said.put((name, share, text))

    started = time.perf_counter()
    data = load_figure(name).compute(quick, tell)
    stored = {
        "figure": name,
        "made_with": made_with,
        "seconds": time.perf_counter() - started,
        "data": data,
    }
    write_text(out / f"{name}.json", json.dumps(stored, allow_nan=False) + "\n")
    said.put((name, 1.0, ""))
    return data
