"""Contacts as data: sizes, units and rows that belong together; one of a user's own."""

import runpy
from pathlib import Path

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.optimize import linprog

from drake_linefoot.constants import STANDARD_GRAVITY
from drake_linefoot.contact.contacts import LineContact
from drake_linefoot.contact.point import PointContact
from drake_linefoot.contact.surface import SurfaceContact
from drake_linefoot.contact.wrench_cone import with_friction
from drake_linefoot.robot.humanoid import load_humanoid

EXAMPLE = Path(__file__).parents[2] / "examples" / "10_own_contact.py"
OctagonalLine = runpy.run_path(str(EXAMPLE))["OctagonalLine"]
X, Y, MU, MASS = 0.07, 0.02, 0.6, 24.0
CONTACTS = [LineContact(X), OctagonalLine(X), PointContact(X), SurfaceContact(X, Y)]
KINDS = pytest.mark.parametrize("contact", CONTACTS, ids=lambda contact: type(contact).__name__)


@KINDS
def test_rows_ends_and_units_have_the_size_of_the_wrench(contact):
    rows, size = contact.cone(MU).shape
    assert (size, len(contact.ends), len(contact.units(MASS))) == (contact.size, rows, size)
    np.testing.assert_allclose(contact.units(MASS)[:3], MASS * STANDARD_GRAVITY)


@pytest.mark.parametrize(
    ("contact", "arms"),
    [(LineContact(X), [X, X]), (PointContact(X), []), (SurfaceContact(X, Y), [X, X + Y, Y])],
)
def test_torques_have_the_unit_of_what_bounds_them(contact, arms):
    """Of a wrench with f_z = 1 and no f_x and f_y, but the friction of a turn."""
    units = contact.units(MASS)
    np.testing.assert_allclose(units[3:] / units[0], arms)
    for column, arm in zip((3, 4, 5), arms, strict=False):
        cost, fixed = np.eye(contact.size)[column], np.eye(contact.size)[:3]
        args = {"A_eq": fixed, "b_eq": [0.0, 0.0, 1.0], "bounds": (None, None)}
        found = linprog(-cost, contact.cone(MU), np.zeros(len(contact.ends)), **args)
        assert -found.fun == pytest.approx(arm * (MU if column == 4 else 1.0))


@KINDS
@given(shares=arrays(float, 6, elements=st.floats(-2.0, 2.0)), mu=st.floats(0.1, 1.5))
def test_the_cone_of_the_scaled_contact_is_that_of_scaled_wrenches(contact, shares, mu):
    z, units = shares[: contact.size], contact.units(MASS)
    in_units = contact.cone(mu) @ (z * units) / units[0]
    np.testing.assert_allclose(contact.scaled().cone(mu) @ z, in_units, atol=1e-12)


@KINDS
@given(mu=st.floats(0.1, 1.5), share=st.floats(0.05, 1.0))
def test_friction_enters_where_it_is_said_to(contact, mu, share):
    """A share of the friction of both ends is a smaller friction: no other column depends on it."""
    less = with_friction(contact.cone(mu), contact.ends, np.full(2, share))
    np.testing.assert_allclose(less, contact.cone(share * mu), atol=1e-12)


def ends_of(w):
    """Forces at heel and toe that are known of a wrench, f_y and f_z; the sum of both f_x."""
    f_y = 0.5 * (w[1] + np.array([-1.0, 1.0]) * w[4] / X)
    f_z = 0.5 * (w[2] - np.array([-1.0, 1.0]) * w[3] / X)
    return f_y, f_z


def least_excess(w):
    """By how much two forces that make a wrench leave their octagons at least: by a program.

    Unknowns: f_x of heel and toe, and the excess s; eight sides at each end.
    """
    f_y, f_z = ends_of(w)
    A, b = [], []
    for end in range(2):
        for k in range(8):
            c, s = np.round([np.cos(k * np.pi / 4), np.sin(k * np.pi / 4)], 12)
            if k % 2:
                c, s = np.sign([c, s])  # |f_x| + |f_y| <= sqrt(2) mu f_z
            row = np.zeros(3)
            row[end], row[2] = c, -1.0
            A.append(row)
            b.append((2**0.5 if k % 2 else 1.0) * MU * f_z[end] - s * f_y[end])
    sums = {"A_eq": [[1.0, 1.0, 0.0]], "b_eq": [w[0]]}
    found = linprog([0, 0, 1], A_ub=A, b_ub=b, bounds=(None, None), **sums)
    assert found.status == 0
    return found.fun


@given(st.lists(st.floats(-1.0, 1.0), min_size=4, max_size=4))
def test_the_octagonal_line_is_two_octagons(shares):
    """Both ways: a wrench is inside its rows when forces at both ends make it."""
    f_z = 200.0
    w = f_z * np.array([shares[0], shares[1], 1.0, shares[2] * X, shares[3] * X])
    excess = least_excess(w)
    assume(abs(excess) > 1e-6)
    assert bool(np.all(OctagonalLine(X).cone(MU) @ w <= 0.0)) == (excess < 0.0)


def test_a_robot_has_the_contact_that_it_is_loaded_with():
    humanoid = load_humanoid("mit_humanoid", contact=OctagonalLine)
    assert isinstance(humanoid.contact, OctagonalLine)
    assert humanoid.contact.half_length == humanoid.half_length
    assert load_humanoid("mit_humanoid").contact == LineContact(humanoid.half_length)


@pytest.mark.parametrize("bad", [0.0, -1.0, np.nan, np.inf])
def test_lengths_and_frictions_that_are_none_are_refused(bad):
    for contact, name in (
        (LineContact(bad), "half length"),
        (SurfaceContact(bad, Y), "half length"),
        (SurfaceContact(X, bad), "half width"),
    ):
        with pytest.raises(ValueError, match=name):
            contact.cone(MU)
    for contact in CONTACTS[2:]:
        with pytest.raises(ValueError, match="friction"):
            contact.cone(bad)
