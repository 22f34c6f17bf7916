"""Parameters in the context of a block: alone, and in the middle of a walk."""

import re
from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest
from pydrake.systems.analysis import InitializeParams, Simulator

from drake_linefoot import Scenario, Segment, build_closed_loop
from drake_linefoot.errors import InputError
from drake_linefoot.estimation.contact_estimator import ContactEstimator
from drake_linefoot.estimation.state_estimator import StateEstimator
from drake_linefoot.fields import tunable
from drake_linefoot.gait.gait_planner import GaitPlanner
from drake_linefoot.mpc.ecd_mpc import EcdMpc
from drake_linefoot.parameters import numbers_of
from drake_linefoot.robot.scaling import scaled
from drake_linefoot.wbc.whole_body_controller import WholeBodyController

ROOT = Path(__file__).parents[1]
WALK = Scenario(
    segments=[
        Segment("stand", 0.2),
        Segment("walk", 2.0, walk=True, velocity=[0.4, 0.1], turn_rate=0.2),
    ],
    estimation=True,
)
BLOCKS = {  # name in the loop, part of the scenario, and what is changed
    "gait_planner": ("gait", {"com_height": 0.63, "speed_scale": [1.0, 1.1]}),
    "ecd_mpc": (
        "mpc",
        {"friction": 0.5, "weights": {"force": 4e-5, "position": [1.0, 0.0, 900.0]}},
    ),
    "whole_body_controller": ("wbc", {"swing_position_gain": 900.0, "force_error_weight": 0.02}),
    "contact_estimator": ("estimator", {"filter_constant": 0.5, "external_max": 20.0}),
    "state_estimator": ("state_estimator", {"slip": 3e-4, "point_noise": 5e-4}),
}
each_block = pytest.mark.parametrize("name", BLOCKS)


def built(name, humanoid, scenario):
    """A block alone."""
    s, tick = scenario, scenario.period
    return {
        "gait_planner": lambda: GaitPlanner(humanoid, s.gait, s.mpc.horizon, tick, s.mpc.knots),
        "ecd_mpc": lambda: EcdMpc(humanoid, s.mpc),
        "whole_body_controller": lambda: WholeBodyController(humanoid, s.wbc, s.mpc.knots),
        "contact_estimator": lambda: ContactEstimator(humanoid, s.estimator, tick),
        "state_estimator": lambda: StateEstimator(humanoid, s.onboard, s.state_estimator, tick),
    }[name]()


def changed(scenario, part, changes):
    """A scenario with other parameters in one of its parts."""
    old = getattr(scenario, part)
    inner = {
        name: replace(getattr(old, name), **value) if isinstance(value, dict) else value
        for name, value in changes.items()
    }
    return replace(scenario, **{part: replace(old, **inner)})


def block_of(loop, name):
    """A block of a loop."""
    systems = [*loop.GetSystems(), *loop.controller.GetSystems()]
    return next(s for s in systems if s.get_name() == name)


def take_state(context, there):
    """Copy a block's state from one context to another."""
    numbers = [
        context.get_numeric_parameter(i).value().copy()
        for i in range(context.num_numeric_parameter_groups())
    ]
    context.SetStateAndParametersFrom(there)
    for i, values in enumerate(numbers):
        context.get_mutable_numeric_parameter(i).SetFromVector(values)


@pytest.fixture(scope="module")
def walking():
    """A loop in a step, and its context."""
    loop = build_closed_loop(WALK)
    simulator = loop.make_simulator()
    simulator.AdvanceTo(1.0)
    return loop, simulator.get_context().Clone()


@pytest.fixture
def vectors(walking):
    """Return what comes of a block whose inputs and state are those of the walk."""
    loop, root = walking

    def outputs(name, system, context):
        block = block_of(loop, name)
        there = block.GetMyContextFromRoot(root)
        for i in range(block.num_input_ports()):
            port = block.get_input_port(i)
            if port.HasValue(there):
                system.get_input_port(i).FixValue(context, port.Eval(there).copy())
        take_state(context, there)
        context.SetTime(root.get_time())
        simulator = Simulator(system, context)
        simulator.Initialize(InitializeParams(suppress_initialization_events=True))
        simulator.AdvanceTo(root.get_time() + 0.5 * WALK.period)  # its update, at this time
        ports = [system.get_output_port(i) for i in range(system.num_output_ports())]
        kept = [p for p in ports if p.get_name() != "report" or name == "state_estimator"]
        found = np.concatenate([p.Eval(context).copy() for p in kept])
        return found[:-2] if name == "ecd_mpc" else found  # without milliseconds

    return outputs


@each_block
def test_the_vector_has_the_numbers_in_the_size_of_the_robot(walking, name):
    loop, root = walking
    block = block_of(loop, name)
    context = block.GetMyContextFromRoot(root)
    numbers = context.get_numeric_parameter(0).value()
    expected = numbers_of(scaled(getattr(WALK, BLOCKS[name][0]), loop.humanoid))
    assert len(set(block.parameter_names)) == len(numbers) > 5
    assert dict(zip(block.parameter_names, numbers, strict=True)) == expected


@each_block
def test_set_in_the_context_is_as_if_built_with_it(walking, vectors, name):
    humanoid, (part, changes) = walking[0].humanoid, BLOCKS[name]
    as_built = built(name, humanoid, WALK)
    plain, set_, direct = (as_built.CreateDefaultContext() for _ in range(3))
    as_built.set_parameters(set_, **changes)
    other = built(name, humanoid, changed(WALK, part, changes))
    expected = vectors(name, other, other.CreateDefaultContext())
    np.testing.assert_array_equal(vectors(name, as_built, set_), expected)
    direct.get_mutable_numeric_parameter(0).SetFromVector(set_.get_numeric_parameter(0).value())
    np.testing.assert_array_equal(vectors(name, as_built, direct), expected)
    assert np.abs(vectors(name, as_built, plain) - expected).max() > 1e-9  # of its own context


