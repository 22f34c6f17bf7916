"""Times of ticks: their shares, and the command that prints them."""

import os

import numpy as np
import pytest

from drake_linefoot.errors import InputError
from drake_linefoot.lab import cli
from drake_linefoot.lab.remote.control import RemoteControl
from drake_linefoot.lab.remote.latency import LocalLine, machine, table_of
from drake_linefoot.lab.remote.messages import RobotInput, RobotOutput
from drake_linefoot.lab.remote.priority import HELPERS, TICKS, run_first
from drake_linefoot.wiring.without_simulator import Controller


def test_shares_are_those_of_the_ticks_after_the_first():
    times = [9.0, *np.linspace(0.0, 2e-3, 1001)]
    assert dict(table_of(times, 0.001)) == {
        "half of the ticks took at most": "1.00 ms",
        "99 % took at most": "1.98 ms",
        "99.9 % took at most": "2.00 ms",
        "all took at most": "2.00 ms",
        "longer than the period of 1 ms": "49.95 %",
    }


def test_the_machine_is_described():
    rows = dict(machine())
    assert "cores" in rows["machine"] and set(rows) >= {"machine"}


def test_a_line_takes_the_time_of_each_answer(humanoid):
    line = LocalLine(RemoteControl(Controller(humanoid)))
    q, v = np.split(humanoid.x_nominal, [humanoid.nq])
    for seq in range(3):
        line.publish(RobotOutput(1000 * seq, seq, q, v, np.zeros(humanoid.na), np.zeros(6)))
        assert line.take(RobotInput).seq == seq
        assert line.take(RobotInput) is None
    assert len(line.times) == 3 and min(line.times) > 0.0


@pytest.mark.slow
def test_the_command_prints_them(capsys):
    assert cli.main(["latency", "walk", "--duration", "1"]) == 0
    said = capsys.readouterr().out
    assert "99.9 % took at most" in said and "scheduled" in said
    assert cli.main(["latency", "walk", "--duration", "1", "--process"]) == 0
    assert "plans late or unsolved" in capsys.readouterr().out


@pytest.mark.slow
def test_ticks_run_before_what_they_start_and_both_before_all_else(monkeypatch, capsys):
    asked = []
    monkeypatch.setattr(
        os, "sched_setscheduler", lambda who, how, p: asked.append((who, how, p.sched_priority))
    )
    assert cli.main(["latency", "stand", "--duration", "0.1", "--first"]) == 0
    assert asked == [(0, os.SCHED_FIFO, HELPERS), (0, os.SCHED_FIFO, TICKS)]
    assert HELPERS < TICKS


def test_who_may_not_run_first_is_told_what_would_allow_it(monkeypatch, capsys):
    def refused(*_):
        raise PermissionError(1, "Operation not permitted")

    monkeypatch.setattr(os, "sched_setscheduler", refused)
    assert cli.main(["latency", "stand", "--duration", "0.1", "--first"]) == 2
    assert "--first = 10: must be left out, or allowed: by root" in capsys.readouterr().err
    monkeypatch.delattr(os, "SCHED_FIFO")
    with pytest.raises(InputError, match="this system has no SCHED_FIFO"):
        run_first(TICKS)
