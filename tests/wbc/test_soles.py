"""Feet that are surfaces: a swinging one lies down on the ground; ankles at their stops."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from drake_linefoot.axes import TAU_X, TAU_Y
from drake_linefoot.centroidal import PlanSample
from drake_linefoot.robot.dynamics import robot_dynamics
from drake_linefoot.signals import SwingTarget
from drake_linefoot.wbc.control import WholeBodyControl
from drake_linefoot.wbc.joint_limits import acceleration_within_limits, leg_limits, rows_at_limits
from drake_linefoot.wbc.parameters import WbcParameters
from drake_linefoot.wbc.tasks.contact import contact_task
from drake_linefoot.wbc.tasks.momentum import momentum_task
from drake_linefoot.wbc.tasks.swing import swing_task
from drake_linefoot.wbc.tasks.task import TaskRows
from tests.helpers.whole_body import prioritised, stack_of
from tests.wbc.conftest import FullPlant

PITCH, ROLL = 4, 5  # joints of the ankle
SIDES = pytest.mark.parametrize("side", [0, 1])


@pytest.fixture(scope="module")
def control(sole_biped):
    return WholeBodyControl(sole_biped, WbcParameters())


@pytest.fixture(scope="module")
def states(sole_biped, walking_state):
    return [walking_state(sole_biped, seed, speed=0.3) for seed in range(4)]


def dynamics(robot, x):
    return robot_dynamics(robot, robot.scratch, x)


def flat_on(d_W, slope):
    """Axes of a sole that points along d_W, its y in a plane of some slope."""
    normal = np.array([-slope[0], -slope[1], 1.0])
    y = np.cross(normal, d_W)
    y /= np.linalg.norm(y)
    return np.column_stack([d_W, y, np.cross(d_W, y)])


def unit(v):
    return v / np.linalg.norm(v)


@SIDES
def test_the_swing_task_turns_a_sole_about_all_axes(sole_biped, states, control, side):
    """alpha = alpha_d + kd (w_d - w) + kp times the rotation to a sole flat on the ground."""
    plant, gains, rng = FullPlant(sole_biped), control.constants.gains, np.random.default_rng(side)
    kp, kd = gains.swing_position, gains.swing_velocity
    for x in states:
        d, slope = dynamics(sole_biped, x), 0.2 * rng.normal(size=2)
        ahead = d.R_WC[side, :, 0]
        rest = rng.normal(size=(5, 3))
        target = SwingTarget(*rest[:3], unit(ahead + 0.1 * rng.normal(size=3)), *rest[3:])
        task = swing_task(d, side, target, slope, gains)
        vdot = np.linalg.lstsq(task.J, task.b, rcond=None)[0]
        np.testing.assert_allclose(task.J @ vdot, task.b, atol=1e-7)
        a, alpha = plant.put(x).line_acceleration(side, vdot)
        v, w = plant.line_velocity(side)
        X = sole_biped.foot_frames[side].CalcPoseInWorld(plant.context)
        error = Rotation.from_matrix(flat_on(target.d_W, slope) @ X.rotation().matrix().T)
        expected = target.alpha_W + kd * (target.w_W - w) + kp * error.as_rotvec()
        np.testing.assert_allclose(alpha, expected, atol=1e-6)
        place = X @ sole_biped.p_FC[side]
        expected = target.a_WC + kd * (target.v_WC - v) + kp * (target.p_WC - place)
        np.testing.assert_allclose(a, expected, atol=1e-6)


def test_a_swinging_sole_comes_to_lie_on_a_side_slope(sole_biped, control):
    """Integrated with nothing but this task: its normal is the ground's, whatever it was."""
    robot, gains, slope, side = sole_biped, control.constants.gains, np.array([0.0, 0.17]), 1
    plant, x0 = FullPlant(robot), robot.x_nominal
    p, zero = plant.put(x0).line(side)[0], np.zeros(3)
    target = SwingTarget(p + 0.05 * np.eye(3)[2], zero, zero, np.eye(3)[0], zero, zero)

    def rate(t, x):
        task = swing_task(dynamics(robot, x), side, target, slope, gains)
        vdot = np.linalg.lstsq(task.J, task.b, rcond=None)[0]
        qdot = robot.plant.MapVelocityToQDot(plant.put(x).context, x[robot.nq :])
        return np.concatenate([qdot, vdot])

    x = solve_ivp(rate, (0.0, 0.4), x0, rtol=1e-5, atol=1e-7).y[:, -1]
    plant.put(x)
    R = robot.foot_frames[side].CalcPoseInWorld(plant.context).rotation().matrix()
    np.testing.assert_allclose(R[:, 2], unit(np.array([0.0, -0.17, 1.0])), atol=1e-4)
    np.testing.assert_allclose(R[:, 0], [1.0, 0.0, 0.0], atol=1e-4)


def standing_still(d):
    """A plan that asks for nothing."""
    zero = np.zeros(3)
    return PlanSample(d.p_WG, d.v_WG, zero, d.L_G, zero, np.zeros((2, 6)))


def driven(robot, limits, x, side, joint, rate):
    """Dynamics with a joint at its stop and moving towards it, and its least braking."""
    x = x.copy()
    x[limits.index_q[side, joint]] = (limits.lower if rate < 0.0 else limits.upper)[side, joint]
    x[robot.nq + limits.index_v[side, joint]] = rate
    bound = -2.0 * limits.rate * rate
    return dynamics(robot, x), bound


