"""What was recorded is what the blocks saw: run alone, they say again what they said."""

import numpy as np

from studies.bench import blocks
from tests.helpers.walked import walk


def test_dynamics_are_timed_as_they_are_and_by_drakes_calls():
    times = blocks.dynamics_of(walk().humanoid, walk().walking_states(3))()
    assert {name: len(some) for name, some in times.items()} == {"dynamics": 3, "dynamics_drake": 3}
    assert min(map(min, times.values())) > 0.0


def test_controller_gives_the_recorded_torque():
    wbc = blocks.WbcTick(walk().humanoid, walk().scenario)
    for tick in walk().walking_ticks(5):
        seconds, torque = wbc(tick)
        assert seconds > 0.0
        np.testing.assert_allclose(torque, tick.torque, atol=1e-9)  # [N m]


def test_estimator_gives_the_recorded_state():
    update = blocks.estimator_update(walk().humanoid, walk().scenario)
    for tick in walk().walking_ticks(5):
        _, state = update(tick, tick.before.estimator)
        for group, expected in zip(state, tick.after.estimator, strict=True):
            np.testing.assert_allclose(group, expected, atol=1e-9)


def test_gait_gives_the_recorded_state():
    update = blocks.gait_update(walk().humanoid, walk().scenario)
    for tick in walk().walking_ticks(5):
        _, (state,) = update(tick, [tick.before.gait])
        np.testing.assert_allclose(state, tick.after.gait, atol=1e-9)


def test_mpc_gives_the_recorded_plan():
    update = blocks.MpcUpdate(walk().humanoid, walk().scenario)
    for problem in walk().walking_problems(4):
        _, reference = update.reference(problem)
        np.testing.assert_allclose(reference.r, problem.reference.r, atol=1e-9)
        _, plan = update.whole(problem)
        np.testing.assert_allclose(plan.wrench, problem.plan.wrench, atol=1e-6)  # [N, N m]


def test_parts_of_the_mpc_are_all_there():
    update = blocks.MpcUpdate(walk().humanoid, walk().scenario)
    parts = update.parts(walk().walking_problems(1)[0])
    assert tuple(parts) == blocks.MpcUpdate.PARTS
    assert min(parts.values()) >= 0.0


def test_problems_with_the_same_horizon_are_the_recorded_ones():
    recorded = walk().walking_problems(1000)[:3]
    again = blocks.with_other_horizon(walk().humanoid, walk().scenario, recorded)
    for new, old in zip(again, recorded[1:], strict=True):
        np.testing.assert_allclose(new.reference.L, old.reference.L, atol=1e-9)
        np.testing.assert_allclose(new.plan.wrench[0], old.plan.wrench[0], atol=1e-3)  # [N, N m]
