import numpy as np
import pytest
from pydrake.systems.framework import LeafSystem
from recorded_runs import SHORT

from drake_linefoot.errors import InputError
from drake_linefoot.simulation.command import HeldCommand
from drake_linefoot.wiring.closed_loop import build_closed_loop


def test_a_push_acts_on_the_torso_for_its_time():
    loop = build_closed_loop(SHORT, pushes=True)
    context = loop.push.CreateDefaultContext()
    context.SetTime(1.0)
    force, push = loop.push.GetOutputPort("force"), loop.push.GetOutputPort("push")
    np.testing.assert_array_equal(push.Eval(context), np.zeros(3))
    loop.push.push(context, [1.0, 2.0, 3.0], 0.1)
    (applied,) = force.Eval(context)
    assert applied.body_index == loop.plant.GetBodyByName("torso").index()
    np.testing.assert_array_equal(applied.F_Bq_W.translational(), [1.0, 2.0, 3.0])
    np.testing.assert_array_equal(applied.F_Bq_W.rotational(), np.zeros(3))
    context.SetTime(1.099)
    np.testing.assert_array_equal(push.Eval(context), [1.0, 2.0, 3.0])
    context.SetTime(1.1)
    np.testing.assert_array_equal(push.Eval(context), np.zeros(3))


def test_the_impulse_is_what_the_robot_gains():
    """In the air nothing else acts but weight."""
    velocities = []
    for force in (0.0, 50.0):
        loop = build_closed_loop(SHORT, pushes=True)
        simulator = loop.make_simulator()
        root = simulator.get_mutable_context()
        plant_context = loop.plant.GetMyMutableContextFromRoot(root)
        q = loop.plant.GetPositions(plant_context)
        q[6] += 2.0
        loop.plant.SetPositions(plant_context, q)
        loop.push.push(loop.push.GetMyMutableContextFromRoot(root), [0.0, force, 0.0], 0.01)
        simulator.AdvanceTo(0.02)
        v = loop.plant.CalcCenterOfMassTranslationalVelocityInWorld(plant_context)
        velocities.append(v[1])
    gained = velocities[1] - velocities[0]
    assert gained == pytest.approx(50.0 * 0.01 / loop.humanoid.mass, rel=1e-3)


def test_a_command_is_held():
    command = HeldCommand()
    context = command.CreateDefaultContext()
    port = command.GetOutputPort("command")
    np.testing.assert_array_equal(port.Eval(context), np.zeros(4))
    command.hold(context, [0.1, 0.2, 0.3, 1.0])
    np.testing.assert_array_equal(port.Eval(context), [0.1, 0.2, 0.3, 1.0])


def test_a_command_of_ones_own_needs_its_port():
    loop = build_closed_loop(SHORT, command=HeldCommand())
    assert loop.push is None
    mute = LeafSystem()
    mute.set_name("mute")
    with pytest.raises(InputError, match="'mute': lacks the output port command"):
        build_closed_loop(SHORT, command=mute)
