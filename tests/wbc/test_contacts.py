"""The wrench program (49) with contacts of three and of six numbers, on a robot with soles."""

import numpy as np
import pytest
from pydrake.solvers import ClarabelSolver, MathematicalProgram

from drake_linefoot.centroidal import NO_WRENCH
from drake_linefoot.contact.contacts import LineContact
from drake_linefoot.contact.point import PointContact
from drake_linefoot.contact.surface import SurfaceContact
from drake_linefoot.contact.wrench_cone import point_cone
from drake_linefoot.robot.dynamics import robot_dynamics
from drake_linefoot.wbc.parameters import WbcParameters
from drake_linefoot.wbc.wrench_qp import (
    WrenchSolver,
    solve_program,
    wrench_program,
    wrench_weights,
)
from tests.helpers.cones import ThinSurface, corner_excess, grasp
from tests.helpers.whole_body import EVERYWHERE

P = WbcParameters(solver="clarabel", tolerance=1e-10)
X, Y, MASS = 0.095, 0.025, 33.0
POINT, LINE, SURFACE = PointContact(), LineContact(X), SurfaceContact(X, Y)
STANCES = pytest.mark.parametrize("sides", [[0], [1], [0, 1]])
CORNERS = {3: np.eye(3), 6: grasp(X, Y)}  # forces at points to a wrench


@pytest.fixture(scope="module")
def ticks(sole_biped, walking_state):
    """States, accelerations and wrenches of both feet, of which friction cannot give all."""
    out, context = [], sole_biped.plant.CreateDefaultContext()
    for seed in range(8):
        rng = np.random.default_rng(seed)
        d = robot_dynamics(sole_biped, context, walking_state(sole_biped, seed, tilt=0.05))
        wrench = rng.normal(size=(2, 6)) * [60.0, 60.0, 60.0, 6.0, 4.0, 2.0]
        wrench[:, 2] += 120.0
        out.append((d, 2.0 * rng.normal(size=sole_biped.nv), wrench))
    return out


def program_of(contact, tick, sides):
    """(49) with the first numbers of each wrench."""
    (d, vdot, wrench), n = tick, contact.size
    d = d._replace(J=d.J[:, :n].copy(), Jdot_v=d.Jdot_v[:, :n].copy())
    weights = wrench_weights(P, MASS, contact)
    args = (
        (0 in sides, 1 in sides),
        wrench[:, :n].copy(),
        (np.zeros((2, 2)), 1.0, EVERYWHERE),
        NO_WRENCH,
    )
    return d, weights, wrench_program(d, vdot, *args, weights)


def solved(contact, tick, sides):
    """Wrenches of the standing feet, by few active rows and by the solver, and who succeeded."""
    _, weights, program = program_of(contact, tick, sides)
    few, _, found = solve_program(program, weights.weight)
    by_solver, status = WrenchSolver(P, MASS, contact).solve(program)
    assert status.success
    shape = program.u.shape
    return program.u + few.reshape(shape), program.u + by_solver.reshape(shape), found


