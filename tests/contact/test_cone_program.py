"""The quadratic program of wrenches: optimality conditions, other solvers, failures."""

import ctypes
import itertools

import numpy as np
import pytest
from pydrake.solvers import MathematicalProgram
from scipy.optimize import minimize, nnls
from scipy.spatial.transform import Rotation

from drake_linefoot.contact.cone_program import ConeProgram, make_solver
from drake_linefoot.contact.solvers import SOLVERS
from drake_linefoot.contact.wrench_cone import line_cone
from drake_linefoot.errors import InputError
from drake_linefoot.statuses import Solved
from tests.helpers.cones import turned_cone

MU, X = 0.8, 0.075
TOLERANCE = 1e-9
RHO = 0.1  # near the smallest curvature of `random_program`
SEEDS = range(6)


def make(solver, tolerance=TOLERANCE, iterations=20000):
    return ConeProgram(solver, tolerance, iterations, RHO)


def random_program(seed, count, room=0.0):
    """A strictly convex cost, and the cone (18) of turned feet in scaled variables."""
    rng = np.random.default_rng(seed)
    n = 5 * count
    root = rng.normal(size=(n, n))
    H = root @ root.T / n + 0.1 * np.eye(n)
    g = rng.normal(size=n)
    turns = Rotation.from_euler("z", rng.uniform(-2, 2, (count, 1))).as_matrix()
    W = np.stack([turned_cone(MU, X, R) for R in turns])
    W[:, 2:] /= X
    W[..., 3:] *= X
    return H, g, W, np.full((count, 6), room)


def stacked(W):
    """Return the block-diagonal matrix of all rows."""
    count, rows, columns = W.shape
    out = np.zeros((count * rows, count * columns))
    for i, Wi in enumerate(W):
        out[rows * i : rows * (i + 1), columns * i : columns * (i + 1)] = Wi
    return out


def kkt_residuals(z, H, g, W, b):
    """Return (stationarity, primal) residuals with the best nonnegative multipliers.

    Only rows that are active get one, so dual feasibility and complementarity hold by
    construction and whatever is wrong shows in the stationarity.
    """
    rows, slack = stacked(W), b.ravel() - stacked(W) @ z
    active = rows[slack < 1e-5]
    gradient = H @ z + g
    stationarity = nnls(active.T, -gradient)[1] if len(active) else np.linalg.norm(gradient)
    return stationarity, max(-slack.min(), 0.0)


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize("count", [1, 2, 8])
@pytest.mark.parametrize("seed", SEEDS)
def test_solutions_are_optimal(solver, count, seed):
    for room in (0.0, 0.3):
        program = random_program(seed, count, room)
        solution = make(solver).solve(*program)
        assert solution.success
        assert solution.status == Solved.SOLVER
        assert solution.iterations > 0
        stationarity, primal = kkt_residuals(solution.z, *program)
        assert stationarity < 1e-5
        assert primal < 1e-7


@pytest.mark.parametrize("seed", SEEDS)
def test_osqp_and_clarabel_agree(seed):
    program = random_program(seed, 4, 0.1)
    first, second = (make(name).solve(*program) for name in SOLVERS)
    np.testing.assert_allclose(first.z, second.z, rtol=0, atol=1e-6)


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize("seed", SEEDS)
def test_brute_force_over_active_sets(solver, seed):
    """One wrench: every subset of the six rows as equations, the best feasible one wins."""
    H, g, W, b = random_program(seed, 1, 0.05)
    best, lowest = None, np.inf
    for size in range(6):
        for active in itertools.combinations(range(6), size):
            A = W[0][list(active)]
            K = np.block([[H, A.T], [A, np.zeros((size, size))]])
            z = np.linalg.lstsq(K, np.concatenate([-g, b[0][list(active)]]), rcond=None)[0][:5]
            cost = 0.5 * z @ H @ z + g @ z
            if np.all(W[0] @ z <= b[0] + 1e-9) and cost < lowest:
                best, lowest = z, cost
    np.testing.assert_allclose(make(solver).solve(H, g, W, b).z, best, rtol=0, atol=1e-6)


