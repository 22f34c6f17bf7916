"""The closed loop under a force that lasts: a cable, wind, a payload's pull."""

import numpy as np
import pytest

from drake_linefoot.lab.scenario import Scenario, Segment
from drake_linefoot.lab.scenario.disturbances import PushParameters
from drake_linefoot.lab.simulation.run import simulate
from drake_linefoot.lab.wiring.closed_loop import build_closed_loop
from drake_linefoot.robot.humanoid import load_humanoid

BEGINS = 1.0  # [s]


def under(force, direction, segment):
    """A segment under a force [N] from `BEGINS` on."""
    lasts = segment.duration - BEGINS
    push = PushParameters(BEGINS, lasts, force * lasts, direction)
    run = simulate(build_closed_loop(Scenario(segments=[segment], pushes=[push])))
    assert not run.fell
    return run


def velocity(run, begin, end):
    first, last = np.searchsorted(run.time, [begin, end - 1e-9])
    return (run.com[last] - run.com[first])[:2] / (run.time[last] - run.time[first])


def known(run, force, direction, within):
    expected = force * np.array([np.cos(direction), np.sin(direction), 0.0])
    np.testing.assert_allclose(run.reference_external[-1, 3:], expected, atol=within)


@pytest.mark.slow
@pytest.mark.parametrize("direction", [np.pi, 0.0, 0.5 * np.pi, -2.2])
def test_it_walks_as_it_is_told_whatever_pulls(direction):
    """30 N are an eighth of its weight; within 0.05 m/s after 3 s."""
    run = under(30.0, direction, Segment("forward", 6.3, True, [0.4, 0.0]))  # 5 strides more
    np.testing.assert_allclose(velocity(run, BEGINS + 3.0, 6.3), [0.4, 0.0], atol=0.05)
    known(run, 30.0, direction, within=2.0)


@pytest.mark.slow
@pytest.mark.parametrize("direction", [np.pi, 0.0, 0.5 * np.pi, -2.2])
def test_it_stands_still_under_a_force_that_begins_at_once(direction):
    """15 N: no step, and at rest within 2 s, as far upwind as balance asks for."""
    run = under(15.0, direction, Segment("stand", 3.6))
    late = run.time >= BEGINS + 2.0
    assert not run.gait_steps.any()
    assert np.abs(run.v[late]).max() < 0.05  # [m/s], [rad/s]
    known(run, 15.0, direction, within=0.5)
    weight, height = load_humanoid("mit_humanoid").mass * 9.81, run.q[-1, 6]  # where it acts
    moved = run.com[-1, :2] - run.com[int(1000 * BEGINS), :2]
    assert np.linalg.norm(moved) == pytest.approx(15.0 * height / weight, abs=0.01)


@pytest.mark.slow
@pytest.mark.parametrize("direction", [np.pi, 0.5 * np.pi])
def test_it_stands_again_under_a_force_that_makes_it_step(direction):
    """30 N: as hard as its feet are long; it steps, and then stands for good."""
    run = under(30.0, direction, Segment("stand", 6.0))
    late = run.time >= BEGINS + 3.0
    assert np.ptp(run.gait_steps[late]) == 0.0
    assert np.ptp(run.com[late], axis=0).max() < 0.1


def test_what_nothing_pulls_at_leans_nowhere():
    segments = [Segment("stand", 0.5), Segment("forward", 1.5, True, [0.6, 0.0])]
    run = simulate(build_closed_loop(Scenario(segments=segments)))
    assert np.linalg.norm(run.reference_external[:, 3:5], axis=1).max() < 2.0
