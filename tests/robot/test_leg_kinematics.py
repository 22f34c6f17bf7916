"""Leg kinematics against the plant, finite differences, round trips and mirror images."""

import numpy as np
import pytest
import yaml
from scipy.spatial.transform import Rotation

from drake_linefoot.errors import ModelError
from drake_linefoot.robot import leg_kinematics
from drake_linefoot.robot.humanoid import load_humanoid
from drake_linefoot.robot.legs import Legs, read_legs
from tests.helpers.small_biped import copied

SIDES = (0, 1)
EXACT = {"iterations": 30, "tolerance": 1e-13}


class OneLeg:
    """One of the two legs by itself."""

    def __init__(self, robot, side):
        *rows, zeros = read_legs(robot)
        self.legs = Legs(*(row[side : side + 1].copy() for row in rows), zeros)
        self.lower, self.upper = self.legs.lower[0], self.legs.upper[0]
        self.joints = len(zeros)
        self.sole = self.joints == 6

    def forward(self, q):
        return tuple(part[0] for part in leg_kinematics.forward(self.legs, q[None]))

    def inverse(self, p, R, guess, iterations=8, tolerance=1e-6):
        frames = np.array(R)
        if not self.sole:
            frames[..., 1:] = np.nan  # of a line the other axes do not count
        wanted = (np.ascontiguousarray(part)[None] for part in (p, frames, guess))
        found = leg_kinematics.inverse(self.legs, *wanted, iterations, tolerance)
        return tuple(part[0] for part in found)

    def rates(self, q, v, w):
        motion = (np.ascontiguousarray(part)[None] for part in (q, v, w))
        return leg_kinematics.rates(self.legs, *motion)[0]

    def angle(self, R, wanted):
        """How far a foot is off an orientation, of a line its x axis alone [rad]."""
        if self.sole:
            return Rotation.from_matrix(wanted @ np.swapaxes(R, -1, -2)).magnitude()
        a, b = R[..., 0], wanted[..., 0]
        return np.arctan2(np.linalg.norm(np.cross(a, b), axis=-1), np.sum(a * b, axis=-1))


def random_angles(chain, seed, count=40):
    rng = np.random.default_rng(seed)
    return rng.uniform(chain.lower, chain.upper, (count, chain.joints))


def walking_angles(robot, side, seed, count=40):
    """Angles around the nominal posture, bent knees."""
    rng = np.random.default_rng(seed)
    chain = OneLeg(robot, side)
    q = robot.q_nominal[robot.leg_q[side]] + rng.uniform(-0.4, 0.4, (count, chain.joints))
    return np.clip(q, chain.lower + 0.01, chain.upper - 0.01)


# --- forward --------------------------------------------------------------------------------


@pytest.mark.parametrize("side", SIDES)
def test_forward_is_the_plants_pose(robot, side):
    plant, context = robot.plant, robot.plant.CreateDefaultContext()
    chain = OneLeg(robot, side)
    angles = random_angles(chain, side)
    p_BC, R_BF, J = chain.forward(angles)
    q = robot.q_nominal.copy()
    q[:7] = [0.5, -0.5, 0.1, 0.7, 1.0, 2.0, 3.0]  # the torso's pose must not matter
    q[:4] /= np.linalg.norm(q[:4])
    for k, row in enumerate(angles):
        q[robot.leg_q[side]] = row
        plant.SetPositions(context, q)
        X_BF = robot.foot_frames[side].CalcPose(context, robot.base.body_frame())
        np.testing.assert_allclose(p_BC[k], X_BF @ robot.p_FC[side], rtol=0, atol=1e-13)
        np.testing.assert_allclose(R_BF[k], X_BF.rotation().matrix(), rtol=0, atol=1e-13)
    assert J.shape == (len(angles), 6, chain.joints)


