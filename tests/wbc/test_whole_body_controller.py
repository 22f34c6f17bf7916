"""The whole-body controller as a LeafSystem, through its ports only."""

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator

from drake_linefoot.errors import InputError, SignalError
from drake_linefoot.statuses import Solved
from drake_linefoot.wbc.control import WholeBodyControl
from drake_linefoot.wbc.parameters import WbcParameters
from drake_linefoot.wbc.whole_body_controller import WholeBodyController
from tests.helpers.ports import look, put
from tests.helpers.walking import dynamics_of, mirror_plan, mirror_targets


class Bench:
    """A controller whose inputs are those of a recorded tick."""

    def __init__(self, humanoid, record, **parameters):
        self.system = WholeBodyController(humanoid, WbcParameters(**parameters))
        self.context = self.system.CreateDefaultContext()
        self.feed(record.x, record.targets, record.plan)

    def feed(self, x, targets, plan):
        s = self.system
        self.put(dynamics_of(x))
        put(s, self.context, "targets", targets)
        put(s, self.context, "plan", plan)

    def put(self, dynamics):
        put(self.system, self.context, "dynamics", dynamics)

    def torque(self):
        return self.system.get_torque_output_port().Eval(self.context)

    def report(self):
        return look(self.system.get_report_output_port(), self.context)


@pytest.fixture
def calls(monkeypatch):
    """Counts how often a tick is computed."""
    made, compute = [], WholeBodyControl.compute

    def counted(self, *args):
        made.append(args)
        return compute(self, *args)

    monkeypatch.setattr(WholeBodyControl, "compute", counted)
    return made


def test_names_and_sizes_of_the_ports(humanoid, records):
    s = Bench(humanoid, records[0]).system
    assert s.get_name() == "whole_body_controller"
    inputs = [s.get_input_port(i) for i in range(s.num_input_ports())]
    assert [p.get_name() for p in inputs] == ["dynamics", "targets", "plan"]
    outputs = [s.get_output_port(i) for i in range(s.num_output_ports())]
    assert [p.get_name() for p in outputs] == ["torque", "report"]
    assert outputs[0].size() == humanoid.na


def test_it_is_stateless_and_passes_its_inputs_through(humanoid, records):
    """No state and no events: the torque belongs to the state it is asked for."""
    bench = Bench(humanoid, records[0])
    assert bench.context.is_stateless()
    assert bench.system.HasDirectFeedthrough(0)
    simulator = Simulator(bench.system, bench.context)
    simulator.AdvanceTo(0.1)
    assert simulator.get_num_discrete_updates() == 0
    assert simulator.get_num_unrestricted_updates() == 0


def test_known_ticks_of_the_closed_loop(humanoid, records):
    for record in records[::30]:
        bench = Bench(humanoid, record)
        np.testing.assert_allclose(bench.torque(), record.torque, atol=1e-9)
        np.testing.assert_allclose(bench.report().vdot, record.report.vdot, atol=1e-7)


def test_torque_and_report_come_of_one_computation(humanoid, records, calls):
    bench = Bench(humanoid, records[100])
    torque, report = bench.torque(), bench.report()
    bench.torque()
    assert len(calls) == 1
    np.testing.assert_array_equal(report.torque, torque)


def test_time_alone_computes_nothing_and_every_input_does(humanoid, records, calls):
    a, b = records[100], records[101]
    bench = Bench(humanoid, a)
    bench.torque()
    bench.context.SetTime(0.5)
    bench.torque()
    assert len(calls) == 1
    bench.feed(b.x, a.targets, a.plan)
    first = bench.torque()
    bench.feed(b.x, b.targets, a.plan)
    second = bench.torque()
    bench.feed(b.x, b.targets, records[140].plan)
    third = bench.torque()
    assert len(calls) == 4
    assert np.abs(first - second).max() > 0.0
    assert np.abs(second - third).max() > 0.0


def test_mirrored_input_gives_mirrored_output(humanoid, records):
    for record in records[90::40]:
        exact = {"solver": "clarabel", "tolerance": 1e-10}
        one, other = Bench(humanoid, record, **exact), Bench(humanoid, record, **exact)
        targets, plan = mirror_targets(record.targets), mirror_plan(record.plan)
        other.feed(humanoid.mirror_state(record.x), targets, plan)
        expected = humanoid.mirror_joints(one.torque())
        np.testing.assert_allclose(other.torque(), expected, atol=1e-4)


def test_a_failing_solver_is_reported(humanoid, records, solver_only):
    record = next(r for r in records if r.report.status == Solved.ACTIVE_SET)
    bench = Bench(humanoid, record, max_iterations=1)
    assert not bench.report().success
    assert np.isfinite(bench.torque()).all()
    assert np.all(np.abs(bench.torque()) <= humanoid.effort_limits)


@pytest.mark.parametrize("port", ["torque", "report"])
@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_a_state_that_is_not_finite_is_refused_by_name(humanoid, records, port, value):
    d = dynamics_of(records[100].x.copy())
    d.q[7] = value
    bench = Bench(humanoid, records[100])
    bench.put(d)
    with pytest.raises(SignalError, match=rf"whole_body_controller\.dynamics: q\[7\] is {value}"):
        getattr(bench, port)()


@pytest.mark.parametrize(
    ("port", "part", "name"),
    [
        ("dynamics", "J", r"J\[1, 4, 23\]"),
        ("targets", "swing", r"swing\[1, 5, 2\]"),
        ("targets", "yaw", "yaw"),
        ("plan", "wrench", r"wrench\[13, 1, 4\]"),
    ],
)
def test_a_number_that_is_not_finite_is_refused_by_name(humanoid, records, port, part, name):
    """The last one of a part, of whichever signal."""
    bench, record = Bench(humanoid, records[100]), records[100]
    signals = {"targets": record.targets, "plan": record.plan, "dynamics": dynamics_of(record.x)}
    numbers = np.array(getattr(signals[port], part))
    numbers.flat[-1] = np.inf
    put(bench.system, bench.context, port, signals[port]._replace(**{part: numbers}))
    with pytest.raises(SignalError, match=rf"whole_body_controller\.{port}: {name} is inf: must"):
        bench.torque()


@pytest.mark.parametrize("port", ["dynamics", "targets", "plan"])
def test_a_signal_of_another_size_is_refused(humanoid, records, port):
    bench = Bench(humanoid, records[100])
    into = bench.system.GetInputPort(port)
    with pytest.raises(RuntimeError, match=f"(?i)expected.* size={into.size()}.*{port}"):
        into.FixValue(bench.context, np.zeros(into.size() - 1))


def test_an_unknown_solver_is_refused_when_it_is_built(humanoid):
    with pytest.raises(InputError, match="must be one of"):
        WholeBodyController(humanoid, WbcParameters(solver="nlopt"))
