"""Times of ticks: their shares, and the command that prints them."""

import numpy as np
import pytest

from drake_linefoot.lab import cli
from drake_linefoot.lab.remote.control import RemoteControl
from drake_linefoot.lab.remote.latency import LocalLine, machine, table_of
from drake_linefoot.lab.remote.messages import RobotInput, RobotOutput
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