@pytest.mark.parametrize("side", SIDES)
def test_jacobian_is_the_rate_of_the_pose(robot, side):
    chain = OneLeg(robot, side)
    angles = random_angles(chain, 2 + side)
    _, _, J = chain.forward(angles)
    h = 1e-6
    for i, e in enumerate(np.eye(chain.joints)):
        p1, R1, _ = chain.forward(angles + h * e)
        p0, R0, _ = chain.forward(angles - h * e)
        np.testing.assert_allclose(J[:, :3, i], (p1 - p0) / (2 * h), rtol=0, atol=1e-9)
        turn = Rotation.from_matrix(R1 @ np.swapaxes(R0, 1, 2)).as_rotvec()
        np.testing.assert_allclose(J[:, 3:, i], turn / (2 * h), rtol=0, atol=1e-9)


def test_limits_are_those_of_the_joints(robot):
    for side in SIDES:
        chain = OneLeg(robot, side)
        joints = [robot.plant.GetJointByName(n) for n in robot.description.feet[side].leg_joints]
        np.testing.assert_array_equal(chain.lower, [j.position_lower_limit() for j in joints])
        np.testing.assert_array_equal(chain.upper, [j.position_upper_limit() for j in joints])


# --- inverse --------------------------------------------------------------------------------


@pytest.mark.parametrize("side", SIDES)
def test_inverse_reaches_what_forward_gives(robot, side):
    """From the nominal posture, with the number of iterations the program uses."""
    chain = OneLeg(robot, side)
    p, R, _ = chain.forward(walking_angles(robot, side, 4 + side))
    guess = np.tile(robot.q_nominal[robot.leg_q[side]], (len(p), 1))
    q, residual = chain.inverse(p, R, guess)
    assert residual.max() < 1e-6
    p_found, R_found, _ = chain.forward(q)
    assert np.linalg.norm(p_found - p, axis=1).max() < 1e-6
    assert chain.angle(R_found, R).max() < 1e-6
    assert np.all((q >= chain.lower) & (q <= chain.upper))


@pytest.mark.parametrize("side", SIDES)
def test_inverse_returns_the_same_angles(robot, side):
    """Where the knee is bent there is one posture near the guess."""
    chain = OneLeg(robot, side)
    angles = walking_angles(robot, side, 6 + side)
    angles[:, 3] = np.maximum(angles[:, 3], 0.2)
    p, R, _ = chain.forward(angles)
    q, residual = chain.inverse(p, R, angles + 0.02, **EXACT)
    assert residual.max() < 1e-12
    np.testing.assert_allclose(q, angles, rtol=0, atol=1e-9)


def test_the_rest_of_a_batch_does_not_matter(robot):
    chain = OneLeg(robot, 0)
    p, R, _ = chain.forward(walking_angles(robot, 0, 8, count=6))
    p[2] += [0.0, 0.0, -3.0]  # out of reach
    p[4] = np.nan
    guess = np.tile(robot.q_nominal[robot.leg_q[0]], (6, 1))
    q, residual = chain.inverse(p, R, guess, **EXACT)
    for k in (0, 1, 3, 5):
        assert residual[k] < 1e-12
        alone, _ = chain.inverse(p[k : k + 1], R[k : k + 1], guess[:1], **EXACT)
        np.testing.assert_allclose(alone[0], q[k], rtol=0, atol=1e-10)
    assert residual[2] > 1.0
    assert not np.isfinite(residual[4])
    np.testing.assert_array_equal(q[4], guess[4])


@pytest.mark.parametrize("side", SIDES)
def test_out_of_reach_is_said_and_made_good_as_far_as_possible(robot, side):
    chain = OneLeg(robot, side)
    guess = robot.q_nominal[robot.leg_q[side]][None]
    p, R, _ = chain.forward(guess)
    below = p - np.array([0.0, 0.0, 0.5])
    q, residual = chain.inverse(below, R, guess, iterations=60)
    p_found, R_found, _ = chain.forward(q)
    distance = np.linalg.norm(p_found - below)
    angle = chain.angle(R_found, R)[0]
    turned = angle if chain.sole else np.sin(angle)
    assert residual[0] == pytest.approx(np.hypot(distance, turned), abs=1e-12)
    assert residual[0] < 0.5  # better than staying
    assert p_found[0, 2] < p[0, 2] - 0.01  # stretched
    assert np.all((q >= chain.lower) & (q <= chain.upper))


