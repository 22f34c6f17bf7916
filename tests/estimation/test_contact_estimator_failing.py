"""The contact estimator when inputs are no numbers or do not fit, and when it is stopped."""

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator

from drake_linefoot.errors import SignalError, SolverError
from drake_linefoot.estimation import contact_estimator
from drake_linefoot.estimation.contact_estimator import ContactEstimator
from drake_linefoot.estimation.contact_parameters import CONSTRAINED, EstimatorParameters
from drake_linefoot.robot.dynamics import robot_dynamics
from tests.helpers.estimator_bench import Bench, standing
from tests.helpers.ports import look


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_a_state_that_is_not_finite_raises_and_is_named(humanoid, bad):
    x, torque, _ = standing(humanoid)
    bench = Bench(humanoid, x, torque)
    d = robot_dynamics(humanoid, bench.scratch, x)
    v = d.v.copy()
    v[5] = bad
    broken = d._replace(v=v)
    bench.after(0.0105)
    bench.dynamics(broken)
    named = rf"contact_estimator\.dynamics: v\[5\] is {bad}"
    with pytest.raises(SignalError, match=named) as caught:
        bench.after(0.0115)
    assert caught.value.port == "contact_estimator.dynamics"
    fresh = Bench(humanoid, x, torque)
    fresh.dynamics(broken)
    with pytest.raises(SignalError, match=r"contact_estimator\.dynamics"):
        fresh.simulator.Initialize()


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_a_torque_that_is_not_finite_raises_and_is_named(humanoid, bad):
    x, torque, _ = standing(humanoid)
    torque[4] = bad
    with pytest.raises(SignalError, match=r"contact_estimator\.applied_torque.*element 4"):
        Bench(humanoid, x, torque).after(0.001)


@pytest.mark.parametrize("method", ["pseudoinverse", "constrained"])
def test_an_estimate_that_is_not_finite_is_not_used(humanoid, method, monkeypatch):
    x, torque, _ = standing(humanoid)
    bench = Bench(humanoid, x, torque, method=method)
    bench.after(0.0105)
    before = bench.context.get_discrete_state_vector().value().copy()
    solved = contact_estimator.next_estimate
    monkeypatch.setattr(contact_estimator, "next_estimate", lambda *a: solved(*a) * np.nan)
    with pytest.raises((SignalError, SolverError)):
        bench.after(0.0115)
    np.testing.assert_array_equal(bench.context.get_discrete_state_vector().value(), before)


@pytest.mark.parametrize("port", ["dynamics", "applied_torque"])
def test_a_vector_of_another_size_is_refused_when_it_is_put_on_a_port(humanoid, port):
    x, torque, _ = standing(humanoid)
    bench = Bench(humanoid, x, torque)
    size = bench.system.GetInputPort(port).size()
    for wrong in (1, size - 1, size + 1):
        with pytest.raises((RuntimeError, ValueError), match=port):
            bench.system.GetInputPort(port).FixValue(bench.context, np.zeros(wrong))


def test_a_context_that_was_saved_goes_on(humanoid):
    """With the same bits, in another simulator, whose Initialize begins nothing anew."""
    x, torque, _ = standing(humanoid, 0.05)
    bench = Bench(humanoid, x, torque)
    bench.after(0.0105)
    saved, expected = bench.context.Clone(), bench.after(0.0305)
    simulator = Simulator(bench.system, saved)
    simulator.Initialize()
    simulator.AdvanceTo(0.0305)
    found = look(bench.system.get_contact_output_port(), simulator.get_context())
    np.testing.assert_array_equal(found.residual, expected.residual)
    np.testing.assert_array_equal(found.wrench, expected.wrench)


def test_an_input_that_is_not_connected_is_said(humanoid):
    system = ContactEstimator(humanoid, EstimatorParameters())
    with pytest.raises((RuntimeError, ValueError), match="dynamics"):
        Simulator(system).Initialize()


def test_a_constrained_estimate_that_fails_raises(humanoid):
    """Numbers that are finite and far too large for any solver."""
    x, torque, _ = standing(humanoid)
    bench = Bench(humanoid, x, torque, method=CONSTRAINED)
    np.testing.assert_array_equal(bench.after(0.0015).contact, [1.0, 1.0])
    bench.feed(torque=np.full(humanoid.na, 1e200))
    with pytest.raises(SolverError, match="contact program not solved"):
        bench.after(0.0025)
