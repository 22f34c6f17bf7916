"""The tasks against the full plant: what an acceleration that meets them does to the robot."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from drake_linefoot.centroidal import PlanSample
from drake_linefoot.constants import GRAVITY
from drake_linefoot.signals import SwingTarget
from drake_linefoot.wbc.tasks.momentum import momentum_task
from drake_linefoot.wbc.tasks.posture import Joints, joint_task
from drake_linefoot.wbc.tasks.swing import swing_task
from tests.helpers.whole_body import contact_tasks, gains_of


@pytest.fixture(scope="module")
def states(humanoid, walking_state, records):
    return [r.x for r in records[70::60]] + [walking_state(humanoid, seed) for seed in (1, 2, 3)]


def meet(task, nv, seed=0):
    """Some acceleration that meets a task; not the least one."""
    rng = np.random.default_rng(seed)
    free = 10.0 * rng.normal(size=nv)
    return free + np.linalg.lstsq(task.J, task.b - task.J @ free, rcond=None)[0]


def test_contact_rows_are_the_velocity_of_the_line(
    humanoid, states, dynamics_of, advance, full_plant
):
    """J v against central differences of the line's place and direction."""
    h = 1e-6
    for x in states:
        d = dynamics_of(x)
        J = contact_tasks(d, [0, 1], 0.0).J
        assert J.shape == (10, humanoid.nv)
        rate = (J @ d.v).reshape(2, 5)
        for side in (0, 1):
            p0, _ = full_plant.put(advance(humanoid, x, -h)).line(side)
            R0 = humanoid.foot_frames[side].CalcPoseInWorld(full_plant.context).rotation().matrix()
            p1, _ = full_plant.put(advance(humanoid, x, h)).line(side)
            R1 = humanoid.foot_frames[side].CalcPoseInWorld(full_plant.context).rotation().matrix()
            np.testing.assert_allclose(rate[side, :3], (p1 - p0) / (2 * h), atol=1e-7)
            w = Rotation.from_matrix(R1 @ R0.T).as_rotvec() / (2 * h)
            _, R = full_plant.put(x).line(side)
            np.testing.assert_allclose(rate[side, 3:], R[:, 1:].T @ w, atol=1e-6)


@pytest.mark.parametrize("sides", [[0], [1], [0, 1]])
@pytest.mark.parametrize("damping", [0.0, 20.0])
def test_the_contact_task_stops_the_line(humanoid, states, dynamics_of, full_plant, sides, damping):
    """The line's acceleration is - k times its velocity; about itself it may turn."""
    for x in states:
        task = contact_tasks(dynamics_of(x), sides, damping)
        vdot = meet(task, humanoid.nv)
        full_plant.put(x)
        for side in sides:
            a, alpha = full_plant.line_acceleration(side, vdot)
            v, w = full_plant.line_velocity(side)
            _, R = full_plant.line(side)
            np.testing.assert_allclose(a, -damping * v, atol=1e-8)
            np.testing.assert_allclose(R[:, 1:].T @ (alpha + damping * w), 0.0, atol=1e-8)


def test_in_flight_there_is_no_contact_tasks(humanoid, states, dynamics_of):
    task = contact_tasks(dynamics_of(states[0]), [], 1.0)
    assert task.J.shape == (0, humanoid.nv)
    assert task.b.shape == (0,)


def sample(rng):
    motion = rng.normal(size=(5, 3)) * [[1], [1], [3], [2], [5]]
    return PlanSample(*motion, np.zeros((2, 5)))


@pytest.mark.parametrize("gains", [(0.0, 0.0, 0.0), (30.0, 9.0, 12.0)])
def test_the_momentum_task_gives_the_wanted_rates(humanoid, states, dynamics_of, advance, gains):
    """Momentum and CoM velocity of the plant, differentiated along the motion; (52), (53)."""
    plant, m, h = humanoid.plant, humanoid.mass, 1e-5
    context = plant.CreateDefaultContext()
    p = gains_of(
        com_position_gain=gains[0], com_velocity_gain=gains[1], angular_momentum_gain=gains[2]
    )

    def momentum(x):
        plant.SetPositionsAndVelocities(context, x)
        r = plant.CalcCenterOfMassPositionInWorld(context)
        H = plant.CalcSpatialMomentumInWorldAboutPoint(context, r)
        return r, H.translational() / m, H.rotational()

    for seed, x in enumerate(states):
        wanted = sample(np.random.default_rng(seed))
        vdot = meet(momentum_task(dynamics_of(x), wanted, m, p), humanoid.nv, seed)
        before, after = (advance(humanoid, x, s * h) for s in (-1, 1))
        before[humanoid.nq :] -= h * vdot
        after[humanoid.nq :] += h * vdot
        (_, v0, L0), (_, v1, L1) = momentum(before), momentum(after)
        r, v, L = momentum(x)
        a = wanted.a - gains[0] * (r - wanted.r) - gains[1] * (v - wanted.v)
        L_dot = wanted.L_dot - gains[2] * (L - wanted.L)
        np.testing.assert_allclose((v1 - v0) / (2 * h), a, atol=1e-5)
        np.testing.assert_allclose((L1 - L0) / (2 * h), L_dot, atol=1e-5)


def swing_target(line, rng, size):
    """A target `size` away from a line (p, R), moving, and turned by as much."""
    p, R = line
    turn = Rotation.from_rotvec(size * rng.normal(size=3)).as_matrix()
    moved = p + size * rng.normal(size=3)
    rates = rng.normal(size=(2, 3))
    return SwingTarget(moved, *rates, turn @ R[:, 0], *rng.normal(size=(2, 3)))


