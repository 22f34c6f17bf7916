"""The command: tries everything, stores what was counted, makes `docs/reliability.md` of it."""

import json
import secrets
import sys
import tempfile
import time as clock
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Annotated, Any

import typer

from drake_linefoot.lab.results.page import render
from drake_linefoot.resources import PACKAGE
from studies.common.command import BROKE_OFF, Quick, run
from studies.common.files import write_json, write_text
from studies.common.stamp import cpu_seconds, stamped
from studies.fault_injection import again as repeated
from studies.fault_injection import hour as long_walk
from studies.fault_injection.bad_inputs import KINDS, bad_inputs, probe
from studies.fault_injection.faults import full_disks, kills
from studies.fault_injection.solver_faults import FAULTS as KINDS_OF_FAULTS
from studies.fault_injection.solver_faults import solver_faults
from studies.fault_injection.sweep_kills import sweep_kills
from studies.fault_injection.tally import Tally

Data = dict[str, Any]
PAGE = PACKAGE.parent / "docs" / "reliability.md"
NOTHING: Data = {"tallies": [], "fresh": 0, "minutes": 0.0, "made_with": {}}
NOTHING |= dict.fromkeys(("hour", "again"))
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
    again: Annotated[
        bool, typer.Option("--again", help="Drive and sweep again and again instead.")
    ] = False,
    minutes: Annotated[float, typer.Option(min=0.0, help="Of --again.")] = repeated.MINUTES,
    redraw: Annotated[bool, typer.Option("--page", help="Only write the page anew.")] = False,
) -> None:
    """Try to break it: bad inputs, faults, kills, full disks; or watch it for an hour."""
    file = out.with_suffix(".json")
    data = json.loads(file.read_text(encoding="utf-8")) if file.exists() else {}
    share = QUICK if quick else 1.0
    wrong = []
    if hour or again:
        with tempfile.TemporaryDirectory() as scratch:
            if hour:
                found = long_walk.hour(share * long_walk.DURATION, Path(scratch))
            else:
                found = repeated.again(share * minutes, repeated.LENGTH, Path(scratch))
        data["hour" if hour else "again"], wrong = found, found["wrong"]
    elif not redraw:
        data |= _counted(secrets.randbelow(2**31) if seed is None else seed, share)
        wrong = [line for tally in data["tallies"] for line in tally["wrong"]]
    write_json(file, data)
    write_text(out, page(data))
    typer.echo(str(out))
    if wrong:
        raise typer.Exit(BROKE_OFF)


def _counted(fresh: int, share: float) -> Data:
    """Try a share of everything, new from `fresh` on; return what was counted, as JSON takes it."""
    start, tallies = clock.monotonic(), list[Tally]()
    with tempfile.TemporaryDirectory() as scratch:
        for what, trial in trials(fresh, share, Path(scratch)).items():
            typer.echo(f"{what} ...")
            tallies.append(trial())
            for line in tallies[-1].wrong:
                typer.echo(line)
    minutes = (clock.monotonic() - start) / 60.0
    facts = {
        "fresh": fresh,
        "minutes": minutes,
        **stamped("fault_injection", cpu_seconds(), probe if share == 1.0 else None),
    }
    return {"tallies": summed(tallies), **facts}


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


def summed(tallies: list[Tally]) -> list[Data]:
    """Return tallies as JSON takes them, those of one kind as one."""
    kinds: dict[str, Tally] = {}
    for tally in tallies:
        same = kinds.setdefault(tally.what, Tally(tally.what))
        same.ends += tally.ends
        same.wrong += tally.wrong
    return [{**vars(tally), "ends": dict(tally.ends)} for tally in kinds.values()]


def page(data: Data) -> str:
    """Return the page of what was counted and measured, as it is stored."""
    data = NOTHING | data
    tallies = data["tallies"]
    tried = sum(sum(tally["ends"].values()) for tally in tallies)
    facts = {"tried": tried, "wrong": sum(len(tally["wrong"]) for tally in tallies)}
    return render("reliability.md.j2", Path(__file__).parent, **facts, **data)


if __name__ == "__main__":
    sys.exit(run(fault_injection, "fault_injection"))