@pytest.mark.parametrize("seed", SEEDS)
def test_another_method_finds_no_better(seed):
    H, g, W, b = random_program(seed, 2, 0.2)
    rows = stacked(W)
    constraint = {"type": "ineq", "fun": lambda z: b.ravel() - rows @ z, "jac": lambda z: -rows}
    found = minimize(
        lambda z: 0.5 * z @ H @ z + g @ z,
        np.zeros(10),
        jac=lambda z: H @ z + g,
        constraints=[constraint],
        method="SLSQP",
        options={"ftol": 1e-14, "maxiter": 500},
    )
    assert found.success
    z = make("osqp").solve(H, g, W, b).z
    np.testing.assert_allclose(z, found.x, rtol=0, atol=1e-5)


@pytest.mark.parametrize("solver", SOLVERS)
def test_without_active_rows_it_is_a_linear_system(solver, capfd):
    H, g, W, _ = random_program(1, 3)
    solution = make(solver).solve(H, g, W, np.full((3, 6), 100.0))
    np.testing.assert_allclose(solution.z, -np.linalg.solve(H, g), rtol=0, atol=1e-7)
    ctypes.CDLL(None).fflush(None)  # what a solver says stays in the buffer of its library
    assert capfd.readouterr().out == ""


@pytest.mark.parametrize("solver", SOLVERS)
def test_programs_are_reused_without_a_trace(solver):
    """Other sizes in between, other numbers before: the same answer."""
    program = make(solver)
    expected = {}
    for round_ in range(2):
        for count in (2, 1, 6, 2):
            random = random_program(10 * round_ + count, count, 0.1)
            program.solve(*random)
            fixed = random_program(count, count, 0.1)
            z = program.solve(*fixed).z
            assert len(z) == 5 * count
            np.testing.assert_array_equal(expected.setdefault(count, z), z)
            np.testing.assert_array_equal(make(solver).solve(*fixed).z, z)


@pytest.mark.parametrize("solver", SOLVERS)
def test_as_many_blocks_of_another_shape(solver):
    program = make(solver)
    program.solve(*random_program(1, 2))
    # |z_i| <= 1 around the minimum at (3, -3, 0.5, 0.5): one row and three columns change.
    box = np.array([[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]])
    target = np.array([3.0, -3.0, 0.5, 0.25])
    solution = program.solve(np.eye(4), -target, np.stack([box, box]), np.ones((2, 4)))
    assert solution.success
    np.testing.assert_allclose(solution.z, [1.0, -1.0, 0.5, 0.25], rtol=0, atol=1e-6)


@pytest.mark.parametrize("solver", SOLVERS)
def test_a_guess_changes_the_work_and_not_the_answer(solver):
    program = random_program(3, 4, 0.1)
    cold = make(solver).solve(*program)
    for guess in (cold.z, 10.0 * np.ones(20), np.full(20, np.nan), np.full(20, np.inf)):
        warm = make(solver).solve(*program, guess)
        assert warm.success
        np.testing.assert_allclose(warm.z, cold.z, rtol=0, atol=1e-6)


@pytest.mark.parametrize("solver", SOLVERS)
def test_no_foot_stands(solver):
    solution = make(solver).solve(
        np.zeros((0, 0)), np.zeros(0), np.zeros((0, 6, 5)), np.zeros((0, 6))
    )
    assert solution.success
    assert solution.status == Solved.NO_CONTACT
    assert solution.z.shape == (0,)
    assert solution.iterations == 0


