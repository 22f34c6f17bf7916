"""The contact estimator through its ports alone, and once in the loop of a walking robot."""

import numpy as np
import pytest

from drake_linefoot.estimation.contact_estimator import ContactEstimator
from drake_linefoot.estimation.contact_parameters import CONSTRAINED, METHODS, EstimatorParameters
from drake_linefoot.lab.scenario import Scenario, Segment
from drake_linefoot.lab.wiring.closed_loop import build_closed_loop
from drake_linefoot.layout import Layout
from drake_linefoot.robot.dynamics import dynamics_layout, robot_dynamics
from drake_linefoot.signals import ContactEstimate
from tests.helpers.estimator_bench import Bench, standing
from tests.helpers.ports import look

WRENCH_MIRROR = np.array([1.0, -1.0, 1.0, 1.0, -1.0, -1.0])

# --- ports ----------------------------------------------------------------------------------


def test_ports_have_the_names_and_sizes_that_are_documented(robot):
    system = ContactEstimator(robot, EstimatorParameters())
    assert system.get_name() == "contact_estimator"
    dynamics, torque = system.GetInputPort("dynamics"), system.GetInputPort("applied_torque")
    assert system.num_input_ports() == 2
    assert torque.size() == robot.na
    assert dynamics.size() == dynamics_layout(robot).size
    assert system.get_dynamics_input_port().get_index() == dynamics.get_index()
    assert system.get_applied_torque_input_port().get_index() == torque.get_index()
    assert system.num_output_ports() == 1
    contact = system.GetOutputPort("contact")
    assert system.get_contact_output_port().get_index() == contact.get_index()
    assert not system.HasAnyDirectFeedthrough()
    layout = Layout(ContactEstimate, robot.sizes)
    assert contact.size() == layout.size == 2 * robot.contact.size + 2 + robot.nv + 6
    value = look(contact, system.CreateDefaultContext(), robot)
    assert (value.wrench.shape, value.residual.shape) == ((2, robot.contact.size), (robot.nv,))


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
    np.testing.assert_array_equal(estimate.contact, [1.0, 1.0])
    half = 0.5 * robot.mass * 9.81
    expected = np.zeros((2, robot.contact.size))
    expected[:, 2] = half
    np.testing.assert_allclose(estimate.wrench, expected, rtol=1e-12)
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
    np.testing.assert_array_equal(estimate.contact, [1.0, 1.0])


@pytest.mark.parametrize("lean", [-0.08, 0.08])
def test_a_foot_with_little_load_is_in_the_air(robot, lean):
    x, torque, wrench = standing(robot, lean)
    loads = wrench[:, 2] / (robot.mass * 9.81)
    release, touch = 0.4 * robot.mass * 9.81, 0.6 * robot.mass * 9.81
    assert loads.max() > 0.6
    assert loads.min() < 0.4
    estimate = Bench(robot, x, torque, touch_force=touch, release_force=release).after(0.2)
    np.testing.assert_array_equal(estimate.contact, loads > 0.5)


def test_between_the_limits_a_foot_stays_what_it_was(humanoid):
    """Half the weight on each foot is between the two limits; leaning lifts one out of them."""
    weight = humanoid.mass * 9.81
    middle, leaning = standing(humanoid)[:2], standing(humanoid, 0.08)[:2]
    limits = {"touch_force": 0.6 * weight, "release_force": 0.4 * weight}
    bench = Bench(humanoid, *middle, **limits)
    for time in (0.1, 0.101):  # after an even and an odd number of updates
        np.testing.assert_array_equal(bench.after(time).contact, [1.0, 1.0])
    bench.feed(*leaning)
    one = bench.after(0.2).contact
    assert sorted(one) == [0.0, 1.0]
    bench.feed(*middle)
    for time in (0.3, 0.301):
        np.testing.assert_array_equal(bench.after(time).contact, one)


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
    expected = plain.wrench[::-1] * WRENCH_MIRROR[: robot.contact.size]
    np.testing.assert_allclose(mirrored.wrench, expected, rtol=0, atol=tolerance)
    np.testing.assert_array_equal(mirrored.contact, plain.contact[::-1])
    as_state = np.concatenate([robot.q_nominal, plain.residual])
    np.testing.assert_allclose(
        mirrored.residual, robot.mirror_state(as_state)[robot.nq :], rtol=0, atol=1e-10 * scale
    )


# --- in the loop ----------------------------------------------------------------------------


@pytest.mark.slow
def test_while_walking_it_follows_the_simulators_forces(contact_wrenches):
    """With the parameters of the program; half of the weight is 122 N.

    Large errors are the filter's delay at touchdown, a few milliseconds long.
    """
    segments = [Segment("stand", 0.4), Segment("step", 0.6, True), Segment("walk", 1.0, True)]
    segments[2].velocity = [0.3, 0.0]
    loop = build_closed_loop(Scenario(segments=segments))
    humanoid, plant = loop.humanoid, loop.plant.system
    simulator = loop.make_simulator()
    root = simulator.get_mutable_context()
    context = plant.GetMyMutableContextFromRoot(root)
    own = loop.controller.GetMyContextFromRoot(root)
    scratch = humanoid.plant.CreateDefaultContext()
    errors, agree = [], []

    def monitor(_):
        x = plant.get_state_output_port().Eval(context)
        true = contact_wrenches(humanoid, plant, context, robot_dynamics(humanoid, scratch, x))
        estimate = look(loop.controller.GetOutputPort("contact"), own)
        errors.append(np.abs(estimate.wrench - true))
        agree.append(np.array_equal(true[:, 2] > 35.0, estimate.contact))

    simulator.Initialize()
    simulator.set_monitor(monitor)
    simulator.AdvanceTo(2.0)
    assert plant.GetPositions(context)[6] > 0.6  # it has not fallen
    unequal = np.array(errors)[..., 2].max(axis=1) > 100.0
    assert np.all(np.median(errors, axis=0) < [0.5, 0.5, 0.5, 0.1, 0.1])
    assert np.all(np.quantile(errors, 0.9, axis=0) < [5.0, 5.0, 15.0, 1.5, 1.5])
    assert np.mean(unequal) < 0.02
    assert np.mean(agree) > 0.95