def accelerated(control, d, contact, slope=(0.0, 0.0)):
    """A tick on standing feet, the others to lie on a slope where they are: vdot, plan, targets."""
    swing = np.zeros((2, 6, 3))
    swing[:, 0], swing[:, 3] = d.p_WC, d.R_WC[:, :, 0]
    standing = np.array(contact, dtype=float)
    targets = SimpleNamespace(
        contact=standing,
        swings=1.0 - standing,
        swing=swing,
        slope=np.tile(slope, (2, 1)),
        arms=np.zeros(3),
    )
    plan = standing_still(d)
    tasks, places, feet = stack_of(control, d, targets, plan)
    limits = control.constants.limits
    vdot, dropped, positive = acceleration_within_limits(d, tasks, places, feet[:2], limits)
    assert positive and dropped == 0
    return vdot, plan, swing


@SIDES
@pytest.mark.parametrize(("joint", "row"), [(PITCH, TAU_Y), (ROLL, TAU_X)])
@pytest.mark.parametrize("rate", [-6.0, 6.0])
def test_a_standing_sole_tips_over_the_edge_its_ankle_stops_at(
    sole_biped, states, control, side, joint, row, rate
):
    """That turn of the foot is given up alone: its place, its other turns, momentum are met."""
    c = control.constants
    for x in states:
        d, bound = driven(sole_biped, c.limits, x, side, joint, rate)
        vdot, plan, _ = accelerated(control, d, [side == 0, side == 1])
        assert vdot[c.limits.index_v[side, joint]] == pytest.approx(bound, abs=1e-6)
        task = contact_task(d, side, c.gains)
        missed = np.abs(task.J @ vdot - task.b)
        np.testing.assert_allclose(np.delete(missed, row), 0.0, atol=1e-6)
        assert missed[row] > 1.0
        task = momentum_task(d, plan, c.mass, c.gains)
        np.testing.assert_allclose(task.J @ vdot, task.b, atol=1e-6)


@SIDES
def test_a_swinging_sole_goes_on_to_its_place_with_its_roll_at_the_stop(
    sole_biped, states, control, side
):
    c = control.constants
    sign = 1.0 if side else -1.0
    for x in states:
        d, bound = driven(sole_biped, c.limits, x, side, ROLL, sign * 6.0)
        farther = Rotation.from_rotvec(0.5 * sign * d.R_WC[side, :, 0]).apply(d.R_WC[side, :, 2])
        slope = -farther[:2] / farther[2]
        vdot, _, swing = accelerated(control, d, [side == 1, side == 0], slope)
        assert vdot[c.limits.index_v[side, ROLL]] == pytest.approx(bound, abs=1e-6)
        task = swing_task(d, side, SwingTarget(*swing[side]), slope, c.gains)
        missed = np.abs(task.J @ vdot - task.b)
        assert missed[3:].max() > 1.0
        # A radian is given up for `pitch_length`: 5 cm of a robot of the shipped one's size.
        assert missed[:3].max() < 0.1 * c.limits.pitch_length * missed[3:].max()


@pytest.mark.parametrize("joints", [{ROLL: 40.0}, {3: 30.0, ROLL: -10.0}])
def test_with_held_joints_the_others_do_their_best(sole_biped, states, control, joints):
    """No other motion of the leg comes nearer to the task of the foot, by weighted squares."""
    h, c = sole_biped, control.constants
    weights = np.array([1.0] * 3 + [c.limits.pitch_length] * 3)
    for x in states:
        d, leg, rng = dynamics(h, x), h.leg_v[0], np.random.default_rng(0)
        target = SwingTarget(*rng.normal(size=(3, 3)), d.R_WC[0, :, 0], *rng.normal(size=(2, 3)))
        task = swing_task(d, 0, target, np.array([0.0, 0.1]), c.gains)
        which, a = np.zeros(6, dtype=bool), np.zeros(6)
        which[list(joints)], a[list(joints)] = True, list(joints.values())
        held = rows_at_limits(task, leg, which, a, c.limits.pitch_length)
        assert len(held.b) == 6
        base = TaskRows(np.eye(h.nv)[:6], np.zeros(6))
        vdot, dropped = prioritised(d.M, [base, held])
        assert dropped == 0
        np.testing.assert_allclose(vdot[leg[list(joints)]], list(joints.values()), atol=1e-8)
        free = leg[~which]
        given = np.zeros(h.nv)
        given[leg[which]] = a[which]
        J = weights[:, None] * task.J
        best, *_ = np.linalg.lstsq(J[:, free], weights * task.b - J @ given, rcond=None)
        np.testing.assert_allclose(vdot[free], best, rtol=1e-6, atol=1e-6)


def test_the_limits_are_those_of_all_six_joints(sole_biped):
    limits = leg_limits(sole_biped, WbcParameters())
    for side, foot in enumerate(sole_biped.description.feet):
        joints = [sole_biped.plant.GetJointByName(name) for name in foot.leg_joints]
        lower = [joint.position_lower_limit() for joint in joints]
        margin = WbcParameters().joint_limit_margin
        np.testing.assert_allclose(limits.lower[side], np.array(lower) + margin)
    assert (limits.knee, limits.ankle, limits.roll) == (3, PITCH, ROLL)
