from dataclasses import replace

import numpy as np
import pytest

from drake_linefoot.lab.plants.initial_state import initial_state, lowest_contact_point
from drake_linefoot.lab.scenario import Perturbation, Scenario
from drake_linefoot.robot.humanoid import load_humanoid


@pytest.fixture(scope="module")
def humanoid():
    return load_humanoid("mit_humanoid")


def perturbed(seed=0, **bounds):
    return Scenario(seed=seed, perturbation=Perturbation(**bounds))


def test_without_perturbation_it_is_the_nominal_posture_at_rest(humanoid):
    np.testing.assert_array_equal(initial_state(humanoid, perturbed(7)), humanoid.x_nominal)


def test_changes_stay_within_their_bounds_and_are_used(humanoid):
    bounds = {"joint_position": 0.01, "joint_velocity": 0.2, "base_velocity": 0.05}
    states = np.array([initial_state(humanoid, perturbed(s, **bounds)) for s in range(50)])
    change = states - humanoid.x_nominal
    joints, rates = change[:, 7:25], change[:, 25 + 6 :]
    base = change[:, 25 + 3 : 25 + 6]
    for values, bound in ((joints, 0.01), (rates, 0.2), (base, 0.05)):
        assert np.abs(values).max() <= bound
        assert values.min() < -0.8 * bound
        assert values.max() > 0.8 * bound
    assert (change[:, :6] == 0.0).all()  # orientation, x, y
    assert (change[:, 25:28] == 0.0).all()  # angular velocity


def test_no_foot_is_in_the_ground_and_one_touches_it(humanoid):
    for seed in range(10):
        x = initial_state(humanoid, perturbed(seed, joint_position=0.1))
        assert lowest_contact_point(humanoid, x[:25]) == pytest.approx(0.0, abs=1e-12)


def test_joints_stay_within_their_limits(humanoid):
    for seed in range(10):
        x = initial_state(humanoid, perturbed(seed, joint_position=1.5))
        angles = x[humanoid.actuated_q]
        assert (angles >= humanoid.position_lower).all()
        assert (angles <= humanoid.position_upper).all()


def test_the_seed_decides(humanoid):
    scenario = perturbed(3, joint_position=0.01)
    a, b = initial_state(humanoid, scenario), initial_state(humanoid, scenario)
    np.testing.assert_array_equal(a, b)
    other = initial_state(humanoid, replace(scenario, seed=4))
    assert (a != other).any()
