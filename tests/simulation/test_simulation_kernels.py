"""What the recorder computes of many samples against one sample after the other."""

import numpy as np
import pytest

from drake_linefoot.robot.dynamics import GRAVITY
from drake_linefoot.signals import CentroidalPlan, SolverReport
from drake_linefoot.simulation.kernels import add_contacts, planned_motion

SAMPLES, CONTACTS = 5, 60


def random_contacts(seed):
    """Arguments of `add_contacts`; samples begin before the first row and end after the last."""
    rng = np.random.default_rng(seed)
    return {
        "sample": rng.integers(-2, SAMPLES + 2, CONTACTS),
        "on_A": rng.integers(-1, 2, CONTACTS),
        "on_B": rng.integers(-1, 2, CONTACTS),
        "force": rng.normal(size=3 * CONTACTS),
        "point": rng.normal(size=3 * CONTACTS),
        "speed": rng.uniform(size=CONTACTS),
        "ends": rng.normal(size=(SAMPLES, 2, 2, 3)),
    }


def added(contacts):
    total, normal = np.zeros((SAMPLES, 2, 3)), np.zeros((SAMPLES, 2, 2))
    slip = np.zeros((SAMPLES, 2))
    add_contacts(**contacts, total=total, normal=normal, slip=slip)
    return total, normal, slip


def test_contacts_are_added_to_the_foot_and_to_the_nearer_end():
    contacts = random_contacts(0)
    total, normal, slip = added(contacts)
    expected = np.zeros_like(total), np.zeros_like(normal), np.zeros_like(slip)
    forces, points = contacts["force"].reshape(-1, 3), contacts["point"].reshape(-1, 3)
    counted = 0
    for k, i in enumerate(contacts["sample"]):
        side, f = contacts["on_B"][k], forces[k]
        if side < 0:
            side, f = contacts["on_A"][k], -forces[k]
        if side < 0 or not 0 <= i < SAMPLES:
            continue
        counted += 1
        distances = np.linalg.norm(contacts["ends"][i, side] - points[k], axis=1)
        expected[0][i, side] += f
        expected[1][i, side, np.argmin(distances)] += f[2]
        expected[2][i, side] = max(expected[2][i, side], contacts["speed"][k])
    assert CONTACTS / 3 < counted < CONTACTS
    for found, wanted in zip((total, normal, slip), expected, strict=True):
        np.testing.assert_allclose(found, wanted, atol=1e-14)


def test_other_feet_have_the_same_contacts():
    """Sides exchanged: nothing depends on which foot is the left one."""
    contacts = random_contacts(1)
    other = dict(contacts)
    for name in ("on_A", "on_B"):
        other[name] = np.where(contacts[name] < 0, -1, 1 - contacts[name])
    other["ends"] = contacts["ends"][:, ::-1].copy()
    for one, two in zip(added(contacts), added(other), strict=True):
        np.testing.assert_array_equal(two, one[:, ::-1])


@pytest.fixture
def plan():
    rng, K = np.random.default_rng(2), 6
    return CentroidalPlan(
        times=1.0 + np.cumsum(rng.uniform(0.02, 0.05, K + 1)),
        wrench=rng.normal(size=(K, 2, 5)),
        states=rng.normal(size=(K + 1, 12)),
        r_G=rng.normal(size=3),
        mass=24.0,
        p_WC=rng.normal(size=(K, 2, 3)),
        R_WC=rng.normal(size=(K, 2, 3, 3)),
        footholds=np.zeros((0, 4)),
        report=SolverReport(True, "", 1, 1.0),
        failures=0,
    )


def test_a_plan_at_many_times_is_the_plan_at_each(plan):
    """Also at its knots, and beyond its end."""
    middle = 0.5 * (plan.times[1:] + plan.times[:-1])
    t = np.sort([*plan.times, *middle, plan.times[-1] + 0.1])
    k = plan.intervals(t)
    force, moment = plan.resultants
    motion, eta = planned_motion(
        t, k, plan.times, plan.states, plan.r_G, force, moment, plan.mass, GRAVITY
    )
    for i, time in enumerate(t.tolist()):
        s = plan.sample(time, GRAVITY)
        np.testing.assert_array_equal(motion[:, i], [s.r, s.v, s.a, s.L, s.L_dot])
    for axis in range(3):
        between = np.interp(t, plan.times, plan.states[:, 9 + axis])
        np.testing.assert_allclose(eta[:, axis], between, atol=1e-12)
