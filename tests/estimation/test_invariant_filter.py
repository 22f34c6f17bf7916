"""The filter's functions: on the group, on exact motion, and over seeded synthetic motions."""

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.spatial.transform import Rotation
from scipy.stats import chi2

from drake_linefoot.constants import GRAVITY
from drake_linefoot.estimation.filter_state import (
    ACCELEROMETER_BIAS,
    CONTACT,
    ERRORS,
    GYRO_BIAS,
    PLACE,
    POINTS,
    VELOCITY,
    Noise,
    filter_of,
    new_filter,
)
from drake_linefoot.estimation.invariant_filter import (
    anchor,
    begin,
    correct,
    exponential,
    propagate,
    responses,
    retract,
    tick,
    transition,
)
from drake_linefoot.math.rotation import skew

H = 0.002
QUIET = Noise(
    *(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1e-9, np.inf, 0.0),
    change=0.01,
    delay=0.0,
    dissipation=0.0,
    full=30.0,
    touch=15.0,
    release=8.0,
    gate=np.inf,
    patience=0.01,
)
NOISY = QUIET._replace(
    gyro=2e-3, accelerometer=0.02, gyro_walk=1e-5, accelerometer_walk=1e-4, slip=2e-3, point=1e-3
)
FULL = np.full(POINTS, 1e9)  # load without slip beyond that of `slip`
STEADY = np.zeros(POINTS)  # [N/s]


def some_filter(seed):
    rng = np.random.default_rng(seed)
    s = filter_of(new_filter())
    s.R[:] = Rotation.from_rotvec(rng.normal(size=3)).as_matrix()
    s.v[:], s.p[:], s.d[:] = rng.normal(size=3), 2.0 * rng.normal(size=3), rng.normal(size=(4, 3))
    s.gyro_bias[:], s.accelerometer_bias[:] = 0.1 * rng.normal(size=3), rng.normal(size=3)
    return s


def error(estimate, true):
    """Return xi and zeta of an estimate, by a matrix logarithm on the group."""
    gamma = estimate.R @ true.R.T
    phi = Rotation.from_matrix(gamma).as_rotvec()
    J = exponential(phi)[1]
    xi = np.zeros(ERRORS)
    xi[:3] = phi
    pairs = [(estimate.v, true.v), (estimate.p, true.p), *zip(estimate.d, true.d, strict=True)]
    for i, (a, b) in enumerate(pairs):
        xi[3 + 3 * i : 6 + 3 * i] = np.linalg.solve(J, a - gamma @ b)
    xi[GYRO_BIAS:ACCELEROMETER_BIAS] = estimate.gyro_bias - true.gyro_bias
    xi[ACCELEROMETER_BIAS:] = estimate.accelerometer_bias - true.accelerometer_bias
    return xi


def moved(s, xi):
    """Return a copy of a filter with an error."""
    vector = np.frombuffer(s.tobytes()).copy()
    copy = filter_of(vector)
    retract(copy, np.asarray(xi, dtype=float))
    return copy


def test_exponential_is_that_of_the_group():
    """Of SE_1(3): rotation and left Jacobian are two blocks of a matrix exponential."""
    rng = np.random.default_rng(0)
    for size in (0.0, 1e-6, 0.3, 3.0):
        phi, rho = size * rng.normal(size=3), rng.normal(size=3)
        whole = np.zeros((4, 4))
        whole[:3, :3], whole[:3, 3] = skew(phi), rho
        R, J = exponential(phi)
        np.testing.assert_allclose(expm(whole)[:3], np.column_stack([R, J @ rho]), atol=1e-12)


def test_retract_makes_the_error_it_is_given():
    s, xi = some_filter(1), 0.3 * np.random.default_rng(2).normal(size=ERRORS)
    np.testing.assert_allclose(error(moved(s, xi), s), xi, atol=1e-12)


