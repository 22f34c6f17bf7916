"""What else than the ground acts on the robot, from the rows of base and legs."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydrake.multibody.tree import JacobianWrtVariable

from drake_linefoot.estimation.contact_parameters import EstimatorParameters
from drake_linefoot.estimation.external_wrench import (
    ExternalConstants,
    external_constants,
    external_wrench,
    follow_wrench,
    on_base,
    without_external,
)
from drake_linefoot.robot.dynamics import robot_dynamics

MOST = 1e9 * np.ones(6)
FORCE = np.array([0.0, 0.0, 0.0, 1.0, 0.0, 0.0])


def generalized(robot, context, d, F, p_BQ):
    """Generalized force of a force F [N] at a point of the torso, by Drake's Jacobian."""
    robot.plant.SetPositions(context, d.q)
    W = robot.plant.world_frame()
    J = robot.plant.CalcJacobianTranslationalVelocity(
        context, JacobianWrtVariable.kV, robot.base.body_frame(), p_BQ, W, W
    )
    return J.T @ F


@pytest.mark.parametrize("seed", range(6))
def test_a_force_on_the_torso_is_told_from_those_on_the_feet(robot, walking_state, seed):
    """Whatever both feet bear, and wherever it acts."""
    rng, context = np.random.default_rng(seed), robot.plant.CreateDefaultContext()
    d = robot_dynamics(robot, robot.scratch, walking_state(robot, seed))
    nw = robot.contact.size
    wrench = rng.normal(size=(2, nw)) * [80.0, 80.0, 200.0, 8.0, 8.0, 8.0][:nw]
    F, p_BQ = 30.0 * rng.normal(size=3), 0.3 * rng.normal(size=3)
    pull = generalized(robot, context, d, F, p_BQ)
    of_feet = np.einsum("fij,fi->j", d.J, wrench)
    lever = d.p_WG - d.p_WB
    found, told = external_wrench(of_feet + pull, d.J, lever, robot.leg_v)
    assert told
    expected = np.concatenate([np.cross(d.R_WB @ p_BQ - lever, F), F])
    np.testing.assert_allclose(found, expected, atol=1e-7)
    np.testing.assert_allclose(on_base(found, lever), pull[:6], atol=1e-7)
    np.testing.assert_allclose(pull[6:], 0.0, atol=1e-9)
    np.testing.assert_allclose(without_external(of_feet + pull, found, lever), of_feet, atol=1e-7)


def test_a_straight_leg_tells_nothing(humanoid):
    x = humanoid.x_nominal.copy()
    straight = humanoid.leg_q[1]
    x[straight] = 0.0
    d = robot_dynamics(humanoid, humanoid.scratch, x)
    _, told = external_wrench(np.ones(humanoid.nv), d.J, d.p_WG - d.p_WB, humanoid.leg_v)
    assert not told


def constants(share=0.01, change=MOST, largest=MOST):
    return ExternalConstants(np.zeros((2, 5), dtype=int), share, change, largest)


@given(st.floats(0.001, 1.0), st.floats(-50.0, 50.0))
def test_it_comes_to_what_lasts_as_a_filter_of_first_order(share, F):
    estimate, c = np.zeros(6), constants(share)
    for _ in range(200):
        estimate = follow_wrench(estimate, F * FORCE, c)
    np.testing.assert_allclose(estimate, (1.0 - (1.0 - share) ** 200) * F * FORCE, atol=1e-9)


def test_of_a_short_push_little_stays(humanoid):
    """200 N for 0.1 s; half of 15 N that last is known long before."""
    c = external_constants(EstimatorParameters(), humanoid, 0.001)
    pushed, pulled, known = np.zeros(6), np.zeros(6), []
    for _ in range(100):
        pushed = follow_wrench(pushed, 200.0 * FORCE, c)
    assert pushed[3] < 5.0
    for _ in range(500):
        pulled = follow_wrench(pulled, 15.0 * FORCE, c)
        known.append(pulled[3])
    assert np.searchsorted(known, 7.5) < 250
    assert known[-1] > 11.0


def test_it_is_bounded(humanoid):
    p = EstimatorParameters()
    c, estimate = external_constants(p, humanoid, 0.001), np.zeros(6)
    for _ in range(20000):
        estimate = follow_wrench(estimate, np.array([-1e4, 1e4, 0.0, 1e4, -1e4, 0.0]), c)
    most = np.array([-humanoid.com_height, humanoid.com_height, 0.0, 1.0, -1.0, 0.0])
    np.testing.assert_allclose(estimate, p.external_max * most)


def test_a_time_of_zero_learns_nothing(humanoid):
    c = external_constants(EstimatorParameters(external_time=0.0), humanoid, 0.001)
    np.testing.assert_array_equal(follow_wrench(np.zeros(6), 50.0 * FORCE, c), 0.0)
