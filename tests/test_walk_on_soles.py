"""The closed loop of a robot on soles, on the estimate: it walks every way and takes a push."""

from dataclasses import replace

import numpy as np
import pytest

from drake_linefoot.constants import STANDARD_GRAVITY
from drake_linefoot.lab.results.metrics import segment_velocity
from drake_linefoot.lab.scenario import Segment
from drake_linefoot.lab.scenario.disturbances import PushParameters
from drake_linefoot.lab.simulation.run import simulate
from drake_linefoot.lab.wiring.closed_loop import build_closed_loop
from tests.helpers.walk_on_soles import robot_on_soles

WALK = [
    Segment("stand", 0.5),
    Segment("ahead", 2.5, True, [0.4, 0.0]),
    Segment("aside", 2.5, True, [0.0, 0.15]),
    Segment("turn", 2.5, True, [0.1, 0.0], 0.4),
    Segment("stop", 4.0),
]
SIDE_PUSH = 0.14  # [-] of m sqrt(g l)


@pytest.mark.slow
def test_it_walks_ahead_aside_turns_and_stops():
    humanoid, scenario = robot_on_soles()
    run = simulate(build_closed_loop(replace(scenario, segments=WALK)))
    assert not run.fell, run.fall_reason
    begin = 0.0
    for segment in WALK:
        if segment.walk:
            measured = segment_velocity(run, begin, begin + segment.duration)
            commanded = [*segment.velocity, segment.turn_rate]
            np.testing.assert_allclose(measured, commanded, atol=0.08, err_msg=segment.name)
        begin += segment.duration
    standing = run.time > begin - 0.5
    assert run.planned_contact[standing].min() == 1.0
    assert np.ptp(run.com[standing], axis=0).max() < 0.01
    assert humanoid.contact.size == 6
    assert int(np.max(run.mpc_failures)) == 0


@pytest.mark.slow
@pytest.mark.parametrize("direction", [0.5 * np.pi, -0.5 * np.pi])
def test_standing_it_takes_a_push_to_the_side(direction):
    humanoid, scenario = robot_on_soles()
    unit = humanoid.mass * np.sqrt(STANDARD_GRAVITY * humanoid.com_height)
    push = PushParameters(
        time=1.0, duration=0.1, impulse=float(SIDE_PUSH * unit), direction=direction
    )
    segments = [Segment("stand", 5.0)]
    run = simulate(build_closed_loop(replace(scenario, segments=segments, pushes=[push])))
    assert not run.fell, run.fall_reason
    assert np.ptp(run.com[run.time > 4.5], axis=0).max() < 0.02  # it stands again