@pytest.mark.parametrize("seed", range(4))
def test_transition_is_the_derivative_on_the_group(seed):
    """Finite differences of two filters that go through one tick."""
    imu = np.random.default_rng(seed).normal(size=6) * [2, 2, 2, 5, 5, 5]
    step, columns = 1e-6, []
    s = some_filter(seed)
    _, turned, pushed = responses(s, imu, H)
    for i in range(ERRORS):
        ahead, behind = (moved(s, sign * step * np.eye(ERRORS)[i]) for sign in (1.0, -1.0))
        base = moved(s, np.zeros(ERRORS))
        for each in (ahead, behind, base):
            propagate(each, imu, (FULL, STEADY), H, QUIET)
        columns.append((error(ahead, base) - error(behind, base)) / (2.0 * step))
    wanted = np.array(columns).T
    got = transition(np.eye(ERRORS), H, turned, pushed)
    # A bias turns the tick's own rotation, whose Jacobian is taken in its middle.
    np.testing.assert_allclose(got, wanted, rtol=2e-5, atol=1e-8)


def test_transition_is_exact_for_large_errors_of_the_state():
    """Group-affine: xi after a tick is Phi xi, however large, and wherever the state is."""
    imu = np.array([1.0, -2.0, 3.0, 4.0, -5.0, 6.0])
    s, xi = some_filter(3), 0.5 * np.random.default_rng(4).normal(size=ERRORS)
    xi[GYRO_BIAS:] = 0.0
    _, turned, pushed = responses(s, imu, H)
    far = moved(s, xi)
    for each in (s, far):
        propagate(each, imu, (FULL, STEADY), H, QUIET)
    wanted = transition(xi[:, None], H, turned, pushed)[:, 0]
    np.testing.assert_allclose(error(far, s), wanted, atol=1e-12)


def test_innovation_is_linear_in_the_error():
    """z = J (xi_p - xi_d): what `correct` has in C."""
    s = some_filter(5)
    s.P[:] = np.eye(ERRORS)
    rng, step = np.random.default_rng(6), 1e-7
    p_BC = s.R.T @ (s.d[2] - s.p)
    for _ in range(5):
        xi = rng.normal(size=ERRORS)
        far = moved(s, step * xi)
        correct(far, 2, p_BC, np.eye(3), np.inf)
        at = CONTACT + 6
        wanted = xi[PLACE:CONTACT] - xi[at : at + 3]
        np.testing.assert_allclose(far.innovation[2] / step, wanted, atol=1e-5)


class Motion:
    """A body that sways over four fixed points, in the steps of a plant; sensors of it."""

    def __init__(self, seed, noise):
        self.rng, self.c = np.random.default_rng(seed), noise
        self.true = filter_of(new_filter())
        self.true.R[:] = Rotation.from_euler("ZYX", self.rng.normal(0, 0.05, 3)).as_matrix()
        self.true.p[2] = 0.7
        self.true.d[:] = [[-0.05, 0.1, 0], [0.1, 0.1, 0], [-0.05, -0.1, 0], [0.1, -0.1, 0]]
        self.phase, self.t = self.rng.uniform(0, 6, 6), 0.0

    def step(self):
        """Move on by a tick; return what the IMU says."""
        s, c, self.t = self.true, self.c, self.t + H
        sway = np.cos(self.phase + self.t * np.array([3, 4, 2, 5, 3, 4]))
        w, a = 0.6 * sway[:3], 1.0 * sway[3:]
        s.R[:] = s.R @ Rotation.from_rotvec(H * w).as_matrix()
        s.v[:] += H * a
        s.p[:] += H * s.v
        s.d[:] += c.slip * np.sqrt(H) * self.rng.normal(size=(4, 3))
        walk = np.sqrt(H) * self.rng.normal(size=6)
        s.gyro_bias[:] += c.gyro_walk * walk[:3]
        s.accelerometer_bias[:] += c.accelerometer_walk * walk[3:]
        white = self.rng.normal(size=6) / np.sqrt(H)
        gyro = w + s.gyro_bias + c.gyro * white[:3]
        force = s.R.T @ (a - GRAVITY) + s.accelerometer_bias + c.accelerometer * white[3:]
        return np.concatenate([gyro, force])

    def points(self):
        s = self.true
        exact = (s.d - s.p) @ s.R
        return exact + self.c.point * self.rng.normal(size=(4, 3))

    def follow(self, s, ticks):
        for _ in range(ticks):
            propagate(s, self.step(), (FULL, STEADY), H, self.c)
            for k, p_BC in enumerate(self.points()):
                correct(s, k, p_BC, self.c.point**2 * np.eye(3), np.inf)


