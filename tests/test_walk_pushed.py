"""The closed loop under pushes that its controller knows nothing of."""

import numpy as np
import pytest

from drake_linefoot.lab.scenario import Scenario, Segment
from drake_linefoot.lab.simulation.run import FallWatch, fall_of
from drake_linefoot.lab.wiring.closed_loop import build_closed_loop
from drake_linefoot.math.rotation import roll_pitch_yaw

DIRECTIONS = 8
PUSH = 2.2  # [s]
WALK = Scenario(segments=[Segment("forward", PUSH + 2.3, True, [0.3, 0.0])])  # ten steps more


def walks_on(loop, simulator, before, direction, impulse=10.0):
    """Whether a walk survives an impulse [N s] within 0.1 s, after a context, until its end."""
    context = simulator.get_mutable_context()
    context.SetTimeStateAndParametersFrom(before)
    x = loop.plant.state(context)
    angle = roll_pitch_yaw(x[:4])[2] + direction
    force = 10.0 * impulse * np.array([np.cos(angle), np.sin(angle), 0.0])
    loop.push.push(loop.push.GetMyMutableContextFromRoot(context), force, 0.1)
    watch = FallWatch(loop)
    simulator.set_monitor(watch)
    try:
        simulator.Initialize()
        simulator.AdvanceTo(loop.scenario.duration)
    except (RuntimeError, np.linalg.LinAlgError) as error:
        watch.reason = fall_of(error)
    assert watch.reason or context.get_time() == loop.scenario.duration
    return not watch.reason


@pytest.mark.slow
def test_it_takes_a_push_from_nearly_every_side():
    """0.4 m/s more or less: all eight when this was written, one may fall."""
    loop = build_closed_loop(WALK, pushes=True)
    simulator = loop.make_simulator()
    simulator.AdvanceTo(PUSH)
    before = simulator.get_context().Clone()
    directions = 2.0 * np.pi * np.arange(DIRECTIONS) / DIRECTIONS
    survived = [walks_on(loop, simulator, before, each) for each in directions]
    assert sum(survived) >= DIRECTIONS - 1, survived


@pytest.mark.slow
def test_steps_save_it_from_hard_pushes_to_the_side_of_its_stance_foot():
    """1.3 m/s more to the left at four moments of a step: all four when this was written."""
    segments = [Segment("stand", 0.3), Segment("forward", 3.2, True, [0.8, 0.0])]
    loop = build_closed_loop(Scenario(segments=segments), pushes=True)
    simulator, moments = loop.make_simulator(), []
    for time in (2.12, 2.18, 2.24, 2.30):
        simulator.AdvanceTo(time)
        moments.append(simulator.get_context().Clone())
    survived = [walks_on(loop, simulator, each, 0.5 * np.pi, 32.0) for each in moments]
    assert sum(survived) >= 3, survived
