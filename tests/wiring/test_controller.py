"""The controller as one Diagram: what it shows, how it is wired, how often it computes what."""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
import pytest
from pydrake.systems.framework import LeafSystem

from drake_linefoot.errors import InputError, SignalError
from drake_linefoot.estimation import contact_estimator
from drake_linefoot.gait import gait_planner
from drake_linefoot.lab.scenario import Scenario, Segment
from drake_linefoot.lab.wiring.closed_loop import build_closed_loop
from drake_linefoot.layout import flat
from drake_linefoot.mpc.ecd_mpc import standing_plan
from drake_linefoot.mpc.parameters import MpcParameters
from drake_linefoot.mpc.reference import ReferenceGenerator
from drake_linefoot.mpc.solve import MpcSolver
from drake_linefoot.statuses import Mode
from drake_linefoot.terrain import TERRAIN
from drake_linefoot.wbc.control import WholeBodyControl
from drake_linefoot.wiring.controller import build_controller
from tests.helpers.phases import named
from tests.helpers.walking import dynamics_of, recorded_walk

BLOCKS = [
    "state_dynamics", "contact_estimator", "gait_planner", "centroidal_reference", "ecd_mpc",
]  # fmt: skip
WBC = "whole_body_controller"
WALK = Scenario(segments=[Segment("walk", 1.0, True, [0.2, 0.0], 0.2)])


@pytest.fixture(scope="module")
def controller(humanoid):
    return build_controller(humanoid, Scenario())


# --- ports and connections --------------------------------------------------------------


def test_ports_of_the_diagram(humanoid, controller):
    assert controller.get_name() == "controller"
    inputs = [controller.get_input_port(i) for i in range(controller.num_input_ports())]
    sizes = {port.get_name(): port.size() for port in inputs}
    assert sizes == {
        "state": 49,
        "command": 4,
        "applied_torque": humanoid.na,
        "terrain": TERRAIN.size,
    }
    outputs = [controller.get_output_port(i) for i in range(controller.num_output_ports())]
    names = [port.get_name() for port in outputs]
    assert names == [
        "torque", "dynamics", "contact", "targets", "reference", "plan", "report",
    ]  # fmt: skip
    assert controller.GetOutputPort("torque").size() == humanoid.na


def test_blocks_are_wired_as_the_loop_goes_round(controller):
    assert [s.get_name() for s in controller.GetSystems()] == [*BLOCKS, WBC]
    wires = {
        (target.get_name(), target.get_input_port(int(i)).get_name()): (
            source.get_name(),
            source.get_output_port(int(j)).get_name(),
        )
        for (target, i), (source, j) in controller.connection_map().items()
    }
    dynamics = ("state_dynamics", "dynamics")
    assert wires == {
        **{(name, "dynamics"): dynamics for name in [*BLOCKS[1:], WBC]},
        ("gait_planner", "contact"): ("contact_estimator", "contact"),
        ("centroidal_reference", "horizon"): ("gait_planner", "horizon"),
        ("ecd_mpc", "reference"): ("centroidal_reference", "reference"),
        (WBC, "targets"): ("gait_planner", "targets"),
        (WBC, "plan"): ("ecd_mpc", "plan"),
    }
    for name in [*BLOCKS, WBC]:
        block = controller.GetSubsystemByName(name)
        for i in range(block.num_input_ports()):
            port = block.get_input_port(i)
            outside = port.get_name() in ("state", "command", "applied_torque", "terrain")
            assert outside != ((name, port.get_name()) in wires)


def test_only_the_state_passes_straight_through_to_the_torque(controller):
    """Everything else is held in discrete state, so no loop closes in itself."""
    through = {
        (controller.get_input_port(i).get_name(), controller.get_output_port(j).get_name())
        for i in range(controller.num_input_ports())
        for j in range(controller.num_output_ports())
        if controller.HasDirectFeedthrough(i, j)
    }
    shown = ("torque", "report", "reference", "dynamics")
    assert through == {("state", name) for name in shown}


def test_the_diagram_says_what_the_blocks_say(humanoid, controller):
    """Known answer: before any event, standing with the standing plan."""
    context = controller.CreateDefaultContext()
    controller.GetInputPort("state").FixValue(context, humanoid.x_nominal)
    torque = controller.GetOutputPort("torque").Eval(context)
    targets = controller.GetOutputPort("targets").Eval(context)
    plan = controller.GetOutputPort("plan").Eval(context)
    own = WholeBodyControl(humanoid, Scenario().wbc)
    report = own.compute(flat(dynamics_of(humanoid.x_nominal)), targets, plan)
    np.testing.assert_array_equal(torque, own.report.open(report).torque)
    assert named(own.targets.open(targets)) == Mode.STAND
    np.testing.assert_allclose(torque, humanoid.mirror_joints(torque), atol=1e-6)


