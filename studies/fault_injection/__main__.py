"""The command: tries everything, writes `docs/reliability.md`, fails when anything was wrong."""

import secrets
import sys
import tempfile
import time as clock
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from drake_linefoot.files import write_file
from drake_linefoot.lab.results.page import render
from drake_linefoot.lab.results.provenance import made_with
from drake_linefoot.resources import PACKAGE
from studies.common.command import BROKE_OFF, Quick, run
from studies.fault_injection import hour as long_walk
from studies.fault_injection.bad_inputs import KINDS, bad_inputs
from studies.fault_injection.faults import full_disks, kills
from studies.fault_injection.solver_faults import FAULTS as KINDS_OF_FAULTS
from studies.fault_injection.solver_faults import solver_faults
from studies.fault_injection.sweep_kills import sweep_kills
from studies.fault_injection.tally import Tally

PAGE = PACKAGE.parent / "docs" / "reliability.md"
QUICK = 0.01  # of what is tried
FAULTS, KILLS, SWEEPS, DISKS = 2 * len(KINDS_OF_FAULTS), 60, 16, 10
FIXED = 0.5  # of the bad inputs have the same seeds every time


def fault_injection(
    quick: Quick = False,
    seed: Annotated[
        int | None, typer.Option(min=0, metavar="NUMBER", help="Of the fresh ones; else random.")
    ] = None,
    out: Annotated[Path, typer.Option(metavar="FILE", help="The page.")] = PAGE,
    hour: Annotated[bool, typer.Option("--hour", help="Walk for an hour instead.")] = False,
) -> None:
    """Try to break it: bad inputs, faults, kills, full disks; or watch it walk for an hour."""
    if hour:
        _walk_for_an_hour(out, QUICK if quick else 1.0)
        return
    fresh = secrets.randbelow(2**31) if seed is None else seed
    start = clock.monotonic()
    tallies = []
    with tempfile.TemporaryDirectory() as scratch:
        for what, trial in trials(fresh, QUICK if quick else 1.0, Path(scratch)).items():
            typer.echo(f"{what} ...")
            tallies.append(trial())
            for line in tallies[-1].wrong:
                typer.echo(line)
    counts = page(tallies, fresh, (clock.monotonic() - start) / 60.0)
    write_file(out, (counts + _sections(out)[1]).encode())
    typer.echo(str(out))
    if any(tally.wrong for tally in tallies):
        raise typer.Exit(BROKE_OFF)


def _walk_for_an_hour(out: Path, share: float) -> None:
    """Write the section of the page on a long walk; the counts stay."""
    with tempfile.TemporaryDirectory() as scratch:
        text, wrong = long_walk.hour(share * long_walk.DURATION, Path(scratch))
    write_file(out, f"{_sections(out)[0]}\n{text}".encode())
    typer.echo(str(out))
    if wrong:
        raise typer.Exit(BROKE_OFF)


def _sections(file: Path) -> tuple[str, str]:
    """Return the counts on the page there is, and its section on a long walk."""
    text = file.read_text(encoding="utf-8") if file.exists() else ""
    counts, title, walked = text.partition(f"\n{long_walk.TITLE}")
    return counts, title + walked


def trials(fresh: int, share: float, folder: Path) -> dict[str, Callable[[], Tally]]:
    """Return what is tried: a share of the full number, new from `fresh` on; files in `folder`."""

    def some(count: int) -> int:
        return max(1, round(count * share))

    made: dict[str, Callable[[], Tally]] = {}
    for kind, (_, _, count) in KINDS.items():
        again, new = some(round(FIXED * count)), some(round((1.0 - FIXED) * count))
        made[f"{kind}, seeds 0 to {again - 1}"] = partial(bad_inputs, kind, again, 0, folder)
        made[f"{kind}, fresh"] = partial(bad_inputs, kind, new, fresh, folder)
    made["faults of solvers"] = partial(solver_faults, some(FAULTS), fresh, folder)
    made["kills"] = partial(kills, some(KILLS), fresh, folder)
    made["kills of sweeps"] = partial(sweep_kills, some(SWEEPS), fresh, folder)
    made["full disks"] = partial(full_disks, some(DISKS), folder)
    return made


def page(tallies: list[Tally], fresh: int, minutes: float) -> str:
    """Return the page of what was counted."""
    kinds: dict[str, Tally] = {}
    for tally in tallies:
        same = kinds.setdefault(tally.what, Tally(tally.what))
        same.ends += tally.ends
        same.wrong += tally.wrong
    facts = {"fresh": fresh, "minutes": minutes, "made_with": made_with()}
    return render("reliability.md.j2", Path(__file__).parent, tallies=[*kinds.values()], **facts)


if __name__ == "__main__":
    sys.exit(run(fault_injection, "fault_injection"))