def by_forces(contact, tick, sides):
    """(49) with forces at points for unknowns, and its equality as it stands."""
    d, _, _ = program_of(contact, tick, sides)
    (_, vdot, wrench), n, prog = tick, contact.size, MathematicalProgram()
    G, mu = CORNERS[n], P.friction
    df, forces, rows = prog.NewContinuousVariables(6), [], [d.M[:6, :6]]
    Q2 = [P.angular_acceleration_error_weight] * 3 + [P.acceleration_error_weight] * 3
    prog.AddQuadraticCost(2.0 * np.diag(Q2), np.zeros(6), df)
    Q1 = np.diag([P.force_error_weight] * 3 + [P.torque_error_weight] * (n - 3))
    for side in sides:
        R, f = d.R_WC[side], prog.NewContinuousVariables(G.shape[1])
        turn = np.eye(n)
        turn[:3, :3] = R
        to_w = turn @ G  # in the ground's frame, which is the foot's here, to the wrench
        u = wrench[side, :n]
        prog.AddQuadraticCost(2.0 * to_w.T @ Q1 @ to_w, -2.0 * to_w.T @ Q1 @ u, f, is_convex=True)
        pyramids = np.kron(np.eye(len(f) // 3), point_cone(mu))
        prog.AddLinearConstraint(
            pyramids, np.full(len(pyramids), -np.inf), np.zeros(len(pyramids)), f
        )
        rows.append(-d.J[side, :, :6].T @ to_w)
        forces.append((to_w, f))
    right = -(d.M @ vdot + d.Cv - d.tau_g)[:6]
    unknowns = np.concatenate([df, *(f for _, f in forces)])
    prog.AddLinearEqualityConstraint(np.hstack(rows), right, unknowns)
    result = ClarabelSolver().Solve(prog)
    assert result.is_success()
    return np.array([to_w @ result.GetSolution(f) for to_w, f in forces])


@STANCES
@pytest.mark.parametrize("contact", [POINT, SURFACE], ids=["point", "surface"])
def test_it_is_the_optimum_over_forces_at_points(ticks, contact, sides):
    """Feet lie on the ground as it is believed to be: what it is across them is their own roll."""
    moved = solved_by_few = 0
    for d, vdot, wrench in ticks:
        flat = d.R_WC.copy()
        for R in flat:  # y level, as the ground is
            y = np.cross([0.0, 0.0, 1.0], R[:, 0])
            R[:, 1] = y / np.linalg.norm(y)
            R[:, 2] = np.cross(R[:, 0], R[:, 1])
        tick = d._replace(R_WC=flat), vdot, wrench
        best = by_forces(contact, tick, sides)
        few, by_solver, found = solved(contact, tick, sides)
        solved_by_few += found
        for w in (few, by_solver) if found else (by_solver,):
            np.testing.assert_allclose(w[:, :3], best[:, :3], atol=0.05)
            np.testing.assert_allclose(w[:, 3:], best[:, 3:], atol=0.02)
        moved += np.abs(best - wrench[sides, : contact.size]).max() > 5.0
    assert moved > 3
    assert solved_by_few > 3


@STANCES
def test_a_surface_with_tau_x_held_at_0_is_the_line(ticks, sides):
    for tick in ticks:
        d, vdot, wrench = tick
        held = d, vdot, wrench * [1.0, 1.0, 1.0, 1.0, 1.0, 0.0]
        _, line, _ = solved(LINE, held, sides)
        _, thin, _ = solved(ThinSurface(X, Y), held, sides)
        np.testing.assert_allclose(thin[:, :5], line, atol=0.02)
        np.testing.assert_allclose(thin[:, 5], 0.0, atol=1e-5)


@STANCES
def test_after_a_failure_a_wrench_is_inside_its_corners(ticks, sides):
    solver = WrenchSolver(P, MASS, SURFACE)
    for d, _, wrench in ticks:
        moved = solver.inside_cones(
            wrench[sides], d.R_WC[sides], np.zeros((len(sides), 2)), P.friction, EVERYWHERE[sides]
        )
        for side, w in zip(sides, moved, strict=True):
            rows = program_of(SURFACE, (d, np.zeros(d.M.shape[0]), wrench), [side])[2].W[0]
            assert (rows @ w).max() < 1e-9 * MASS * 9.81
            assert w[2] >= 0.0
            assert np.linalg.norm(w[:3]) <= np.linalg.norm(wrench[side, :3]) * (1.0 + 1e-9)


def test_corners_agree_with_the_rows_of_the_program(ticks):
    """A wrench on a sole that lies flat: rows of the program say what forces at corners say."""
    for seed, (d, vdot, _) in enumerate(ticks):
        level = d._replace(R_WC=np.array([np.eye(3)] * 2))
        W = program_of(SURFACE, (level, vdot, np.zeros((2, 6))), [0])[2].W[0]
        w = np.random.default_rng(seed).uniform(-1, 1, 6) * [40.0, 40.0, 0.0, 8.0, 4.0, 2.0]
        w[2] = 100.0
        assert ((W @ w).max() <= 0.0) == (corner_excess(w, X, Y, P.friction) <= 1e-9)
