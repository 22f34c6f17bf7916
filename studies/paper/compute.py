"""Figures computed side by side, in processes of their own."""

import time
from collections.abc import Sequence
from concurrent.futures import as_completed
from functools import partial
from pathlib import Path
from typing import Any

from rich.console import Console

from drake_linefoot.errors import LinefootError
from studies.common.files import write_json
from studies.common.pool import PROCESSES, progress_bar, say, workers
from studies.paper.figure import ALONE, load_figure

SHARED = ("fig3", "fig5", "fig6", "fig7", "feasibility")  # show the same simulated walk
LONGEST = ("grid", "fig4")  # begun first


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
    """Compute figures and write their JSON files, with `made_with` in each, showing how far it is.

    Raises:
        LinefootError: a figure could not be computed, or its process died; those that were
            computed are written.
    """
    failed: dict[str, str] = {}
    shares = dict.fromkeys(names, 0.0)
    texts: dict[str, str] = {}
    with progress_bar(console) as bar:
        task = bar.add_task("starting", total=float(len(names)))

        def report(name: str, share: float, text: str) -> None:
            shares[name], texts[name] = share, text
            going = "; ".join(f"{n}: {t}" for n, t in texts.items() if shares[n] < 1.0)
            bar.update(task, completed=sum(shares.values()), description=going)

        side_by_side, alone = batches(names)
        for group, processes in ((side_by_side, PROCESSES), (alone, 1)):
            with workers(processes, report) as pool:
                jobs = [pool.submit(compute, batch, quick, out, made_with) for batch in group]
                for job in as_completed(jobs):
                    failed |= job.result()
    if failed:
        raise LinefootError("; ".join(f"{name}: {why}" for name, why in failed.items()))


def compute(
    batch: Sequence[str], quick: bool, out: Path, made_with: dict[str, Any]
) -> dict[str, str]:
    """Compute the figures of a batch and write their files; return why some failed, by name."""
    failed = {}
    for name in batch:
        started = time.perf_counter()
        try:
            data = load_figure(name).compute(quick, partial(say, name))
            seconds = time.perf_counter() - started
            stored = {"figure": name, "made_with": made_with, "seconds": seconds, "data": data}
            write_json(out / f"{name}.json", stored, indent=None)
        except Exception as error:  # one figure's failure is not the others'
            failed[name] = f"{type(error).__name__}: {error}"
        say(name, 1.0, "")
    return failed
