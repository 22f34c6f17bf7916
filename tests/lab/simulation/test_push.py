import numpy as np
import pytest
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import LeafSystem

from drake_linefoot.constants import GRAVITY
from drake_linefoot.errors import InputError
from drake_linefoot.lab.scenario import Scenario, Segment
from drake_linefoot.lab.scenario.disturbances import PushParameters
from drake_linefoot.lab.simulation.command import HeldCommand
from drake_linefoot.lab.simulation.push import Push
from drake_linefoot.lab.simulation.run import simulate
from drake_linefoot.lab.wiring.closed_loop import build_closed_loop
from tests.helpers.recorded_runs import SHORT, short_run, yaw_quaternion


def test_a_push_acts_for_its_time():
    loop = build_closed_loop(SHORT, pushes=True)
    context = loop.push.CreateDefaultContext()
    context.SetTime(1.0)
    push = loop.push.GetOutputPort("push")
    np.testing.assert_array_equal(push.Eval(context), np.zeros(3))
    loop.push.push(context, [1.0, 2.0, 3.0], 0.1)
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
        x = loop.plant.state(root)
        x[6] += 2.0
        loop.plant.place(root, x)
        loop.push.push(loop.push.GetMyMutableContextFromRoot(root), [0.0, force, 0.0], 0.01)
        simulator.AdvanceTo(0.02)
        plant = loop.plant.system
        own = plant.GetMyContextFromRoot(root)
        v = plant.CalcCenterOfMassTranslationalVelocityInWorld(own)
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


SCHEDULE = [
    PushParameters(time=0.0, duration=0.05, impulse=1.0, direction=0.0),
    PushParameters(time=0.02, duration=0.02, impulse=0.5, direction=-0.5 * np.pi),
    PushParameters(time=0.1, duration=0.004, impulse=0.4, direction=0.5 * np.pi),
]


def facing(yaw):
    """The state of a robot that looks along `yaw`."""
    x = np.zeros(49)
    x[:4] = yaw_quaternion(np.array([yaw]))[0]
    return x


def test_a_schedule_pushes_from_the_heading_at_which_each_push_begins():
    push = Push(build_closed_loop(SHORT).humanoid, SCHEDULE)
    simulator = Simulator(push)
    context = simulator.get_mutable_context()
    state, out = push.GetInputPort("state"), push.GetOutputPort("push")
    state.FixValue(context, facing(0.3))
    simulator.Initialize()

    def at(time, heading=None):
        """Advance, with this heading in the step that ends there; return the force."""
        ticks = round(1e3 * time)
        if round(1e3 * context.get_time()) < ticks - 1:  # no step of no length: it has events
            simulator.AdvanceTo((ticks - 1) * 1e-3)
        if heading is not None:
            state.FixValue(context, facing(heading))
        simulator.AdvanceTo(ticks * 1e-3)
        return out.Eval(context)

    first = 20.0 * np.array([np.cos(0.3), np.sin(0.3), 0.0])
    np.testing.assert_allclose(out.Eval(context), first, atol=1e-12)
    np.testing.assert_allclose(at(0.019), first, atol=1e-12)
    second = 25.0 * np.array([np.sin(1.0), -np.cos(1.0), 0.0])
    np.testing.assert_allclose(at(0.02, heading=1.0), first + second, atol=1e-9)
    np.testing.assert_allclose(at(0.039, heading=2.0), first + second, atol=1e-9)
    np.testing.assert_allclose(at(0.04), first, atol=1e-9)
    np.testing.assert_array_equal(at(0.05), np.zeros(3))
    np.testing.assert_array_equal(at(0.099), np.zeros(3))
    third = 100.0 * np.array([-np.sin(-1.2), np.cos(-1.2), 0.0])
    np.testing.assert_allclose(at(0.1, heading=-1.2), third, atol=1e-9)
    by_hand = np.array([0.0, 0.0, 7.0])
    push.push(context, by_hand, 1.0)
    np.testing.assert_allclose(out.Eval(context), third + by_hand, atol=1e-9)
    np.testing.assert_allclose(at(0.104), by_hand, atol=1e-9)


def test_without_pushes_nothing_is_added_and_zero_is_recorded():
    assert build_closed_loop(SHORT).push is None
    np.testing.assert_array_equal(short_run().push, 0.0)


def test_momentum_changes_by_the_impulses_of_push_contact_and_weight():
    """Standing and walking, to a thousandth of the push's 4 N s."""
    pushes = [PushParameters(time=0.3, impulse=4.0, direction=0.7)]
    segments = [Segment("stand", 0.2), Segment("walk", 0.4, True, [0.1, 0.0])]
    run = simulate(build_closed_loop(Scenario(segments=segments, pushes=pushes)))
    assert not run.fell
    acts = (run.time > 0.2995) & (run.time < 0.3995)
    np.testing.assert_allclose(np.linalg.norm(run.push[acts], axis=1), 40.0)
    np.testing.assert_array_equal(run.push[~acts], 0.0)
    yaw = run.rpy[np.argmax(acts), 2]
    direction = [np.cos(yaw + 0.7), np.sin(yaw + 0.7), 0.0]
    np.testing.assert_allclose(run.push[acts], 40.0 * np.tile(direction, (100, 1)), atol=1e-9)
    mass = build_closed_loop(SHORT).humanoid.mass
    momentum = mass * velocity_of_com(run)
    # the contact forces of a sample belong to the step that ended there
    contact = run.true_force[1:].sum(axis=1)
    forces = contact + run.push[:-1] + mass * GRAVITY
    begin, end = 250, 450
    change = momentum[end] - momentum[begin]
    np.testing.assert_allclose(1e-3 * forces[begin:end].sum(axis=0), change, atol=0.004)


def velocity_of_com(run):
    """Velocity of the centre of mass at every sample [m/s], shape (n, 3)."""
    loop = build_closed_loop(run.scenario)
    plant, context = loop.humanoid.plant, loop.humanoid.plant.CreateDefaultContext()
    rows = []
    for q, v in zip(run.q, run.v, strict=True):
        plant.SetPositionsAndVelocities(context, np.concatenate([q, v]))
        rows.append(plant.CalcCenterOfMassTranslationalVelocityInWorld(context))
    return np.array(rows)
