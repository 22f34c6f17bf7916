"""Dynamics of one state against the plant's own calls, sums over bodies, finite differences."""

import numpy as np
import pytest
from pydrake.multibody.math import SpatialForce
from pydrake.multibody.tree import BodyIndex, MultibodyForces
from scipy.spatial.transform import Rotation

from drake_linefoot.robot.dynamics import contact_frame, robot_dynamics
from tests.helpers.feet import feet_of

SEEDS = range(5)
AXES = [1, 2, 0]  # of the contact frame: of moments, in their order
STEP = 1e-5  # [s] of central differences, good to about 1e-9


@pytest.fixture
def context(robot):
    return robot.plant.CreateDefaultContext()


@pytest.fixture
def scratch(robot):
    return robot.plant.CreateDefaultContext()


def seen(robot, context, x):
    """Put a state into a context, and return its dynamics."""
    robot.plant.SetPositionsAndVelocities(context, x)
    return robot_dynamics(robot, context, x)


def momentum_over_bodies(robot, context):
    """Sum angular momentum about the CoM and linear momentum, body by body."""
    plant = robot.plant
    p_WG = plant.CalcCenterOfMassPositionInWorld(context)
    total = np.zeros(6)
    for i in range(1, plant.num_bodies()):
        body = plant.get_body(BodyIndex(i))
        inertia = body.default_spatial_inertia()
        m, p_BBcm = inertia.get_mass(), inertia.get_com()
        I_Bcm = inertia.Shift(p_BBcm).CalcRotationalInertia().CopyToFullMatrix3()
        X_WB = plant.EvalBodyPoseInWorld(context, body)
        V = plant.EvalBodySpatialVelocityInWorld(context, body)
        R, w = X_WB.rotation().matrix(), V.rotational()
        arm = X_WB @ p_BBcm
        velocity = V.translational() + np.cross(w, R @ p_BBcm)
        total[:3] += R @ I_Bcm @ R.T @ w + np.cross(arm - p_WG, m * velocity)
        total[3:] += m * velocity
    return total


def momentum_of_plant(robot, context, x):
    """Return angular momentum about the CoM over linear momentum, as the plant has it."""
    robot.plant.SetPositionsAndVelocities(context, x)
    p_WG = robot.plant.CalcCenterOfMassPositionInWorld(context)
    L = robot.plant.CalcSpatialMomentumInWorldAboutPoint(context, p_WG)
    return np.concatenate([L.rotational(), L.translational()])


@pytest.mark.parametrize("seed", SEEDS)
def test_mass_matrix_is_that_of_inverse_dynamics(robot, context, walking_state, seed):
    d = seen(robot, context, walking_state(robot, seed))
    expected = robot.plant.CalcMassMatrixViaInverseDynamics(context)
    np.testing.assert_allclose(d.M, expected, rtol=0, atol=1e-12)
    np.linalg.cholesky(d.M)  # positive definite


@pytest.mark.parametrize("seed", SEEDS)
def test_centroidal_momentum_matrix(robot, context, walking_state, seed):
    x = walking_state(robot, seed)
    d = seen(robot, context, x)
    over_bodies = momentum_over_bodies(robot, context)
    near = {"rtol": 0, "atol": 1e-11}
    np.testing.assert_allclose(d.A @ d.v, over_bodies, **near)
    np.testing.assert_allclose(d.A @ d.v, momentum_of_plant(robot, context, x), **near)
    np.testing.assert_allclose(d.L_G, over_bodies[:3], **near)
    np.testing.assert_allclose(robot.mass * d.v_WG, over_bodies[3:], **near)
    for j, e in enumerate(np.eye(robot.nv)):
        column = momentum_of_plant(robot, context, np.concatenate([d.q, e]))
        np.testing.assert_allclose(d.A[:, j], column, **near)


@pytest.mark.parametrize("seed", SEEDS)
def test_positions_and_velocities(robot, context, walking_state, seed):
    d = seen(robot, context, walking_state(robot, seed))
    plant = robot.plant
    X_WB = plant.EvalBodyPoseInWorld(context, robot.base)
    near = {"rtol": 0, "atol": 1e-12}
    np.testing.assert_allclose(d.R_WB, X_WB.rotation().matrix(), **near)
    np.testing.assert_allclose(d.p_WB, X_WB.translation(), **near)
    np.testing.assert_allclose(d.p_WG, plant.CalcCenterOfMassPositionInWorld(context), **near)
    velocity = plant.CalcCenterOfMassTranslationalVelocityInWorld(context)
    np.testing.assert_allclose(d.v_WG, velocity, **near)


