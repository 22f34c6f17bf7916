"""The wrench program (49) against the program as it is written, solved by another solver."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from pydrake.solvers import ClarabelSolver, MathematicalProgram, SolverOptions

from drake_linefoot.centroidal import PlanSample
from drake_linefoot.contact.wrench_cone import line_cone
from drake_linefoot.errors import InputError
from drake_linefoot.statuses import Solved
from drake_linefoot.wbc.parameters import WbcParameters
from drake_linefoot.wbc.tasks.momentum import momentum_task
from drake_linefoot.wbc.tasks.posture import joint_task
from drake_linefoot.wbc.wrench_qp import WrenchSolver, into_cone
from tests.helpers.cones import wrench_from_points
from tests.helpers.feet import feet_of
from tests.helpers.whole_body import contact_tasks, controller_of, prioritised, solve_wrenches

MU, X = WbcParameters().friction, 0.075
STANCES = [[0], [1], [0, 1]]


@pytest.fixture(scope="module")
def states(humanoid, walking_state, records):
    return [r.x for r in records[40::70]] + [walking_state(humanoid, seed) for seed in (5, 6)]


def local(wrench, R):
    """A wrench with its force turned into the contact frame."""
    return np.concatenate([R.T @ wrench[:3], wrench[3:]])


def excess(d, sides, wrenches):
    """By how much the worst row of a cone is exceeded [N]; negative inside."""
    rows = []
    for side, wrench in zip(sides, wrenches, strict=True):
        row = line_cone(MU, X) @ local(wrench, feet_of(d)[side].R_WC)
        rows.append(row / [1, 1, X, X, X, X])
    return np.max(rows)


def inside(d, side, rng, total):
    """A random wrench inside the cone of a foot: two point forces within their pyramids."""
    f = rng.uniform(0.2, 0.8, size=(2, 3)) * total / 2
    f[:, :2] = 0.8 * MU * f[:, 2:] * rng.uniform(-1, 1, size=(2, 2))
    w = wrench_from_points(f[0], f[1], X)
    return np.concatenate([feet_of(d)[side].R_WC @ w[:3], w[3:]])


def reference_solution(d, vdot, sides, f_mpc, p):
    """(49) with all its variables and its equality, by Clarabel to 1e-10."""
    n = len(sides)
    prog = MathematicalProgram()
    df, dfr = prog.NewContinuousVariables(6), prog.NewContinuousVariables(5 * n)
    Q1 = np.diag(([p.force_error_weight] * 3 + [p.torque_error_weight] * 2) * n)
    Q2 = [p.angular_acceleration_error_weight] * 3 + [p.acceleration_error_weight] * 3
    prog.AddQuadraticCost(2.0 * np.diag(Q2), np.zeros(6), df)
    prog.AddQuadraticCost(2 * Q1, np.zeros(5 * n), dfr)
    J = np.vstack([feet_of(d)[i].J for i in sides])
    rhs = J[:, :6].T @ f_mpc.ravel() - (d.M @ vdot + d.Cv - d.tau_g)[:6]
    A = np.hstack([d.M[:6, :6], -J[:, :6].T])
    prog.AddLinearEqualityConstraint(A, rhs, np.concatenate([df, dfr]))
    for k, side in enumerate(sides):
        R = feet_of(d)[side].R_WC
        turn = np.zeros((5, 5))
        turn[:3, :3], turn[3:, 3:] = R.T, np.eye(2)
        W = line_cone(MU, X) @ turn
        room = -W @ f_mpc[k]
        prog.AddLinearConstraint(W, np.full(6, -np.inf), room, dfr[5 * k : 5 * k + 5])
    options = SolverOptions()
    for name in ("tol_gap_abs", "tol_gap_rel", "tol_feas"):
        options.SetOption(ClarabelSolver.id(), name, 1e-10)
    result = ClarabelSolver().Solve(prog, None, options)
    assert result.is_success()
    return result.GetSolution(df), result.GetSolution(dfr).reshape(n, 5)


@pytest.mark.parametrize("sides", STANCES)
@pytest.mark.parametrize("spread", [5.0, 60.0, 300.0])
def test_it_is_the_optimum_of_the_program_as_written(humanoid, states, dynamics_of, sides, spread):
    """Wrenches far inside, at the border and far outside the cones."""
    constrained = 0
    for seed, x in enumerate(states):
        rng, d = np.random.default_rng(seed), dynamics_of(x)
        weight = 240.0 / len(sides)
        f_mpc = np.array([inside(d, i, rng, weight) for i in sides])
        f_mpc += spread * rng.normal(size=f_mpc.shape) * [1, 1, 1, 0.05, 0.05]
        vdot = 3.0 * rng.normal(size=humanoid.nv)
        solution = solve_wrenches(d, vdot, sides, f_mpc)
        delta_f, delta_fr = reference_solution(d, vdot, sides, f_mpc, WbcParameters())
        assert solution.success
        constrained += solution.status != Solved.UNCONSTRAINED
        scale = 1.0 + np.abs(f_mpc).max() / 240.0
        np.testing.assert_allclose(solution.delta_fr[:, :3], delta_fr[:, :3], atol=0.02 * scale)
        np.testing.assert_allclose(solution.delta_fr[:, 3:], delta_fr[:, 3:], atol=2e-3 * scale)
        np.testing.assert_allclose(solution.delta_f, delta_f, atol=2e-3 * scale)
        np.testing.assert_allclose(solution.wrench, f_mpc + solution.delta_fr, atol=1e-10)
        assert excess(d, sides, solution.wrench) < 1e-4
    assert constrained > 0 or spread < 10.0


@pytest.mark.parametrize("pull", [0.0, 1.0])
@pytest.mark.parametrize("sides", STANCES)
def test_the_base_rows_hold(humanoid, states, dynamics_of, full_plant, sides, pull):
    """The plant needs no force on its base for vdot + delta_f with these wrenches.

    None but the one that is said to act there.
    """
    external = pull * np.array([3.0, -5.0, 2.0, -30.0, 20.0, 15.0])
    for seed, x in enumerate(states):
        rng, d = np.random.default_rng(seed), dynamics_of(x)
        vdot = 5.0 * rng.normal(size=humanoid.nv)
        f_mpc = 100.0 * rng.normal(size=(len(sides), 5))
        solution = solve_wrenches(d, vdot, sides, f_mpc, external=external)
        vdot[:6] += solution.delta_f
        wrench = np.zeros((2, 5))
        wrench[sides] = solution.wrench
        needed = full_plant.put(x).needed_forces(vdot, wrench)
        lever = np.cross(d.p_WG - d.p_WB, external[3:])
        needed[:3] -= external[:3] + lever
        needed[3:6] -= external[3:]
        np.testing.assert_allclose(needed[:6], 0.0, atol=1e-9 * (1 + np.abs(f_mpc).max() * 10))


@pytest.mark.parametrize("sides", STANCES)
def test_a_consistent_wrench_is_not_corrected(humanoid, states, dynamics_of, sides):
    """The MPC's momentum rates with the MPC's wrenches: no error in either, as in Fig. 5."""
    c = controller_of().constants
    for seed, x in enumerate(states):
        rng, d = np.random.default_rng(seed), dynamics_of(x)
        f = np.array([inside(d, i, rng, 240.0 / len(sides)) for i in sides])
        feet = [feet_of(d)[i] for i in sides]
        force = f[:, :3].sum(axis=0) + humanoid.mass * np.array([0, 0, -9.81])
        moment = sum(
            np.cross(foot.p_WC - d.p_WG, w[:3]) + foot.R_WC[:, 1:] @ w[3:]
            for foot, w in zip(feet, f, strict=True)
        )
        plan = wanted(force / humanoid.mass, moment)
        task = momentum_task(d, plan, c.mass, c.gains)
        arms = joint_task(d, c.arms, np.zeros(3), c.gains)
        vdot, _ = prioritised(d.M, [contact_tasks(d, sides, 0.0), task, arms])
        solution = solve_wrenches(d, vdot, sides, f)
        assert solution.status == Solved.UNCONSTRAINED
        np.testing.assert_allclose(solution.delta_fr, 0.0, atol=1e-8)
        np.testing.assert_allclose(solution.delta_f, 0.0, atol=1e-8)


def wanted(a, L_dot):
    """Momentum rates without feedback; the task reads nothing else with gains of 0."""
    zero = np.zeros(3)
    return PlanSample(zero, zero, a, zero, L_dot, np.zeros((2, 5)))


def test_in_flight_the_base_falls(humanoid, states, dynamics_of, full_plant):
    """Without contact only joint torques are left: delta_f makes the base rows hold."""
    for x in states:
        d = dynamics_of(x)
        vdot = np.random.default_rng(0).normal(size=humanoid.nv)
        solution = solve_wrenches(d, vdot, [], np.zeros((0, 5)))
        assert (solution.success, solution.status) == (True, Solved.NO_CONTACT)
        assert solution.wrench.shape == solution.delta_fr.shape == (0, 5)
        vdot[:6] += solution.delta_f
        needed = full_plant.put(x).needed_forces(vdot, np.zeros((2, 5)))
        np.testing.assert_allclose(needed[:6], 0.0, atol=1e-9)


def test_clarabel_finds_the_same(humanoid, states, dynamics_of):
    for seed, x in enumerate(states):
        rng, d = np.random.default_rng(seed), dynamics_of(x)
        f_mpc = np.array([inside(d, i, rng, 120.0) for i in (0, 1)])
        f_mpc[:, :2] += 150.0 * rng.normal(size=(2, 2))
        vdot = rng.normal(size=humanoid.nv)
        one = solve_wrenches(d, vdot, [0, 1], f_mpc)
        two = solve_wrenches(d, vdot, [0, 1], f_mpc, solver="clarabel")
        assert one.success
        assert two.success
        np.testing.assert_allclose(one.wrench, two.wrench, atol=0.05)


def test_weights_shift_the_error_from_one_to_the_other(humanoid, states, dynamics_of):
    d = dynamics_of(states[0])
    f_mpc = np.array([inside(d, i, np.random.default_rng(1), 120.0) for i in (0, 1)])
    vdot = np.random.default_rng(2).normal(size=humanoid.nv)
    errors = []
    for weight in (1e-3, 10.0, 1e5):
        weights = {f"{kind}acceleration_error_weight": weight for kind in ("", "angular_")}
        solution = solve_wrenches(d, vdot, [0, 1], f_mpc, **weights)
        errors.append((np.linalg.norm(solution.delta_f), np.linalg.norm(solution.delta_fr)))
    acceleration, wrench = zip(*errors, strict=True)
    assert acceleration[0] > acceleration[1] > acceleration[2]
    assert wrench[0] < wrench[1] < wrench[2]


# --- failure ----------------------------------------------------------------------------


@pytest.mark.parametrize("sides", STANCES)
def test_when_the_solver_fails_the_wrench_is_moved_into_the_cone(
    humanoid, states, dynamics_of, sides, solver_only
):
    """And said: the solver may not take more than one iteration here."""
    failures = 0
    for seed, x in enumerate(states):
        rng, d = np.random.default_rng(seed), dynamics_of(x)
        f_mpc = np.array([inside(d, i, rng, 120.0) for i in sides])
        f_mpc[:, :2] += 400.0
        vdot = rng.normal(size=humanoid.nv)
        solution = solve_wrenches(d, vdot, sides, f_mpc, max_iterations=1)
        if solution.status == Solved.UNCONSTRAINED:
            continue  # the dynamics alone brought it back inside
        assert not solution.success
        failures += 1
        assert excess(d, sides, solution.wrench) < 1e-9
        np.testing.assert_allclose(solution.wrench - f_mpc, solution.delta_fr, atol=1e-12)
        for side, w, f in zip(sides, solution.wrench, f_mpc, strict=True):
            R = feet_of(d)[side].R_WC
            assert local(w, R)[2] == pytest.approx(max(local(f, R)[2], 0.0), abs=1e-9)
    assert failures >= len(states) - 1


def test_an_unknown_solver_is_refused(humanoid):
    with pytest.raises(InputError, match="must be one of"):
        WrenchSolver(WbcParameters(solver="ipopt"), humanoid.mass, humanoid.contact)


@given(arrays(float, 5, elements=st.floats(-1e3, 1e3)), st.floats(0.1, 1.5), st.floats(0.02, 0.2))
def test_into_cone_is_always_inside(wrench, mu, half_length):
    W = line_cone(mu, half_length)
    out = into_cone(wrench, W)
    assert np.max(W @ out) <= 1e-9 * (1 + np.abs(wrench).max())
    assert out[2] == max(wrench[2], 0.0)
    again = into_cone(out, W)
    np.testing.assert_allclose(again, out, rtol=1e-9, atol=1e-9)


@given(arrays(float, 6, elements=st.floats(0.0, 1.0)), st.floats(0.1, 1.5))
def test_into_cone_leaves_a_wrench_inside_alone(share, mu):
    f = np.array([share[:3], share[3:]]) * [2, 2, 100] - [1, 1, 0]
    f[:, :2] *= 0.999 * mu * f[:, 2:]
    wrench = wrench_from_points(f[0], f[1], X)
    np.testing.assert_allclose(into_cone(wrench, line_cone(mu, X)), wrench, rtol=1e-12, atol=1e-12)
