"""Joints of the legs that are kept off their limits."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drake_linefoot.centroidal import sample_plan
from drake_linefoot.wbc.held_joints import limited_acceleration
from drake_linefoot.wbc.joint_limits import (
    acceleration_within_limits,
    leg_limits,
    rows_at_limits,
)
from drake_linefoot.wbc.parameters import WbcParameters
from drake_linefoot.wbc.tasks.momentum import momentum_task
from drake_linefoot.wbc.tasks.swing import swing_task
from drake_linefoot.wbc.tasks.task import TaskRows
from tests.helpers.feet import feet_of
from tests.helpers.walking import robot
from tests.helpers.whole_body import (
    computed,
    contact_tasks,
    controller_of,
    foot_in_the_air,
    gains_of,
    prioritised,
    stack_of,
    standing,
)

RATE, MARGIN = WbcParameters().joint_limit_rate, WbcParameters().joint_limit_margin
DAMPING = WbcParameters().contact_velocity_gain
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
            a, _ = limited_acceleration(
                x, rate_of, np.array([-sign * abs(wish)]), lower, upper, RATE
            )
            rate_of = rate_of + DT * a
            x = x + DT * rate_of
            assert sign * x[0] > -1e-3 - 0.005 * q


def test_far_from_the_stops_nothing_changes():
    a = np.array([300.0, -200.0])
    found, changed = limited_acceleration(np.zeros(2), np.ones(2), a, -np.ones(2), np.ones(2), RATE)
    assert not changed.any()
    np.testing.assert_array_equal(found, a)


@pytest.fixture(scope="module")
def swinging(records):
    return [r for r in records if r.targets.swings.any()]


def test_a_walk_hardly_needs_it(swinging):
    """Only the ankle, where the trailing foot is lifted, comes near its stop."""
    h, held = robot(), []
    limits = leg_limits(h, WbcParameters())
    for r in swinging:
        stance = 1 - foot_in_the_air(r.targets)
        q, v, a = r.x[h.leg_q[stance]], r.x[h.nq + h.leg_v[stance]], r.report.vdot[h.leg_v[stance]]
        assert not limited_acceleration(q, v, a, limits.lower[stance], limits.upper[stance], RATE)[
            1
        ].any()
        side = foot_in_the_air(r.targets)
        q, v, a = r.x[h.leg_q[side]], r.x[h.nq + h.leg_v[side]], r.report.vdot[h.leg_v[side]]
        allowed, _ = limited_acceleration(q, v, a, limits.lower[side], limits.upper[side], RATE)
        np.testing.assert_allclose(a, allowed, atol=1e-6)
        held.append(np.abs(a - allowed).max() > 0.0)
        assert np.flatnonzero(a != allowed).tolist() in ([], [ANKLE])
    assert np.mean(held) < 0.15


def swing_rows(r, dynamics):
    side = foot_in_the_air(r.targets)
    return side, swing_task(dynamics, side, r.targets.swing_target(side), np.zeros(2), gains_of())


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
        held = rows_at_limits(task, leg, which, a, WbcParameters().pitch_length)
        base = TaskRows(np.eye(h.nv)[:6], np.zeros(6))
        arms = TaskRows(np.eye(h.nv)[h.arm_v], np.zeros(len(h.arm_v)))
        vdot, dropped = prioritised(d.M, [base, arms, held])
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
    side = foot_in_the_air(r.targets)
    away = feet_of(dynamics)[side].p_WC - dynamics.p_WB
    away /= np.linalg.norm(away)
    beyond = feet_of(dynamics)[side].p_WC + 0.4 * away
    swing = r.targets.swing.copy()
    swing[side] = r.targets.swing_target(side)._replace(p_WC=beyond)
    return side, r.targets._replace(swing=swing)


def test_a_foot_beyond_reach_does_not_stretch_the_knee(swinging, dynamics_of):
    """The knee is slowed down before it is straight, by torques that the joints have."""
    h = robot()
    control, free = controller_of(), controller_of(joint_limit_margin=0.0, joint_limit_rate=1e4)
    held = 0
    for r in swinging:
        x = r.x.copy()
        side = foot_in_the_air(r.targets)
        x[h.leg_q[side, KNEE]] = 0.15
        x[h.nq + h.leg_v[side, KNEE]] = -4.0
        d = dynamics_of(x)
        side, targets = stretched(r, d)
        knee = h.leg_v[side, KNEE]
        slowed = computed(control, d, targets, r.plan).vdot[knee]
        bound = RATE * (RATE * (MARGIN - 0.15) - 2.0 * -4.0)
        assert slowed >= bound - 1e-6
        held += computed(free, d, targets, r.plan).vdot[knee] < bound - 100.0
    assert held > len(swinging) / 2


def driven(x, dynamics_of, joints):
    """The state with joints of legs 0.1 rad from their stops and at a rate [rad/s] towards them.

    Returns:
        Dynamics of it, and the least and greatest acceleration [rad/s^2] of each joint.
    """
    h, x, bounds = robot(), x.copy(), []
    limits = leg_limits(h, WbcParameters())
    for (side, joint), rate in joints.items():
        end = (limits.lower if rate < 0.0 else limits.upper)[side, joint]
        x[limits.index_q[side, joint]] = end - 0.1 * np.sign(rate)
        x[h.nq + limits.index_v[side, joint]] = rate
        bounds.append(RATE * (RATE * 0.1 * np.sign(rate) - 2.0 * rate))
    return dynamics_of(x), bounds


def missed(task, vdot):
    return np.abs(task.J @ vdot - task.b)


def test_two_feet_in_the_air_are_held_off_their_stops_each(swinging, dynamics_of):
    """The knee of one is at its stop: the other foot goes where it is told, whichever it is."""
    control = controller_of()
    for r in swinging[::5]:
        for side in (0, 1):
            d, (bound,) = driven(r.x, dynamics_of, {(side, KNEE): -6.0})
            swing = np.zeros((2, 6, 3))
            for foot in (0, 1):
                place = feet_of(d)[foot].p_WC
                if foot == side:
                    place = place + 0.4 * (place - d.p_WB) / np.linalg.norm(place - d.p_WB)
                swing[foot, 0], swing[foot, 3] = place, feet_of(d)[foot].R_WC[:, 0]
            air = r.targets._replace(contact=np.zeros(2), swings=np.ones(2), swing=swing)
            vdot, dropped = acceleration(control, d, air, plan_of(r))
            other = swing_task(d, 1 - side, air.swing_target(1 - side), np.zeros(2), gains_of())
            assert dropped == 0
            assert vdot[robot().leg_v[side, KNEE]] == pytest.approx(bound, abs=1e-6)
            np.testing.assert_allclose(missed(other, vdot), 0.0, atol=1e-6)


def plan_of(r, rise=0.0):
    """The plan's motion at a tick, with a vertical acceleration [m/s^2] added."""
    sample = sample_plan(r.plan, r.targets.time)
    return sample._replace(a=sample.a + np.array([0.0, 0.0, rise]))