def test_exact_on_motion_without_noise():
    motion = Motion(0, QUIET)
    s = moved(motion.true, np.zeros(ERRORS))
    s.P[:] = 1e-6 * np.eye(ERRORS)
    s.active[:] = 1.0
    motion.follow(s, 400)
    np.testing.assert_allclose(error(s, motion.true), 0.0, atol=1e-7)


DEVIATIONS = np.concatenate(
    [[0.02, 0.02, 1e-4, *[0.05] * 3, *[1e-3] * 15], np.full(3, 5e-3), np.full(3, 0.05)]
)


def nees_at(seed, ticks):
    """Return the squared error of a filter in units of its covariance, after so many ticks."""
    motion = Motion(seed, NOISY)
    s = moved(motion.true, DEVIATIONS * motion.rng.normal(size=ERRORS))
    s.P[:] = np.diag(DEVIATIONS**2)
    s.active[:] = 1.0
    found = []
    for each in np.diff([0, *ticks]):
        motion.follow(s, each)
        xi = error(s, motion.true)
        found.append(xi @ np.linalg.solve(s.P, xi))
    return found


def test_consistent_over_fifty_seeded_motions():
    """The mean NEES of fifty motions lies inside its 95 % bounds."""
    seeds, ticks = 50, (50, 250)
    mean = np.mean([nees_at(seed, ticks) for seed in range(seeds)], axis=0)
    low, high = chi2.ppf([0.025, 0.975], seeds * ERRORS) / seeds
    assert ((low < mean) & (mean < high)).all(), (low, mean, high)


def test_only_place_and_heading_cannot_be_observed():
    """Over a motion, their variance stays what it was, and that of everything else falls."""
    motion = Motion(7, NOISY._replace(slip=0.0, gyro=0.0, gyro_walk=0.0))
    s = moved(motion.true, np.zeros(ERRORS))
    s.P[:] = np.diag(np.full(ERRORS, 1e-2))
    s.active[:] = 1.0
    # A turn about the vertical through the origin, and a shift, of everything together.
    hidden = np.zeros((ERRORS, 4))
    hidden[2, 3] = 1.0
    for i in range(3):
        hidden[PLACE + i : GYRO_BIAS : 3, i] = 1.0
    hidden /= np.linalg.norm(hidden, axis=0)
    motion.follow(s, 1500)
    information = np.linalg.inv(s.P)
    kept = np.diagonal(hidden.T @ information @ hidden)
    np.testing.assert_allclose(kept, 100.0, rtol=1e-3)
    spread = np.linalg.eigvalsh(s.P)
    assert (spread[-4:] > 9e-3).all() and spread[-5] < 2.5e-3


def test_an_outlier_is_refused_and_changes_nothing():
    s = some_filter(8)
    s.P[:] = 1e-6 * np.eye(ERRORS)
    before = np.frombuffer(s.tobytes()).copy()
    p_BC = s.R.T @ (s.d[1] - s.p) + [0.1, 0.0, 0.0]
    assert not correct(s, 1, p_BC, 1e-6 * np.eye(3), 16.27)
    assert s.nis[1] > 1000.0
    s.nis[1], s.innovation[1] = 0.0, 0.0
    np.testing.assert_array_equal(np.frombuffer(s.tobytes()), before)


