"""The reference of the MPC against the full plant, on the updates of a recorded walk."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from drake_linefoot.gait.schedule import contacts, feet_motion
from drake_linefoot.math.rotation import log, wrap_angle
from drake_linefoot.mpc.models.motion import body_motion, line_plan, relative_rates
from drake_linefoot.mpc.models.reaching import joints
from drake_linefoot.mpc.parameters import MpcParameters
from drake_linefoot.mpc.reference import ReferenceGenerator
from drake_linefoot.robot.leg_kinematics import rates
from drake_linefoot.robot.legs import read_legs
from tests.helpers.full_plant import composite_inertia
from tests.helpers.walking import dynamics_of, recorded_walk, robot


@pytest.fixture(scope="module")
def records():
    """Updates in stand, shift, double and single support, straight and turning."""
    return recorded_walk().mpc[::6]


@pytest.fixture(scope="module")
def context():
    return robot().plant.CreateDefaultContext()


def configurations(record, times):
    """Positions and velocities at `times`, and how far the feet are out of reach."""
    d = dynamics_of(record.x)
    body = body_motion(record.horizon, d.p_WG, times)
    lines = line_plan(feet_motion(record.horizon, times), np.zeros((len(times), 2, 2)), 5)
    h, com = robot(), d.R_WB.T @ (d.p_WG - d.q[4:7])
    legs = read_legs(h)
    angles, reach = joints(legs, body, lines, com, d.q[h.leg_q])
    joint_rates = rates(legs, angles, *relative_rates(body, lines))
    q, v = np.tile(d.q, (len(times), 1)), np.zeros((len(times), h.nv))
    offset = body.R @ (d.R_WB.T @ (d.p_WG - d.q[4:7]))
    w = np.einsum("kij,kj->ki", body.R, body.Omega)
    q[:, :4] = np.roll(Rotation.from_matrix(body.R).as_quat(), 1, axis=1)
    q[:, 4:7] = body.r - offset
    v[:, :3], v[:, 3:6] = w, body.v - np.cross(w, offset)
    for side in (0, 1):
        q[:, h.leg_q[side]], v[:, h.leg_v[side]] = angles[side], joint_rates[side]
    return q, v, reach


def line_axes(feet):
    """Contact frames of [x, y, z, pitch, yaw], shape (n, 3, 3)."""
    return Rotation.from_euler("ZY", feet[:, [4, 3]]).as_matrix()


def middles(record):
    times = record.reference.times
    return 0.5 * (times[1:] + times[:-1])


def momentum(context, q, v):
    """Angular momentum about the CoM [kg m^2/s], by the plant."""
    plant = robot().plant
    plant.SetPositions(context, q)
    plant.SetVelocities(context, v)
    r = plant.CalcCenterOfMassPositionInWorld(context)
    return plant.CalcSpatialMomentumInWorldAboutPoint(context, r).rotational()


def test_the_records_cover_what_is_claimed(records):
    standing = {tuple(r.reference.contact[0]) for r in records}
    assert standing == {(1.0, 1.0), (1.0, 0.0), (0.0, 1.0)}
    assert {np.sign(r.horizon.turn_rate) for r in records} == {-1.0, 0.0, 1.0}


def test_knots_are_those_of_the_schedule_from_now_on(records):
    for r in records:
        ref = r.reference
        assert ref.times[0] == r.horizon.time
        assert len(ref.times) == 15
        assert ref.dt.max() <= 0.04 + 1e-6
        np.testing.assert_array_equal(ref.contact, contacts(r.horizon, middles(r)))
        for side in (0, 1):
            feet = feet_motion(r.horizon, middles(r)).position[side]
            np.testing.assert_allclose(ref.p_WC[:, side], feet[:, :3], atol=1e-15)
            np.testing.assert_allclose(ref.R_WC[:, side], line_axes(feet), atol=1e-15)


def test_the_com_starts_where_it_is_with_the_velocity_it_has(records):
    """The pendulum's DCM is the measured one, and so is then its velocity."""
    for r in records:
        context = robot().plant.CreateDefaultContext()
        robot().plant.SetPositionsAndVelocities(context, r.x)
        v = robot().plant.CalcCenterOfMassTranslationalVelocityInWorld(context)
        np.testing.assert_allclose(r.reference.r[0, :2], dynamics_of(r.x).p_WG[:2], atol=1e-12)
        np.testing.assert_allclose(r.reference.v[0, :2], v[:2], atol=1e-9)
        above = r.reference.r - r.horizon.ground
        height = above[:, 2] - above[:, :2] @ r.horizon.slope
        np.testing.assert_allclose(height, r.horizon.com_height, atol=1e-12)


def test_velocity_is_the_derivative_of_position(records):
    """By central differences at knots and middles; at a jump of the CoP they err by h c''."""
    h = 1e-6
    for r in records:
        com = dynamics_of(r.x).p_WG
        for times, v in (
            (r.reference.times[1:], r.reference.v[1:]),
            (middles(r), r.reference.v_mid),
        ):
            before, after = (body_motion(r.horizon, com, times + s * h).r for s in (-1, 1))
            np.testing.assert_allclose((after - before) / (2 * h), v, atol=1e-5)


