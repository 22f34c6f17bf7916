"""The Enhanced Centroidal Dynamics against the full plant, body by body.

Momenta and their rates are those of `full_plant`, which knows nothing of the model.
"""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from drake_linefoot.centroidal import NO_WRENCH
from drake_linefoot.constants import GRAVITY
from drake_linefoot.math.rotation import from_quaternion
from drake_linefoot.mpc.ecd import (
    Linearisation,
    centroidal_state,
    input_matrices,
    orientation_terms,
    system_matrices,
)
from tests.helpers.full_plant import (
    accelerations,
    contact_lines,
    linearisation,
    momentum_about,
    momentum_rates,
    put,
)
from tests.helpers.walking import recorded_walk

R_G = np.array([0.3, -0.4, 0.5])  # somewhere, on purpose not at the CoM


@pytest.fixture(scope="module")
def context(humanoid):
    return humanoid.plant.CreateDefaultContext()


@pytest.fixture(scope="module")
def states(humanoid, walking_state):
    """States of a walk and random ones."""
    walk = [record.x for record in recorded_walk().wbc[60::60]]
    return walk + [walking_state(humanoid, seed) for seed in range(4)]


@pytest.mark.parametrize("pull", [0.0, 1.0])
def test_r_v_and_L_G_are_exact(humanoid, context, states, pull):
    """(31), (37)-(39): whatever the joints do and however far the state is from a reference.

    Also where something pulls at the robot.
    """
    rng = np.random.default_rng(4)
    about = linearisation(humanoid, context, states[0])
    external = pull * np.array([3.0, -5.0, 2.0, -30.0, 20.0, 15.0])
    A, C = system_matrices(about, R_G, humanoid.mass, external)
    for x in states:
        r, v = put(humanoid, context, x)
        L = momentum_about(humanoid, context, r)
        u = rng.normal(size=10) * np.tile([60, 60, 150, 10, 10], 2)
        torque = 30.0 * rng.normal(size=humanoid.na)
        vdot = accelerations(humanoid, context, torque, u, external)
        linear, angular = momentum_rates(humanoid, context, vdot, R_G)
        p, R = contact_lines(humanoid, context)
        B = input_matrices(p[None], R[None], R_G, humanoid.mass, 5)
        state = centroidal_state(r, v, L, rng.normal(size=3), R_G, humanoid.mass)
        rate = A[0] @ state + B[0] @ u + C[0]
        expected = np.concatenate([v, linear / humanoid.mass, angular])
        np.testing.assert_allclose(rate[:9], expected, rtol=1e-9, atol=1e-9)


def test_L_G_is_the_momentum_about_the_fixed_point(humanoid, context, states):
    for x in states:
        r, v = put(humanoid, context, x)
        L = momentum_about(humanoid, context, r)
        state = centroidal_state(r, v, L, np.zeros(3), R_G, humanoid.mass)
        np.testing.assert_allclose(
            state[6:9], momentum_about(humanoid, context, R_G), rtol=1e-12, atol=1e-11
        )


def perturbed(humanoid, x, size, seed):
    """A state near `x`: torso and CoM moved and moving otherwise, joints and rates the same."""
    d = size * np.random.default_rng(seed).normal(size=12)
    y = x.copy()
    R = Rotation.from_matrix(from_quaternion(x[:4]))
    q = (R * Rotation.from_rotvec(d[:3])).as_quat()
    y[:4], y[4:7] = np.roll(q, 1), x[4:7] + d[3:6]
    nq = humanoid.nq
    # Joint rates count in the torso frame: turn the torso's own velocity along with it.
    y[nq : nq + 6] = x[nq : nq + 6] + d[6:]
    return y


def eta_rate(R, w, R_d, Omega_d, h=1e-5):
    """d/dt log(R_d' R) by a central difference while both turn at constant rates."""

    def eta(t):
        now = Rotation.from_rotvec(w * t) * R
        wanted = R_d * Rotation.from_rotvec(Omega_d * t)
        return (wanted.inv() * now).as_rotvec()

    return (eta(h) - eta(-h)) / (2 * h)


def eta_error(humanoid, context, x, size, seed):
    """How far the linear model's eta' is from the true one, near the reference `x`."""
    about = linearisation(humanoid, context, x)
    y = perturbed(humanoid, x, size, seed)
    r, v = put(humanoid, context, y)
    L = momentum_about(humanoid, context, r)
    R = Rotation.from_matrix(from_quaternion(y[:4]))
    R_d = Rotation.from_matrix(about.R_d[0])
    w = y[humanoid.nq : humanoid.nq + 3]
    true = eta_rate(R, w, R_d, about.Omega_d[0])
    eta = (R_d.inv() * R).as_rotvec()
    A, C = system_matrices(about, R_G, humanoid.mass, NO_WRENCH)
    state = centroidal_state(r, v, L, eta, R_G, humanoid.mass)
    return (A[0] @ state + C[0])[9:] - true


