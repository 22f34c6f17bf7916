"""Two point contacts against one line contact: the same motion, the same torques."""

from dataclasses import replace

import numpy as np
import pytest

from drake_linefoot.contact.wrench_cone import (
    line_cone,
    point_cone,
    points_from_wrench,
    wrench_from_points,
)
from drake_linefoot.robot.dynamics import GRAVITY
from drake_linefoot.wbc.control import WholeBodyControl
from drake_linefoot.wbc.parameters import WbcParameters
from drake_linefoot.wbc.priorities import prioritised_acceleration, recursive_acceleration
from drake_linefoot.wbc.tasks import contact_task
from drake_linefoot.wbc.two_point import (
    TwoPointControl,
    TwoPointQp,
    independent_point_task,
    point_contacts,
    point_map,
)

# Without stops of joints, which only the line controller has.
EXACT = WbcParameters(solver="osqp", tolerance=1e-11, stop_margin=0.0, stop_rate=1e4)


@pytest.fixture(scope="module")
def X(humanoid):
    return humanoid.half_length


@pytest.fixture(scope="module")
def some(records):
    return records[::8]


def sides_of(record):
    return [i for i in (0, 1) if record.targets.contact[i]]


def excess(wrench, R, mu, half_length):
    """By how much the worst row of (18) is exceeded [N]."""
    rows = line_cone(mu, half_length) @ np.concatenate([R.T @ wrench[:3], wrench[3:]])
    rows[2:] /= half_length
    return rows.max()


def test_the_map_is_the_velocity_of_two_points_of_a_body(X, walking_state, humanoid, dynamics_of):
    d = dynamics_of(walking_state(humanoid, 3))
    for foot in d.feet:
        w = foot.w_WF - foot.R_WC[:, 0] * (foot.R_WC[:, 0] @ foot.w_WF)
        found = point_map(foot.R_WC, X) @ (foot.J @ d.v)
        for sign, velocity in zip((-1.0, 1.0), found.reshape(2, 3), strict=True):
            arm = sign * X * foot.R_WC[:, 0]
            np.testing.assert_allclose(velocity, foot.v_WC + np.cross(w, arm), atol=1e-12)


def test_its_transpose_adds_two_forces_to_a_wrench(X):
    rng = np.random.default_rng(1)
    f = rng.normal(size=(2, 3))
    expected = wrench_from_points(f[0], f[1], X)
    np.testing.assert_allclose(point_map(np.eye(3), X).T @ f.ravel(), expected, atol=1e-14)


def test_six_rows_have_rank_five(X, records, dynamics_of):
    for record in records[::40]:
        d, sides = dynamics_of(record.x), sides_of(record)
        d = point_contacts(d, sides, X)
        full, kept = contact_task(d, sides, 0.0), independent_point_task(d, sides, 0.0)
        assert full.J.shape[0] == 6 * len(sides)
        assert np.linalg.matrix_rank(full.J) == np.linalg.matrix_rank(kept.J) == 5 * len(sides)
        stacked = np.column_stack([full.J, full.b])
        assert np.linalg.matrix_rank(stacked, tol=1e-9) == 5 * len(sides)


def test_all_ways_to_handle_the_dependent_row_give_the_acceleration_of_the_line(
    humanoid, X, some, dynamics_of
):
    control, gain = WholeBodyControl(humanoid, EXACT), EXACT.contact_velocity_gain
    for record in some:
        d, sides = dynamics_of(record.x), sides_of(record)
        line = control.tasks(d, record.targets, record.plan.sample(record.targets.time, GRAVITY))
        rest = line[1:]
        expected, _ = prioritised_acceleration(d.M, line)
        points = point_contacts(d, sides, X)
        five = [independent_point_task(points, sides, gain), *rest]
        six = [contact_task(points, sides, gain), *rest]
        found, dropped = prioritised_acceleration(d.M, five)
        assert dropped == 0
        scale = 1e-7 * max(1.0, np.abs(expected).max())
        np.testing.assert_allclose(found, expected, atol=scale)
        np.testing.assert_allclose(recursive_acceleration(d.M, six), expected, atol=scale)


@pytest.mark.parametrize("damping", [0.0, 30.0])
def test_the_compiled_acceleration_is_that_of_the_tasks(humanoid, some, dynamics_of, damping):
    for kind in (WholeBodyControl, TwoPointControl):
        control = kind(humanoid, replace(EXACT, contact_velocity_gain=damping))
        for record in some:
            targets = record.targets
            sample = record.plan.sample(targets.time, GRAVITY)
            d = control.contacts(dynamics_of(record.x), sides_of(record))
            found, dropped = control.acceleration(d, targets, sample)
            expected, count = prioritised_acceleration(d.M, control.tasks(d, targets, sample))
            assert dropped == count
            np.testing.assert_allclose(found, expected, rtol=0, atol=1e-10)


