"""Rotations against scipy's, matrix exponentials, and the kinematics (4)-(8)."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from pydrake.math import RollPitchYaw
from scipy.linalg import expm
from scipy.spatial.transform import Rotation

from drake_linefoot.math import rotation
from drake_linefoot.math.rotation import from_quaternion, roll_pitch_yaw, rotation_error

AXES = np.vstack([np.eye(3), -np.eye(3), [[1, 1, 1], [-0.6, 0.0, 0.8], [1e-9, 1.0, -1e-9]]])
AXES = AXES / np.linalg.norm(AXES, axis=1, keepdims=True)
HEADINGS = st.floats(-np.pi, np.pi)


def exp(theta):
    return Rotation.from_rotvec(theta).as_matrix()


def vectors(size=10.0):
    return arrays(float, 3, elements=st.floats(-size, size))


def rotations():
    return vectors(2.0).map(lambda theta: Rotation.from_rotvec(theta).as_matrix())


def random_rotations(seed, *shape):
    count = int(np.prod(shape))
    return Rotation.random(count, random_state=seed).as_matrix().reshape(*shape, 3, 3)


# --- cross-product matrices ---------------------------------------------------------------


@given(vectors(), vectors())
def test_skew_is_the_cross_product(a, b):
    np.testing.assert_allclose(rotation.skew(a) @ b, np.cross(a, b), rtol=0, atol=1e-13)
    np.testing.assert_array_equal(rotation.skew(a).T, -rotation.skew(a))


@given(vectors(), vectors())
def test_cross_is_numpys(a, b):
    np.testing.assert_array_equal(rotation.cross(a, b), np.cross(a, b))


# --- exponential and logarithm ------------------------------------------------------------


@pytest.mark.parametrize("axis", AXES)
@pytest.mark.parametrize(
    "angle", [0.0, 1e-300, 1e-12, 1e-8, 1e-7, 0.99e-4, 1.01e-4, 1e-3, 0.5, 2.0, 3.0]
)
def test_log_undoes_exp(axis, angle):
    """Also next to the identity and on both sides of the switch to the series."""
    theta = angle * axis
    np.testing.assert_allclose(rotation.log(exp(theta)), theta, rtol=1e-12, atol=1e-15)


@pytest.mark.parametrize("axis", AXES)
@pytest.mark.parametrize("short", [0.3, 1e-2, 1e-3, 1.01e-4, 0.99e-4, 1e-5, 1e-7])
def test_log_undoes_exp_near_half_a_turn(axis, short):
    theta = (np.pi - short) * axis
    np.testing.assert_allclose(rotation.log(exp(theta)), theta, rtol=0, atol=3e-12)


@pytest.mark.parametrize("axis", AXES)
def test_log_of_half_a_turn_has_either_sign(axis):
    R = 2.0 * np.outer(axis, axis) - np.eye(3)
    theta = rotation.log(R)
    assert np.linalg.norm(theta) == pytest.approx(np.pi, abs=1e-12)
    np.testing.assert_allclose(np.abs(theta @ axis), np.pi, rtol=0, atol=1e-12)


@given(st.floats(np.pi + 1e-3, 2 * np.pi - 1e-3), st.sampled_from(list(AXES)))
def test_log_beyond_half_a_turn_goes_the_short_way(angle, axis):
    expected = (angle - 2 * np.pi) * axis
    np.testing.assert_allclose(rotation.log(exp(angle * axis)), expected, rtol=0, atol=3e-12)


def test_log_agrees_with_another_library():
    R = random_rotations(1, 500)
    expected = Rotation.from_matrix(R).as_rotvec()
    np.testing.assert_allclose([rotation.log(row) for row in R], expected, rtol=0, atol=1e-11)


# --- headings and quaternions -------------------------------------------------------------


@given(st.floats(-100.0, 100.0))
def test_wrap_angle_is_the_same_heading_within_half_a_turn(angle):
    wrapped = float(rotation.wrap_angle(angle))
    assert -np.pi <= wrapped < np.pi
    assert np.exp(1j * wrapped) == pytest.approx(np.exp(1j * angle), abs=1e-13)


def test_wrap_angle_of_half_turns():
    angles = np.pi * np.array([-3.0, -1.0, 1.0, 3.0])
    np.testing.assert_allclose(rotation.wrap_angle(angles), -np.pi, rtol=0, atol=1e-15)
    assert rotation.wrap_angle(np.nextafter(-np.pi, -4.0)) < np.pi


def test_from_quaternion_agrees_with_another_library_whatever_its_length():
    rng = np.random.default_rng(4)
    for q in rng.normal(size=(50, 4)):
        expected = Rotation.from_quat(np.roll(q, -1)).as_matrix()
        np.testing.assert_allclose(from_quaternion(q), expected, rtol=0, atol=1e-14)
        np.testing.assert_allclose(from_quaternion(-1e3 * q), expected, rtol=0, atol=1e-14)


def test_from_quaternion_refuses_zero():
    with pytest.raises(ValueError, match="quaternion is zero"):
        from_quaternion(np.zeros(4))


@given(st.floats(-3.1, 3.1), st.floats(-1.5, 1.5), st.floats(-3.1, 3.1))
def test_roll_pitch_yaw_are_those_of_drake(roll, pitch, yaw):
    q = RollPitchYaw(roll, pitch, yaw).ToQuaternion().wxyz()
    np.testing.assert_allclose(roll_pitch_yaw(q), [roll, pitch, yaw], rtol=0, atol=1e-13)
    rows = roll_pitch_yaw(np.array([q, 3.0 * q]))
    np.testing.assert_allclose(rows, [[roll, pitch, yaw]] * 2, rtol=0, atol=1e-13)


def test_a_torso_that_looks_straight_down_has_some_roll_and_yaw():
    q = RollPitchYaw(0.3, 0.5 * np.pi, 0.0).ToQuaternion().wxyz()
    R = Rotation.from_euler("ZYX", roll_pitch_yaw(q)[::-1]).as_matrix()
    np.testing.assert_allclose(R, from_quaternion(q), rtol=0, atol=1e-7)


# --- the variation (4)-(8) ----------------------------------------------------------------


@given(rotations(), vectors(1.0))
def test_rotation_error_is_the_variation_to_first_order(R_d, eta):
    """(7): R = R_d + eps R_d [eta]x + O(eps^2)."""
    eps = 1e-4
    R = R_d + eps * R_d @ rotation.skew(eta)
    U, _, Vt = np.linalg.svd(R)  # the nearest rotation is eps^2 away
    np.testing.assert_allclose(rotation_error(U @ Vt, R_d), eps * eta, rtol=0, atol=5 * eps**2)


@given(rotations(), rotations(), rotations())
def test_rotation_error_is_zero_on_target_odd_and_blind_to_the_world(R, R_d, Q):
    eta = rotation_error(R, R_d)
    np.testing.assert_allclose(rotation_error(R, R), 0.0, rtol=0, atol=1e-14)
    if np.linalg.norm(eta) < np.pi - 1e-3:  # beyond, the sign is not determined
        np.testing.assert_allclose(rotation_error(R_d, R), -eta, rtol=0, atol=1e-11)
        np.testing.assert_allclose(rotation_error(Q @ R, Q @ R_d), eta, rtol=0, atol=1e-11)
        np.testing.assert_allclose(R_d @ expm(rotation.skew(eta)), R, rtol=0, atol=1e-11)


class Trajectory:
    """A rotation R(t) = R_0 exp(p(t)), with p a polynomial, and its velocity in the body."""

    def __init__(self, seed, size):
        rng = np.random.default_rng(seed)
        self.c = size * rng.normal(size=(4, 3))

    def rotation(self, t):
        return Rotation.from_rotvec(self.c.T @ [1.0, t, t**2, t**3]).as_matrix()

    def omega(self, t, h=1e-5):
        """(4), (5): [Omega]x = R' Rdot; the central difference is good to 1e-10."""
        rate = (self.rotation(t + h) - self.rotation(t - h)) / (2 * h)
        S = self.rotation(t).T @ rate
        return np.array([S[2, 1], S[0, 2], S[1, 0]])


