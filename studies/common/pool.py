"""Jobs of a study carried out side by side, with a bar that shows how far they are."""

from collections.abc import Callable, Iterable, Sequence
from functools import partial
from typing import Any

from rich.console import Console
from rich.progress import track

from drake_linefoot.lab.pool import Done, Pool

PROCESSES = 2


def carry_out(
    function: Callable[[Any], Any],
    jobs: Sequence[Any],
    lost: Callable[[Any, str], Any],
    pool: Pool | None = None,
    console: Console | None = None,
) -> list[Any]:
    """Return what a function gives for each job, in their order.

    Args:
        function: of a module, so that a process can import it.
        jobs: its arguments.
        lost: called for a job whose process crashed, ran out of memory or took too long, with the
            reason; returns what stands for the result.
        pool: that carries them out; None for one of `PROCESSES`.
        console: that shows a bar; None for none.
    """
    if pool is None:
        with Pool(PROCESSES, most=len(jobs)) as own:
            return carry_out(function, jobs, lost, own, console)
    results: dict[int, Any] = {}
    numbered = list(enumerate(jobs))
    done: Iterable[Done[tuple[int, Any], Any]] = pool.run(partial(_numbered, function), numbered)
    if console is not None:
        quiet = not console.is_terminal
        done = track(done, "", len(jobs), console=console, transient=True, disable=quiet)
    for one in done:
        number, job = one.job
        results[number] = lost(job, one.error) if one.error else one.value
    return [results[number] for number in range(len(jobs))]


def _numbered(function: Callable[[Any], Any], job: tuple[int, Any]) -> Any:
    return function(job[1])