@pytest.mark.parametrize("seed", SEEDS)
def test_momentum_bias_is_its_rate_without_acceleration(
    robot, context, scratch, walking_state, advance, seed
):
    x = walking_state(robot, seed)
    d = seen(robot, context, x)
    after, before = (momentum_of_plant(robot, scratch, advance(robot, x, t)) for t in (STEP, -STEP))
    rate = (after - before) / (2 * STEP)
    np.testing.assert_allclose(d.Adot_v, rate, rtol=0, atol=2e-7)


@pytest.mark.parametrize("seed", SEEDS)
def test_gravity(robot, context, walking_state, seed):
    d = seen(robot, context, walking_state(robot, seed))
    expected = robot.plant.CalcGravityGeneralizedForces(context)
    np.testing.assert_allclose(d.tau_g, expected, rtol=0, atol=1e-11)


@pytest.mark.parametrize("seed", SEEDS)
def test_equation_of_motion(robot, context, walking_state, seed):
    """M vdot + Cv = tau_g + S' tau + sum J' w, with the wrenches given to the plant as forces."""
    plant = robot.plant
    d = seen(robot, context, walking_state(robot, seed))
    rng = np.random.default_rng(seed)
    vdot = 5.0 * rng.normal(size=robot.nv)
    nw = robot.contact.size
    wrenches = rng.normal(size=(2, nw)) * [60, 60, 120, 10, 10, 10][:nw]
    forces = MultibodyForces(plant)
    plant.CalcForceElementsContribution(context, forces)
    for foot, frame, p_FC, w in zip(
        feet_of(d), robot.foot_frames, robot.p_FC, wrenches, strict=True
    ):
        tau_W = foot.R_WC[:, AXES[: nw - 3]] @ w[3:]
        p_FC_W = frame.CalcPoseInWorld(context).rotation() @ p_FC
        F_C = SpatialForce(tau_W, w[:3])
        frame.body().AddInForce(context, p_FC_W, F_C, plant.world_frame(), forces)
    needed = plant.CalcInverseDynamics(context, vdot, forces)
    pushed = sum(foot.J.T @ w for foot, w in zip(feet_of(d), wrenches, strict=True))
    np.testing.assert_allclose(d.M @ vdot + d.Cv - d.tau_g - pushed, needed, rtol=0, atol=1e-10)


@pytest.mark.parametrize("seed", SEEDS)
def test_foot_jacobian_is_the_rate_of_the_foots_pose(
    robot, context, scratch, walking_state, advance, seed
):
    d = seen(robot, context, walking_state(robot, seed))
    for side, foot in enumerate(feet_of(d)):

        def pose(v, t, side=side):
            x = advance(robot, np.concatenate([d.q, v]), t)
            robot.plant.SetPositions(scratch, x[: robot.nq])
            X = robot.foot_frames[side].CalcPoseInWorld(scratch)
            return X @ robot.p_FC[side], X.rotation().matrix()

        for j, v in enumerate([*np.eye(robot.nv), d.v]):
            (p1, R1), (p0, R0) = pose(v, STEP), pose(v, -STEP)
            linear = (p1 - p0) / (2 * STEP)
            angular = Rotation.from_matrix(R1 @ R0.T).as_rotvec() / (2 * STEP)
            about = (foot.R_WC.T @ angular)[AXES[: len(foot.J) - 3]]
            rows = np.concatenate([linear, about])
            found = foot.J[:, j] if j < robot.nv else foot.J @ v
            np.testing.assert_allclose(found, rows, rtol=0, atol=2e-8)
        np.testing.assert_allclose(foot.v_WC, linear, rtol=0, atol=2e-8)
        np.testing.assert_allclose(foot.w_WF, angular, rtol=0, atol=2e-8)


@pytest.mark.parametrize("seed", SEEDS)
def test_foot_bias_is_the_acceleration_without_joint_acceleration(
    robot, context, scratch, walking_state, advance, seed
):
    """The accelerations are components along the axes the contact frame has now.

    So the bias is the rate of the foot's velocity, taken in axes that stand still. The rate
    of J v would hold the turning of the axes in addition.
    """
    x = walking_state(robot, seed)
    d = seen(robot, context, x)
    for side, foot in enumerate(feet_of(d)):
        later, earlier = (
            feet_of(robot_dynamics(robot, scratch, advance(robot, x, t)))[side]
            for t in (STEP, -STEP)
        )
        linear = (later.v_WC - earlier.v_WC) / (2 * STEP)
        angular = (later.w_WF - earlier.w_WF) / (2 * STEP)
        about = (foot.R_WC.T @ angular)[AXES[: len(foot.J) - 3]]
        expected = np.concatenate([linear, about])
        np.testing.assert_allclose(foot.Jdot_v, expected, rtol=0, atol=1e-7)


