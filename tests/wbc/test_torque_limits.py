"""Torque limits in the wrench program, against the program as it is written, by another solver."""

import numpy as np
import pytest
from pydrake.solvers import ClarabelSolver, MathematicalProgram, SolverOptions

from drake_linefoot.centroidal import NO_WRENCH, sample_plan
from drake_linefoot.contact.wrench_cone import LEVEL, line_cone, world_cone
from drake_linefoot.robot.humanoid import load_humanoid
from drake_linefoot.wbc.control import WholeBodyControl
from drake_linefoot.wbc.parameters import WbcParameters
from drake_linefoot.wbc.torque_limits import excess, solve_by, solve_limited, torque_rows
from drake_linefoot.wbc.wrench_qp import WrenchSolver, solve_program, wrench_program
from tests.helpers.feet import feet_of
from tests.helpers.walking import robot
from tests.helpers.whole_body import EVERYWHERE, computed, standing

P = WbcParameters()
WEIGHT = robot().mass * 9.81
WEAK = [0.1, 0.2, 0.3]  # shares of the limits


def limited_solution(d, vdot, contact, wrench_mpc, limits):
    """(49) with all its variables, a slack for every torque and its equation, by Clarabel."""
    h, sides = robot(), np.flatnonzero(contact)
    n = len(sides)
    J = np.vstack([feet_of(d)[i].J for i in sides])
    prog = MathematicalProgram()
    df, dfr = prog.NewContinuousVariables(6), prog.NewContinuousVariables(5 * n)
    slack, tau = prog.NewContinuousVariables(h.na), prog.NewContinuousVariables(h.na)
    for weight, variables in (
        ([P.angular_acceleration_error_weight] * 3, df[:3]),
        ([P.acceleration_error_weight] * 3, df[3:]),
        (([P.force_error_weight] * 3 + [P.torque_error_weight] * 2) * n, dfr),
        ([P.torque_limit_weight] * h.na, slack),
    ):
        prog.AddQuadraticCost(2.0 * np.diag(weight), np.zeros(len(weight)), variables)
    # M (vdot + df) + Cv - tau_g - J' (u + dfr) = S' tau, all rows of it.
    select = np.zeros((h.nv, h.na))
    select[h.actuated_v, range(h.na)] = 1.0
    known = d.M @ vdot + d.Cv - d.tau_g - J.T @ wrench_mpc[sides].ravel()
    A = np.hstack([d.M[:, :6], -J.T, -select])
    rows = np.r_[0:6, h.actuated_v]
    prog.AddLinearEqualityConstraint(A[rows], -known[rows], np.concatenate([df, dfr, tau]))
    below = np.full(h.na, -np.inf)
    for sign in (1.0, -1.0):
        A = np.hstack([sign * np.eye(h.na), -np.eye(h.na)])
        prog.AddLinearConstraint(A, below, limits, np.concatenate([tau, slack]))
    for k, side in enumerate(sides):
        W = world_cone(line_cone(P.friction, h.half_length), d.R_WC[side], LEVEL)
        room = -W @ wrench_mpc[side]
        prog.AddLinearConstraint(W, np.full(6, -np.inf), room, dfr[5 * k : 5 * k + 5])
    options = SolverOptions()
    for name in ("tol_gap_abs", "tol_gap_rel", "tol_feas"):
        options.SetOption(ClarabelSolver.id(), name, 1e-10)
    result = ClarabelSolver().Solve(prog, solver_options=options)
    assert result.is_success()
    return result.GetSolution(dfr), result.GetSolution(tau)


def programs(records, dynamics_of, share):
    """Yield programs of a walk that break torque limits, with what they are made of."""
    h, found = robot(), 0
    control = WholeBodyControl(h, P)
    limits = share * h.effort_limits
    for r in records[40::7]:
        d, contact = dynamics_of(r.x), standing(r.targets)
        if not any(contact):
            continue
        wrench = sample_plan(r.plan, r.targets.time).wrench
        c = control.constants
        program = wrench_program(
            d,
            r.report.vdot,
            contact,
            wrench,
            (np.zeros((2, 2)), 1.0, EVERYWHERE),
            NO_WRENCH,
            c.weights,
        )
        rows = torque_rows(d, r.report.vdot, program, contact, c.actuated_v)
        delta, _, solved = solve_program(program, WEIGHT)
        if solved and excess(rows, delta, limits).any():
            found += 1
            yield d, r, wrench, program, rows, delta, limits
    assert found > 3


@pytest.mark.parametrize("share", WEAK)
def test_the_solution_is_that_of_the_program_with_slacks(records, dynamics_of, share):
    solved = total = 0
    for d, r, wrench, program, rows, free, limits in programs(records, dynamics_of, share):
        delta, _, found = solve_limited(program, rows, free, limits, P.torque_limit_weight, WEIGHT)
        solved, total = solved + found, total + 1
        if found:
            contact = standing(r.targets)
            expected, tau = limited_solution(d, r.report.vdot, contact, wrench, limits)
            np.testing.assert_allclose(delta, expected, atol=2e-3)
            np.testing.assert_allclose(rows.T @ delta + rows.t, tau, atol=2e-3)
    assert solved > 0.7 * total


@pytest.mark.parametrize("share", WEAK)
def test_a_solver_comes_to_the_same(records, dynamics_of, share):
    solver = WrenchSolver(
        WbcParameters(solver="clarabel", tolerance=1e-11), robot().mass, robot().contact
    )
    for _, _, _, program, rows, free, limits in programs(records, dynamics_of, share):
        one, _, found = solve_limited(program, rows, free, limits, P.torque_limit_weight, WEIGHT)
        other, status = solve_by(solver, program, rows, limits, P.torque_limit_weight)
        assert status.success
        if found:
            np.testing.assert_allclose(one, other, atol=2e-3)


def test_torques_come_nearer_to_their_limits(records, dynamics_of):
    """And what is left of the excess shrinks with its weight."""
    for _, _, _, program, rows, free, limits in programs(records, dynamics_of, 0.2):
        sizes = [np.linalg.norm(excess(rows, free, limits))]
        for weight in (0.01, 1.0, 100.0):
            delta, _, found = solve_limited(program, rows, free, limits, weight, WEIGHT)
            if found:
                sizes.append(np.linalg.norm(excess(rows, delta, limits)))
        assert np.all(np.diff(sizes) < 1e-9)


def test_a_weak_robot_is_controlled_within_its_limits(records, dynamics_of):
    """By the whole tick: no torque above the limits, and less clipped than without the rows."""
    weak = load_humanoid("mit_humanoid")
    weak.effort_limits = 0.2 * weak.effort_limits
    errors = {}
    for weight in (0.0, 10.0):
        control = WholeBodyControl(weak, WbcParameters(torque_limit_weight=weight))
        clipped = []
        for r in records[40::5]:
            report = computed(control, dynamics_of(r.x), r.targets, r.plan)
            assert report.success
            assert (np.abs(report.torque) <= weak.effort_limits).all()
            d = dynamics_of(r.x)
            J = d.J.reshape(10, -1)
            needed = d.M @ report.vdot + d.Cv - d.tau_g - report.wrench.ravel() @ J
            np.testing.assert_allclose(needed[:6], 0.0, atol=1e-8)
            clipped.append(np.linalg.norm(needed[weak.actuated_v] - report.torque))
        errors[weight] = np.sum(clipped)
    assert errors[10.0] < 0.5 * errors[0.0]
