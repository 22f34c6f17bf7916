"""The MPC with contacts of other sizes than a line: three numbers and six."""

import numpy as np
import pytest
from scipy.optimize import nnls

from drake_linefoot.contact.contacts import LineContact
from drake_linefoot.contact.point import PointContact
from drake_linefoot.contact.surface import SurfaceContact
from drake_linefoot.math.active_set import solve_few_active
from drake_linefoot.mpc.ecd import input_matrices
from drake_linefoot.mpc.parameters import ACTIVE_SET, MPC_SOLVERS, MpcParameters, MpcWeights
from drake_linefoot.mpc.solve import MpcSolver
from tests.helpers.cones import ThinSurface, corner_excess
from tests.helpers.walking import ground_frame, robot

X, Y, MU = robot().half_length, 0.03, 0.6
POINT, LINE, SURFACE = PointContact(), LineContact(X), SurfaceContact(X, Y)
FREE = MpcWeights(
    centre_of_pressure=0.0
)  # as a line: what a sole costs beside has tests of its own
OTHERS = pytest.mark.parametrize("contact", [POINT, SURFACE], ids=["point", "surface"])


def solver_for(contact, **changes):
    return MpcSolver(
        MpcParameters(**{"model": "ecd", "weights": FREE, **changes}), robot().mass, contact
    )


@pytest.fixture(scope="module")
def some(problems):
    return problems[7::16]


def test_a_surface_with_tau_x_held_at_0_is_the_line(some):
    """The same optimum, by the interior point method and by OSQP."""
    held = 0.0
    for solver, tolerance, atol in (("clarabel", 1e-10, 0.05), ("osqp", 1e-7, 0.1)):
        line = solver_for(LINE, solver=solver, tolerance=tolerance)
        thin = solver_for(ThinSurface(X, Y), solver=solver, tolerance=tolerance)
        wide = solver_for(SURFACE, solver=solver, tolerance=tolerance)
        for p in some:
            a, b, c = (s.solve(p.record.reference, p.measured) for s in (line, thin, wide))
            assert a.success
            assert b.success
            np.testing.assert_allclose(b.wrench[..., :3], a.wrench[..., :3], atol=atol)
            np.testing.assert_allclose(b.wrench[..., 3:5], a.wrench[..., 3:], atol=0.3 * atol)
            np.testing.assert_allclose(b.wrench[..., 5], 0.0, atol=0.3 * atol)
            held = max(held, np.abs(c.wrench[..., 5]).max())
    assert held > 0.5  # a width would be used [N m]


@OTHERS
def test_its_inputs_act_as_forces_and_torques_do(contact):
    """(37): force over mass, and the moment about r_G of forces in W and torques in C."""
    rng, m = np.random.default_rng(1), 20.0
    p, r_G = rng.normal(size=(3, 2, 3)), rng.normal(size=3)
    R = np.linalg.qr(rng.normal(size=(3, 2, 3, 3)))[0]
    w = rng.normal(size=(3, 2, contact.size))
    B = input_matrices(p, R, r_G, m, contact.size)
    torque = np.zeros((3, 2, 3))
    torque[..., [1, 2, 0][: contact.size - 3]] = w[..., 3:]
    moment = np.cross(p - r_G, w[..., :3]) + np.einsum("kfij,kfj->kfi", R, torque)
    rate = np.einsum("kij,kj->ki", B, w.reshape(3, -1))
    np.testing.assert_allclose(rate[:, 3:6], w[..., :3].sum(axis=1) / m, atol=1e-12)
    np.testing.assert_allclose(rate[:, 6:9], moment.sum(axis=1), atol=1e-12)
    np.testing.assert_array_equal(rate[:, [0, 1, 2, 9, 10, 11]], 0.0)


def excess(contact, w, R_WC, slope):
    """By how much a wrench is outside what forces of points can be [N]."""
    R_WS = ground_frame(R_WC, slope)
    force = R_WS.T @ w[:3]
    if contact is POINT:
        return np.abs(force[:2]).max() - MU * force[2]
    torque = R_WS.T @ R_WC @ w[[5, 3, 4]]
    return corner_excess(np.concatenate([force, torque[[1, 2, 0]]]), X, Y, MU)