@pytest.mark.parametrize("seed", SEEDS)
def test_a_standing_foot_needs_no_frozen_axes(
    robot, context, scratch, walking_state, advance, seed
):
    """Where the velocities of a foot are zero, the bias is also the rate of J v, (51)."""
    x = walking_state(robot, seed)
    d = seen(robot, context, x)
    J = np.vstack([foot.J for foot in feet_of(d)])
    v = d.v - np.linalg.pinv(J) @ (J @ d.v)
    x = np.concatenate([d.q, v])
    d = seen(robot, context, x)
    rates = []
    for side, foot in enumerate(feet_of(d)):
        np.testing.assert_allclose(foot.J @ v, 0.0, rtol=0, atol=1e-12)
        later, earlier = (
            feet_of(robot_dynamics(robot, scratch, advance(robot, x, t)))[side].J @ v
            for t in (STEP, -STEP)
        )
        rates.append((later - earlier) / (2 * STEP))
        np.testing.assert_allclose(foot.Jdot_v, rates[-1], rtol=0, atol=1e-7)
    assert np.abs(rates).max() > 0.1  # there is something to see


@pytest.mark.parametrize("seed", SEEDS)
def test_a_wrench_has_power_and_a_line_no_moment_about_itself(robot, context, walking_state, seed):
    """The power is that of its force at C and of its moment, of a line across it."""
    d = seen(robot, context, walking_state(robot, seed))
    rng = np.random.default_rng(seed)
    for foot, frame in zip(feet_of(d), robot.foot_frames, strict=True):
        line = frame.CalcPoseInWorld(context).rotation().matrix()[:, 0]
        np.testing.assert_allclose(foot.R_WC[:, 0], line, rtol=0, atol=1e-14)
        w = rng.normal(size=robot.contact.size)
        moment = w[3] * foot.R_WC[:, 1] + w[4] * foot.R_WC[:, 2]
        assert moment @ line == pytest.approx(0.0, abs=1e-14)
        moment += sum(w[5:]) * line  # of a sole
        power = w[:3] @ foot.v_WC + moment @ foot.w_WF
        assert w @ foot.J @ d.v == pytest.approx(power, abs=1e-12)


def test_contact_frame():
    for seed, R in enumerate(Rotation.random(50, random_state=1).as_matrix()):
        R_WC = contact_frame(R)
        np.testing.assert_allclose(R_WC.T @ R_WC, np.eye(3), rtol=0, atol=1e-14)
        assert np.linalg.det(R_WC) == pytest.approx(1.0)
        np.testing.assert_allclose(R_WC[:, 0], R[:, 0], rtol=0, atol=1e-14)
        assert R_WC[2, 1] == 0.0, seed  # y is level
        assert R_WC[2, 2] >= 0.0  # z is up
        roll = Rotation.from_rotvec(0.3 * R[:, 0]).as_matrix()
        np.testing.assert_allclose(contact_frame(roll @ R), R_WC, rtol=0, atol=1e-14)


@pytest.mark.parametrize("pitch", [np.pi / 2, -np.pi / 2])
def test_an_upright_line_has_no_contact_frame(pitch):
    with pytest.raises(ValueError, match="upright"):
        contact_frame(Rotation.from_euler("ZYX", [0.4, pitch, 0.0]).as_matrix())


@pytest.mark.parametrize("seed", SEEDS)
def test_locked_inertia_is_that_of_all_bodies(robot, context, walking_state, seed):
    plant = robot.plant
    d = seen(robot, context, walking_state(robot, seed))
    bodies = [BodyIndex(i) for i in range(1, plant.num_bodies())]
    inertia = plant.CalcSpatialInertia(context, robot.base.body_frame(), bodies)
    expected = inertia.Shift(inertia.get_com()).CalcRotationalInertia().CopyToFullMatrix3()
    I_B = d.R_WB.T @ d.A[:3, :3] @ d.R_WB  # (23): the momentum of turning with locked joints
    np.testing.assert_allclose(I_B, expected, rtol=0, atol=1e-12)


def test_results_do_not_change_with_the_next_state(robot, context, walking_state):
    first = seen(robot, context, walking_state(robot, 0))
    kept = {name: np.array(value) for name, value in first._asdict().items()}
    seen(robot, context, walking_state(robot, 1))
    for name, value in kept.items():
        np.testing.assert_array_equal(getattr(first, name), value)