@pytest.mark.parametrize(
    ("name", "changes", "said"),
    [
        ("gait_planner", {"swing_height": -0.1}, r"gait_planner: swing_height = -0.1: must .* 0 m"),
        ("gait_planner", {"swing_hight": 0.1}, "swing_hight = 0.1: unknown field; .*swing_height"),
        ("gait_planner", {"recovery_steps": 1}, "recovery_steps = 1: .* built with"),
        ("gait_planner", {"flight": 0.05}, "flight = 0.05: .* built with"),
        ("gait_planner", {"single_support": 0.02}, r"single_support = 0.02: must be above settle"),
        ("gait_planner", {"com_height": 0.0}, "gait_planner = .*com_height.*: cannot be"),
        ("ecd_mpc", {"knot_step": 0.05}, "knot_step = 0.05: .* built with"),
        ("ecd_mpc", {"weights": {"force": 0.0}}, r"ecd_mpc: weights.force = 0.0: must .* 1/N\^2"),
        ("ecd_mpc", {"weights": {"velocity": [1.0]}}, r"weights.velocity = \[1.0\]: .* 3 items"),
        ("whole_body_controller", {"tolerance": 1e-6}, "tolerance = 1e-06: .* built with"),
        ("contact_estimator", {"release_force": 50.0}, "release_force = 50.0: must be below touch"),
    ],
)
def test_what_cannot_be_is_a_line_and_nothing_is_set(humanoid, name, changes, said):
    system = built(name, humanoid, Scenario())
    context = system.CreateDefaultContext()
    good = next(n for n in system.parameter_names if n.isidentifier() and n not in changes)
    with pytest.raises(InputError, match=said) as raised:
        system.set_parameters(context, **{good: 0.5}, **changes)
    assert "\n" not in str(raised.value)
    default = system.CreateDefaultContext()
    assert system.parameters(context) == system.parameters(default)


def test_a_vector_that_cannot_be_is_named_when_it_is_used(humanoid):
    system = built("ecd_mpc", humanoid, Scenario())
    context = system.CreateDefaultContext()
    place = system.parameter_names.index("weights.velocity[1]")
    context.get_mutable_numeric_parameter(0).SetAtIndex(place, -3.0)
    with pytest.raises(InputError, match=r"ecd_mpc: weights.velocity\[1\] = -3.0: must be"):
        system.parameters(context)
    with pytest.raises(InputError, match=r"ecd_mpc: weights.velocity\[1\] = -3.0: must be"):
        system.constants_in(context)
    context.get_mutable_numeric_parameter(0).SetAtIndex(place, 3.0)
    assert system.parameters(context).weights.velocity == [10.0, 3.0, 10.0]


def test_constants_are_made_once_for_each_change(humanoid):
    system = built("whole_body_controller", humanoid, Scenario())
    context = system.CreateDefaultContext()
    first = system.constants_in(context)
    assert system.constants_in(context) is first
    system.set_parameters(context, arm_velocity_gain=7.0)
    second = system.constants_in(context)
    assert second is not first and system.constants_in(context) is second
    copy = context.Clone()
    assert system.parameters(copy).arm_velocity_gain == 7.0


def test_a_walk_goes_on_as_a_loop_that_was_built_with_what_was_changed(walking):
    loop, _ = walking
    scenario, tuned = WALK, loop.CreateDefaultContext()
    for name, (part, changes) in BLOCKS.items():
        block = block_of(loop, name)
        block.set_parameters(block.GetMyMutableContextFromRoot(tuned), **changes)
        scenario = changed(scenario, part, changes)
    other = build_closed_loop(scenario)
    pairs = (
        (loop, tuned),
        (other, other.CreateDefaultContext()),
        (loop, loop.CreateDefaultContext()),
    )
    found, expected, untouched = (gone_on(*pair, walking) for pair in pairs)
    np.testing.assert_array_equal(found, expected)
    assert np.abs(found - untouched).max() > 1e-3


def gone_on(loop, context, walking):
    """Torque and state of a loop 0.2 s after it took over the states of the walk."""
    before, root = walking
    context.SetTime(root.get_time())
    loop.prepare(context)
    loop.plant.place(context, before.plant.state(root))
    for name in [*BLOCKS, "onboard"]:
        there = block_of(before, name).GetMyContextFromRoot(root)
        take_state(block_of(loop, name).GetMyMutableContextFromRoot(context), there)
    simulator = Simulator(loop, context)
    simulator.Initialize(InitializeParams(suppress_initialization_events=True))
    simulator.AdvanceTo(root.get_time() + 0.2)
    return np.concatenate([loop.look("torque", context), loop.plant.state(context)])


def test_the_docs_name_what_a_context_cannot_change():
    """Every field that is built in is in the list, and no other."""
    text = " ".join((ROOT / "docs" / "own_block.md").read_text(encoding="utf-8").split())
    (listed,) = re.findall(
        r"What sets sizes or times of events, or is a choice, .*?: (.*?), which", text
    )
    kinds = [type(getattr(WALK, part)) for part, _ in BLOCKS.values()]
    built_in = {f.name for kind in kinds for f in fields(kind) if f.name not in tunable(kind)}
    assert set(re.findall(r"`(\w+)`", listed)) == built_in
