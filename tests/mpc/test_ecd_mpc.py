"""The MPC as a LeafSystem, through its ports only."""

from dataclasses import replace

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator

from drake_linefoot.centroidal import sample_plan
from drake_linefoot.errors import InputError, SignalError
from drake_linefoot.layout import Layout, flat
from drake_linefoot.mpc.ecd_mpc import EcdMpc, has_flight
from drake_linefoot.mpc.models.ecd import ECD
from drake_linefoot.mpc.models.model import measure_centroidal
from drake_linefoot.mpc.parameters import MpcParameters
from drake_linefoot.mpc.solve import MpcSolver
from drake_linefoot.robot.dynamics import dynamics_layout
from drake_linefoot.signals import CentroidalPlan, Reference
from tests.helpers.ports import look, put
from tests.helpers.walking import dynamics_of, mirror_plan, mirror_reference, recorded_walk


class Bench:
    """An MPC whose inputs are those of a recorded update."""

    def __init__(self, humanoid, record, **parameters):
        self.system = EcdMpc(humanoid, MpcParameters(**{"model": "ecd", **parameters}))
        self.simulator = Simulator(self.system)
        self.context = self.simulator.get_mutable_context()
        self.feed(record.x, record.reference)

    def feed(self, x, reference):
        self.put(dynamics_of(x))
        put(self.system, self.context, "reference", reference)

    def put(self, dynamics):
        put(self.system, self.context, "dynamics", dynamics)

    def plan(self):
        return look(self.system.get_plan_output_port(), self.context)

    def until(self, time):
        self.simulator.AdvanceTo(time)
        return self.plan()


@pytest.fixture(scope="module")
def records():
    return recorded_walk().mpc


def test_names_and_sizes_of_the_ports(humanoid, records):
    s = Bench(humanoid, records[0]).system
    assert s.get_name() == "ecd_mpc"
    inputs = [s.get_input_port(i) for i in range(s.num_input_ports())]
    assert [p.get_name() for p in inputs] == ["dynamics", "reference"]
    assert s.num_output_ports() == 1
    assert s.get_plan_output_port().get_name() == "plan"
    sizes = {"knots": MpcParameters().knots, "nw": humanoid.contact.size}
    assert inputs[0].size() == dynamics_layout(humanoid).size
    assert inputs[1].size() == Layout(Reference, sizes).size
    assert s.get_plan_output_port().size() == Layout(CentroidalPlan, sizes).size
    assert not s.HasAnyDirectFeedthrough()


def test_it_measures_what_the_plant_says(humanoid, walking_state):
    x = walking_state(humanoid, 11)
    m = measure_centroidal(dynamics_of(x))
    context = humanoid.plant.CreateDefaultContext()
    humanoid.plant.SetPositionsAndVelocities(context, x)
    h = humanoid.plant.CalcSpatialMomentumInWorldAboutPoint(context, m.r)
    np.testing.assert_allclose(m.r, humanoid.plant.CalcCenterOfMassPositionInWorld(context))
    np.testing.assert_allclose(h.translational(), humanoid.mass * m.v, atol=1e-11)
    np.testing.assert_allclose(h.rotational(), m.L, atol=1e-12)
    X_WB = humanoid.plant.EvalBodyPoseInWorld(context, humanoid.base)
    np.testing.assert_allclose(m.R_WB, X_WB.rotation().matrix(), atol=1e-14)


def test_it_starts_from_what_its_model_measures(humanoid, records, own_models):
    record = records[40]
    d = dynamics_of(record.x)
    measured = replace(ECD.measure(d), L=np.array([0.1, -0.2, 0.3]))
    own_models(replace(ECD, name="mine", measure=lambda _: measured))
    for model, L in (
        ("mine", measured.L),
        ("ecd", d.A[:3] @ d.v),
        ("srbm", d.A[:3, :3] @ d.v[:3]),
        ("srbm_momentum", d.A[:3] @ d.v),
    ):
        plan = Bench(humanoid, record, model=model).until(0.001)
        np.testing.assert_allclose(plan.states[0, 6:9], L, rtol=0, atol=1e-15)


def test_before_its_first_update_it_stands(humanoid, records):
    """Known answer: half the weight on each foot, at any time and place, and no motion."""
    bench = Bench(humanoid, records[0])
    plan = bench.plan()
    for t in (0.0, 0.3, 9.0):
        sample = sample_plan(plan, t)
        np.testing.assert_allclose(sample.wrench[:, 2], 0.5 * humanoid.mass * 9.81)
        np.testing.assert_allclose([sample.v, sample.a], 0.0, atol=1e-12)
        np.testing.assert_allclose(sample.L_dot, 0.0, atol=0.1)


@pytest.fixture
def solved(monkeypatch):
    """A list of all plans that are made from now on."""
    made, solve = [], MpcSolver.solve

    def kept(self, *args):
        made.append(solve(self, *args))
        return made[-1]

    monkeypatch.setattr(MpcSolver, "solve", kept)
    return made