def test_eta_is_exact_on_the_reference(humanoid, context, states):
    for x in states:
        np.testing.assert_allclose(eta_error(humanoid, context, x, 0.0, 0), 0.0, atol=1e-9)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_eta_has_only_quadratic_errors(humanoid, context, states, seed):
    """Half the perturbation, a quarter of the error, (7), (8), (25)-(30)."""
    for x in states:
        errors = [
            np.linalg.norm(eta_error(humanoid, context, x, size, seed))
            for size in (4e-3, 2e-3, 1e-3)
        ]
        ratios = np.array(errors[:-1]) / errors[1:]
        np.testing.assert_allclose(ratios, 4.0, atol=0.25)


@pytest.mark.parametrize("which", [0, 2, -1])
def test_the_whole_model_is_the_derivative_of_the_nonlinear_one(humanoid, context, states, which):
    """A and B by central differences of the nonlinear right-hand side, C by its value."""
    rng = np.random.default_rng(8)
    m, x = humanoid.mass, states[which]
    about = linearisation(humanoid, context, x)
    I_B, R_d, Omega_d, L_d, r_d, v_d = (
        getattr(about, n)[0] for n in ("I_B", "R_d", "Omega_d", "L_d", "r_d", "v_d")
    )
    h_joints = R_d.T @ L_d - I_B @ Omega_d  # momentum of the joints, in B, (23)
    p, R = contact_lines(humanoid, context)

    def rhs(state, u):
        r, v, L_G, eta = state[:3], state[3:6], state[6:9], state[9:]
        f, tau = u[[0, 1, 2, 5, 6, 7]].reshape(2, 3), u[[3, 4, 8, 9]].reshape(2, 2)
        a = GRAVITY + f.sum(axis=0) / m
        moment = np.cross(p - R_G, f).sum(axis=0) + sum(
            Rc[:, 1:] @ t for Rc, t in zip(R, tau, strict=True)
        )
        R_now = Rotation.from_matrix(R_d) * Rotation.from_rotvec(eta)
        L = L_G - m * np.cross(r - R_G, v)
        Omega = np.linalg.solve(I_B, R_now.inv().apply(L) - h_joints)
        deta = eta_rate(R_now, R_now.apply(Omega), Rotation.from_matrix(R_d), Omega_d)
        return np.concatenate([v, a, moment + np.cross(r - R_G, m * GRAVITY), deta])

    x0 = centroidal_state(r_d, v_d, L_d, np.zeros(3), R_G, m)
    u0 = rng.normal(size=10) * 50
    A, C = system_matrices(about, R_G, m, NO_WRENCH)
    B = input_matrices(p[None], R[None], R_G, m, 5)
    np.testing.assert_allclose(A[0] @ x0 + B[0] @ u0 + C[0], rhs(x0, u0), atol=1e-8)
    h = 1e-4
    A_numeric = [(rhs(x0 + h * e, u0) - rhs(x0 - h * e, u0)) / (2 * h) for e in np.eye(12)]
    B_numeric = [(rhs(x0, u0 + e) - rhs(x0, u0 - e)) / 2 for e in np.eye(10)]
    np.testing.assert_allclose(A[0], np.transpose(A_numeric), atol=2e-5)
    np.testing.assert_allclose(B[0], np.transpose(B_numeric), atol=1e-8)


def test_r_G_drops_out_of_a0_and_a1_and_turns_only_what_it_should(humanoid, context, states):
    """Moving r_G changes the state L_G, but not the rate of eta."""
    about = linearisation(humanoid, context, states[-1])
    r, v = put(humanoid, context, perturbed(humanoid, states[-1], 0.1, 5))
    L, eta, m = momentum_about(humanoid, context, r), np.array([0.1, -0.05, 0.2]), humanoid.mass
    rates = []
    for point in (R_G, np.zeros(3), r):
        A, C = system_matrices(about, point, m, NO_WRENCH)
        rates.append((A[0] @ centroidal_state(r, v, L, eta, point, m) + C[0])[9:])
    np.testing.assert_allclose(rates[1], rates[0], atol=1e-11)
    np.testing.assert_allclose(rates[2], rates[0], atol=1e-11)


def test_stacks_are_the_single_intervals(humanoid, context, states):
    singles = [linearisation(humanoid, context, x) for x in states[:3]]
    fields = ("I_B", "R_d", "Omega_d", "L_d", "r_d", "v_d")
    stack = Linearisation(*(np.concatenate([getattr(s, f) for s in singles]) for f in fields))
    A, C = system_matrices(stack, R_G, humanoid.mass, NO_WRENCH)
    terms = orientation_terms(stack, R_G, humanoid.mass)
    assert [t.shape for t in terms] == [(3, 3)] + [(3, 3, 3)] * 4
    for k, single in enumerate(singles):
        row = np.column_stack([term[k] for term in terms])
        np.testing.assert_array_equal(row, np.c_[C[k, 9:], A[k, 9:]])
        a, c = system_matrices(single, R_G, humanoid.mass, NO_WRENCH)
        np.testing.assert_allclose(A[k], a[0], rtol=1e-13, atol=1e-13)
        np.testing.assert_allclose(C[k], c[0], rtol=1e-13, atol=1e-13)
