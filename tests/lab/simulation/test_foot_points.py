"""Forces, centre of pressure and hull of the points of feet, against mechanics and Qhull."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

from drake_linefoot.lab.simulation.foot_points import (
    OUTLINES,
    centre_of_pressure,
    ends_of,
    forces_at_points,
    hull_of,
    place_in,
    sole_frame,
)
from tests.helpers.cones import wrench_from_points

X, Y = 0.1, 0.03
LINE = np.array([[-X, 0.0, 0.0], [X, 0.0, 0.0]])
SOLE = np.array([[-X, Y, 0.0], [-X, -Y, 0.0], [X, Y, 0.0], [X, -Y, 0.0]])
MIDDLE = np.array([0.4, -0.2, 0.05])
seeds = st.integers(0, 2**32 - 1)


def turned(points, rpy):
    """Points of a foot somewhere in W, and their frame."""
    R = Rotation.from_euler("xyz", rpy).as_matrix()
    return MIDDLE + points @ R.T, R


@given(seeds)
def test_forces_on_a_line_are_those_that_the_wrench_came_from(seed):
    """To the side and along the normal; ahead they only have their sum."""
    heel, toe = np.random.default_rng(seed).uniform([0, -50, 10], [0, 50, 200], (2, 3))
    wrench = wrench_from_points(heel, toe, X)
    points, R = turned(LINE, [0.0, -0.1, 0.7])
    wrench[:3] = R @ wrench[:3]
    np.testing.assert_allclose(forces_at_points(wrench, points), [R @ heel, R @ toe], atol=1e-9)


@given(seeds)
def test_forces_on_a_sole_add_up_to_its_wrench_and_press(seed):
    """Wherever in the sole the pressure is no corner pulls."""
    random = np.random.default_rng(seed)
    ahead, left = random.uniform(-1.0, 1.0, 2)
    f, tau_z = random.uniform([-80, -80, 50], [80, 80, 300]), random.uniform(-5.0, 5.0)
    tau = np.array([f[2] * left * Y, -f[2] * ahead * X, tau_z])
    points, R = turned(SOLE, random.uniform([-0.3, -0.3, -3.0], [0.3, 0.3, 3.0]))
    forces = forces_at_points(np.concatenate([R @ f, tau[[1, 2, 0]]]), points)
    np.testing.assert_allclose(forces.sum(axis=0), R @ f, atol=1e-9)
    moment = np.cross(points - MIDDLE, forces).sum(axis=0)
    np.testing.assert_allclose(moment, R @ tau, atol=1e-9)
    normal = forces @ R[:, 2]
    assert normal.min() > -1e-9
    np.testing.assert_allclose(centre_of_pressure(normal), [ahead, left], atol=1e-9)
    place = place_in(points, centre_of_pressure(normal))
    np.testing.assert_allclose(place, MIDDLE + R @ [ahead * X, left * Y, 0.0], atol=1e-9)


def test_without_a_load_there_is_no_force_and_no_centre():
    for points in (LINE, SOLE):
        assert (forces_at_points(np.zeros(6), points) == 0.0).all()
        centre = centre_of_pressure(np.zeros((3, 2, len(points))))
        assert centre.shape == (3, 2, 2)
        assert np.isnan(centre).all()


def test_on_a_line_the_centre_is_in_its_middle_across():
    np.testing.assert_allclose(centre_of_pressure(np.array([30.0, 90.0])), [0.5, 0.0])


def test_a_sole_has_its_ends_in_the_middle_and_its_frame():
    points, R = turned(SOLE, [0.2, -0.1, 0.5])
    np.testing.assert_allclose(ends_of(points), MIDDLE + LINE @ R.T, atol=1e-12)
    np.testing.assert_allclose(sole_frame(points), R, atol=1e-12)
    level, _ = turned(LINE, [0.2, -0.1, 0.5])
    np.testing.assert_allclose(sole_frame(level)[2, 1], 0.0, atol=1e-12)  # y of a line is level
    np.testing.assert_array_equal(ends_of(LINE), LINE)


@pytest.mark.parametrize("points", [LINE, SOLE])
def test_an_outline_goes_along_the_edges(points):
    steps = np.diff(points[list(OUTLINES[len(points)])], axis=0)
    assert (np.count_nonzero(steps, axis=1) == 1).all()  # no diagonal
    length = {2: 2.0 * X, 4: 4.0 * (X + Y)}[len(points)]
    assert np.linalg.norm(steps, axis=1).sum() == pytest.approx(length)


@given(seeds, st.integers(3, 12))
def test_the_hull_is_that_of_qhull(seed, count):
    points = np.random.default_rng(seed).uniform(-1.0, 1.0, (count, 2))
    hull = hull_of(points).tolist()
    wanted = ConvexHull(points).vertices.tolist()  # counterclockwise
    at = wanted.index(hull[0])
    assert hull == wanted[at:] + wanted[:at]


def test_the_hull_of_few_points():
    assert hull_of(np.empty((0, 3))).tolist() == []
    assert hull_of(LINE[:1]).tolist() == [0]
    assert hull_of(LINE).tolist() == [0, 1]
    assert len(hull_of(np.concatenate([LINE, 0.5 * LINE]))) == 2  # on one line