def test_orientation_and_angular_velocity_follow_the_command(records):
    """R' = R [Omega]x, (4), between knots; the torso stays upright."""
    for r in records:
        ref = r.reference
        for k, dt in enumerate(ref.dt):
            turn = log(ref.R[k].T @ ref.R[k + 1]) / dt
            np.testing.assert_allclose(turn, ref.Omega_mid[k], atol=1e-10)
        np.testing.assert_allclose(ref.R[:, 2, 2], 1.0, atol=1e-15)


# --- joints -----------------------------------------------------------------------------


def test_the_configurations_reach_the_planned_feet(records, context):
    h = robot()
    for r in records:
        q, _, reach = configurations(r, middles(r))
        assert reach < 1e-5
        for k in range(len(q)):
            h.plant.SetPositions(context, q[k])
            for side in (0, 1):
                X_WF = h.foot_frames[side].CalcPoseInWorld(context)
                foot = feet_motion(r.horizon, middles(r)[k : k + 1]).position[side, 0]
                np.testing.assert_allclose(X_WF @ h.p_FC[side], foot[:3], atol=2e-6)
                line = X_WF.rotation().col(0)
                assert np.arctan2(line[1], line[0]) == pytest.approx(wrap_angle(foot[4]), abs=5e-6)
                assert line[2] == pytest.approx(-np.sin(foot[3]), abs=5e-6)
        np.testing.assert_array_equal(q[:, h.arm_q], np.tile(r.x[h.arm_q], (len(q), 1)))


def test_the_velocities_are_those_of_the_configurations(records, context):
    """qdot by central differences over 2 ms against v, at every middle."""
    h, step = robot(), 1e-3
    for r in records[::2]:
        times = middles(r)[r.reference.dt > 4 * step]
        _, v, _ = configurations(r, times)
        before, after = (configurations(r, times + s * step)[0] for s in (-1, 1))
        q = configurations(r, times)[0]
        for k in range(len(times)):
            h.plant.SetPositions(context, q[k])
            numeric = h.plant.MapQDotToVelocity(context, (after[k] - before[k]) / (2 * step))
            np.testing.assert_allclose(v[k, :6], numeric[:6], atol=2e-3)  # c'' jumps
            np.testing.assert_allclose(v[k, 6:], numeric[6:], atol=0.02)  # of up to 10 rad/s


def test_angular_momentum_is_that_of_the_plant(records, context):
    for r in records:
        q, v, _ = configurations(r, middles(r))
        expected = [momentum(context, qk, vk) for qk, vk in zip(q, v, strict=True)]
        np.testing.assert_allclose(r.reference.L_mid, expected, atol=1e-10)


def test_inertia_is_that_of_the_plant(records, context):
    for r in records:
        q, _, _ = configurations(r, middles(r))
        expected = [composite_inertia(robot(), context, qk) for qk in q]
        np.testing.assert_allclose(r.reference.I_B, expected, atol=1e-10)


def test_angular_momentum_at_the_knots_is_near_the_plants(records, context):
    """Knots take the mean of their neighbours: right to second order of 0.04 s."""
    for r in records:
        q, v, _ = configurations(r, r.reference.times)
        expected = np.array([momentum(context, qk, vk) for qk, vk in zip(q, v, strict=True)])
        error = np.abs(r.reference.L - expected)[1:-1]
        assert error.max() < 0.25  # of up to 1.3
        assert error.mean() < 0.08


def test_the_swing_leg_carries_momentum_that_a_locked_robot_has_not(records):
    for r in records:
        ref = r.reference
        locked = np.einsum("kij,kjl,kl->ki", ref.R_mid, ref.I_B, ref.Omega_mid)
        swinging = ref.contact.min(axis=1) == 0.0
        if swinging.any() and np.linalg.norm(r.reference.v[:, :2], axis=1).mean() > 0.2:
            assert np.abs(ref.L_mid - locked)[swinging].max() > 0.1
    assert np.ptp([r.reference.I_B[:, 1, 1] for r in records]) > 0.02


# --- single rigid body ------------------------------------------------------------------


def test_the_baseline_freezes_the_inertia_and_locks_the_joints(records, context):
    generator = ReferenceGenerator(robot(), MpcParameters(model="srbm"))
    for r in records:
        d = dynamics_of(r.x)
        ref = generator.generate(r.horizon, d)
        now = composite_inertia(robot(), context, d.q)
        np.testing.assert_allclose(ref.I_B, np.tile(now, (14, 1, 1)), atol=1e-10)
        expected = [R @ now @ Omega for R, Omega in zip(ref.R_mid, ref.Omega_mid, strict=True)]
        np.testing.assert_allclose(ref.L_mid, expected, atol=1e-10)
        for name in ("times", "r", "v", "R", "contact", "p_WC", "R_WC"):
            np.testing.assert_array_equal(getattr(ref, name), getattr(r.reference, name))


# --- reach ------------------------------------------------------------------------------


@pytest.mark.parametrize("too_high", [0.1, 0.4])
def test_the_reach_error_says_how_far_the_feet_are_out_of_reach(too_high):
    """Straight legs reach a CoM height of about 0.70 m and not more."""
    record = recorded_walk().mpc[0]
    horizon = record.horizon._replace(com_height=0.70 + too_high)
    ref = ReferenceGenerator(robot(), MpcParameters(model="ecd")).generate(
        horizon, dynamics_of(record.x)
    )
    assert ref.reach_error == pytest.approx(too_high, abs=0.03)
    assert np.isfinite(ref.L_mid).all()
    assert np.isfinite(ref.I_B).all()
