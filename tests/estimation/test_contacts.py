"""Estimates of contact wrenches of six numbers, on a robot with soles."""

import numpy as np
import pytest
from scipy.optimize import nnls

from drake_linefoot.constants import STANDARD_GRAVITY
from drake_linefoot.estimation.external_wrench import external_wrench, on_base
from drake_linefoot.estimation.wrench_estimate import ConstrainedEstimate, estimate_wrenches
from drake_linefoot.math.compiled import as_python
from drake_linefoot.robot.dynamics import robot_dynamics
from tests.helpers.cones import grasp

MU, SEEDS = 0.8, pytest.mark.parametrize("seed", range(5))


def dynamics(robot, walking_state, seed):
    context = robot.plant.CreateDefaultContext()
    d = robot_dynamics(robot, context, walking_state(robot, seed, tilt=0.05))
    R = d.R_WC.copy()
    R[:, :, 1] = np.cross([0.0, 0.0, 1.0], R[:, :, 0])  # as the ground is: level across the feet
    R[:, :, 1] /= np.linalg.norm(R[:, :, 1], axis=1)[:, None]
    R[:, :, 2] = np.cross(R[:, :, 0], R[:, :, 1])
    return d, R


def generalized(J, wrench):
    return np.einsum("fij,fi->j", J, wrench)


@SEEDS
def test_six_numbers_of_each_foot_are_found(sole_biped, walking_state, seed):
    d, _ = dynamics(sole_biped, walking_state, seed)
    wrench = 100.0 * np.random.default_rng(seed).normal(size=(2, 6))
    assert d.J.shape == (2, 6, sole_biped.nv)
    found = estimate_wrenches(generalized(d.J, wrench), d.J)
    np.testing.assert_allclose(found, wrench, atol=1e-8)


@SEEDS
def test_what_else_acts_is_told_from_the_feet(sole_biped, walking_state, seed):
    """Six joints of a leg tell six numbers, whatever pulls at the torso."""
    d, _ = dynamics(sole_biped, walking_state, seed)
    rng, lever = np.random.default_rng(seed), d.p_WG - d.p_WB
    wrench, pull = 100.0 * rng.normal(size=(2, 6)), 20.0 * rng.normal(size=6)
    force = generalized(d.J, wrench)
    force[:6] += on_base(pull, lever)
    found, told = as_python(external_wrench)(force, d.J, lever, sole_biped.leg_v)
    assert told
    np.testing.assert_allclose(found, pull, atol=1e-8)


def corner_rays(contact, R):
    """Wrenches of the edges of the friction pyramids of all corners, forces in W, shape (16, 6)."""
    edges = [np.array([a * MU, b * MU, 1.0]) for a in (-1, 1) for b in (-1, 1)]
    rays = []
    for corner in range(4):
        for edge in edges:
            w = (
                grasp(contact.half_length, contact.half_width)[:, 3 * corner : 3 * corner + 3]
                @ edge
            )
            rays.append([*(R @ w[:3]), *w[3:]])
    return np.array(rays)


@SEEDS
@pytest.mark.parametrize("pulled", [0.0, 60.0])
def test_the_constrained_estimate_is_the_best_that_corners_can_give(
    sole_biped, walking_state, seed, pulled
):
    """(22) against non-negative least squares over forces at the corners."""
    d, R = dynamics(sole_biped, walking_state, seed)
    rng, contact = np.random.default_rng(seed), sole_biped.contact
    shares = rng.uniform(0.0, 20.0, size=(2, 16))
    wrench = np.array(
        [s @ corner_rays(contact, R_foot) for s, R_foot in zip(shares, R, strict=True)]
    )
    residual = generalized(d.J, wrench) + pulled * rng.normal(size=sole_biped.nv) / 10.0
    found = ConstrainedEstimate(sole_biped.mass, sole_biped.contact).solve(residual, d.J, R, MU)
    columns = [d.J[side].T @ ray for side in (0, 1) for ray in corner_rays(contact, R[side])]
    best = nnls(np.array(columns).T, residual, maxiter=2000)[1]
    error = np.linalg.norm(residual - generalized(d.J, found))
    assert error == pytest.approx(best, rel=1e-4, abs=1e-3)
    if not pulled:
        weight = sole_biped.mass * STANDARD_GRAVITY
        np.testing.assert_allclose(found, wrench, atol=1e-3 * weight)
