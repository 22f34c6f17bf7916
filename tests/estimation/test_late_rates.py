"""Joint rates that are late: their observer is as late, and sees no force where there is none."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydrake.multibody.plant import AddMultibodyPlant, MultibodyPlantConfig
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

from drake_linefoot.estimation.contact_estimator import Constants
from drake_linefoot.estimation.estimate import track
from drake_linefoot.estimation.momentum_observer import follow_late
from drake_linefoot.lab.scenario import Scenario, Segment
from drake_linefoot.lab.wiring.closed_loop import build_closed_loop
from drake_linefoot.robot.dynamics import robot_dynamics
from tests.helpers.estimator_bench import Bench

H, BANDWIDTH, STEP = 1e-3, 1000.0, 6.4e-5


@given(st.integers(0, 2**32 - 1), st.sampled_from([300.0, 1000.0]))
def test_a_signal_is_as_late_as_the_rates_of_encoders(seed, bandwidth):
    """Of any motion in steps of the plant, q = q + h v."""
    rates = np.random.default_rng(seed).normal(size=(50, 3))
    angles = np.cumsum(H * rates, axis=0)
    joints, stages = np.zeros((3, 3)), np.zeros((2, 3))
    for q, v in zip(angles, rates, strict=True):
        track(joints, q, H, bandwidth)
        late = follow_late(stages, v, np.exp(-H * bandwidth))
        np.testing.assert_allclose(late, joints[2], atol=1e-9)


def test_what_is_not_late_is_what_it_was_to_the_bit():
    rng, stages = np.random.default_rng(0), np.zeros((2, 4))
    for _ in range(20):
        now = rng.normal(size=4)
        np.testing.assert_array_equal(follow_late(stages, now, 0.0), now)


def forces_in_free_fall(robot, **parameters):
    """Vertical force of each foot that is seen of a robot that falls and kicks, shape (n, 2).

    Drake's plant moves; encoders with steps say what its joints do. Torques jump every 12 ms, and
    keep every joint within some degrees, away from its limits.
    """
    builder = DiagramBuilder()
    plant, _ = AddMultibodyPlant(MultibodyPlantConfig(time_step=H), builder)
    robot.add_to(plant)
    plant.Finalize()
    diagram = builder.Build()
    simulator = Simulator(diagram)
    context = plant.GetMyMutableContextFromRoot(simulator.get_mutable_context())
    plant.SetPositionsAndVelocities(context, robot.x_nominal)
    x, rng, rates, found = (
        robot.x_nominal,
        np.random.default_rng(3),
        robot.nq + robot.actuated_v,
        [],
    )
    angles, inertia = x[robot.actuated_q], np.diag(robot_dynamics(robot, robot.scratch, x).M)
    kick = 100.0 * inertia[robot.actuated_v] * rng.choice([-1.0, 1.0], robot.na)
    joints = np.array([angles, angles, 0.0 * angles])
    bench = Bench(robot, x, kick, **parameters)
    for k in range(160):
        torque = kick * (-1.0) ** ((k + 6) // 12)
        plant.get_actuation_input_port().FixValue(context, torque)
        simulator.AdvanceTo((k + 1) * H)
        x = plant.GetPositionsAndVelocities(context)
        track(joints, STEP * np.round(x[robot.actuated_q] / STEP), H, BANDWIDTH)
        x[rates] = joints[2]
        bench.feed(x, torque)
        found.append(bench.after((k + 0.5) * H).wrench[:, 2])
    return np.array(found[60:])  # half the weight, with which it began, is forgotten


def test_a_robot_that_falls_and_kicks_feels_no_ground(humanoid):
    """Not so where base and torques are taken for as late as the joints when they are not."""
    late = forces_in_free_fall(humanoid, rate_bandwidth=BANDWIDTH)
    assert np.abs(late).max() < 6.0  # of 235 N; `release_force` is 12 N
    assert np.abs(forces_in_free_fall(humanoid)).max() > 3.0 * np.abs(late).max()


@pytest.mark.parametrize("estimation", [False, True])
def test_the_observer_of_a_loop_is_as_late_as_its_state(estimation):
    segments = [Segment("stand", 0.1)]
    loop = build_closed_loop(Scenario(estimation=estimation, segments=segments))
    observer = loop.controller.GetSubsystemByName("contact_estimator")
    constants = Constants(*observer.constants_in(observer.CreateDefaultContext()))
    assert constants.theta == (pytest.approx(np.exp(-1.0)) if estimation else 0.0)
