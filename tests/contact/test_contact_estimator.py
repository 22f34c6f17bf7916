"""The contact estimator through its ports alone, and once in the loop of a walking robot."""

import numpy as np
import pytest
from pydrake.common.value import AbstractValue
from pydrake.systems.analysis import Simulator

from drake_linefoot.contact import contact_estimator
from drake_linefoot.contact.contact_estimator import ContactEstimator
from drake_linefoot.contact.parameters import CONSTRAINED, METHODS, EstimatorParameters
from drake_linefoot.errors import SignalError, SolverError
from drake_linefoot.robot.dynamics import robot_dynamics
from drake_linefoot.scenario import Scenario, Segment
from drake_linefoot.signals import ContactEstimate
from drake_linefoot.wiring.closed_loop import build_closed_loop
from tests.helpers.feet import feet_of

WRENCH_MIRROR = np.array([1.0, -1.0, 1.0, 1.0, -1.0])


class Bench:
    """An estimator with fixed inputs and a simulator that runs nothing else."""

    def __init__(self, robot, x, torque, **parameters):
        self.robot, self.scratch = robot, robot.plant.CreateDefaultContext()
        self.system = ContactEstimator(robot, EstimatorParameters(**parameters))
        self.simulator = Simulator(self.system)
        self.context = self.simulator.get_mutable_context()
        self.feed(x, torque)

    def feed(self, x=None, torque=None):
        if x is not None:
            dynamics = AbstractValue.Make(robot_dynamics(self.robot, self.scratch, x))
            self.system.get_dynamics_input_port().FixValue(self.context, dynamics)
        if torque is not None:
            self.system.get_applied_torque_input_port().FixValue(self.context, torque)

    def estimate(self):
        return self.system.get_contact_output_port().Eval(self.context)

    def after(self, time):
        self.simulator.AdvanceTo(time)
        return self.estimate()


def standing(robot, lean=0.0):
    """Return (x, torque, wrench) of a posture at rest: what holds it there.

    Both legs lean to one side by an angle, so that one foot carries more. Line feet at one
    height cannot choose how to share the weight; the least forces that the six base rows
    of the statics allow are taken, and the joint rows say which torque goes with them.
    """
    x = robot.x_nominal
    left, right = robot.leg_q[:, 1]  # the joints about the forward axis
    x[left] = lean
    x[right] = -robot.mirror_state(x)[right]
    context = robot.plant.CreateDefaultContext()
    robot.plant.SetPositionsAndVelocities(context, x)
    d = robot_dynamics(robot, context, x)
    gravity = robot.plant.CalcGravityGeneralizedForces(context)
    J = np.vstack([foot.J for foot in feet_of(d)])
    wrench = np.linalg.lstsq(J[:, :6].T, -gravity[:6], rcond=None)[0]
    torque = -(gravity + J.T @ wrench)[robot.actuated_v]
    return x, torque, wrench.reshape(2, 5)


# --- ports ----------------------------------------------------------------------------------


def test_ports_have_the_names_and_sizes_that_are_documented(robot):
    system = ContactEstimator(robot, EstimatorParameters())
    assert system.get_name() == "contact_estimator"
    dynamics, torque = system.GetInputPort("dynamics"), system.GetInputPort("applied_torque")
    assert system.num_input_ports() == 2
    assert torque.size() == robot.na
    assert dynamics is not torque
    assert system.get_dynamics_input_port().get_index() == dynamics.get_index()
    assert system.get_applied_torque_input_port().get_index() == torque.get_index()
    assert system.num_output_ports() == 1
    contact = system.GetOutputPort("contact")
    assert system.get_contact_output_port().get_index() == contact.get_index()
    assert not system.HasAnyDirectFeedthrough()
    value = contact.Allocate().get_value()
    assert isinstance(value, ContactEstimate)
    assert (value.wrench.shape, value.residual.shape) == ((2, 5), (robot.nv,))


def test_updates_come_at_1_khz(humanoid):
    system = ContactEstimator(humanoid, EstimatorParameters())
    timing = system.GetUniquePeriodicDiscreteUpdateAttribute()
    assert timing.period_sec() == 1e-3
    assert timing.offset_sec() == 0.0


# --- what comes out -------------------------------------------------------------------------


def test_it_starts_with_both_feet_under_half_the_weight(robot):
    x, torque, _ = standing(robot)
    bench = Bench(robot, x, torque)
    bench.simulator.Initialize()
    estimate = bench.estimate()
    assert estimate.contact == (True, True)
    half = 0.5 * robot.mass * 9.81
    np.testing.assert_allclose(estimate.wrench, [[0, 0, half, 0, 0]] * 2, rtol=1e-12)
    # The residual is what these forces do: on the base, the weight.
    assert estimate.residual[5] == pytest.approx(robot.mass * 9.81)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("lean", [0.0, 0.08])