@OTHERS
@pytest.mark.parametrize("name", MPC_SOLVERS)
def test_every_solver_plans_forces_that_the_ground_gives(some, contact, name):
    solver, best = solver_for(contact, solver=name), solver_for(contact, solver="clarabel")
    for p in some[::2]:
        ref, plan = p.record.reference, solver.solve(p.record.reference, p.measured)
        assert plan.success
        assert plan.wrench.shape == (len(ref.contact), 2, contact.size)
        other = best.solve(ref, p.measured)
        np.testing.assert_allclose(plan.wrench[..., :3], other.wrench[..., :3], atol=2.0)
        for k, side in np.argwhere(ref.contact == 1.0)[::5]:
            slope = ref.slope[k, side]
            assert excess(contact, plan.wrench[k, side], ref.R_WC[k, side], slope) < 0.01


@OTHERS
def test_the_active_set_meets_the_conditions_of_optimality(some, contact):
    solver, touched = solver_for(contact, solver=ACTIVE_SET), 0
    for p in some:
        qp = solver.build(p.record.reference, p.measured)
        A = qp.rows()
        z, found = solve_few_active(qp.H, qp.g, A, np.zeros(len(A)), 1e-8)
        if not found:
            continue
        active = A[A @ z > -1e-10]
        gradient = qp.H @ z + qp.g
        residual = nnls(active.T, -gradient)[1] if len(active) else np.linalg.norm(gradient)
        assert residual < 1e-10
        touched += len(active)
    assert touched > 0


def test_more_of_a_contact_costs_no_more(some):
    """A point is a line without torques, a line a surface without tau_x: costs in this order."""
    for p in some:
        costs = []
        for contact in (POINT, LINE, SURFACE):
            solver = solver_for(contact, solver="clarabel", tolerance=1e-9)
            qp = solver.build(p.record.reference, p.measured)
            plan = solver.solve(p.record.reference, p.measured)
            costs.append(qp.cost(plan.wrench[qp.active[:, 0], qp.active[:, 1]].ravel()))
        assert costs[0] > costs[1] * (1.0 - 1e-6) > costs[2] * (1.0 - 1e-5)


def test_a_price_keeps_the_centre_of_pressure_off_the_edge(some):
    """And only of a sole: programs of points and lines are the same with any."""
    shares = []
    for price in (0.0, 1e-6, 1e-4):
        changes = {"weights": MpcWeights(centre_of_pressure=price), "solver": "clarabel"}
        solver, far = solver_for(SURFACE, **changes), []
        for p in some:
            plan = solver.solve(p.record.reference, p.measured)
            w = plan.wrench[p.record.reference.contact == 1.0]
            far += [np.abs(w[:, [3, 5]] / w[:, 2:3] / [X, Y])]
        shares.append(np.concatenate(far).mean(axis=0))
        for contact in (POINT, LINE):
            priced, free = solver_for(contact, **changes), solver_for(contact, solver="clarabel")
            one, other = (
                s.build(some[0].record.reference, some[0].measured) for s in (priced, free)
            )
            np.testing.assert_array_equal(one.H, other.H)
            np.testing.assert_array_equal(one.g, other.g)
    assert np.all(shares[0] > 2.0 * shares[2])
    assert np.all(np.diff(shares, axis=0) < 0.0)


def test_the_price_is_that_of_a_force_at_the_edge(some):
    """A wrench whose centre of pressure is at an edge costs as much more as the force itself."""
    p, price = some[0], 1e-3
    for at in ([3], [5], [3, 5]):
        cost = []
        for each in (0.0, price):
            weights = MpcWeights(centre_of_pressure=each)
            qp = solver_for(SURFACE, weights=weights).build(p.record.reference, p.measured)
            w = np.zeros((len(qp.active), 6))
            w[0, 2] = 100.0
            for column in at:
                w[0, column] = 100.0 * (X if column == 3 else Y)
            cost.append(qp.cost(w.ravel()))
        dt = p.record.reference.dt[qp.active[0, 0]] / MpcParameters().knot_step
        assert cost[1] - cost[0] == pytest.approx(len(at) * price * 100.0**2 * dt, rel=1e-6)
