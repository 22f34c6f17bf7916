"""A simulation goes on from a context that was saved, with the same bits."""

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator

from drake_linefoot.lab.scenario import Scenario, Segment
from drake_linefoot.lab.scenario.disturbances import (
    ActuatorParameters,
    ErrorParameters,
    PushParameters,
    SensorParameters,
)
from drake_linefoot.lab.wiring.closed_loop import build_closed_loop
from drake_linefoot.layout import flat
from drake_linefoot.mpc.parameters import MpcParameters
from drake_linefoot.wiring.controller import EXPORTS

SAVED, END = 0.151, 0.25  # [s] the first is in the middle of a push, while the robot turns
SCENARIO = Scenario(
    name="everything that can go wrong",
    segments=[Segment("step", 0.1, True, [0.1, 0.0], 0.5), Segment("stand", 0.2)],
    pushes=[
        PushParameters(time=0.14, duration=0.05, impulse=1.0, direction=0.3),
        PushParameters(time=0.2, duration=0.02, impulse=1.0),
    ],
    sensors=SensorParameters(gyro=0.01, joint_velocity=0.01, encoder_resolution=1e-4),
    actuators=ActuatorParameters(torque_speed=True, delay=0.002),
    error=ErrorParameters(torso_mass=0.5, joint_damping=0.1, joint_friction=0.1),
)


WALK = Scenario(
    name="in the middle of a walk",
    segments=[Segment("walk", 1.0, True, [0.3, 0.0], 0.2)],
    pushes=[PushParameters(time=0.56, duration=0.05, impulse=2.0, direction=1.0)],
    mpc=MpcParameters(late=True),
)


def state_of(loop, root):
    return loop.plant.state(root)


def signals_of(loop, root):
    """All that the controller says, as one array: each block's state has a part in it.

    But for wall times.
    """
    values = {name: loop.look(name, root) for name in EXPORTS}
    for name in ("plan", "report"):
        values[name] = values[name]._replace(milliseconds=0.0)
    return np.hstack([state_of(loop, root), values.pop("torque"), *map(flat, values.values())])


@pytest.mark.parametrize(
    ("scenario", "saved", "end"), [(SCENARIO, SAVED, END), (WALK, 0.5705, 0.65)], ids=lambda s: ""
)
def test_the_whole_loop_goes_on_with_the_same_bits(scenario, saved, end):
    """From a clone, from a context that is set to it, and when all is done a second time."""
    loop = build_closed_loop(scenario)
    simulator = loop.make_simulator()
    simulator.AdvanceTo(saved)
    context = simulator.get_context().Clone()
    before = signals_of(loop, context)
    simulator.AdvanceTo(end)
    expected = signals_of(loop, simulator.get_context())
    other = Simulator(loop)
    other.get_mutable_context().SetTimeStateAndParametersFrom(context)
    simulator.get_mutable_context().SetTimeStateAndParametersFrom(context)
    for again in (Simulator(loop, context.Clone()), other, simulator):
        again.Initialize()
        np.testing.assert_array_equal(signals_of(loop, again.get_context()), before)
        again.AdvanceTo(end)
        np.testing.assert_array_equal(signals_of(loop, again.get_context()), expected)


def test_pushes_of_a_saved_context_go_on():
    loop = build_closed_loop(SCENARIO)
    simulator = loop.make_simulator()
    simulator.AdvanceTo(SAVED)
    saved = simulator.get_context().Clone()
    Simulator(loop, saved).AdvanceTo(END)
    pushes = loop.recorder.samples("push")
    assert (np.linalg.norm(pushes[[150, 160, 210]], axis=1) > 10.0).all()
