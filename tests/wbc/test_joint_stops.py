"""Joints of a swinging leg that are kept off their stops."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from walking import robot

from drake_linefoot.signals import SwingTarget
from drake_linefoot.wbc.control import WholeBodyControl, leg_stops
from drake_linefoot.wbc.parameters import WbcParameters
from drake_linefoot.wbc.priorities import RANK_TOLERANCE, TaskRows, prioritised_acceleration
from drake_linefoot.wbc.stop_kernels import held_rows, off_stops
from drake_linefoot.wbc.tasks import swing_task

RATE, MARGIN = WbcParameters().stop_rate, WbcParameters().stop_margin
KNEE, ANKLE = 3, 4  # number in the leg
DT = 1e-4


@given(st.floats(0.0, 1.5), st.floats(-1.0, 1.0), st.floats(-2000.0, 2000.0))
def test_a_joint_driven_at_its_stop_does_not_reach_it(q, speed, wish):
    """Any wish, from any speed that the spring can stop; by integration, at both stops."""
    v = -speed * RATE * q  # a critically damped spring stops v = -rate q just at its end
    for sign in (1.0, -1.0):
        x, rate_of = np.array([sign * q]), np.array([sign * v])
        stop = np.array([0.0]), np.array([np.inf])
        lower, upper = stop if sign > 0 else (-stop[1], stop[0])
        for _ in range(2000):
            a, _ = off_stops(x, rate_of, np.array([-sign * abs(wish)]), lower, upper, RATE)
            rate_of = rate_of + DT * a
            x = x + DT * rate_of
            assert sign * x[0] > -1e-3 - 0.005 * q


def test_far_from_the_stops_nothing_changes():
    a = np.array([300.0, -200.0])
    found, changed = off_stops(np.zeros(2), np.ones(2), a, -np.ones(2), np.ones(2), RATE)
    assert not changed.any()
    np.testing.assert_array_equal(found, a)


@pytest.fixture(scope="module")
def swinging(records):
    return [r for r in records if r.targets.swing is not None]


def test_a_walk_hardly_needs_it(swinging):
    """Only the ankle, where the trailing foot is lifted, comes near its stop."""
    h, held = robot(), []
    stops = leg_stops(h, WbcParameters())
    for r in swinging:
        side = r.targets.contact.index(False)
        q, v, a = r.x[h.leg_q[side]], r.x[h.nq + h.leg_v[side]], r.report.vdot[h.leg_v[side]]
        allowed, _ = off_stops(q, v, a, stops.lower[side], stops.upper[side], RATE)
        np.testing.assert_allclose(a, allowed, atol=1e-6)
        held.append(np.abs(a - allowed).max() > 0.0)
        assert np.flatnonzero(a != allowed).tolist() in ([], [ANKLE])
    assert np.mean(held) < 0.15


def swing_rows(r, dynamics):
    side = r.targets.contact.index(False)
    return side, swing_task(dynamics, side, r.targets.swing, WbcParameters())


@pytest.mark.parametrize("joints", [{ANKLE: 50.0}, {KNEE: -20.0}, {KNEE: 30.0, ANKLE: -10.0}])
def test_held_joints_move_as_told_and_the_others_do_their_best(swinging, dynamics_of, joints):
    """No other motion of the leg comes nearer to the task of the foot, a radian as 5 cm."""
    h = robot()
    weights = np.array([1.0, 1.0, 1.0, 0.05, 0.05])
    for r in swinging[::6]:
        d = dynamics_of(r.x)
        side, task = swing_rows(r, d)
        leg = h.leg_v[side]
        which, a = np.zeros(len(leg), dtype=bool), np.zeros(len(leg))
        which[list(joints)], a[list(joints)] = True, list(joints.values())
        held = TaskRows(*held_rows(task.J, task.b, leg, which, a, RANK_TOLERANCE))
        base = TaskRows(np.eye(h.nv)[:6], np.zeros(6))
        arms = TaskRows(np.eye(h.nv)[h.arm_v], np.zeros(len(h.arm_v)))
        vdot, dropped = prioritised_acceleration(d.M, [base, arms, held])
        assert dropped == 0
        np.testing.assert_allclose(vdot[leg[list(joints)]], list(joints.values()), atol=1e-8)
        free = [j for j in range(len(leg)) if j not in joints]
        given = np.zeros(h.nv)
        given[leg[list(joints)]] = list(joints.values())
        J = weights[:, None] * task.J
        best, *_ = np.linalg.lstsq(J[:, leg[free]], weights * task.b - J @ given, rcond=None)
        np.testing.assert_allclose(vdot[leg[free]], best, rtol=1e-6, atol=1e-6)


def stretched(r, dynamics):
    """A tick whose foot is to go 40 cm further than it is, away from the hip."""
    side = r.targets.contact.index(False)
    away = dynamics.feet[side].p_WC - dynamics.p_WB
    away /= np.linalg.norm(away)
    motion = r.targets.swing.motion.copy()
    motion[0] = dynamics.feet[side].p_WC + 0.4 * away
    return side, replace(r.targets, swing=SwingTarget(motion))


def test_a_foot_beyond_reach_does_not_stretch_the_knee(swinging, dynamics_of):
    """The knee is slowed down before it is straight, by torques that the joints have."""
    h = robot()
    control = WholeBodyControl(h, WbcParameters())
    free = WholeBodyControl(h, WbcParameters(stop_margin=0.0, stop_rate=1e4))
    held = 0
    for r in swinging:
        x = r.x.copy()
        side = r.targets.contact.index(False)
        x[h.leg_q[side, KNEE]] = 0.15
        x[h.nq + h.leg_v[side, KNEE]] = -4.0
        side, targets = stretched(r, dynamics_of(x))
        knee = h.leg_v[side, KNEE]
        slowed = control.compute(x, targets, r.plan).vdot[knee]
        bound = RATE * (RATE * (MARGIN - 0.15) - 2.0 * -4.0)
        assert slowed >= bound - 1e-6
        held += free.compute(x, targets, r.plan).vdot[knee] < bound - 100.0
    assert held > len(swinging) / 2
