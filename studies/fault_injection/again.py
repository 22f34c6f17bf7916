"""Drives with resets, and sweeps, in one process: none takes more than those before."""

import io
import time as clock
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import psutil
from rich.console import Console

from drake_linefoot.lab.drive.session import Session
from drake_linefoot.lab.results.provenance import made_with
from drake_linefoot.lab.scenario import Scenario
from drake_linefoot.lab.sweep.main import Options, main_sweep
from drake_linefoot.mpc.models.registry import MODELS

MINUTES = 60.0  # half of them of drives, and again of sweeps
LENGTH = 10.0  # [s] simulated, of a drive
FORCE = 80.0  # [N] for 0.1 s, of the push in its middle
LARGEST_GROWTH = 50.0  # [MB]
LARGEST_SLOWING = 1.5  # [-] of the median of the first third
SWEEP = """
name: again
scenario: stand
runs: 2
set: {segments: [{name: stand, duration: 0.1}]}
sample: {perturbation.joint_velocity: {uniform: [0.0, 0.5]}}
"""


class Look(NamedTuple):
    """What is seen after a drive or a sweep."""

    seconds: float  # that it took; of the processor, where it is all in this process
    memory: float  # of this process [MB]


class Series(NamedTuple):
    """What was done again and again, and what is to say of it."""

    what: str
    number: int  # of them
    first: float  # [s] of one, the median of the first third
    last: float  # of the last third
    memory: float  # [MB] after the first third
    growth: float  # [MB] at most, from then on

    def wrong(self) -> list[str]:
        """Return what should not have been, a line each."""
        found = []
        if self.growth > LARGEST_GROWTH:
            found.append(f"{self.what}: memory grew by {self.growth:.0f} MB")
        if self.last > LARGEST_SLOWING * self.first:
            found.append(f"{self.what}: {self.last:.2f} s at the end, {self.first:.2f} s before")
        return found


def again(minutes: float, length: float, folder: Path) -> dict[str, Any]:
    """Drive, and then sweep; return what the section of the page says, `wrong` among it.

    Args:
        minutes: of wall time for both; each is done three times at least.
        length: of a drive, simulated [s].
        folder: for the sweeps.
    """
    seconds = 30.0 * minutes
    driven = f"drives of {length:g} s, recorded, with a push, another model and a reset"
    found = [
        series(driven, seconds, driver(length)),
        series("sweeps of 2 runs, with table and report", seconds, sweeper(folder)),
    ]
    wrong = [line for each in found for line in each.wrong()]
    series_of = [each._asdict() for each in found]
    return {"made_with": made_with(), "minutes": minutes, "series": series_of, "wrong": wrong}


def series(what: str, seconds: float, do: Callable[[int], float]) -> Series:
    """Do something again and again; `do` takes its number and returns the time it took [s]."""
    looks, end, process = list[Look](), clock.monotonic() + seconds, psutil.Process()
    while clock.monotonic() < end or len(looks) < 3:
        took = do(len(looks))
        looks.append(Look(took, process.memory_info().rss / 1e6))
    return summary(what, looks)


def summary(what: str, looks: list[Look]) -> Series:
    """Return what is to say of at least three looks; the first third is for caches to fill."""
    third = len(looks) // 3
    settled = looks[third - 1].memory
    return Series(
        what,
        len(looks),
        float(np.median([look.seconds for look in looks[:third]])),
        float(np.median([look.seconds for look in looks[-third:]])),
        settled,
        max(look.memory for look in looks[third:]) - settled,
    )


def driver(length: float) -> Callable[[int], float]:
    """Return what drives: a robot that walks, is pushed and retuned, and begins again."""
    session, models = Session(Scenario(), None, record=True), list(MODELS)

    def drive(number: int) -> float:
        start = clock.process_time()
        session.command([0.4, 0.0, 0.3 * (-1) ** number, 1.0])
        session.advance(0.5 * length)
        session.push(FORCE * np.array([np.cos(number), np.sin(number)]))
        session.retune(replace(session.tuning, model=models[number % len(models)]))
        session.advance(0.5 * length)
        session.reset()
        return clock.process_time() - start

    return drive


def sweeper(folder: Path) -> Callable[[int], float]:
    """Return what sweeps: on one process, into the same folder, begun anew."""
    file, screen = folder / "again.yaml", Console(file=io.StringIO())
    file.write_text(SWEEP, encoding="utf-8")

    def sweep(number: int) -> float:
        start = clock.monotonic()
        main_sweep(file, Options(folder / "again", workers=1, fresh=number > 0, replays=0), screen)
        return clock.monotonic() - start

    return sweep