def test_the_swing_task_is_of_second_order(humanoid, states, dynamics_of, full_plant):
    """e'' + kd e' + kp e = 0 of the line's middle, and of its direction to first order."""
    p = gains_of(swing_position_gain=400.0, swing_velocity_gain=40.0)
    for seed, x in enumerate(states):
        side, rng = seed % 2, np.random.default_rng(seed)
        full_plant.put(x)
        line = full_plant.line(side)
        target = swing_target(line, rng, 1e-4)
        vdot = meet(swing_task(dynamics_of(x), side, target, np.zeros(2), p), humanoid.nv)
        a, alpha = full_plant.line_acceleration(side, vdot)
        v, w = full_plant.line_velocity(side)
        e = target.p_WC - line[0]
        expected = target.a_WC + 40.0 * (target.v_WC - v) + 400.0 * e
        np.testing.assert_allclose(a, expected, atol=1e-8)
        # The rotation that takes the line to the target, by the cosine rule of the sphere.
        R = line[1]
        away = np.cross(R[:, 0], target.d_W)
        across = R[:, 1:].T @ (target.alpha_W + 40.0 * (target.w_W - w) + 400.0 * away)
        np.testing.assert_allclose(R[:, 1:].T @ alpha, across, atol=1e-8)


def test_a_swing_foot_settles_like_a_critically_damped_spring(humanoid, dynamics_of, full_plant):
    """Integrated with nothing but this task: (1 + 40 t) exp(-40 t) of the first error."""
    x0, side = humanoid.x_nominal, 1
    full_plant.put(x0)
    p, R = full_plant.line(side)
    turn = Rotation.from_euler("ZY", [0.12, 0.08]).as_matrix()
    zero = np.zeros(3)
    away = np.array([0.03, -0.02, 0.04])
    target = SwingTarget(p + away, zero, zero, turn @ R[:, 0], zero, zero)
    nq, gains = humanoid.nq, gains_of()

    def rate(t, x):
        task = swing_task(dynamics_of(x), side, target, np.zeros(2), gains)
        vdot = np.linalg.lstsq(task.J, task.b, rcond=None)[0]
        qdot = humanoid.plant.MapVelocityToQDot(full_plant.put(x).context, x[nq:])
        return np.concatenate([qdot, vdot])

    times = np.array([0.01, 0.03, 0.06, 0.12])
    motion = solve_ivp(rate, (0.0, times[-1]), x0, t_eval=times, rtol=1e-6, atol=1e-8)
    for t, x in zip(times, motion.y.T, strict=True):
        left = (1.0 + 40.0 * t) * np.exp(-40.0 * t)
        p_now, R_now = full_plant.put(x).line(side)
        np.testing.assert_allclose(target.p_WC - p_now, left * (target.p_WC - p), atol=1e-6)
        angle = np.arccos(np.clip(R_now[:, 0] @ target.d_W, -1.0, 1.0))
        first = np.arccos(R[:, 0] @ target.d_W)
        assert angle == pytest.approx(left * first, rel=0.01, abs=1e-4)


def test_a_target_that_is_met_asks_for_its_own_acceleration(
    humanoid, states, dynamics_of, full_plant
):
    for x in states:
        d = dynamics_of(x)
        p, R = full_plant.put(x).line(0)
        v, w = full_plant.line_velocity(0)
        target = SwingTarget(p, v, np.array([1.0, -2.0, 3.0]), R[:, 0].copy(), w, np.zeros(3))
        gains = [gains_of(), gains_of(swing_position_gain=1.0)]
        tasks = [swing_task(d, 0, target, np.zeros(2), g) for g in gains]
        np.testing.assert_allclose(tasks[0].b, tasks[1].b, atol=1e-9)
        a, _ = full_plant.line_acceleration(0, meet(tasks[0], humanoid.nv))
        np.testing.assert_allclose(a, target.a_WC, atol=1e-8)


def test_the_joint_task_holds_the_arms_or_lets_them_follow(humanoid, states, dynamics_of):
    """e'' + kd e' + kp e = 0 of these joints only, e from a motion that all turn with or none."""
    gains = gains_of(arm_position_gain=100.0, arm_velocity_gain=20.0)
    for x in states:
        d = dynamics_of(x)
        goal, turns = humanoid.q_nominal[humanoid.arm_q] + 0.1, np.zeros(len(humanoid.arm_q))
        turns[0], motion = -1.0, np.array([0.2, 3.0, -5.0])
        arms = Joints(humanoid.arm_q, humanoid.arm_v, goal, turns)
        task = joint_task(d, arms, motion, gains)
        vdot = meet(task, humanoid.nv)
        q, v = x[: humanoid.nq][humanoid.arm_q], x[humanoid.nq :][humanoid.arm_v]
        expected = 100.0 * (goal - q) - 20.0 * v
        expected[0] = 5.0 + 100.0 * (goal[0] - 0.2 - q[0]) + 20.0 * (-3.0 - v[0])
        np.testing.assert_allclose(vdot[humanoid.arm_v], expected, atol=1e-9)
        assert np.linalg.matrix_rank(task.J) == len(humanoid.arm_v)
        assert np.count_nonzero(task.J) == len(humanoid.arm_v)


def test_gravity_is_that_of_the_plant(humanoid):
    g = humanoid.plant.gravity_field().gravity_vector()
    np.testing.assert_array_equal(g, GRAVITY)