def test_standing_still_the_feet_carry_the_weight(robot, method, lean):
    x, torque, wrench = standing(robot, lean)
    estimate = Bench(robot, x, torque, method=method, friction=2.0).after(0.2)
    tolerance = 1e-8 if method != CONSTRAINED else 2e-3
    np.testing.assert_allclose(estimate.wrench, wrench, rtol=0, atol=tolerance)
    total = estimate.wrench[:, 2].sum()
    assert total == pytest.approx(robot.mass * 9.81, abs=2 * tolerance)
    np.testing.assert_allclose(estimate.residual[3:6], [0, 0, robot.mass * 9.81], atol=1e-8)
    assert estimate.contact == (True, True)


@pytest.mark.parametrize("lean", [-0.08, 0.08])
def test_a_foot_with_little_load_is_in_the_air(robot, lean):
    x, torque, wrench = standing(robot, lean)
    loads = wrench[:, 2] / (robot.mass * 9.81)
    release, touch = 0.4 * robot.mass * 9.81, 0.6 * robot.mass * 9.81
    assert loads.max() > 0.6
    assert loads.min() < 0.4
    estimate = Bench(robot, x, torque, touch_force=touch, release_force=release).after(0.2)
    assert estimate.contact == tuple(loads > 0.5)


def test_between_the_limits_a_foot_stays_what_it_was(humanoid):
    """Half the weight on each foot is between the two limits; leaning lifts one out of them."""
    weight = humanoid.mass * 9.81
    middle, leaning = standing(humanoid)[:2], standing(humanoid, 0.08)[:2]
    limits = {"touch_force": 0.6 * weight, "release_force": 0.4 * weight}
    bench = Bench(humanoid, *middle, **limits)
    for time in (0.1, 0.101):  # after an even and an odd number of updates
        assert bench.after(time).contact == (True, True)
    bench.feed(*leaning)
    one = bench.after(0.2).contact
    assert sorted(one) == [False, True]
    bench.feed(*middle)
    for time in (0.3, 0.301):
        assert bench.after(time).contact == one


def test_between_updates_everything_is_held(humanoid):
    x, torque, _ = standing(humanoid)
    bench = Bench(humanoid, x, torque)
    held = bench.after(0.1002)
    bench.feed(torque=torque + 5.0)
    np.testing.assert_array_equal(bench.estimate().residual, held.residual)
    np.testing.assert_array_equal(bench.after(0.1009).residual, held.residual)
    np.testing.assert_array_equal(bench.estimate().wrench, held.wrench)
    changed = bench.after(0.1011)
    # gamma = 0.8: the torque that is not there shows with 0.2 of its size, in its own rows.
    expected = np.zeros(humanoid.nv)
    expected[humanoid.actuated_v] = -0.2 * 5.0
    np.testing.assert_allclose(changed.residual - held.residual, expected, rtol=0, atol=1e-9)
    assert np.abs(changed.wrench - held.wrench).max() > 0.1


@pytest.mark.parametrize("gamma", [0.0, 0.5, 0.9])
def test_the_filter_takes_one_step_every_millisecond(humanoid, gamma):
    """The error after n updates is gamma^n of the first one."""
    x, torque, _ = standing(humanoid)
    torque[3] += 5.0  # the robot would move; the estimator cannot know
    bench = Bench(humanoid, x, torque, filter_constant=gamma)
    bench.simulator.Initialize()
    start, end = bench.estimate().residual, Bench(humanoid, x, torque).after(0.3).residual
    assert np.abs(start - end).max() > 5.0
    for count in (1, 2, 5, 10):
        found = bench.after((count - 0.5) * 1e-3).residual  # ticks at 0, 1, ... ms
        expected = end + gamma**count * (start - end)
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-8)


def test_without_a_filter_the_first_update_is_right(robot):
    x, torque, wrench = standing(robot, lean=0.05)
    estimate = Bench(robot, x, torque, filter_constant=0.0).after(1e-4)
    np.testing.assert_allclose(estimate.wrench, wrench, rtol=0, atol=1e-8)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("method", METHODS)
