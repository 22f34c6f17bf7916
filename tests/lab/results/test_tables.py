"""What is printed while a walk goes on."""

import io

import numpy as np
from rich.console import Console

from drake_linefoot.lab.results import tables
from drake_linefoot.lab.simulation import run as simulation
from drake_linefoot.lab.simulation.run import Progress


def test_progress_names_time_rate_and_both_velocities():
    progress = simulation.Progress(1.5, 14.0, 0.5, (0.4, 0.0, 0.0), (0.38, -0.01, 0.0), ())
    first, second = tables.progress_text(progress).splitlines()
    assert first == " 1.50 of 14.00 s, 0.50 x real time"
    assert second == "commanded  0.40  0.00  0.00, measured  0.38 -0.01  0.00"
    slowed = tables.progress_text(progress._replace(warnings=("command limited: slope", "a")))
    assert slowed.splitlines()[0] == f"{first}, command limited: slope, a"


def test_without_a_terminal_a_slow_walk_says_now_and_then_how_far_it_is(monkeypatch):
    now, console = [0.0], Console(file=io.StringIO(), width=110)
    monkeypatch.setattr(tables.clock, "monotonic", lambda: now[0])
    with tables.progress_bar(console) as progress:
        for now[0] in (10.0, 61.0, 100.0, 122.0):
            progress(Progress(0.01 * now[0], 9.0, 0.01, np.zeros(3), np.zeros(3), ()))
    assert console.file.getvalue().splitlines() == [
        " 0.61 of 9.00 s, 0.01 x real time",
        " 1.22 of 9.00 s, 0.01 x real time",
    ]