# --- how often --------------------------------------------------------------------------


@dataclass
class Counts:
    """Calls by name, with the simulated time at which they were made."""

    clock: Callable[[], float]
    times: dict = field(default_factory=dict)

    def watch(self, monkeypatch, owner, name):
        inner = getattr(owner, name)

        def counted(*args, **kwargs):
            self.times.setdefault(name, []).append(self.clock())
            return inner(*args, **kwargs)

        monkeypatch.setattr(owner, name, counted)


def test_every_block_is_evaluated_as_often_as_it_must(monkeypatch):
    """0.5 s: 500 ticks of the 1 kHz blocks, 25 updates of the 50 Hz ones, and no more."""
    simulator = build_closed_loop(WALK).make_simulator()
    counts = Counts(simulator.get_context().get_time)
    for owner, name in (
        (WholeBodyControl, "compute"),
        (MpcSolver, "solve"),
        (ReferenceGenerator, "vector"),
        (gait_planner, "horizon_vector"),
        (gait_planner, "update"),
        (contact_estimator, "next_estimate"),
    ):
        counts.watch(monkeypatch, owner, name)
    simulator.AdvanceTo(0.4999)
    numbers = {name: len(times) for name, times in counts.times.items()}
    assert numbers["update"] == 500
    assert numbers["next_estimate"] == 500
    assert 500 <= numbers["compute"] <= 501  # the recorder may ask for the last state
    assert numbers["solve"] == numbers["vector"] == 25
    assert numbers["horizon_vector"] == 25
    np.testing.assert_allclose(counts.times["solve"], 0.02 * np.arange(25), atol=1e-9)


def test_the_plan_the_controller_uses_was_made_of_the_state_before(humanoid):
    """Each plan starts at the CoM of the state at its first knot, one tick before its use."""
    context = humanoid.plant.CreateDefaultContext()
    for record in recorded_walk().mpc[::15]:
        humanoid.plant.SetPositionsAndVelocities(context, record.x)
        r = humanoid.plant.CalcCenterOfMassPositionInWorld(context)
        np.testing.assert_allclose(record.plan.states[0, :3], r, atol=1e-12)
        assert record.plan.times[0] == record.horizon.time


# --- blocks of one's own ----------------------------------------------------------------


class StandingMpc(LeafSystem):
    """An MPC that never looks: no inputs, always the standing plan."""

    def __init__(self, humanoid, port="plan"):
        super().__init__()
        self.set_name("standing_mpc")
        plan = flat(standing_plan(humanoid, MpcParameters()))
        self.DeclareVectorOutputPort(
            port,
            len(plan),
            lambda context, output: output.SetFromVector(plan),
            prerequisites_of_calc={self.nothing_ticket()},
        )


def test_a_block_of_ones_own_is_put_in_and_needs_only_the_ports_it_uses(humanoid):
    scenario = Scenario(segments=[Segment("stand", 0.1)])
    own = build_controller(humanoid, scenario, mpc=StandingMpc(humanoid))
    assert "standing_mpc" in [s.get_name() for s in own.GetSystems()]
    assert own.HasOutputPort("plan")
    loop = build_closed_loop(scenario, controller=own)
    simulator = loop.make_simulator()
    simulator.AdvanceTo(0.1)
    q = loop.plant.state(simulator.get_context())
    assert q[6] == pytest.approx(humanoid.q_nominal[6], abs=0.01)


def test_a_block_without_a_port_that_another_needs_is_refused(humanoid):
    with pytest.raises(InputError, match="no such output port"):
        build_controller(humanoid, Scenario(), mpc=StandingMpc(humanoid, port="plans"))


def test_a_state_that_is_not_finite_is_refused_by_the_name_of_a_port(humanoid, controller):
    context = controller.CreateDefaultContext()
    x = humanoid.x_nominal
    x[10] = np.nan
    controller.GetInputPort("state").FixValue(context, x)
    with pytest.raises(SignalError, match=r"state_dynamics\.state: element 10 is nan"):
        controller.GetOutputPort("torque").Eval(context)
