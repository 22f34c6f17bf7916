"""The torso that follows from feet, CoM and momentum: motions of which it is known."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from studies.paper.full_body import FullBody, Motion

N = 61  # times, every other one in the middle of a step
STEP = 0.005  # [s] between two of them


@pytest.fixture(scope="module")
def swaying(humanoid):
    """A motion of every joint and of the torso; what it is of feet and momentum says Drake.

    Returns positions, shape (N, nq), and the motion.
    """
    h, times = humanoid, STEP * np.arange(N)
    rng, nominal = np.random.default_rng(5), humanoid.q_nominal
    sway, pace = rng.uniform(-0.25, 0.25, h.nq), rng.uniform(3.0, 12.0, h.nq)
    sway[4:7] *= 0.2
    angles = np.outer(times, pace)
    q = nominal + sway * np.sin(angles)
    qdot = sway * pace * np.cos(angles)
    turn = np.sin(np.outer(times, [7.0, 5.0, 9.0])) * [0.15, -0.2, 0.3]
    q[:, :4] = Rotation.from_rotvec(turn).as_quat(scalar_first=True)
    later = Rotation.from_rotvec(
        np.sin(np.outer(times + 1e-6, [7.0, 5.0, 9.0])) * [0.15, -0.2, 0.3]
    )
    w = (later * Rotation.from_rotvec(turn).inv()).as_rotvec() / 1e-6
    return q, asked(h, times, q, qdot, w)


def asked(h, times, q, qdot, w):
    """What Drake says of CoM, momentum and feet."""
    plant, context = h.plant, h.plant.CreateDefaultContext()
    r, v, L = np.empty((3, N, 3))
    p, x, p_dot, w_F = np.empty((4, 2, N, 3))
    for k in range(N):
        plant.SetPositions(context, q[k])
        velocities = plant.MapQDotToVelocity(context, qdot[k])
        velocities[:6] = [*w[k], *qdot[k, 4:7]]
        plant.SetVelocities(context, velocities)
        r[k] = plant.CalcCenterOfMassPositionInWorld(context)
        v[k] = plant.CalcCenterOfMassTranslationalVelocityInWorld(context)
        momentum = plant.CalcSpatialMomentumInWorldAboutPoint(context, r[k])
        L[k] = momentum.rotational()
        for side, frame in enumerate(h.foot_frames):
            X, V = frame.CalcPoseInWorld(context), frame.CalcSpatialVelocityInWorld(context)
            arm = X.rotation() @ h.p_FC[side]
            p[side, k], x[side, k] = X.translation() + arm, X.rotation().matrix()[:, 0]
            p_dot[side, k] = V.translational() + np.cross(V.rotational(), arm)
            w_F[side, k] = V.rotational()
    return Motion(times, r, v, L, p, x, p_dot, w_F, q[:, h.arm_q], qdot[:, h.arm_q])


def off(found, q):
    """How far the torso is off at every other time [rad]."""
    true = Rotation.from_quat(q[::2, :4], scalar_first=True)
    return (true.inv() * Rotation.from_matrix(found)).magnitude()


def test_the_torso_of_a_known_motion_comes_back(humanoid, swaying):
    q, motion = swaying
    assert Rotation.from_quat(q[:, :4], scalar_first=True).magnitude().max() > 0.2
    start = q[0] + np.concatenate([np.zeros(4), np.full(humanoid.nq - 4, 0.03)])
    assert off(FullBody(humanoid).torso(start, motion), q).max() < 1e-4


@pytest.mark.parametrize("wrong", ["L", "rates", "p_dot"])
def test_momentum_arms_and_feet_all_count(humanoid, swaying, wrong):
    q, motion = swaying
    other = motion._replace(**{wrong: 0.5 * getattr(motion, wrong)})
    assert off(FullBody(humanoid).torso(q[0], other), q).max() > 2e-3


def test_what_no_leg_reaches_has_no_torso(humanoid, swaying):
    q, motion = swaying
    p = motion.p.copy()
    p[0, 20:, 0] += 2.0
    found = FullBody(humanoid).torso(q[0], motion._replace(p=p))
    assert np.isfinite(found[:10]).all()
    assert np.isnan(found[10:]).all()
