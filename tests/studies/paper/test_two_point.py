"""Two point contacts against one line contact: the same motion, the same torques."""

import numpy as np
import pytest

from drake_linefoot.centroidal import sample_plan
from drake_linefoot.contact.wrench_cone import LEVEL, line_cone, point_cone, points_from_wrench
from drake_linefoot.statuses import Solved
from drake_linefoot.wbc.control import WholeBodyControl
from drake_linefoot.wbc.parameters import WbcParameters
from drake_linefoot.wbc.priorities import prioritised_acceleration
from drake_linefoot.wbc.wrench_qp import solve_program
from studies.paper.two_point import LineContacts, PointContacts, point_map, recursive_acceleration
from tests.helpers.cones import wrench_from_points
from tests.helpers.feet import feet_of
from tests.helpers.walking import ground_frame
from tests.helpers.whole_body import computed, standing

# Without stops of joints, which neither of the two controllers compared has.
EXACT = WbcParameters(solver="osqp", tolerance=1e-11, joint_limit_margin=0.0, joint_limit_rate=1e4)


@pytest.fixture(scope="module")
def X(humanoid):
    return humanoid.half_length


@pytest.fixture(scope="module")
def some(records):
    return records[::8]


@pytest.fixture(scope="module")
def line(humanoid):
    return LineContacts(humanoid, EXACT)


@pytest.fixture(scope="module")
def points(humanoid):
    return PointContacts(humanoid, EXACT)


def sides_of(record):
    return [i for i in (0, 1) if record.targets.contact[i]]


def excess(wrench, R, mu, half_length):
    """By how much the worst row of (18) is exceeded [N]."""
    rows = line_cone(mu, half_length) @ np.concatenate([R.T @ wrench[:3], wrench[3:]])
    rows[2:] /= half_length
    return rows.max()


def solved(contacts, program):
    """The corrections: few active rows first, then the solver."""
    delta, _, found = solve_program(program, contacts.constants.weights.weight)
    if not found:
        delta, status = contacts.solver.solve(program, contacts.units)
        assert status.success
    return program.u + delta.reshape(program.u.shape), program.G @ delta + program.c


def accelerated(contacts, d, record, kind="five"):
    """The acceleration that the tasks ask for, by one factorisation, and dropped rows."""
    feet = contacts.feet(d, sides_of(record))
    sample = sample_plan(record.plan, record.targets.time)
    tasks = contacts.tasks(d, [getattr(foot, kind) for foot in feet], record.targets, sample)
    J, b = (np.concatenate(part) for part in zip(*tasks, strict=True))
    vdot, dropped, able = prioritised_acceleration(d.M, J, b)
    assert able
    return vdot, dropped, tasks


def effort(contacts, d, record):
    """Wrenches of the standing feet, and the torques within their limits."""
    feet, c = contacts.feet(d, sides_of(record)), contacts.constants
    vdot = accelerated(contacts, d, record)[0].copy()
    wrench = sample_plan(record.plan, record.targets.time).wrench[sides_of(record)]
    slopes = record.targets.slope[sides_of(record)]
    unknowns, delta = solved(contacts, contacts.program(d, vdot, feet, wrench, slopes))
    vdot[:6] += delta
    needed = d.M @ vdot + d.Cv - d.tau_g
    needed -= sum(foot.rows.J.T @ u for foot, u in zip(feet, unknowns, strict=True))
    torque = np.clip(needed[c.actuated_v], -c.effort_limits, c.effort_limits)
    return np.array([u @ foot.T for foot, u in zip(feet, unknowns, strict=True)]), torque


def test_the_map_is_the_velocity_of_two_points_of_a_body(X, walking_state, humanoid, dynamics_of):
    d = dynamics_of(walking_state(humanoid, 3))
    for foot in feet_of(d):
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


def test_six_rows_have_rank_five(points, records, dynamics_of):
    for record in records[::40]:
        d, sides = dynamics_of(record.x), sides_of(record)
        feet = points.feet(d, sides)
        full, kept = (np.vstack([getattr(f, k).J for f in feet]) for k in ("rows", "five"))
        assert full.shape[0] == 6 * len(sides)
        assert np.linalg.matrix_rank(full) == np.linalg.matrix_rank(kept) == 5 * len(sides)
        stacked = np.column_stack([full, np.concatenate([foot.rows.b for foot in feet])])
        assert np.linalg.matrix_rank(stacked, tol=1e-9) == 5 * len(sides)


