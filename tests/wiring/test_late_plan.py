import numpy as np
import pytest
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import EventStatus, LeafSystem

from drake_linefoot.lab.drive.session import Session
from drake_linefoot.lab.scenario import Scenario, Segment
from drake_linefoot.lab.simulation.run import simulate
from drake_linefoot.lab.wiring.closed_loop import build_closed_loop
from drake_linefoot.layout import Layout
from drake_linefoot.mpc.parameters import MpcParameters
from drake_linefoot.parts import KNOTS
from drake_linefoot.signals import CentroidalPlan
from drake_linefoot.wiring.controller import build_controller
from tests.helpers.recorded_runs import SHORT

LATE = Scenario(segments=SHORT.segments, mpc=MpcParameters(late=True))


class Counting(LeafSystem):
    """An MPC whose plan is full of the number of its updates so far."""

    def __init__(self):
        super().__init__()
        self.set_name("counting")
        index = self.DeclareDiscreteState(Layout(CentroidalPlan, {"knots": KNOTS, "nw": 5}).size)
        self.DeclareStateOutputPort("plan", index)

        def update(context, state):
            updates = context.get_discrete_state_vector().value()
            state.get_mutable_discrete_state(0).set_value(updates + 1.0)
            return EventStatus.Succeeded()

        self.DeclarePeriodicUnrestrictedUpdateEvent(0.02, 0.0, update)


def counting_simulator(humanoid, late):
    """A simulator of the controller with `Counting`."""
    scenario = Scenario(mpc=MpcParameters(late=late))
    controller = build_controller(humanoid, scenario, mpc=Counting())
    simulator = Simulator(controller)
    context = simulator.get_mutable_context()
    for name, value in (("state", humanoid.x_nominal), ("command", np.zeros(4))):
        controller.GetInputPort(name).FixValue(context, value)
    controller.GetInputPort("applied_torque").FixValue(context, np.zeros(humanoid.na))
    return simulator


def used(simulator):
    """How many updates there were of the plan that is used."""
    plan = simulator.get_system().GetOutputPort("plan").Eval(simulator.get_context())
    (updates,) = {*plan}
    return updates


@pytest.mark.parametrize("late", [False, True])
def test_a_late_plan_is_used_one_period_later(humanoid, late):
    """Until there is one, the plan with which the MPC begins."""
    simulator, seen = counting_simulator(humanoid, late), []
    for tick in range(1, 101):
        simulator.AdvanceTo(1e-3 * tick)
        seen.append(used(simulator))
    made = np.repeat(np.arange(1, 6), 20)
    np.testing.assert_array_equal(seen, made - 1 if late else made)


def test_a_late_plan_of_a_saved_state_goes_on(humanoid):
    """A new simulation of it does not begin with the newest plan, whose time has not come."""
    simulator = counting_simulator(humanoid, late=True)
    simulator.AdvanceTo(0.03)
    again = Simulator(simulator.get_system(), simulator.get_context().Clone())
    again.Initialize()
    assert used(again) == used(simulator) == 1.0
    again.AdvanceTo(0.045)
    assert used(again) == 2.0


def test_only_a_late_plan_needs_a_system():
    for scenario, there in ((SHORT, False), (LATE, True)):
        assert build_closed_loop(scenario).controller.HasSubsystemNamed("late_plan") == there


def test_it_walks_on_late_plans():
    run = simulate(build_closed_loop(LATE))
    assert not run.fell
    known = np.flatnonzero(~np.isnan(run.mpc_ms))
    assert run.time[known[0]] == pytest.approx(0.021)  # made at 0, used from 0.02 on
    np.testing.assert_allclose(np.diff(run.time[known]), 0.02, atol=1e-9)


def test_a_drive_takes_the_late_plan_over():
    session = Session(LATE, None, record=True)
    session.advance(0.1)
    session.retune(session.tuning)
    session.advance(0.1)
    assert not session.fall
    around = session.run().mpc_com[90:110]
    np.testing.assert_allclose(np.diff(around, axis=0), 0.0, atol=1.5e-3)


@pytest.mark.slow
def test_it_walks_at_speed_on_late_plans():
    segments = [Segment("stand", 0.3), Segment("walk", 2.5, True, [0.4, 0.0])]
    run = simulate(build_closed_loop(Scenario(segments=segments, mpc=MpcParameters(late=True))))
    assert not run.fell, run.fall_reason
    assert run.com[-1, 0] > 0.6