def test_a_foot_that_points_backwards_is_out_of_reach(robot):
    """The residual grows with the angle, up to pi; its sine alone would vanish there."""
    chain = OneLeg(robot, 0)
    guess = robot.q_nominal[robot.leg_q[0]][None]
    p, R, _ = chain.forward(guess)
    for angle in (0.6 * np.pi, 0.9 * np.pi, np.pi):
        for axis in R[0].T[1:]:
            backwards = Rotation.from_rotvec(angle * axis).as_matrix() @ R
            q, residual = chain.inverse(p, backwards, guess)
            assert residual[0] > 0.1
            p_found, R_found, _ = chain.forward(q)
            error = chain.angle(R_found, backwards)
            if error[0] > np.pi / 2:
                expected = np.hypot(np.linalg.norm(p_found - p), error[0])
                assert residual[0] == pytest.approx(expected, abs=1e-9)


# --- rates ----------------------------------------------------------------------------------


@pytest.mark.parametrize("side", SIDES)
def test_rates_are_the_rate_of_the_inverse(robot, side):
    rng = np.random.default_rng(9)
    chain = OneLeg(robot, side)
    angles = walking_angles(robot, side, 10 + side, count=20)
    angles[:, 3] = np.maximum(angles[:, 3], 0.3)
    p, R, _ = chain.forward(angles)
    v, w = rng.normal(size=(2, 20, 3))
    h = 1e-6

    def moved(t):
        turned = Rotation.from_rotvec(t * w).as_matrix() @ R
        return chain.inverse(p + t * v, turned, angles, **EXACT)[0]

    expected = (moved(h) - moved(-h)) / (2 * h)
    np.testing.assert_allclose(chain.rates(angles, v, w), expected, rtol=1e-5, atol=1e-5)


def test_turning_about_x_counts_for_a_sole_alone(robot):
    rng = np.random.default_rng(12)
    chain = OneLeg(robot, 1)
    angles = walking_angles(robot, 1, 13, count=10)
    angles[:, 3] = np.maximum(angles[:, 3], 0.3)
    _, R, J = chain.forward(angles)
    v, w = rng.normal(size=(2, 10, 3))
    along = rng.normal(size=(10, 1)) * R[..., 0]
    more = chain.rates(angles, v, w + along) - chain.rates(angles, v, w)
    if chain.sole:
        turned = np.einsum("kij,kj->ki", J[:, 3:], more)
        np.testing.assert_allclose(turned, along, rtol=0, atol=1e-5)
    else:
        np.testing.assert_allclose(more, 0.0, rtol=0, atol=1e-8)


def test_rates_move_the_foot_as_asked(robot):
    rng = np.random.default_rng(14)
    chain = OneLeg(robot, 0)
    angles = walking_angles(robot, 0, 15, count=10)
    angles[:, 3] = np.maximum(angles[:, 3], 0.3)
    _, R, J = chain.forward(angles)
    v, w = rng.normal(size=(2, 10, 3))
    moved = np.einsum("kij,kj->ki", J, chain.rates(angles, v, w))
    np.testing.assert_allclose(moved[:, :3], v, rtol=0, atol=1e-5)
    turned, asked = moved[:, 3:], w
    if not chain.sole:
        turned, asked = (np.cross(each, R[..., 0]) for each in (turned, asked))
    np.testing.assert_allclose(turned, asked, rtol=0, atol=1e-5)


def test_a_straight_knee_gives_finite_rates(humanoid):
    chain = OneLeg(humanoid, 0)
    rates = chain.rates(np.zeros((1, 5)), np.array([[0.0, 0.0, -1.0]]), np.zeros((1, 3)))
    assert np.all(np.isfinite(rates))


# --- both legs ------------------------------------------------------------------------------