@pytest.mark.parametrize("solver", SOLVERS)
def test_contradicting_rows_are_no_success(solver):
    H, g = np.eye(5), np.zeros(5)
    W = np.zeros((1, 2, 5))
    W[0, :, 0] = 1.0, -1.0
    solution = make(solver).solve(H, g, W, -np.ones((1, 2)))
    assert not solution.success
    assert solution.status == Solved.INFEASIBLE


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize("which", range(4))
@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_numbers_that_are_none_are_no_success(solver, which, bad):
    """In the cost, the rows or the right-hand side; the next call works again."""
    program = make(solver)
    values = [array.copy() for array in random_program(4, 2, 0.1)]
    values[which].flat[3] = bad
    solution = program.solve(*values)
    # An infinite right-hand side is a row without a bound.
    assert solution.success == (which == 3 and bad == np.inf)
    if which < 3:
        assert solution.status == Solved.NOT_FINITE
    assert solution.z.shape == (10,)
    good = random_program(4, 2, 0.1)
    np.testing.assert_array_equal(program.solve(*good).z, make(solver).solve(*good).z)


@pytest.mark.parametrize("solver", SOLVERS)
def test_too_few_iterations_are_no_success(solver):
    solution = make(solver, tolerance=1e-12, iterations=2).solve(*random_program(5, 4))
    assert not solution.success
    assert solution.status == Solved.ITERATION_LIMIT


def test_almost_solved_is_not_solved():
    """Drake takes OSQP's "solved inaccurately", up to ten times the tolerance, for success."""
    H, g, W, b = random_program(5, 4, 0.1)
    prog = MathematicalProgram()
    z = prog.NewContinuousVariables(20)
    prog.AddQuadraticCost(H, g, z, is_convex=True)
    for i, (rows, bounds) in enumerate(zip(W, b, strict=True)):
        prog.AddLinearConstraint(rows, np.full(6, -np.inf), bounds, z[5 * i : 5 * i + 5])
    seen = set()
    for limit in range(20, 200):
        solver, options = make_solver("osqp", TOLERANCE, limit, RHO)
        plain = solver.Solve(prog, None, options)
        word = plain.get_solver_details().status_val
        seen.add((word, plain.is_success()))
        assert make("osqp", iterations=limit).solve(H, g, W, b).success == (word == 1)
    assert (2, True) in seen
    assert (1, True) in seen


@pytest.mark.parametrize("name", ["", "OSQP", "gurobi", None])
def test_unknown_solvers_are_refused(name):
    for call in (lambda: make(name), lambda: make_solver(name, 1e-6, 10, 0.1)):
        with pytest.raises(InputError, match="solver") as caught:
            call()
        assert caught.value.value == name
        for known in SOLVERS:
            assert known in caught.value.allowed


def test_the_cone_keeps_a_wrench_that_is_inside():
    """min |z - w| is w inside (18), and something on the boundary outside."""
    W = line_cone(MU, X)[None]
    inside = np.array([10.0, -5.0, 100.0, 1.0, -0.5])
    program = make("osqp")
    kept = program.solve(np.eye(5), -inside, W, np.zeros((1, 6)))
    np.testing.assert_allclose(kept.z, inside, rtol=0, atol=1e-5)
    outside = np.array([0.0, 0.0, -50.0, 0.0, 0.0])
    pulled = program.solve(np.eye(5), -outside, W, np.zeros((1, 6)))
    np.testing.assert_allclose(pulled.z, 0.0, rtol=0, atol=1e-5)


@pytest.mark.parametrize("spoil", ["cost", "rows"])
def test_a_program_that_osqp_refuses_is_no_success_and_prints_nothing(capfd, spoil):
    H, g, W, b = random_program(4, 2, 0.1)
    if spoil == "cost":
        H = H - 50.0 * np.eye(len(H))
    else:
        W = 1e300 * W
    solution = make("osqp").solve(H, g, W, b)
    assert (solution.success, solution.status) == (False, Solved.ILL_POSED)
    ctypes.CDLL(None).fflush(None)  # what C keeps until its buffer is full
    assert capfd.readouterr().out == ""