def acceleration(control, d, targets, plan):
    """What a tick desires for a sample of a plan, with any torque; how many rows it drops."""
    tasks, places, feet = stack_of(control, d, targets, plan)
    limits = control.constants.limits
    limits = limits._replace(effort=np.full(limits.effort.shape, np.inf))
    vdot, dropped, positive = acceleration_within_limits(d, tasks, places, feet[:2], limits)
    assert positive
    return vdot, dropped


def test_a_standing_knee_is_not_stretched_for_the_height(swinging, dynamics_of):
    """The foot stays, five rates of momentum are as planned, the vertical force is given up."""
    h, control, free = (
        robot(),
        controller_of(),
        controller_of(joint_limit_margin=0.0, joint_limit_rate=1e4),
    )
    for r in swinging[::3]:
        side, plan = 1 - foot_in_the_air(r.targets), plan_of(r, rise=20.0)
        knee = h.leg_v[side, KNEE]
        d, (bound,) = driven(r.x, dynamics_of, {(side, KNEE): -6.0})
        vdot, dropped = acceleration(control, d, r.targets, plan)
        assert dropped == 0
        assert vdot[knee] == pytest.approx(bound, abs=1e-6)
        assert acceleration(free, d, r.targets, plan)[0][knee] < bound - 10.0
        feet = missed(contact_tasks(d, [side], DAMPING), vdot)
        momentum = missed(momentum_task(d, plan, h.mass, gains_of()), vdot)
        np.testing.assert_allclose(feet, 0.0, atol=1e-6)
        np.testing.assert_allclose(momentum[:5], 0.0, atol=1e-6)
        assert momentum[5] > 1.0


