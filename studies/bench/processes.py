"""What is measured in processes of their own: imports, start-up, memory.

Run as a module it is such a process: with `first_step FOLDER` it does what `linefoot walk` does up
to the end of its first simulated step, and prints the time then; with `memory FIRST LAST` it walks
for `LAST` seconds, and prints JSON.
"""

import json
import os
import runpy
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

from drake_linefoot.errors import LinefootError

LONGEST = 3600.0  # [s] that a process may take
MEGABYTE = 1e6


def run_time(command: list[str]) -> float:
    """Return how long a process takes from its start to its end [s].

    Raises:
        LinefootError: it fails.
    """
    start = time.perf_counter()
    _run(command)
    return time.perf_counter() - start


def import_time(module: str) -> float:
    """Return how long a process takes that imports a module and ends [s]."""
    return run_time([sys.executable, "-c", f"import {module}"])


def help_time() -> float:
    """Return how long `linefoot --help` takes [s], by the installed command when there is one."""
    command = Path(sys.executable).with_name("linefoot")
    words = [str(command)] if command.exists() else [sys.executable, "-m", "drake_linefoot"]
    return run_time([*words, "--help"])


def first_step_time() -> float:
    """Return how long `linefoot walk` takes from its start to the end of its first step [s]."""
    with tempfile.TemporaryDirectory(prefix="linefoot-") as folder:
        start = time.time()
        return float(_run([sys.executable, "-m", __name__, "first_step", f"{folder}/walk"])) - start


def first_walk() -> dict[str, float]:
    """Return what a first `linefoot walk`, which compiles, takes to its first step [s].

    Returns:
        `first_walk_cpu_s`, of all its processes, and `first_walk_wall_s`.
    """
    before = os.times()
    with tempfile.TemporaryDirectory(prefix="linefoot-") as folder:
        words = [sys.executable, "-m", __name__, "first_step", f"{folder}/walk"]
        _run(words, NUMBA_CACHE_DIR=folder)
    after = os.times()
    user, system = (after[i] - before[i] for i in (2, 3))  # of processes that have ended
    wall = after.elapsed - before.elapsed
    return {"first_walk_cpu_s": user + system, "first_walk_wall_s": wall}


def memory_growth(first: float, last: float) -> dict[str, Any]:
    """Return resident memory of a walk at two times, its growth, and the size of the log."""
    words = [sys.executable, "-m", __name__, "memory", f"{first:g}", f"{last:g}"]
    found: dict[str, Any] = json.loads(_run(words))
    return found


def _run(command: list[str], **variables: str) -> str:
    environment = {**os.environ, **variables}
    done = subprocess.run(
        command, capture_output=True, text=True, check=False, timeout=LONGEST, env=environment
    )
    if done.returncode != 0:
        last = (done.stderr.strip().splitlines() or ["no message"])[-1]
        raise LinefootError(f"{' '.join(command[1:])} failed: {last}")
    return done.stdout.strip().rpartition("\n")[2]


def _walk_to_first_step(folder: str) -> None:
    """Do what the command does; the process ends, with the time on stdout, after its first step.

    There are imports, the scenario, the model, Meshcat for the replay, the diagram and its
    initialisation; nothing is written.
    """
    from pydrake.systems.framework import Context, EventStatus

    from drake_linefoot.lab.simulation import run

    class Stop(run.FallWatch):
        def __call__(self, root: Context) -> EventStatus:
            if root.get_time() > 0.0:
                print(repr(time.time()), flush=True)
                os._exit(0)
            return super().__call__(root)

    run.FallWatch = Stop  # type: ignore[misc]
    sys.argv = ["linefoot", "walk", "--out", folder]
    runpy.run_module("drake_linefoot", run_name="__main__")


def _walk_on(first: float, last: float) -> dict[str, object]:
    """Walk for `last` seconds; return memory, and log on the disk, after `first` and `last` [s]."""
    from drake_linefoot.lab.scenario.edit import with_duration
    from drake_linefoot.lab.simulation.drake_logging import silence_drake
    from drake_linefoot.lab.simulation.run import FallWatch, keep_on_disk
    from drake_linefoot.lab.wiring.closed_loop import build_closed_loop
    from studies.common.runs import paper_scenario

    silence_drake()
    loop = build_closed_loop(with_duration(paper_scenario(quick=False), last))
    simulator, watch = loop.make_simulator(), FallWatch(loop)
    simulator.set_monitor(watch)
    found: dict[str, object] = {"fell": "", "times_s": [first, last]}
    resident = []
    with tempfile.TemporaryDirectory(prefix="linefoot-") as folder:
        keep_on_disk(loop, Path(folder))
        for name, end in (("first", first), ("last", last)):
            simulator.AdvanceTo(end)
            log = loop.recorder.count * loop.recorder.dtype.itemsize / MEGABYTE
            statm = Path("/proc/self/statm").read_text(encoding="ascii")  # Linux only
            resident.append(int(statm.split()[1]) * os.sysconf("SC_PAGE_SIZE") / MEGABYTE)
            found[name] = {"resident_mb": resident[-1], "log_mb": log}
            if watch.reason:
                found["fell"] = f"at {simulator.get_context().get_time():.2f} s: {watch.reason}"
                break
    whole = len(resident) == 2 and not found["fell"]
    found["growth_mb"] = resident[1] - resident[0] if whole else None
    return found


if __name__ == "__main__":
    if sys.argv[1] == "first_step":
        _walk_to_first_step(sys.argv[2])
    else:
        print(json.dumps(_walk_on(float(sys.argv[2]), float(sys.argv[3]))))
