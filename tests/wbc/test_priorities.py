"""Strict priorities: one factorisation against the textbook's recursion and brute force."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drake_linefoot.centroidal import sample_plan
from drake_linefoot.math.linear import solve_square
from drake_linefoot.wbc import priorities
from drake_linefoot.wbc.priorities import prioritised_acceleration
from drake_linefoot.wbc.tasks.momentum import momentum_task
from drake_linefoot.wbc.tasks.posture import joint_task
from drake_linefoot.wbc.tasks.swing import swing_task
from drake_linefoot.wbc.tasks.task import TaskRows
from studies.paper.two_point import recursive_acceleration
from tests.helpers.whole_body import (
    contact_tasks,
    controller_of,
    foot_in_the_air,
    prioritised,
)

N = 24
seeds = st.integers(0, 10**6)


def random_mass(rng, n=N):
    A = rng.normal(size=(n, n))
    return A @ A.T / n + 0.05 * np.eye(n)


def random_tasks(rng, sizes, n=N):
    return [TaskRows(rng.normal(size=(m, n)), rng.normal(size=m)) for m in sizes]


def residual(task, vdot):
    return task.J @ vdot - task.b


@given(seeds, st.lists(st.integers(1, 6), min_size=1, max_size=5))
def test_it_equals_the_recursion_on_random_stacks(seed, sizes):
    rng = np.random.default_rng(seed)
    M, tasks = random_mass(rng), random_tasks(rng, sizes)
    if sum(sizes) > 18:  # near N rows the recursion itself loses digits
        tasks = tasks[:3]
    vdot, dropped = prioritised(M, tasks)
    assert dropped == 0
    np.testing.assert_allclose(vdot, recursive_acceleration(M, tasks), rtol=1e-9, atol=1e-9)


@given(seeds, st.lists(st.integers(1, 6), min_size=1, max_size=4))
def test_it_meets_every_task_with_the_least_kinetic_effort(seed, sizes):
    """vdot' M vdot is least: no acceleration of the stack's null space makes it smaller."""
    rng = np.random.default_rng(seed)
    M, tasks = random_mass(rng), random_tasks(rng, sizes)
    vdot, _ = prioritised(M, tasks)
    J, b = np.vstack([t.J for t in tasks]), np.concatenate([t.b for t in tasks])
    np.testing.assert_allclose(J @ vdot, b, atol=1e-8)
    null = np.linalg.svd(J)[2][len(J) :]
    np.testing.assert_allclose(null @ M @ vdot, 0.0, atol=1e-7 * (1 + np.abs(M @ vdot).max()))


def walking_tasks(d, record, humanoid):
    """The stack of the whole-body controller, built as it builds it; feet are not damped."""
    c, targets = controller_of().constants, record.targets
    sides = [i for i in (0, 1) if targets.contact[i]]
    plan = sample_plan(record.plan, targets.time)
    tasks = [contact_tasks(d, sides, 0.0), momentum_task(d, plan, humanoid.mass, c.gains)]
    if targets.swings.any():
        side = foot_in_the_air(targets)
        tasks.append(swing_task(d, side, targets.swing_target(side), np.zeros(2), c.gains))
    return [*tasks, joint_task(d, c.arms, targets.arms, c.gains)]


def test_it_equals_the_recursion_on_a_walk(humanoid, records, dynamics_of):
    """Relative to the largest acceleration; the stacks have 24 rows for 24 unknowns."""
    sizes = set()
    for record in records[::9]:
        d = dynamics_of(record.x)
        tasks = walking_tasks(d, record, humanoid)
        sizes.add(sum(len(t.b) for t in tasks))
        vdot, dropped = prioritised(d.M, tasks)
        assert dropped == 0
        slow = recursive_acceleration(d.M, tasks)
        np.testing.assert_allclose(vdot, slow, rtol=0, atol=1e-9 * np.abs(slow).max())
    assert sizes == {24}


@given(seeds, st.integers(0, 12))
def test_a_lower_task_never_disturbs_a_higher_one(seed, more):
    """Not even when there are more rows than unknowns."""
    rng = np.random.default_rng(seed)
    M, tasks = random_mass(rng), random_tasks(rng, [5, 6, 5, 8])
    lower = random_tasks(rng, [more] if more else [1])
    high, _ = prioritised(M, tasks[:3])
    for stack in (tasks, [*tasks[:3], *lower, tasks[3]]):
        vdot, _ = prioritised(M, stack)
        for task in tasks[:3]:
            np.testing.assert_allclose(residual(task, vdot), residual(task, high), atol=1e-7)


def test_on_a_walk_other_lower_targets_leave_the_higher_tasks_met(humanoid, records, dynamics_of):
    rng = np.random.default_rng(1)
    for record in records[::25]:
        d = dynamics_of(record.x)
        tasks = walking_tasks(d, record, humanoid)
        for k in range(1, len(tasks)):
            other = [
                *tasks[:k],
                *(TaskRows(t.J, t.b + 50 * rng.normal(size=len(t.b))) for t in tasks[k:]),
            ]
            vdot, _ = prioritised(d.M, other)
            for task in tasks[:k]:
                scale = 1.0 + np.abs(task.J) @ np.abs(vdot)
                assert np.abs(residual(task, vdot) / scale).max() < 1e-9


# --- loss of rank -----------------------------------------------------------------------


@pytest.mark.parametrize("contradiction", [0.0, 3.0])
@pytest.mark.parametrize("at", [0, 1])
def test_a_dependent_row_is_dropped_and_the_rest_is_met(at, contradiction):
    """A row that repeats what is asked above it, or asks for something else."""
    rng = np.random.default_rng(2)
    M, tasks = random_mass(rng), random_tasks(rng, [5, 6, 4])
    mix = rng.normal(size=5)
    J = np.vstack([tasks[1].J, mix @ tasks[0].J])
    b = np.append(tasks[1].b, mix @ tasks[0].b + contradiction)
    order = [*range(6), 6] if at else [6, *range(6)]
    stack = [tasks[0], TaskRows(J[order], b[order]), tasks[2]]
    vdot, dropped = prioritised(M, stack)
    assert dropped == 1
    for task in tasks:
        np.testing.assert_allclose(residual(task, vdot), 0.0, atol=1e-9)
    assert mix @ residual(tasks[0], vdot) == pytest.approx(0.0, abs=1e-9)
    expected, _ = prioritised(M, tasks)
    np.testing.assert_allclose(vdot, expected, atol=1e-9)


def test_a_task_given_twice_counts_once():
    rng = np.random.default_rng(3)
    M, tasks = random_mass(rng), random_tasks(rng, [5, 6])
    again = TaskRows(tasks[0].J, tasks[0].b + 7.0)
    vdot, dropped = prioritised(M, [*tasks, again])
    assert dropped == 5
    np.testing.assert_allclose(residual(tasks[0], vdot), 0.0, atol=1e-10)
    once, _ = prioritised(M, tasks)
    np.testing.assert_allclose(vdot, once, atol=1e-10)


def test_with_more_rows_than_unknowns_the_highest_are_met():
    rng = np.random.default_rng(4)
    M, tasks = random_mass(rng), random_tasks(rng, [10, 10, 10])
    vdot, dropped = prioritised(M, tasks)
    assert dropped == 6
    np.testing.assert_allclose(residual(tasks[0], vdot), 0.0, atol=1e-8)
    np.testing.assert_allclose(residual(tasks[1], vdot), 0.0, atol=1e-8)
    np.testing.assert_allclose(residual(tasks[2], vdot)[:4], 0.0, atol=1e-7)
    J = np.vstack([t.J for t in tasks])[:N]
    b = np.concatenate([t.b for t in tasks])[:N]
    np.testing.assert_allclose(vdot, np.linalg.solve(J, b), rtol=1e-7, atol=1e-7)


def test_rows_of_nothing_are_dropped():
    rng = np.random.default_rng(5)
    M, tasks = random_mass(rng), random_tasks(rng, [4, 3])
    nothing = TaskRows(np.zeros((2, N)), np.array([1.0, 0.0]))
    vdot, dropped = prioritised(M, [tasks[0], nothing, tasks[1]])
    assert dropped == 2
    for task in tasks:
        np.testing.assert_allclose(residual(task, vdot), 0.0, atol=1e-10)


def test_both_ways_agree_where_no_row_is_dependent():
    """Row by row (forced by a dependent last row) and all at once."""
    rng = np.random.default_rng(6)
    M, tasks = random_mass(rng), random_tasks(rng, [5, 6, 5])
    extra = TaskRows(tasks[0].J[:1], tasks[0].b[:1])
    slow, dropped = prioritised(M, [*tasks, extra])
    fast, none = prioritised(M, tasks)
    assert (dropped, none) == (1, 0)
    np.testing.assert_allclose(slow, fast, atol=1e-10)


@pytest.mark.parametrize("near", [1.0, 1e-2, 1e-6, 0.0])
def test_as_many_rows_as_velocities(near):
    """Solved as they stand or row by row, where two of them nearly agree: they are met in order."""
    rng = np.random.default_rng(10)
    M, tasks = random_mass(rng), random_tasks(rng, [10, 6, 8])
    tasks[2].J[3] = tasks[0].J[2] + near * tasks[2].J[3]
    vdot, dropped = prioritised(M, tasks)
    assert dropped == (near < priorities.RANK_TOLERANCE)
    scale = N * np.abs(vdot).max()
    for task in tasks[:2]:
        np.testing.assert_allclose(residual(task, vdot), 0.0, atol=1e-12 * scale)
    if not dropped:
        np.testing.assert_allclose(residual(tasks[2], vdot), 0.0, atol=1e-9 * scale)


def test_a_walk_is_mostly_solved_as_it_stands(humanoid, records, dynamics_of):
    """Its stacks are square and well conditioned."""
    regular = []
    for record in records[::9]:
        tasks = walking_tasks(dynamics_of(record.x), record, humanoid)
        J, b = np.vstack([t.J for t in tasks]), np.concatenate([t.b for t in tasks])
        regular.append(solve_square(J, b, priorities.LEAST_PIVOT)[1])
    assert np.mean(regular) > 0.9


@pytest.mark.parametrize("away", [1e-2, 1e-3, 1e-4])
def test_rows_that_nearly_depend_on_each_other_are_met_all_the_same(away):
    """Row by row, with accelerations of 1 / `away`: the highest rows keep their digits."""
    rng = np.random.default_rng(8)
    few = rng.normal(size=(12, 3)) @ rng.normal(size=(3, N))
    J = np.vstack([few + away * rng.normal(size=(12, N)), few[:1] * 0.0])
    task = TaskRows(J, np.append(rng.normal(size=12), 0.0))
    vdot, dropped = prioritised(random_mass(rng), [task])
    assert dropped == 1
    np.testing.assert_allclose(residual(task, vdot)[:12], 0.0, atol=1e-13 * np.abs(vdot).max() * N)


def test_an_empty_task_is_no_task():
    rng = np.random.default_rng(7)
    M, tasks = random_mass(rng), random_tasks(rng, [6])
    flight = TaskRows(np.zeros((0, N)), np.zeros(0))
    one, _ = prioritised(M, [flight, *tasks])
    two, _ = prioritised(M, tasks)
    np.testing.assert_array_equal(one, two)


def test_a_mass_matrix_that_is_not_positive_definite_is_reported():
    rng = np.random.default_rng(9)
    task = random_tasks(rng, [3])[0]
    vdot, dropped, positive = prioritised_acceleration(-random_mass(rng), task.J, task.b)
    assert (dropped, positive) == (0, False)
    np.testing.assert_array_equal(vdot, np.zeros(N))
