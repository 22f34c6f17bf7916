"""Resident memory of a long walk at two times, and the size of the log in it; prints JSON."""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path

from drake_linefoot.benchmark.scenarios import walking
from drake_linefoot.scenario_edit import with_duration
from drake_linefoot.simulation.quiet import quieten_drake
from drake_linefoot.simulation.recorder import Recorder
from drake_linefoot.simulation.recording import CHANNELS
from drake_linefoot.simulation.run import FallWatch
from drake_linefoot.wiring.closed_loop import build_closed_loop

MEGABYTE = 1e6


def resident() -> float:
    """Return the resident memory of this process [MB]; Linux only."""
    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / MEGABYTE


def log_size(recorder: Recorder) -> float:
    """Return what the samples take [MB]; room in reserve is not resident."""
    row = sum(recorder.recent(name, 1).nbytes for name in CHANNELS)
    return recorder.count * row / MEGABYTE


def measure(first: float, last: float) -> dict[str, object]:
    """Walk for `last` seconds; return memory and log after `first` and `last` [s], in MB."""
    loop = build_closed_loop(with_duration(walking(), last))
    simulator = loop.make_simulator()
    watch = FallWatch(loop)
    simulator.set_monitor(watch)
    found: dict[str, object] = {"fell": "", "times_s": [first, last]}
    rest = []
    for name, end in (("first", first), ("last", last)):
        simulator.AdvanceTo(end)
        total, log = resident(), log_size(loop.recorder)
        found[name] = {"resident_mb": total, "log_mb": log}
        rest.append(total - log)
        if watch.reason:
            found["fell"] = f"at {simulator.get_context().get_time():.2f} s: {watch.reason}"
            break
    found["growth_mb"] = rest[1] - rest[0] if len(rest) == 2 and not found["fell"] else None
    return found


if __name__ == "__main__":
    quieten_drake()
    print(json.dumps(measure(float(sys.argv[1]), float(sys.argv[2]))))