def test_a_foot_in_the_air_has_no_rows(X, some, dynamics_of):
    d = point_contacts(dynamics_of(some[0].x), [], X)
    assert independent_point_task(d, [], 0.0).J.shape == (0, 24)
    with pytest.raises(TypeError, match="point_contacts"):
        independent_point_task(d, [0], 0.0)


def test_torques_are_those_of_the_line(humanoid, some, dynamics_of, X):
    """To 1e-6 wherever the MPC's wrench is inside its cone, whatever the solver does then."""
    line, points = WholeBodyControl(humanoid, EXACT), TwoPointControl(humanoid, EXACT)
    used = set()
    for r in some:
        d = dynamics_of(r.x)
        wrench = r.plan.sample(r.targets.time, GRAVITY).wrench
        if any(excess(wrench[i], d.feet[i].R_WC, EXACT.friction, X) > 1e-3 for i in sides_of(r)):
            continue
        one = line.compute(r.x, r.targets, r.plan)
        two = points.compute(r.x, r.targets, r.plan)
        used |= {(one.status, r.targets.contact)}
        scale = np.abs(one.torque).max()
        np.testing.assert_allclose(two.torque, one.torque, atol=1e-6 * scale)
        np.testing.assert_allclose(two.wrench, one.wrench, atol=1e-6 * np.abs(one.wrench).max())
    assert {status.split()[-1] for status, _ in used} >= {"unconstrained", "rows"}
    assert {contact for _, contact in used} == {(True, True), (True, False), (False, True)}


def test_forces_are_in_their_pyramids_and_make_the_wrench(humanoid, X, some, dynamics_of):
    qp = TwoPointQp(EXACT, humanoid.mass, X)
    rng = np.random.default_rng(0)
    for record in some:
        d, sides = dynamics_of(record.x), sides_of(record)
        vdot = rng.normal(size=humanoid.nv)
        wrench = record.plan.sample(record.targets.time, GRAVITY).wrench[sides]
        solution = qp.solve(point_contacts(d, sides, X), vdot, sides, wrench)
        assert solution.success
        for side, forces, w in zip(sides, solution.forces, solution.wrench, strict=True):
            R = d.feet[side].R_WC
            local = forces @ R
            assert (local @ point_cone(EXACT.friction).T).max() < 1e-5
            made = wrench_from_points(local[0], local[1], X)
            np.testing.assert_allclose(np.concatenate([R.T @ w[:3], w[3:]]), made, atol=1e-9)


def test_without_a_solution_the_wrench_is_moved_into_the_cone(
    humanoid, some, dynamics_of, X, solver_only
):
    record = next(r for r in some if r.report.status != "unconstrained")
    d, sides = dynamics_of(record.x), sides_of(record)
    wrench = record.plan.sample(record.targets.time, GRAVITY).wrench[sides]
    wrench[:, 0] += 200.0
    given_up = replace(EXACT, max_iterations=1)
    solution = TwoPointQp(given_up, humanoid.mass, X).solve(
        point_contacts(d, sides, X), np.zeros(24), sides, wrench
    )
    assert not solution.success
    for side, w in zip(sides, solution.wrench, strict=True):
        assert excess(w, d.feet[side].R_WC, EXACT.friction, X) < 1e-6
    missing = d.M[:6] @ np.zeros(24) + d.Cv[:6] - d.tau_g[:6]
    pushed = sum(d.feet[i].J[:, :6].T @ w for i, w in zip(sides, solution.wrench, strict=True))
    np.testing.assert_allclose(d.M[:6, :6] @ solution.delta_f, pushed - missing, atol=1e-7)


def test_nothing_stands(humanoid, X, some, dynamics_of):
    solution = TwoPointQp(EXACT, humanoid.mass, X).solve(
        dynamics_of(some[0].x), np.zeros(24), [], np.zeros((0, 5))
    )
    assert solution.status == "flight"


def test_the_wish_is_split_in_proportion_to_the_normal_forces(humanoid, X, some, dynamics_of):
    qp = TwoPointQp(EXACT, humanoid.mass, X)
    record = some[5]
    d, sides = dynamics_of(record.x), sides_of(record)
    wrench = np.tile([20.0, -10.0, 150.0, 4.0, -1.0], (len(sides), 1))
    program = qp.program(point_contacts(d, sides, X), np.zeros(24), sides, wrench)
    for side, u, w in zip(sides, program.u, wrench, strict=True):
        R = d.feet[side].R_WC
        expected = points_from_wrench(np.concatenate([R.T @ w[:3], w[3:]]), X, EXACT.friction)
        np.testing.assert_allclose(u.reshape(2, 3) @ R, expected, atol=1e-9)
