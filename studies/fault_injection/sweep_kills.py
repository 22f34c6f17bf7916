"""Kills of sweeps: of the process itself, of a worker, of a scheduler elsewhere.

The same command goes on afterwards and ends with the rows of an undisturbed sweep.
"""

import json
import signal
import sqlite3
import subprocess
import sys
import time as clock
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path

import numpy as np
import psutil

from drake_linefoot.lab.sweep.journal import JOURNAL
from studies.fault_injection.faults import TIMEOUT, environment, started
from studies.fault_injection.tally import Tally

SWEEP = """
name: killed
scenario: stand
runs: 6
seed: 1
set:
  segments: [{name: stand, duration: 0.4}]
sample:
  perturbation.joint_velocity: {uniform: [0.0, 0.5]}
"""
LATEST = 12.0  # [s] after the start, at which something is killed
MAIN, INTERRUPT, WORKER, SCHEDULER = "the sweep", "Ctrl-C", "a worker", "the scheduler"
WHOM = (MAIN, WORKER, SCHEDULER, INTERRUPT)
ENDS = {  # statuses with which the command may end; 0 also when it had ended before
    MAIN: {0, -signal.SIGKILL},
    INTERRUPT: {0, 130, -signal.SIGINT},
    WORKER: {0},
    SCHEDULER: {0, 2, 3},
}


def sweep_kills(count: int, seed: int, folder: Path) -> Tally:
    """Kill sweeps, each at a moment of its own, and let them go on."""
    tally, file = Tally("kills of sweeps"), folder / "killed.yaml"
    file.write_text(SWEEP, encoding="utf-8")
    process = begin(file, folder / "whole")
    process.communicate(timeout=TIMEOUT)
    whole = hashes(folder / "whole")
    for number in range(seed, seed + count):
        whom, out = WHOM[number % len(WHOM)], folder / f"sweep{number}"
        wait = LATEST * float(np.random.default_rng(number).random())
        if whom == SCHEDULER:
            with elsewhere(folder / "scheduler.json") as (scheduler, address):
                process = begin(file, out, "--scheduler", address)
                end = killed(process, whom, wait, scheduler)
        else:
            process = begin(file, out)
            end = killed(process, whom, wait)
        said = process.communicate(timeout=TIMEOUT)[1]
        problem = _wrong(process.returncode, whom, said)
        again = begin(file, out)
        said = again.communicate(timeout=TIMEOUT)[1]
        if not problem and (again.returncode != 0 or hashes(out) != whole):
            problem = f"does not go on: {again.returncode} {said.strip()[-200:]}"
        tally.count(end, problem and f"{number}, {whom} after {wait:.2f} s: {problem}")
    return tally


def begin(file: Path, out: Path, *words: str) -> "subprocess.Popen[str]":
    """Start a sweep."""
    return started("sweep", str(file), "--out", str(out), "--replays", "0", *words)


def killed(
    process: "subprocess.Popen[str]",
    whom: str,
    wait: float,
    scheduler: psutil.Process | None = None,
) -> str:
    """Kill something after a while [s]; return what was, in words."""
    deadline = clock.monotonic() + wait
    while process.poll() is None and clock.monotonic() < deadline:
        clock.sleep(0.01)
    if process.poll() is not None:
        return "had ended before"
    if whom == INTERRUPT:
        process.send_signal(signal.SIGINT)
        return whom
    victim = {MAIN: psutil.Process(process.pid), SCHEDULER: scheduler}.get(whom)
    if victim is None:
        family = psutil.Process(process.pid).children(recursive=True)
        workers = [p for p in family if p.ppid() != process.pid]  # forked from a server
        if not workers:
            return "no worker yet"
        victim = workers[0]
    victim.kill()
    return whom


@contextmanager
def elsewhere(file: Path) -> Iterator[tuple[psutil.Process, str]]:
    """Give the process of a scheduler with one worker, and its address."""
    file.unlink(missing_ok=True)
    common = ["--scheduler-file", str(file), "--no-dashboard"]
    parts = {
        "dask_scheduler": ["--host", "127.0.0.1", "--port", "0", *common],
        "dask_worker": ["--nthreads", "1", "--no-nanny", *common],
    }
    started = [
        psutil.Popen(
            [sys.executable, "-m", f"distributed.cli.{name}", *words],
            env=environment(),
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        for name, words in parts.items()
    ]
    try:
        deadline = clock.monotonic() + TIMEOUT
        while not file.exists() and clock.monotonic() < deadline:
            clock.sleep(0.05)
        clock.sleep(0.2)
        yield started[0], json.loads(file.read_text(encoding="utf-8"))["address"]
    finally:
        for each in started:
            each.kill()
            each.wait()


def hashes(out: Path) -> dict[tuple[str, int], str]:
    """Return the hash of each run of a sweep."""
    with closing(sqlite3.connect(out / JOURNAL)) as journal:
        rows = journal.execute('SELECT "group", "index", state_hash FROM runs').fetchall()
    return {(group, index): found for group, index, found in rows}


def _wrong(status: int, whom: str, said: str) -> str:
    """Return what is wrong with how a sweep ended; nothing when all is well."""
    if "Traceback" in said:
        return f"traceback: {said.strip().splitlines()[-1]}"
    return "" if status in ENDS[whom] else f"status {status}: {said.strip()[-200:]}"