def test_the_legs_are_mirror_images(robot):
    left, right = OneLeg(robot, 0), OneLeg(robot, 1)
    S, T = np.diag([1.0, -1.0, 1.0]), np.diag([-1.0, 1.0, -1.0])
    angles = walking_angles(robot, 0, 16)
    mirrored = []
    for row in angles:
        x = robot.x_nominal
        x[robot.leg_q[0]] = row
        mirrored.append(robot.mirror_state(x)[robot.leg_q[1]])
    mirrored = np.array(mirrored)
    p, R, _ = left.forward(angles)
    p_m, R_m, _ = right.forward(mirrored)
    np.testing.assert_allclose(p_m, p @ S, rtol=0, atol=1e-13)
    np.testing.assert_allclose(R_m, S @ R @ S, rtol=0, atol=1e-13)
    v, w = np.random.default_rng(17).normal(size=(2, len(angles), 3))
    sign = np.where(np.abs(mirrored - angles).max(axis=0) < 1e-12, 1.0, -1.0)
    rates = right.rates(mirrored, v @ S, w @ T)
    np.testing.assert_allclose(rates, sign * left.rates(angles, v, w), rtol=1e-6, atol=1e-6)


# --- legs that are none ---------------------------------------------------------------------


@pytest.fixture
def biped_file(small_biped_files, tmp_path):
    """Return a copy of the small biped's description, for a test that writes beside it."""
    return copied(small_biped_files["small biped with arms"], tmp_path / "copied")


def changed_biped(source, change, model=None):
    """Load a small biped with its description changed, and perhaps its model's text."""
    data = yaml.safe_load(source.read_text())
    change(data)
    if model is not None:
        data["model"] = "changed_leg.urdf"
        source.with_name(data["model"]).write_text(
            model(source.with_name("small.urdf").read_text())
        )
    file = source.with_name("changed_leg.yaml")
    file.write_text(yaml.safe_dump(data))
    return load_humanoid(file)


def test_a_leg_of_four_joints_is_refused(biped_file):
    def change(data):
        for foot in data["feet"]:
            data["arm_joints"].append(foot["leg_joints"].pop())

    with pytest.raises(ModelError, match=r"feet\[0\]\.leg_joints .* must name 5 joints"):
        changed_biped(biped_file, change)


def test_joints_out_of_order_are_refused(biped_file):
    def change(data):
        joints = data["feet"][1]["leg_joints"]
        joints[1], joints[2] = joints[2], joints[1]

    with pytest.raises(ModelError, match=r"feet\[1\]\.leg_joints = 'pitch_R': is not next"):
        changed_biped(biped_file, change)


def test_a_chain_that_ends_elsewhere_is_refused(biped_file):
    def change(data):
        data["feet"][0]["frame"] = "knee_L_link"

    with pytest.raises(ModelError, match=r"= 'knee_L_link': the chain must end at the foot"):
        changed_biped(biped_file, change)


def test_a_sliding_joint_is_refused(biped_file):
    def slide(urdf):
        return urdf.replace('"knee_L" type="revolute"', '"knee_L" type="prismatic"')

    with pytest.raises(ModelError, match=r"= 'knee_L': is not next in a revolute chain"):
        changed_biped(biped_file, lambda data: None, slide)


# --- both legs at once ----------------------------------------------------------------------


def test_both_legs_do_what_each_leg_does(robot):
    both, legs = read_legs(robot), [OneLeg(robot, side) for side in SIDES]
    angles = np.stack([walking_angles(robot, side, 30 + side, count=14) for side in SIDES])
    each = [leg.forward(q) for leg, q in zip(legs, angles, strict=True)]
    for together, left, right in zip(leg_kinematics.forward(both, angles), *each, strict=True):
        np.testing.assert_allclose(together, np.stack([left, right]), rtol=0, atol=1e-15)
    p, R, _ = leg_kinematics.forward(both, angles)
    guess = np.repeat(robot.q_nominal[robot.leg_q][:, None], 14, axis=1)
    found, residual = leg_kinematics.inverse(both, p, R, guess, *EXACT.values())
    assert residual.max() < 1e-12
    velocity = np.random.default_rng(0).normal(size=(2, *p.shape))
    rates = leg_kinematics.rates(both, angles, *velocity)
    for side, leg in enumerate(legs):
        alone, _ = leg.inverse(p[side], R[side], guess[side], **EXACT)
        np.testing.assert_allclose(found[side], alone, rtol=0, atol=1e-9)
        expected = leg.rates(angles[side], *velocity[:, side])
        np.testing.assert_allclose(rates[side], expected, rtol=0, atol=1e-10)
