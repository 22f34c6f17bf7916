"""Figures computed side by side, in processes of their own."""

import time
from collections.abc import Sequence
from functools import partial
from itertools import chain
from pathlib import Path
from typing import Any

from rich.console import Console

from drake_linefoot.errors import LinefootError
from drake_linefoot.lab.pool import Pool
from studies.common.files import write_json
from studies.common.pool import PROCESSES
from studies.common.trials import SECONDS
from studies.paper.figure import ALONE, load_figure

SHARED = ("fig3", "fig5", "fig6", "fig7", "feasibility")  # show the same simulated walk
LIMIT = 12.0 * 3600.0  # [s] of a batch
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
    begun = partial(compute, quick=quick, out=out, made_with=made_with)
    side_by_side, alone = batches(names)
    with console.status("computing") as status:
        for group, processes in ((side_by_side, PROCESSES), (alone, 1)):
            going = list(chain(*group))
            status.update(f"computing {', '.join(going)}")
            with Pool(processes) as pool:
                for one in pool.run(begun, group, lambda batch: LIMIT):
                    failed |= one.value or dict.fromkeys(one.job if one.error else (), one.error)
                    going = [name for name in going if name not in one.job]
                    status.update(f"computing {', '.join(going)}")
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
            data = load_figure(name).compute(quick)
            seconds = data.pop(SECONDS, time.perf_counter() - started)  # of all that was kept
            stored = {"figure": name, "made_with": made_with, "seconds": seconds, "data": data}
            write_json(out / f"{name}.json", stored, indent=None)
        except Exception as error:  # one figure's failure is not the others'
            failed[name] = f"{type(error).__name__}: {error}"
    return failed