def test_all_ways_to_handle_the_dependent_row_give_the_acceleration_of_the_line(
    line, points, some, dynamics_of
):
    for record in some:
        d = dynamics_of(record.x)
        expected = accelerated(line, d, record)[0]
        found, dropped, _ = accelerated(points, d, record)
        assert dropped == 0
        scale = 1e-7 * max(1.0, np.abs(expected).max())
        np.testing.assert_allclose(found, expected, atol=scale)
        six = accelerated(points, d, record, "rows")[2]
        np.testing.assert_allclose(recursive_acceleration(d.M, six), expected, atol=scale)


def test_torques_are_those_of_the_line(humanoid, some, dynamics_of, line, points, X):
    """To 1e-6 wherever the MPC's wrench is inside its cone, whatever the solver does then."""
    control, used = WholeBodyControl(humanoid, EXACT), set()
    for r in some:
        d = dynamics_of(r.x)
        wrench = sample_plan(r.plan, r.targets.time).wrench
        if any(excess(wrench[i], d.R_WC[i], EXACT.friction, X) > 1e-3 for i in sides_of(r)):
            continue
        report = computed(control, d, r.targets, r.plan)
        used |= {(report.status, standing(r.targets))}
        scale = np.abs(report.torque).max()
        for contacts in (line, points):
            made, torque = effort(contacts, d, r)
            np.testing.assert_allclose(torque, report.torque, atol=1e-6 * scale)
            expected = report.wrench[sides_of(r)]
            np.testing.assert_allclose(made, expected, atol=1e-6 * np.abs(expected).max())
    assert {status for status, _ in used} >= {Solved.UNCONSTRAINED, Solved.ACTIVE_SET}
    assert {contact for _, contact in used} == {(True, True), (True, False), (False, True)}


def test_forces_are_in_their_pyramids_and_make_the_wrench(humanoid, X, some, dynamics_of, points):
    rng = np.random.default_rng(0)
    for record in some:
        d, sides = dynamics_of(record.x), sides_of(record)
        feet, vdot = points.feet(d, sides), rng.normal(size=humanoid.nv)
        wrench = sample_plan(record.plan, record.targets.time).wrench[sides]
        found, _ = solved(
            points, points.program(d, vdot, feet, wrench, np.tile(LEVEL, (len(feet), 1)))
        )
        for foot, f in zip(feet, found, strict=True):
            local, w = f.reshape(2, 3) @ foot.R_WC, f @ foot.T
            assert (local @ point_cone(EXACT.friction).T).max() < 1e-5
            made = wrench_from_points(local[0], local[1], X)
            turned = np.concatenate([foot.R_WC.T @ w[:3], w[3:]])
            np.testing.assert_allclose(turned, made, atol=1e-9)


def test_the_wish_is_split_in_proportion_to_the_normal_forces(X, some, dynamics_of, points):
    d, sides = dynamics_of(some[5].x), sides_of(some[5])
    wrench = np.array([20.0, -10.0, 150.0, 4.0, -1.0])
    for foot in points.feet(d, sides):
        local = np.concatenate([foot.R_WC.T @ wrench[:3], wrench[3:]])
        expected = points_from_wrench(local, X, EXACT.friction)
        found = points.start(foot, wrench).reshape(2, 3) @ foot.R_WC
        np.testing.assert_allclose(found, expected, atol=1e-9)


@pytest.mark.parametrize("slope", [[0.0, 0.17], [0.12, -0.2], [-0.17, 0.0]], ids=str)
def test_point_forces_are_inside_the_pyramids_of_the_ground(humanoid, records, dynamics_of, slope):
    """On ground that rises across the feet, for wrenches that friction cannot give."""
    parameters = WbcParameters(max_iterations=40000)  # pyramids take OSQP longer
    points = PointContacts(humanoid, parameters)
    for seed, record in enumerate(records[40::15]):
        rng = np.random.default_rng(seed)
        d, sides = dynamics_of(record.x), sides_of(record)
        wrench = rng.normal(size=(len(sides), 5)) * [150.0, 150.0, 20.0, 4.0, 4.0]
        wrench[:, 2] += 150.0
        vdot, feet = rng.normal(size=humanoid.nv), points.feet(d, sides)
        found, _ = solved(
            points, points.program(d, vdot, feet, wrench, np.tile(slope, (len(feet), 1)))
        )
        for side, forces in zip(sides, found, strict=True):
            f = forces.reshape(2, 3) @ ground_frame(d.R_WC[side], np.array(slope))
            assert np.all(np.abs(f[:, :2]) <= parameters.friction * f[:, 2:] + 1e-3)
