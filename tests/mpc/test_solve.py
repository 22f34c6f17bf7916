"""One update of the MPC: what it plans, and what it does when it cannot."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import nnls
from scipy.spatial.transform import Rotation

from drake_linefoot.centroidal import intervals_at, sample_plan
from drake_linefoot.errors import InputError
from drake_linefoot.math.active_set import solve_few_active
from drake_linefoot.mpc import solve
from drake_linefoot.mpc.models.model import CentroidalMeasurement
from drake_linefoot.mpc.parameters import ACTIVE_SET
from drake_linefoot.signals import CentroidalPlan
from drake_linefoot.statuses import Solved
from tests.helpers.walking import (
    SCENARIO,
    axial,
    ground_frame,
    mirror_plan,
    mirror_reference,
    polar,
    recorded_walk,
)

G = np.array([0.0, 0.0, -9.81])


@pytest.fixture(scope="module")
def solver(solver_of):
    return solver_of()


@pytest.fixture(scope="module")
def some(problems):
    return problems[7::16]


def mirror_measured(m):
    S = np.diag([1.0, -1.0, 1.0])
    return CentroidalMeasurement(polar(m.r), polar(m.v), axial(m.L), S @ m.R_WB @ S)


def assert_same_wrenches(a, b, force):
    """Equal within `force` [N], torques within that times 0.3 m."""
    np.testing.assert_allclose(a.wrench[..., :3], b.wrench[..., :3], atol=force)
    np.testing.assert_allclose(a.wrench[..., 3:], b.wrench[..., 3:], atol=0.3 * force)


def test_it_is_what_the_closed_loop_planned(solver, some):
    for p in some:
        plan = solver.solve(p.record.reference, p.measured, p.record.previous)
        assert_same_wrenches(plan, p.record.plan, 1e-9)
        np.testing.assert_array_equal(plan.times, p.record.reference.times)
        np.testing.assert_array_equal(plan.r_G, p.measured.r)
        assert (plan.success, plan.status) == (True, Solved.SOLVER)
        assert plan.iterations > 0
        assert plan.milliseconds > 0.0


def test_the_start_of_the_iteration_does_not_matter(solver, some):
    for p in some:
        assert_same_wrenches(solver.solve(p.record.reference, p.measured), p.record.plan, 1.0)


def test_every_wrench_is_inside_its_cone_and_air_carries_nothing(some):
    for p in some:
        contact = p.record.reference.contact == 1.0
        wrench, R = p.record.plan.wrench, p.record.reference.R_WC
        slopes = p.record.reference.slope
        np.testing.assert_array_equal(wrench[~contact], 0.0)
        for w, R_WC, slope in zip(wrench[contact], R[contact], slopes[contact], strict=True):
            ground = ground_frame(R_WC, slope)
            f, tau = ground.T @ w[:3], ground.T @ R_WC[:, 1:] @ w[3:]
            assert np.all(np.abs(f[:2]) <= 0.6 * f[2] + 1e-3)
            assert abs(tau[1]) <= 0.075 * f[2] + 1e-3


def test_on_slippery_ground_every_wrench_is_inside_the_smaller_cone(solver, some):
    pulled, mu = 0, 0.05
    for p in some:
        reference = p.record.reference._replace(friction=mu)
        plan = solver.solve(reference, p.measured)
        contact = reference.contact == 1.0
        for before, w in zip(p.record.plan.wrench[contact], plan.wrench[contact], strict=True):
            assert np.hypot(*w[:2]) <= np.sqrt(2.0) * mu * w[2] + 0.1
            pulled += np.hypot(*before[:2]) > 2.0 * mu * before[2]
    assert pulled > 10


def pulled_plan(solver, p, pull):
    """The plan of an update, where something may pull at the robot."""
    if not pull:
        return p.record.plan
    external = np.array([3.0, -5.0, 2.0, -30.0, 20.0, 15.0])
    plan = solver.solve(p.record.reference._replace(external=external), p.measured)
    assert plan.success
    np.testing.assert_array_equal(plan.external, external)
    return plan


@pytest.mark.parametrize("pull", [False, True])
def test_the_predicted_states_are_an_integration_of_the_wrenches(humanoid, solver, some, pull):
    """(2), (3) with Runge-Kutta, one interval after the other; also where something pulls."""
    m = humanoid.mass
    for p in some:
        plan = pulled_plan(solver, p, pull)
        x, M, F = plan.states[0, :9], plan.external[:3], m * G + plan.external[3:]
        for k in range(len(plan.wrench)):

            def rate(t, x, w=plan.wrench[k], at=plan.p_WC[k], R=plan.R_WC[k], of=(plan.r_G, M, F)):
                f, (r_G, M, F) = w[:, :3], of
                moment = np.cross(at - r_G, f).sum(axis=0) + M + np.cross(x[:3] - r_G, F)
                moment = moment + R[0][:, 1:] @ w[0, 3:] + R[1][:, 1:] @ w[1, 3:]
                return np.concatenate([x[3:6], (F + f.sum(axis=0)) / m, moment])

            span = (plan.times[k], plan.times[k + 1])
            x = solve_ivp(rate, span, x, rtol=1e-10, atol=1e-12).y[:, -1]
            np.testing.assert_allclose(plan.states[k + 1, :9], x, atol=1e-8)


@pytest.mark.parametrize("pull", [False, True])
def test_a_sample_is_the_integrated_motion(humanoid, solver, some, pull):
    """Its derivatives are those of its values, and at the knots it is the predicted state."""
    m, h = humanoid.mass, 1e-5
    for p in some:
        plan: CentroidalPlan = pulled_plan(solver, p, pull)
        for k in range(len(plan.wrench)):
            t = plan.times[k] + 0.37 * (plan.times[k + 1] - plan.times[k])
            assert intervals_at(plan.times, np.array([t])) == [k]
            before, now, after = (sample_plan(plan, t + s * h) for s in (-1, 0, 1))
            np.testing.assert_allclose((after.r - before.r) / (2 * h), now.v, atol=1e-8)
            np.testing.assert_allclose((after.v - before.v) / (2 * h), now.a, atol=1e-7)
            np.testing.assert_allclose((after.L - before.L) / (2 * h), now.L_dot, atol=1e-5)
            np.testing.assert_array_equal(now.wrench, plan.wrench[k])
            knot = sample_plan(plan, plan.times[k])
            L = plan.states[k, 6:9] - m * np.cross(plan.states[k, :3] - plan.r_G, knot.v)
            np.testing.assert_allclose(np.r_[knot.r, knot.v], plan.states[k, :6], atol=1e-12)
            np.testing.assert_allclose(knot.L, L, atol=1e-12)
            # The end of the interval, found from its beginning.
            end = sample_plan(plan, plan.times[k + 1] - 2e-9)
            np.testing.assert_allclose(end.r, plan.states[k + 1, :3], atol=1e-7)


def test_times_outside_the_plan_use_its_first_and_last_interval(some):
    plan = some[0].record.plan
    outside = np.array([plan.times[0] - 1.0, plan.times[-1] + 1.0])
    np.testing.assert_array_equal(intervals_at(plan.times, outside), [0, len(plan.wrench) - 1])
    for t, interval in zip(outside, (0, -1), strict=True):
        np.testing.assert_array_equal(sample_plan(plan, t).wrench, plan.wrench[interval])


def test_standing_upright_it_carries_the_weight_and_stays(humanoid, solver, problems):
    """Known answer: m g in all, the CoM where it is; the weight on forces takes 0.1 %."""
    p = problems[0]
    height = p.record.reference.r[0, 2]
    middle = p.record.reference.p_WC[0, :, :2].mean(axis=0)
    still = CentroidalMeasurement(np.array([*middle, height]), np.zeros(3), np.zeros(3), np.eye(3))
    ref = p.record.reference
    rest, zero = np.tile(still.r, (len(ref.r), 1)), np.zeros((len(ref.r), 3))
    ref = ref._replace(
        r=rest, r_mid=rest[1:], v=zero, v_mid=zero[1:], L=zero, L_mid=zero[1:],
        R=np.tile(np.eye(3), (len(rest), 1, 1)),
    )  # fmt: skip
    plan = solver.solve(ref, still)
    total = plan.wrench[..., :3].sum(axis=1)
    np.testing.assert_allclose(total[:8, 2], humanoid.mass * 9.81, rtol=2e-3)
    np.testing.assert_allclose(total[:, :2], 0.0, atol=0.05)
    np.testing.assert_allclose(plan.wrench[:, 0, 2], plan.wrench[:, 1, 2], atol=0.05)
    np.testing.assert_allclose(plan.states[:, :3], rest, atol=1e-3)
    np.testing.assert_allclose(plan.states[:, 9:], 0.0, atol=1e-3)


def test_a_mirrored_problem_has_the_mirrored_plan(solver_of, some):
    exact = solver_of(solver="clarabel", tolerance=1e-10)
    for p in some:
        plan = mirror_plan(exact.solve(p.record.reference, p.measured))
        other = exact.solve(mirror_reference(p.record.reference), mirror_measured(p.measured))
        assert_same_wrenches(other, plan, 1e-3)
        np.testing.assert_allclose(other.states, plan.states, atol=1e-6)
        np.testing.assert_allclose(other.footholds, plan.footholds, atol=1e-15)
        np.testing.assert_allclose(other.p_WC, plan.p_WC, atol=1e-15)


def test_a_tilted_torso_is_turned_back(solver, problems):
    """The moment opposes the tilt about roll, pitch and yaw, each by itself."""
    p = problems[0]
    for axis in range(3):
        tilt = 0.05 * np.eye(3)[axis]
        moments = []
        for sign in (1.0, -1.0):
            turned = Rotation.from_rotvec(sign * tilt).as_matrix()
            plan = solver.solve(p.record.reference, replace(p.measured, R_WB=turned))
            moments.append(sample_plan(plan, plan.times[0]).L_dot[axis])
            assert np.abs(plan.states[-1, 9 + axis]) < 0.5 * 0.05
        assert moments[0] < -1.0 < 1.0 < moments[1]


# --- solvers and failures ---------------------------------------------------------------


def test_clarabel_gives_the_same_plan(solver_of, some):
    other = solver_of(solver="clarabel", tolerance=1e-8)
    for p in some:
        plan = other.solve(p.record.reference, p.measured)
        assert plan.success
        assert_same_wrenches(plan, p.record.plan, 1.0)


def test_the_active_set_gives_the_same_plan(solver_of, problems):
    """And it ends: no program of the walk is left to OSQP, which counts iterations."""
    other, statuses = solver_of(solver=ACTIVE_SET), set()
    for p in problems:
        plan = other.solve(p.record.reference, p.measured)
        assert (plan.success, plan.iterations) == (True, 0)
        assert plan.status == (Solved.ACTIVE_SET if plan.active else Solved.UNCONSTRAINED)
        assert_same_wrenches(plan, p.record.plan, 1.0)
        statuses.add(plan.status)
    assert statuses == {Solved.ACTIVE_SET, Solved.UNCONSTRAINED}


def test_the_active_set_is_exact(problems):
    """Stationarity with multipliers >= 0 on active rows, to rounding; non-negative LSQ."""
    for p in problems:
        qp = p.qp
        A = qp.rows()
        z, found = solve_few_active(qp.H, qp.g, A, np.zeros(len(A)), 1e-8)
        assert found
        assert (A @ z).max() < 2e-8
        active = A[A @ z > -1e-10]
        gradient = qp.H @ z + qp.g
        _, residual = nnls(active.T, -gradient) if len(active) else (0, np.linalg.norm(gradient))
        assert residual < 1e-10


def test_what_the_active_set_cannot_solve_goes_to_osqp(solver_of, some, monkeypatch):
    """Whether it gives up on the guesses or on a cost that is not positive definite."""
    monkeypatch.setattr(solve, "solve_few_active", lambda H, g, *_: (np.full(len(g), 1e3), False))
    p = some[0]
    plan = solver_of(solver=ACTIVE_SET).solve(p.record.reference, p.measured)
    osqp = solver_of().solve(p.record.reference, p.measured)
    assert plan.iterations == osqp.iterations > 0
    assert plan.status == osqp.status == Solved.SOLVER
    np.testing.assert_array_equal(plan.wrench, osqp.wrench)


def test_an_unknown_solver_is_refused(solver_of):
    known = r"\('osqp', 'clarabel', 'active_set'\)"
    with pytest.raises(InputError, match=rf"mpc.solver.* 'gurobi': must be one of {known}"):
        solver_of(solver="gurobi")


def test_a_failed_solve_keeps_the_last_plan_and_counts(solver_of, problems):
    poor = solver_of(max_iterations=1)
    p = problems[30]
    first = poor.solve(p.record.reference, p.measured, p.record.previous)
    assert (first.success, first.status) == (False, Solved.ITERATION_LIMIT)
    assert first.failures == p.record.previous.failures + 1
    says = {"status", "active", "iterations", "milliseconds", "failures"}
    for name in set(CentroidalPlan._fields) - says:
        np.testing.assert_array_equal(getattr(first, name), getattr(p.record.previous, name))
    second = poor.solve(problems[31].record.reference, problems[31].measured, first)
    assert second.failures == first.failures + 1
    recovered = solver_of().solve(problems[32].record.reference, problems[32].measured, second)
    assert (recovered.success, recovered.failures) == (True, second.failures)
    assert recovered.times[0] == problems[32].record.reference.times[0]


def test_the_very_first_failure_shares_the_weight(humanoid, solver_of, problems):
    poor = solver_of(max_iterations=1)
    for p in problems[::20]:
        plan = poor.solve(p.record.reference, p.measured)
        assert (plan.success, plan.status, plan.failures) == (False, Solved.ITERATION_LIMIT, 1)
        contact = p.record.reference.contact == 1.0
        np.testing.assert_allclose(
            plan.wrench[..., :3].sum(axis=1), -humanoid.mass * np.tile(G, (len(contact), 1))
        )
        np.testing.assert_array_equal(plan.wrench[~contact], 0.0)
        both = contact.all(axis=1)
        np.testing.assert_array_equal(plan.wrench[both, 0], plan.wrench[both, 1])


def test_a_reference_that_is_not_finite_is_a_failure_not_a_crash(solver, problems):
    p = problems[30]
    for name in ("L", "I_B"):
        value = getattr(p.record.reference, name).copy()
        value[3] = np.nan
        bad = p.record.reference._replace(**{name: value})
        plan = solver.solve(bad, p.measured, p.record.previous)
        assert (plan.success, plan.status) == (False, Solved.NOT_FINITE)
        np.testing.assert_array_equal(plan.wrench, p.record.previous.wrench)


def test_no_update_of_the_walk_failed():
    plans = [record.plan for record in recorded_walk().mpc]
    assert len(plans) == round(SCENARIO.duration / SCENARIO.mpc.period)
    assert all(plan.success for plan in plans)
    assert plans[-1].failures == 0
