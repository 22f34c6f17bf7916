"""Only solvers that are accurate enough are timed, at the loosest setting that is."""

import numpy as np
import pytest

from studies.bench import solvers
from studies.bench.blocks import MpcUpdate
from studies.bench.solvers import LARGEST_ERROR, Target, first_wrench_error, loosest
from studies.common.recorder import spread
from tests.helpers.walked import walk

HALF_LENGTH = 0.075  # [m]


@pytest.fixture(scope="module")
def targets():
    update = MpcUpdate(walk().humanoid, walk().scenario)
    programs = [update.program(p) for p in walk().walking_problems(4)]
    return [Target(qp, solvers.reference_solution(qp)) for qp in programs]


def off_by(newtons, after=0):
    """A solver whose first wrench is wrong by `newtons` times its tolerance."""

    def prepare(qp, tolerance):
        z = solvers.reference_solution(qp)
        z[5 * after] += newtons * tolerance / qp.scale[5 * after]
        return lambda: z

    return prepare


def test_loosest_setting_that_is_accurate_is_taken(targets):
    found = loosest(off_by(50.0), targets, (1.0, 0.1, 0.01, 0.001), HALF_LENGTH)
    assert found.tolerance == 0.01
    assert found.error == pytest.approx(0.5, abs=1e-9)


def test_inaccurate_solver_is_refused(targets):
    found = loosest(off_by(50.0), targets, (1.0, 0.1), HALF_LENGTH)
    assert found.tolerance is None
    assert found.error == pytest.approx(5.0, abs=1e-9)


def test_one_bad_program_is_enough_to_refuse(targets):
    calls = []

    def prepare(qp, tolerance):
        calls.append(qp)
        return off_by(2.0 if len(calls) == len(targets) else 0.0)(qp, 1.0)

    assert loosest(prepare, targets, (1.0,), HALF_LENGTH).tolerance is None


@pytest.mark.parametrize("says", [None, np.zeros(3), np.nan])
def test_failed_solver_is_refused(targets, says):
    def prepare(qp, tolerance):
        return lambda: says if says is None or np.ndim(says) else np.full(len(qp.g), says)

    found = loosest(prepare, targets, (1.0,), HALF_LENGTH)
    assert found.tolerance is None
    assert found.error == float("inf")


def test_only_the_first_wrench_counts_and_torques_count_at_the_end_of_the_line(targets):
    target = targets[0]
    standing = int((target.qp.active[:, 0] == 0).sum())
    for index, change, expected in (
        (0, -3.0, 3.0),
        (3, 0.3, 0.3 / HALF_LENGTH),
        (5 * standing, 7.0, 0.0),
    ):
        z = target.z.copy()
        z[index] += change / target.qp.scale[index]
        assert first_wrench_error(target, z, HALF_LENGTH) == pytest.approx(expected, abs=1e-9)


def test_solutions_of_recorded_programs_are_the_recorded_plans(targets):
    """The programs that are timed are those that were solved on the way."""
    for problem, target in zip(walk().walking_problems(4), targets, strict=True):
        wrench = target.qp.wrenches(target.z * target.qp.scale)
        error = np.abs(wrench[0] - problem.plan.wrench[0]).max()
        assert error < LARGEST_ERROR  # [N, N m]


@pytest.mark.parametrize("name", list(solvers.SOLVERS))
def test_every_solver_that_is_there_is_accurate(targets, name):
    solver = solvers.SOLVERS[name]
    if solver.package != "drake":
        pytest.importorskip(solver.package)
    found = loosest(solver.prepare, targets, solver.tolerances, HALF_LENGTH)
    assert found.tolerance is not None
    assert found.error <= LARGEST_ERROR


def test_rows_are_the_cones(targets):
    qp = targets[0].qp
    z = np.random.default_rng(0).normal(size=len(qp.g))
    expected = np.einsum("nij,nj->ni", qp.W, z.reshape(len(qp.W), -1)).ravel()
    np.testing.assert_allclose(qp.rows() @ z, expected, atol=1e-12)


def test_spread_takes_the_first_and_the_last():
    assert spread(list(range(11)), 3) == [0, 5, 10]
    assert spread(list(range(10)), 4) == [0, 3, 6, 9]
    assert spread([1, 2], 3) == [1, 2]
