"""Kills, interrupts and full disks: what is in the folder of a run afterwards is whole."""

import os
import resource
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np

from drake_linefoot.lab.simulation.recording import LOG, UNFINISHED, Run
from drake_linefoot.resources import PACKAGE
from studies.fault_injection.tally import Tally

LINEFOOT = (sys.executable, "-m", "drake_linefoot")
WALK = ("walk", "stand", "--duration", "0.3")
SIGNALS = (signal.SIGKILL, signal.SIGTERM, signal.SIGINT)
BEGINNING = 2**14  # bytes of a log without a sample, at most
EARLIEST, LATEST = 0.5, 8.0  # [s] after its start at which a run is killed; Python starts first
TIMEOUT = 300.0  # [s]
LARGEST = 2**21  # bytes of a file on the smallest full disk, and half of the next and so on


def environment() -> dict[str, str]:
    """Return the environment of a process that uses this package."""
    return {**os.environ, "PYTHONPATH": str(PACKAGE.parent), "PYTHONDONTWRITEBYTECODE": "1"}


def started(*words: str, new_session: bool = False) -> "subprocess.Popen[str]":
    """Start the command line, of which only errors are heard."""
    return subprocess.Popen(
        [*LINEFOOT, *words],
        start_new_session=new_session,
        env=environment(),
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    )


def begin(out: Path, file_size: int | None = None) -> "subprocess.Popen[str]":
    """Start a short run; its files may have so many bytes."""
    process = started(*WALK, "--out", str(out), new_session=True)
    if file_size is not None:
        resource.prlimit(process.pid, resource.RLIMIT_FSIZE, (file_size, file_size))
    return process


def remains(out: Path, said: str) -> str:
    """Return what is wrong with a folder and what was said; nothing when all is well."""
    if "Traceback" in said:
        return f"traceback: {said.strip().splitlines()[-1]}"
    logs = [out / LOG] if out.exists() else []
    part = out.with_name(out.name + UNFINISHED)
    if (part / LOG).exists() and (part / LOG).stat().st_size > BEGINNING:
        logs.append(part)
    try:
        for log in logs:
            Run.load(log)
    except Exception as error:
        return f"half-written: {error}"
    return ""


def kills(count: int, seed: int, folder: Path) -> Tally:
    """Kill runs that replace an older result, each at a moment of its own."""
    tally, out = Tally("kills and interrupts"), folder / "killed"
    begin(out).communicate(timeout=TIMEOUT)
    for number in range(seed, seed + count):
        process = begin(out)
        how = SIGNALS[number % len(SIGNALS)]
        try:
            wait = float(np.random.default_rng(number).uniform(EARLIEST, LATEST))
            _, said = process.communicate(timeout=wait)
            end = "had ended before"
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, how)
            _, said = process.communicate(timeout=TIMEOUT)
            end = f"ended by {how.name}"
        problem = remains(out, said) or ("" if out.exists() else "the older result is lost")
        tally.count(end, problem and f"{number}, {how.name}: {problem}")
    _, said = begin(out).communicate(timeout=TIMEOUT)
    left = [path.name for path in folder.iterdir() if path.name.startswith(".killed-")]
    if left or (problem := remains(out, said)):
        tally.wrong.append(f"{tally.what}: at the end {left or problem}")
    return tally


def full_disks(count: int, folder: Path) -> Tally:
    """Let runs write to a disk that is full after so many bytes."""
    tally, out = Tally("full disks"), folder / "full"
    for i in range(count):
        size = int(LARGEST * 0.4**i)
        process = begin(out, size)
        _, said = process.communicate(timeout=TIMEOUT)
        lines = [line for line in said.splitlines() if line.startswith("linefoot: ")]
        problem = remains(out, said)
        if process.returncode != 0 and len(lines) != 1:
            problem = problem or f"{len(lines)} lines"
        tally.count(f"status {process.returncode}", problem and f"{size} bytes: {problem}")
    return tally
