"""Inertia and angular momentum of torso and moving legs against the plant's sum over bodies."""

import numpy as np
import pytest

from drake_linefoot.math.rotation import from_quaternion
from drake_linefoot.robot.dynamics import robot_dynamics
from drake_linefoot.robot.leg_inertia import LegInertia
from drake_linefoot.robot.legs import read_legs

COUNT = 6


def random_state(robot, rng):
    """A torso anywhere, joints anywhere within their limits; arms at rest."""
    q, v = robot.q_nominal.copy(), np.zeros(robot.nv)
    q[:4] = rng.normal(size=4)
    q[:4] /= np.linalg.norm(q[:4])
    q[4:7] = rng.normal(size=3)
    q[robot.actuated_q] = rng.uniform(robot.position_lower, robot.position_upper)
    v[:6] = rng.normal(size=6)
    v[robot.leg_v] = 5.0 * rng.normal(size=robot.leg_v.shape)
    return q, v


def by_the_plant(robot, context, q, v):
    """Inertia of all bodies about their common CoM and angular momentum about it, in B."""
    plant = robot.plant
    plant.SetPositions(context, q)
    plant.SetVelocities(context, v)
    r = plant.CalcCenterOfMassPositionInWorld(context)
    L = plant.CalcSpatialMomentumInWorldAboutPoint(context, r).rotational()
    bodies = plant.GetBodyIndices(robot.base.model_instance())
    spatial = plant.CalcSpatialInertia(context, robot.base.body_frame(), bodies)
    central = spatial.Shift(spatial.get_com()).CalcRotationalInertia().CopyToFullMatrix3()
    return central, from_quaternion(q[:4]).T @ L


def linear_momentum(maps, rates):
    """Of the joints, in B, shape (K, 3)."""
    return np.einsum("nkij,nkj->ki", maps.linear, rates)


@pytest.mark.parametrize("seed", range(3))
def test_it_is_what_the_plant_sums_over_the_bodies(robot, seed):
    """[kg m^2] and [kg m^2/s]; the arms are others in every call."""
    rng = np.random.default_rng(seed)
    context = robot.plant.CreateDefaultContext()
    moving = LegInertia(robot, read_legs(robot))
    for _ in range(3):
        arms, _ = random_state(robot, rng)
        states = [random_state(robot, rng) for _ in range(COUNT)]
        for q, _ in states:
            q[robot.arm_q] = arms[robot.arm_q]
        angles, rates = (
            np.array([[x[which[side]] for x in values] for side in (0, 1)])
            for which, values in (
                (robot.leg_q, [q for q, _ in states]),
                (robot.leg_v, [v for _, v in states]),
            )
        )
        Omega = np.array([from_quaternion(q[:4]).T @ v[:3] for q, v in states])
        now = robot_dynamics(robot, context, np.concatenate([arms, np.zeros(robot.nv)]))
        maps = moving(now, angles)
        momenta, linear = maps.momentum(rates, Omega), linear_momentum(maps, rates)
        expected = [by_the_plant(robot, context, q, v) for q, v in states]
        for k, (inertia, momentum) in enumerate(expected):
            np.testing.assert_allclose(maps.I_B[k], inertia, rtol=0, atol=1e-12)
            np.testing.assert_allclose(momenta[k], momentum, rtol=0, atol=1e-11)
        for k, (q, v) in enumerate(states):
            robot.plant.SetPositions(context, q)
            robot.plant.SetVelocities(context, v)
            R_BW, p_WB = from_quaternion(q[:4]).T, q[4:7]
            r = robot.plant.CalcCenterOfMassPositionInWorld(context)
            u = robot.plant.CalcCenterOfMassTranslationalVelocityInWorld(context)
            v_P = v[3:6] + np.cross(v[:3], r - p_WB)
            np.testing.assert_allclose(maps.com[k], R_BW @ (r - p_WB), rtol=0, atol=1e-12)
            expected = robot.mass * R_BW @ (u - v_P)
            np.testing.assert_allclose(linear[k], expected, rtol=0, atol=1e-10)


def test_every_body_counts_once(robot):
    moving = LegInertia(robot, read_legs(robot))
    assert moving._masses.mass.sum() == pytest.approx(robot.mass, rel=1e-14)
    bodies = [index for group in moving._groups for index in group]
    assert sorted(bodies) == sorted(robot.plant.GetBodyIndices(robot.base.model_instance()))
