"""The command of a scenario, through its port."""

import numpy as np
import pytest

from drake_linefoot.lab.scenario import Segment
from drake_linefoot.lab.simulation.command import CommandSchedule

SEGMENTS = [
    Segment("stand", 0.5),
    Segment("walk", 1.0, walk=True, velocity=[0.3, -0.1], turn_rate=0.2),
    Segment("stop", 0.25, walk=True),
]


@pytest.mark.parametrize(
    ("time", "expected"),
    [
        (0.0, [0, 0, 0, 0]),
        (0.499, [0, 0, 0, 0]),
        (0.49999999999999994, [0.3, -0.1, 0.2, 1]),  # half a second of periods, summed up
        (0.5, [0.3, -0.1, 0.2, 1]),  # a boundary belongs to the later segment
        (1.499, [0.3, -0.1, 0.2, 1]),
        (1.5, [0, 0, 0, 1]),
        (9.0, [0, 0, 0, 1]),  # the last is held
    ],
)
def test_segments_follow_each_other(time, expected):
    system = CommandSchedule(SEGMENTS)
    context = system.CreateDefaultContext()
    context.SetTime(time)
    port = system.GetOutputPort("command")
    assert port.get_name() == "command" and port.size() == 4
    assert np.array_equal(port.Eval(context), expected)
