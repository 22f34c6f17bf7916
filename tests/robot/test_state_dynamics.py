"""The dynamics of a state as a LeafSystem, through its ports only."""

import numpy as np
import pytest
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ZeroOrderHold

from drake_linefoot.errors import SignalError
from drake_linefoot.robot import state_dynamics
from drake_linefoot.robot.dynamics import dynamics_layout, dynamics_vector, robot_dynamics
from drake_linefoot.robot.state_dynamics import StateDynamics
from tests.helpers.ports import look


@pytest.fixture
def block(robot):
    return StateDynamics(robot)


def evaluate(block, context, x):
    block.get_state_input_port().FixValue(context, x)
    return look(block.get_dynamics_output_port(), context, block._humanoid)


def test_names_and_sizes_of_the_ports(robot, block):
    assert block.get_name() == "state_dynamics"
    assert (block.num_input_ports(), block.num_output_ports()) == (1, 1)
    state, dynamics = block.GetInputPort("state"), block.GetOutputPort("dynamics")
    assert state.size() == robot.nq + robot.nv
    assert block.get_state_input_port().get_index() == state.get_index()
    assert block.get_dynamics_output_port().get_index() == dynamics.get_index()
    assert dynamics.size() == dynamics_layout(robot).size


def test_it_is_stateless_and_gives_the_dynamics_of_its_input(robot, block, walking_state):
    context = block.CreateDefaultContext()
    assert context.is_stateless()
    scratch = robot.plant.CreateDefaultContext()
    for seed in range(3):
        x = walking_state(robot, seed)
        found, expected = evaluate(block, context, x), robot_dynamics(robot, scratch, x)
        for name, value in expected._asdict().items():
            np.testing.assert_array_equal(getattr(found, name), value)


def test_it_keeps_nothing_of_its_input(robot, block, walking_state):
    """A value that was read does not change with the next state."""
    context = block.CreateDefaultContext()
    first = evaluate(block, context, walking_state(robot, 1))
    kept = [np.array(part) for part in first]
    evaluate(block, context, walking_state(robot, 2))
    for now, before in zip(first, kept, strict=True):
        np.testing.assert_array_equal(now, before)


def test_it_is_computed_once_for_all_who_ask(humanoid, monkeypatch):
    """Until the state changes, whatever the time."""
    calls = []

    def counted(*args):
        calls.append(args)
        return dynamics_vector(*args)

    builder = DiagramBuilder()
    hold = builder.AddSystem(ZeroOrderHold(0.01, humanoid.nq + humanoid.nv))
    block = builder.AddSystem(StateDynamics(humanoid))
    builder.Connect(hold.get_output_port(), block.get_state_input_port())
    builder.ExportInput(hold.get_input_port())
    diagram = builder.Build()
    monkeypatch.setattr(state_dynamics, "dynamics_vector", counted)
    root = diagram.CreateDefaultContext()
    context = hold.GetMyMutableContextFromRoot(root)
    port, own = block.get_dynamics_output_port(), block.GetMyContextFromRoot(root)
    for expected in (1, 2):
        x = humanoid.x_nominal
        x[4] = expected
        context.get_mutable_discrete_state_vector().SetFromVector(x)
        for time in (0.0, 0.1, 0.2):
            root.SetTime(time)
            assert look(port, own).q[4] == expected
        assert len(calls) == expected


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_a_state_that_is_not_finite_raises_and_is_named(humanoid, bad):
    block = StateDynamics(humanoid)
    x = humanoid.x_nominal
    x[30] = bad
    with pytest.raises(SignalError, match=r"state_dynamics\.state.*element 30") as caught:
        evaluate(block, block.CreateDefaultContext(), x)
    assert caught.value.port == "state_dynamics.state"
