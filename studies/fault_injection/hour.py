"""A long walk: memory while it is simulated, and when it is written."""

import os
import subprocess
import time as clock
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import psutil

from drake_linefoot.errors import InputError, LinefootError
from drake_linefoot.lab.results.provenance import made_with
from drake_linefoot.lab.simulation.log import read_log
from drake_linefoot.lab.simulation.recording import LOG, UNFINISHED, Run
from studies.fault_injection.faults import LINEFOOT, environment

DURATION = 3600.0  # [s]
SPEED = 0.4  # [m/s]
POLL = 1.0  # [s]
SETTLED = 30.0  # [s] simulated, after which memory must not grow
LARGEST_GROWTH = 50.0  # [MB]


class Look(NamedTuple):
    """What is seen of a running walk; memory in MB."""

    wall: float  # [s] since the start
    simulated: float  # [s], on the disk
    own: float
    children: float
    disk: float  # of its samples


def hour(duration: float, folder: Path) -> dict[str, Any]:
    """Walk for so long [s]; return what the section of the page says, `wrong` among it."""
    out = folder / "hour"
    words = [*LINEFOOT, "walk", "--vx", str(SPEED), "--duration", str(duration), "--out", str(out)]
    process = psutil.Popen(words, env=environment(), stdout=subprocess.DEVNULL)
    looks, start = [], clock.monotonic()
    while process.poll() is None:
        looks.append(_look(process, out.with_name(out.name + UNFINISHED), start))
        clock.sleep(POLL)
    if process.returncode != 0:
        raise LinefootError(f"the walk ended with status {process.returncode}")
    run = Run.load(out)
    last = max(look.simulated for look in looks)
    while_simulated = [s for s in looks if SETTLED <= s.simulated < last] or looks[:1]
    after = [s for s in looks if s.simulated >= last or s.wall > while_simulated[-1].wall]
    first = while_simulated[0].own
    growth = max(s.own for s in while_simulated) - first
    failures = run.mpc_failures[-1] + np.sum(1.0 - run.wbc_success)
    wrong = []
    if run.fell or abs(float(run.time[-1]) - duration) > 0.01:
        wrong.append(f"ended at {run.time[-1]:.3f} s {run.fall_reason}")
    if growth > LARGEST_GROWTH:
        wrong.append(f"memory grew by {growth:.0f} MB")
    return {
        "made_with": made_with(),
        "speed": SPEED,
        "duration": duration,
        "simulated": float(run.time[-1]),
        "steps": int(run.gait_steps[-1]),
        "failures": int(failures),
        "fell": run.fell,
        "wall": run.wall_seconds,
        "writing": looks[-1].wall - while_simulated[-1].wall,
        "settled": SETTLED,
        "first": first,
        "growth": growth,
        "peak": max(s.own for s in after),
        "drawing": max(s.children for s in after),
        "samples": max(s.disk for s in looks),
        "folder": _size(out),
        "wrong": wrong,
    }


def _look(process: psutil.Popen, part: Path, start: float) -> Look:
    simulated = own = children = 0.0
    try:
        simulated = float(read_log(part / LOG).channel("time")[-1:].sum())
    except InputError:
        pass
    try:
        own = process.memory_info().rss / 1e6
        children = sum(child.memory_info().rss for child in process.children(recursive=True)) / 1e6
    except psutil.Error:
        pass
    return Look(clock.monotonic() - start, simulated, own, children, _size(part))


def _size(folder: Path) -> float:
    """Return what is in a folder [MB]."""
    files = (Path(root) / name for root, _, names in os.walk(folder) for name in names)
    return sum(file.stat().st_size for file in files if file.exists()) / 1e6
