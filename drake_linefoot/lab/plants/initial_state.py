"""Where a run begins: the state of the robot, which follows from the seed."""

import numpy as np

from drake_linefoot.lab.scenario import Scenario
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.types import Array


def initial_state(humanoid: Humanoid, scenario: Scenario) -> Array:
    """Return the state [q, v] a run starts from, shape (nq + nv,); it follows from the seed.

    Joint angles, joint rates and the linear velocity of the torso get a uniform random change
    within the bounds of the perturbation. Angles are clipped to the joint limits, and the
    torso is moved up or down until the lowest contact point is on the ground.
    """
    bounds = scenario.perturbation
    random = np.random.default_rng(scenario.seed)
    q, v = humanoid.q_nominal.copy(), np.zeros(humanoid.nv)
    angles = q[humanoid.actuated_q] + bounds.joint_position * random.uniform(-1, 1, humanoid.na)
    q[humanoid.actuated_q] = np.clip(angles, humanoid.position_lower, humanoid.position_upper)
    v[humanoid.actuated_v] = bounds.joint_velocity * random.uniform(-1, 1, humanoid.na)
    v[3:6] = bounds.base_velocity * random.uniform(-1, 1, 3)
    if bounds.joint_position > 0.0:
        q[6] -= lowest_contact_point(humanoid, q)
    return np.concatenate([q, v])


def lowest_contact_point(humanoid: Humanoid, q: Array) -> float:
    """Return the height of the lowest contact point in a configuration [m]."""
    context = humanoid.plant.CreateDefaultContext()
    humanoid.plant.SetPositions(context, q)
    feet = zip(humanoid.foot_frames, humanoid.contact_points, strict=True)
    return float(min((f.CalcPoseInWorld(context) @ points.T)[2].min() for f, points in feet))