def test_a_standing_foot_turns_when_its_ankle_is_at_the_stop(swinging, dynamics_of):
    """Its place and yaw stay, and the momentum is as planned."""
    h, control = robot(), controller_of()
    for r in swinging[::3]:
        side, plan = 1 - foot_in_the_air(r.targets), plan_of(r)
        d, (bound,) = driven(r.x, dynamics_of, {(side, ANKLE): -6.0})
        vdot, dropped = acceleration(control, d, r.targets, plan)
        assert dropped == 0
        assert vdot[h.leg_v[side, ANKLE]] == pytest.approx(bound, abs=1e-6)
        feet = missed(contact_tasks(d, [side], DAMPING), vdot)
        np.testing.assert_allclose(feet[[0, 1, 2, 4]], 0.0, atol=1e-6)
        assert feet[3] > 1.0
        momentum = missed(momentum_task(d, plan, h.mass, gains_of()), vdot)
        np.testing.assert_allclose(momentum, 0.0, atol=1e-6)


@pytest.mark.parametrize("worse", [0, 1])
def test_of_two_standing_knees_the_faster_one_is_held(records, dynamics_of, worse):
    """There is one height to give up."""
    h, control = robot(), controller_of()
    both = [r for r in records if all(standing(r.targets))]
    assert len(both) > 3
    for r in both[::3]:
        plan = plan_of(r, rise=20.0)
        rates = {(worse, KNEE): -9.0, (1 - worse, KNEE): -5.0}
        d, (bound, _) = driven(r.x, dynamics_of, rates)
        vdot, dropped = acceleration(control, d, r.targets, plan)
        assert dropped == 0
        assert vdot[h.leg_v[worse, KNEE]] == pytest.approx(bound, abs=1e-6)
        feet = missed(contact_tasks(d, [0, 1], DAMPING), vdot)
        places = [0, 1, 2, 4, 5, 6, 7, 9]  # and yaws; an ankle that is held too turns its foot
        np.testing.assert_allclose(feet[places], 0.0, atol=1e-5)


def test_beside_a_straight_knee_no_joint_is_held_that_is_far_from_its_stops(records, dynamics_of):
    """To rise, a leg that is nearly straight asks joints for thousands of rad/s^2.

    Held at the bound of a stop half a radian away, its ankle would throw the robot up.
    """
    h, control, asked = robot(), controller_of(), []
    for r in [r for r in records if all(standing(r.targets))][::4]:
        for side in range(2):
            x = r.x.copy()
            x[h.leg_q[side, [KNEE, ANKLE]]] = 0.2 * MARGIN, 0.3
            x[h.nq + h.leg_v[side, KNEE]] = -0.3
            d, plan, legs = dynamics_of(x), plan_of(r, rise=60.0), np.ravel(h.leg_v)
            tasks, _, _ = stack_of(control, d, r.targets, plan)
            asked.append(np.abs(prioritised(d.M, [tasks])[0][legs]).max())
            vdot, dropped = acceleration(control, d, r.targets, plan)
            bound = RATE * (RATE * 0.8 * MARGIN + 2.0 * 0.3)  # of the knee
            assert dropped == 0
            assert vdot[h.leg_v[side, KNEE]] == pytest.approx(bound, abs=1e-6)
            assert np.abs(vdot[legs]).max() < bound + 1e-6
    assert np.mean(np.array(asked) > 5000.0) > 0.5