def test_a_point_that_is_anchored_has_the_error_of_the_place():
    s = some_filter(9)
    A = np.random.default_rng(9).normal(size=(ERRORS, ERRORS))
    s.P[:] = A @ A.T
    anchor(s, 3, np.array([0.1, 0.2, -0.6]), 1e-4 * np.eye(3))
    np.testing.assert_allclose(s.d[3], s.p + s.R @ [0.1, 0.2, -0.6])
    at = CONTACT + 9
    np.testing.assert_allclose(s.P[at : at + 3, :at], s.P[PLACE:CONTACT, :at])
    wanted = s.P[PLACE:CONTACT, PLACE:CONTACT] + 1e-4 * np.eye(3)
    np.testing.assert_allclose(s.P[at : at + 3, at : at + 3], wanted)
    np.testing.assert_array_equal(s.P, s.P.T)


@pytest.mark.parametrize("roll, pitch", [(0.0, 0.0), (0.2, -0.1), (-1.0, 0.4)])
def test_it_begins_level_with_heading_zero_on_the_ground(roll, pitch):
    R = Rotation.from_euler("ZYX", [0.0, pitch, roll]).as_matrix()
    s = filter_of(new_filter())
    points = np.random.default_rng(0).normal(size=(4, 3)) - [0.0, 0.0, 5.0]
    imu = np.concatenate([np.zeros(3), -R.T @ GRAVITY])
    begin(s, imu, points, np.ones(ERRORS))
    np.testing.assert_allclose(s.R, R, atol=1e-12)
    assert s.d[:, 2].min() == pytest.approx(0.0, abs=1e-12)
    assert VELOCITY == 3 and s.time == 0.0


def standing_filter(points):
    s = filter_of(new_filter())
    begin(s, np.array([0.0, 0.0, 0.0, 0.0, 0.0, 9.81]), points, np.full(ERRORS, 1e-3))
    return s


POSTURE = np.array([[-0.1, y, -0.6] for y in (0.1, 0.1, -0.1, -0.1)]) + np.array(
    [[0.0, 0.0, 0.0], [0.2, 0.0, 0.0]] * 2
)


def test_the_base_sinks_with_points_that_sink_in_under_their_load():
    """Standing still on a leg that does not bend, the base goes down by what the load adds."""
    c = NOISY._replace(stiffness=2e5, accelerometer=1.0)
    s, jacobians = standing_filter(POSTURE), np.zeros((POINTS, 3, 5))
    rest = np.concatenate([np.zeros(3), -GRAVITY])
    loads = np.concatenate([np.full(50, 20.0), np.linspace(20.0, 120.0, 400), np.full(400, 120.0)])
    heights = []
    for load in loads:
        tick(s, rest, (POSTURE, jacobians), np.full(POINTS, load), H, c)
        heights.append(s.p[2])
    assert heights[49] - heights[-1] == pytest.approx(100.0 / 2e5, rel=0.05)


def test_a_point_holds_only_after_its_impact():
    """While it settles it is taken along; then it is held to where it is."""
    c = QUIET._replace(settle=5.5 * H)
    s, jacobians = standing_filter(POSTURE), np.zeros((POINTS, 3, 5))
    rest, load = np.concatenate([np.zeros(3), -GRAVITY]), np.array([60.0, 60.0, 0.0, 0.0])
    for _ in range(20):
        tick(s, rest, (POSTURE, jacobians), load, H, c)
    points, load = POSTURE.copy(), np.full(POINTS, 60.0)
    for k in range(6):
        points[2:, 2] -= 1e-4  # the ground gives way
        tick(s, rest, (points, jacobians), load, H, c)
        assert np.isnan(s.nis[2:]).all() and not np.isnan(s.nis[:2]).any(), k
        np.testing.assert_allclose(s.d[2:] - s.p, points[2:] @ s.R.T, atol=1e-12)
    tick(s, rest, (points, jacobians), load, H, c)
    assert not np.isnan(s.nis).any()