@pytest.mark.parametrize("period", [0.02, 0.005])
def test_it_plans_once_a_period_and_holds_in_between(humanoid, records, solved, period):
    assert MpcParameters().period == 0.02
    bench, every = Bench(humanoid, records[40], period=period), round(1000 * period)
    assert bench.until(0.001).success
    for tick in range(2, 101):
        plan = bench.until(0.001 * tick + 1e-6)
        assert len(solved) == 1 + tick // every
        np.testing.assert_array_equal(flat(plan), flat(solved[-1]))


def test_it_plans_more_often_while_its_plan_has_a_flight(humanoid, records, solved, monkeypatch):
    """Which is asked only between two periods; late plans keep to those."""
    flies = []
    monkeypatch.setattr("drake_linefoot.mpc.ecd_mpc.has_flight", lambda plan: bool(flies))
    bench = Bench(humanoid, records[40])
    bench.until(0.045)
    assert len(solved) == 3
    flies.append(1)
    bench.until(0.095)
    assert len(solved) == 3 + 5
    p = MpcParameters()
    assert (p.shortest_period, replace(p, period=0.015).shortest_period) == (0.01, 0.015)
    assert {replace(p, **{name: True}).shortest_period for name in ("late", "process")} == {0.02}


def test_a_plan_without_force_has_a_flight(humanoid, records):
    plan = Bench(humanoid, records[40]).until(0.001)
    assert not has_flight(plan)
    force = plan.force.copy()
    force[3] = 0.0
    assert has_flight(plan._replace(force=force))


def test_it_plans_what_the_closed_loop_planned(humanoid, records):
    for record in records[20::30]:
        plan = Bench(humanoid, record, solver="clarabel", tolerance=1e-10).until(0.001)
        np.testing.assert_allclose(plan.wrench[0], record.plan.wrench[0], atol=1.0)
        np.testing.assert_array_equal(plan.times, record.plan.times)
        np.testing.assert_allclose(plan.states[0], record.plan.states[0], atol=1e-10)


def test_mirrored_input_gives_mirrored_output(humanoid, records):
    parameters = {"solver": "clarabel", "tolerance": 1e-10}
    for record in records[25::30]:
        bench = Bench(humanoid, record, **parameters)
        plan = mirror_plan(bench.until(0.001))
        other = Bench(humanoid, record, **parameters)
        other.feed(humanoid.mirror_state(record.x), mirror_reference(record.reference))
        mirrored = other.until(0.001)
        np.testing.assert_allclose(mirrored.wrench, plan.wrench, atol=1e-3)
        np.testing.assert_allclose(mirrored.states, plan.states, atol=1e-6)


def test_a_failing_solver_keeps_the_plan_and_counts(humanoid, records):
    bench = Bench(humanoid, records[40], max_iterations=1)
    standing = bench.plan()
    plan = bench.until(0.0999)
    assert plan.failures == 5
    assert not plan.success
    np.testing.assert_array_equal(plan.wrench, standing.wrench)


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_a_state_that_is_not_finite_is_refused_by_name(humanoid, records, value):
    bench = Bench(humanoid, records[40])
    bench.until(0.001)
    d = dynamics_of(records[40].x.copy())
    d.v[20] = value
    bench.put(d)
    with pytest.raises(SignalError, match=rf"ecd_mpc\.dynamics: v\[20\] is {value}"):
        bench.until(0.03)


def test_a_reference_that_is_not_finite_is_refused_by_name(humanoid, records):
    bench = Bench(humanoid, records[40])
    v = records[40].reference.v.copy()
    v[3, 1] = np.nan
    bench.feed(records[40].x, records[40].reference._replace(v=v))
    with pytest.raises(SignalError, match=r"ecd_mpc\.reference: v\[3, 1\] is nan"):
        bench.until(0.001)


def test_a_signal_of_another_size_is_refused_when_it_is_wired(humanoid, records):
    system = Bench(humanoid, records[40]).system
    with pytest.raises((RuntimeError, ValueError), match="reference"):
        system.get_reference_input_port().FixValue(system.CreateDefaultContext(), np.zeros(7))


@pytest.mark.parametrize("late", [False, True])
def test_it_goes_on_from_a_saved_context(humanoid, records, late):
    """A simulator of a clone starts with the same plan and makes the same next one."""
    bench = Bench(humanoid, records[40], late=late)
    plan = bench.until(0.013)
    assert plan.success
    bench.feed(records[41].x, records[41].reference)
    again = Simulator(bench.system, bench.context.Clone())
    again.Initialize()
    port = bench.system.get_plan_output_port()
    np.testing.assert_array_equal(flat(look(port, again.get_context())), flat(plan))
    again.AdvanceTo(0.03)
    other, expected = look(port, again.get_context()), bench.until(0.03)
    assert expected.times[0] > plan.times[0]
    for name in ("times", "wrench", "states", "r_G"):
        np.testing.assert_array_equal(getattr(other, name), getattr(expected, name))


def test_an_unknown_solver_is_refused_when_it_is_built(humanoid):
    with pytest.raises(InputError, match="must be one of"):
        EcdMpc(humanoid, MpcParameters(solver="snopt"))


def test_the_plan_does_not_depend_on_the_time_of_the_context(humanoid, records):
    bench = Bench(humanoid, records[40])
    plan = bench.until(0.001)
    bench.context.SetTime(0.0105)
    np.testing.assert_array_equal(flat(bench.plan()), flat(plan))