class Nearby:
    """A rotation R_d(t) exp(eps p(t)) close to a reference."""

    def __init__(self, reference, seed, eps):
        self.reference, self.away = reference, Trajectory(seed, 1.0)
        self.eps = eps

    def rotation(self, t):
        away = self.eps * self.away.c.T @ [1.0, t, t**2, t**3]
        return self.reference.rotation(t) @ Rotation.from_rotvec(away).as_matrix()

    omega = Trajectory.omega


@pytest.mark.parametrize(("seed", "t"), [(5, 0.3), (6, -0.4)])
def test_rate_of_the_rotation_error(seed, t):
    """(8): eta' = eta x Omega_d + dOmega, with an error of second order in eta."""
    reference = Trajectory(seed, 0.7)
    h = 1e-5
    errors = []
    for eps in (4e-2, 2e-2, 1e-2):
        actual = Nearby(reference, seed + 10, eps)
        eta = [rotation_error(actual.rotation(s), reference.rotation(s)) for s in (t - h, t, t + h)]
        rate = (eta[2] - eta[0]) / (2 * h)
        d_omega = actual.omega(t) - reference.omega(t)
        linear = np.cross(eta[1], reference.omega(t)) + d_omega
        errors.append(np.linalg.norm(rate - linear))
        assert errors[-1] < 2.0 * np.linalg.norm(eta[1]) * np.linalg.norm(d_omega)
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    np.testing.assert_allclose(orders, 2.0, rtol=0, atol=0.1)


# --- frames on a plane --------------------------------------------------------------------


@given(HEADINGS, st.floats(-0.5, 0.5), st.floats(-0.5, 0.5), st.floats(-0.5, 0.5))
def test_axes_on_a_plane_have_their_y_in_it(yaw, pitch, along_x, along_y):
    """And z is its normal where x lies in it as well."""
    slope, normal = np.array([along_x, along_y]), np.array([-along_x, -along_y, 1.0])
    x = np.array([np.cos(yaw) * np.cos(pitch), np.sin(yaw) * np.cos(pitch), -np.sin(pitch)])
    R = rotation.axes_on_plane(x, slope)
    np.testing.assert_allclose(R.T @ R, np.eye(3), atol=1e-12)
    assert np.linalg.det(R) == pytest.approx(1.0)
    np.testing.assert_array_equal(R[:, 0], x)
    assert R[:, 1] @ normal == pytest.approx(0.0, abs=1e-12)
    assert R[:, 2] @ normal > 0.0
    in_plane = np.array([np.cos(yaw), np.sin(yaw), np.cos(yaw) * along_x + np.sin(yaw) * along_y])
    R = rotation.axes_on_plane(in_plane / np.linalg.norm(in_plane), slope)
    np.testing.assert_allclose(R[:, 2], normal / np.linalg.norm(normal), atol=1e-12)