def test_mirrored_input_gives_mirrored_output(robot, walking_state, seed, method):
    """Moving, with a jump of the state so that the momentum changes as well."""
    first = walking_state(robot, seed, speed=0.02)
    second = first + 1e-4 * walking_state(robot, seed + 50, speed=1.0)
    torque = 5.0 * np.random.default_rng(seed).normal(size=robot.na)
    results = []
    for mirror in (False, True):
        turn = robot.mirror_state if mirror else np.array
        given = robot.mirror_joints(torque) if mirror else torque
        bench = Bench(robot, turn(first), given, method=method)
        bench.after(0.0005)
        bench.feed(x=turn(second))
        results.append(bench.after(0.0035))
    plain, mirrored = results
    scale = max(np.abs(plain.wrench).max(), 1.0)
    tolerance = (1e-10 if method != CONSTRAINED else 1e-4) * scale
    expected = plain.wrench[::-1] * WRENCH_MIRROR
    np.testing.assert_allclose(mirrored.wrench, expected, rtol=0, atol=tolerance)
    assert mirrored.contact == plain.contact[::-1]
    as_state = np.concatenate([robot.q_nominal, plain.residual])
    np.testing.assert_allclose(
        mirrored.residual, robot.mirror_state(as_state)[robot.nq :], rtol=0, atol=1e-10 * scale
    )


# --- when things go wrong -------------------------------------------------------------------


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_a_state_that_is_not_finite_raises_and_is_named(humanoid, bad):
    x, torque, _ = standing(humanoid)
    bench = Bench(humanoid, x, torque)
    d = robot_dynamics(humanoid, bench.scratch, x)
    v = d.v.copy()
    v[5] = bad
    broken = AbstractValue.Make(d._replace(v=v))
    bench.after(0.0105)
    bench.system.get_dynamics_input_port().FixValue(bench.context, broken)
    with pytest.raises(SignalError, match=r"contact_estimator\.dynamics.*velocity 5") as caught:
        bench.after(0.0115)
    assert caught.value.port == "contact_estimator.dynamics"
    fresh = Bench(humanoid, x, torque)
    fresh.system.get_dynamics_input_port().FixValue(fresh.context, broken)
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


def test_another_object_is_refused_by_name(humanoid):
    x, torque, _ = standing(humanoid)
    bench = Bench(humanoid, x, torque)
    bench.system.get_dynamics_input_port().FixValue(
        bench.context, AbstractValue.Make(("a", "state"))
    )
    with pytest.raises(SignalError, match=r"dynamics: got a tuple: must be a RobotDynamics"):
        bench.simulator.Initialize()


def test_a_context_that_was_saved_goes_on(humanoid):
    """With the same bits, in another simulator, whose Initialize begins nothing anew."""
    x, torque, _ = standing(humanoid, 0.05)
    bench = Bench(humanoid, x, torque)
    bench.after(0.0105)
    saved, expected = bench.context.Clone(), bench.after(0.0305)
    simulator = Simulator(bench.system, saved)
    simulator.Initialize()
    simulator.AdvanceTo(0.0305)
    found = bench.system.get_contact_output_port().Eval(simulator.get_context())
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
    assert bench.after(0.0015).contact == (True, True)
    bench.feed(torque=np.full(humanoid.na, 1e200))
    with pytest.raises(SolverError, match="contact program not solved"):
        bench.after(0.0025)


# --- in the loop ----------------------------------------------------------------------------


@pytest.mark.slow
def test_while_walking_it_follows_the_simulators_forces(contact_wrenches):
    """With the parameters of the program; half of the weight is 122 N.

    Large errors are the filter's delay at touchdown, a few milliseconds long.
    """
    segments = [Segment("stand", 0.4), Segment("step", 0.6, True), Segment("walk", 1.0, True)]
    segments[2].velocity = [0.3, 0.0]
    loop = build_closed_loop(Scenario(segments=segments))
    humanoid, plant = loop.humanoid, loop.plant
    simulator = loop.make_simulator()
    root = simulator.get_mutable_context()
    context = plant.GetMyMutableContextFromRoot(root)
    own = loop.controller.GetMyContextFromRoot(root)
    scratch = humanoid.plant.CreateDefaultContext()
    errors, agree = [], []

    def monitor(_):
        x = plant.get_state_output_port().Eval(context)
        true = contact_wrenches(humanoid, plant, context, robot_dynamics(humanoid, scratch, x))
        estimate = loop.controller.GetOutputPort("contact").Eval(own)
        errors.append(np.abs(estimate.wrench - true))
        agree.append([bool(f > 35.0) for f in true[:, 2]] == list(estimate.contact))

    simulator.Initialize()
    simulator.set_monitor(monitor)
    simulator.AdvanceTo(2.0)
    assert plant.GetPositions(context)[6] > 0.6  # it has not fallen
    unequal = np.array(errors)[..., 2].max(axis=1) > 100.0
    assert np.all(np.median(errors, axis=0) < [0.5, 0.5, 0.5, 0.1, 0.1])
    assert np.all(np.quantile(errors, 0.9, axis=0) < [5.0, 5.0, 15.0, 1.5, 1.5])
    assert np.mean(unequal) < 0.02
    assert np.mean(agree) > 0.95
