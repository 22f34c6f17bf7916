"""Falls with a known cause: by hand, one fall indicator each, and simulated."""

import numpy as np
import pytest

from drake_linefoot.gait.constants import swing_acceleration, swing_time_min
from drake_linefoot.gait.step_program import PEAK
from drake_linefoot.lab.results.fall_indicators import beyond_capture
from drake_linefoot.lab.results.falls import diagnose
from drake_linefoot.lab.results.judge import judge
from drake_linefoot.lab.scenario import Scenario, Segment
from drake_linefoot.lab.scenario.disturbances import GroundParameters, PushParameters
from drake_linefoot.lab.simulation.run import simulate
from drake_linefoot.lab.wiring.closed_loop import build_closed_loop
from tests.helpers.falls import (
    DUE,
    HUMANOID,
    LEFT,
    LIFT,
    ONSET,
    RIGHT,
    TIME,
    between,
    channels,
    fallen,
    swing,
)
from tests.helpers.recorded_runs import make_run, short_run
from tests.helpers.similar import TIME as SECOND
from tests.helpers.similar import similar_robot, similar_run


def joint(name):
    names = HUMANOID.description.actuated_joints
    return HUMANOID.actuated_q[names.index(name)]


def slides(distance, foot=LEFT):
    values = channels()
    values["contact_points"][:, foot, :, 0] += distance * np.clip((TIME - 1.3) / 0.1, 0, 1)[:, None]
    return values


def stopped(name, angle, begin=1.42, end=1.46):
    values = channels()
    values["q"][between(begin, end), joint(name)] = angle
    return values


def unsolved(name, count):
    values, at = channels(), np.flatnonzero(between(1.4, 1.4 + 0.001 * count))
    if name == "mpc_failures":
        values[name][at[0] :] = np.minimum(np.arange(len(TIME) - at[0]) + 1, count)
    else:
        values[name][at] = 0.0
    return values


def moved(begin, end):
    values = swing(channels())
    values["foothold"][:, 1, 0] += 0.1 * (TIME - DUE)
    values["moved_footholds"] = np.cumsum(between(begin, end)).astype(float)
    return values


def runs_away(speed):
    """The CoM passes the place where the foot lands at a speed that no step captures."""
    values = swing(channels())
    values["com"][:, 0] = speed * (TIME - DUE)
    return values


def lands_beside(miss):
    values = swing(channels())
    values["contact_points"][DUE - 0.01 < TIME, RIGHT, :, 0] += miss
    return values


def reaches_down(duration):
    """A foot that finds no ground and goes straight down, with the swing prolonged."""
    values = swing(channels(), DUE + duration, DUE + duration)
    down = between(DUE, DUE + duration)
    values["swing_position"][down, 1] = [0.0, -0.08, 0.0]
    values["swing_position"][down, 1, 2] -= 0.2 * (TIME[down] - DUE)
    return values


CASES = {
    "nothing": ("other", channels()),
    "a swing": ("other", swing(channels())),
    "slip of 5 cm": ("slip", slides(0.05)),
    "slip of 2 cm": ("other", slides(0.02)),
    "MPC fails": ("solver", unsolved("mpc_failures", 4)),
    "MPC fails once": ("other", unsolved("mpc_failures", 1)),
    "controller fails": ("solver", unsolved("wbc_success", 8)),
    "controller fails once": ("other", unsolved("wbc_success", 1)),
    "straight knee": ("joint limit", stopped("left_knee", 0.0)),
    "ankle": ("joint limit", stopped("right_ankle", 0.8)),
    "knee bent": ("other", stopped("left_knee", 0.1)),
    "straight knee for a moment": ("other", stopped("left_knee", 0.0, 1.42, 1.425)),
    "after the onset": ("other", stopped("left_knee", 0.0, 1.6, 1.7)),
    "long before": ("other", stopped("left_knee", 0.0, 0.7, 0.8)),
    "legs crossed": ("self-collision", stopped("left_hip_abad", -0.5)),
    "foothold clipped": ("no reachable foothold", moved(LIFT, DUE)),
    "foothold clipped at first": ("other", moved(LIFT, LIFT + 0.05)),
    "runs away": ("no reachable foothold", runs_away(6.0)),
    "walks": ("other", runs_away(0.5)),
    "lands late": ("late step", swing(channels(), DUE + 0.03)),
    "lands 10 ms late": ("other", swing(channels(), DUE + 0.01)),
    "reaches down": ("late step", reaches_down(0.03)),
    "lands beside": ("late step", lands_beside(0.06)),
    "lands there": ("other", lands_beside(0.02)),
}


@pytest.mark.parametrize("name", CASES)
def test_each_symptom_is_found_alone(name):
    expected, values = CASES[name]
    found = diagnose(fallen(values))
    assert found.cause == expected
    assert {s.name for s in found.indicators} == {expected} - {"other"}
    assert found.onset == pytest.approx(ONSET, abs=0.002)
    assert "pitch" in found.text


@pytest.fixture(scope="module")
def small(tmp_path_factory):
    return similar_robot(tmp_path_factory.mktemp("small"))


@pytest.mark.parametrize("name", CASES)
def test_a_robot_a_quarter_as_high_falls_of_the_same(name, small):
    """Neither 5 N nor 3 cm nor 15 ms are the same to it."""
    before = diagnose(fallen(CASES[name][1]))
    found = diagnose(similar_run(fallen(CASES[name][1]), small))
    assert found.cause == before.cause
    assert [s.name for s in found.indicators] == [s.name for s in before.indicators]
    assert found.onset == pytest.approx(SECOND * before.onset)
    severities = [s.severity for s in before.indicators]  # but that times are whole ticks of 2 ms
    assert [s.severity for s in found.indicators] == pytest.approx(severities, rel=0.3)


def test_foot_in_the_air_may_slide_and_bend_its_ankle():
    values = slides(0.05, RIGHT)
    values["q"][between(1.3, 1.4), joint("right_ankle")] = 0.8
    values["true_normal"][between(1.25, 1.48), RIGHT] = 0.0
    assert diagnose(fallen(values)).cause == "other"


def test_what_came_first_in_the_last_step_is_the_cause():
    values = slides(0.05)
    values["q"][between(1.42, 1.46), joint("left_knee")] = 0.0
    assert diagnose(fallen(values)).cause == "slip"
    values["q"][between(1.28, 1.30), joint("left_knee")] = 0.0
    assert diagnose(fallen(values)).cause == "joint limit"


def test_what_was_over_a_step_earlier_was_survived():
    values = stopped("left_knee", 0.0, 1.1, 1.2)
    assert diagnose(fallen(values)).cause == "joint limit"
    values["mpc_failures"] = unsolved("mpc_failures", 4)["mpc_failures"]
    found = diagnose(fallen(values))
    assert found.cause == "solver"
    assert [s.name for s in found.indicators] == ["joint limit", "solver"]
    assert found.text.startswith("joint limit -400 ms (left_knee standing for")


def test_upright_run_has_no_cause():
    found = diagnose(make_run(TIME, **channels()))
    assert (found.cause, found.indicators, found.text) == ("upright", (), "")
    assert judge(short_run())["onset"] is None


def captured(offset, growth, low, high):
    """Whether steps of a width within [low, high] keep a DCM `offset` from the foot at bay."""
    steady = 0.5 * (low + high) / (1.0 + growth)  # where the offset repeats
    for _ in range(30):
        offset = np.clip(growth * offset + steady, low, high) - growth * offset
    return abs(offset) < 1.0


def steps_of_legs():
    """Yield steps of some durations: growth of the DCM, largest length, least and largest width.

    A foot goes, from rest to rest, as far as the leg accelerates it, and two lengths in a step.
    """
    gait, limits = Scenario().gait, HUMANOID.description.limits
    acceleration, both = swing_acceleration(HUMANOID), gait.double_support_min
    quickest = swing_time_min(gait.swing_height, acceleration) + both
    still = both + 0.2 * gait.settle_time  # of a step that follows an insufficient one
    for duration in np.arange(quickest, quickest + 0.3, 0.002):
        ahead, aside = acceleration[:2] * (duration - still) ** 2 / PEAK
        growth = np.exp(np.sqrt(9.81 / gait.com_height) * duration)
        narrow, wide = limits.step_width_min, limits.step_width_max
        yield growth, min(limits.step_length, 0.5 * ahead), narrow, min(wide, narrow + aside)


@pytest.mark.parametrize("side", [LEFT, RIGHT])
def test_capture_region_is_that_of_a_pendulum_that_steps(side):
    inwards, steps = (-1.0 if side == LEFT else 1.0), list(steps_of_legs())  # y of the next foot
    for offset in np.linspace(-0.5, 0.8, 53):
        values = channels()
        values["com"][:, 1] = values["contact_points"][0, side, 0, 1] + inwards * offset
        found = beyond_capture(fallen(values), HUMANOID, side, 1000)
        if abs(found - 1.0) > 0.05:
            expected = any(captured(offset, growth, *widths) for growth, _, *widths in steps)
            assert (found < 1.0) == expected, offset
    for offset in np.linspace(-1.5, 1.5, 53):
        values = channels()
        values["com"][:] = [offset, values["contact_points"][0, side, 0, 1] + 0.1 * inwards, 0.642]
        found = beyond_capture(fallen(values), HUMANOID, side, 1000)
        if abs(found - 1.0) > 0.05:
            stays = any(abs(offset) * growth - length < abs(offset) for growth, length, *_ in steps)
            assert (found < 1.0) == stays, offset


def walk_at(speed):
    return [Segment("stand", 0.3), Segment("walk", 3.0, True, [speed, 0.0])]


# Falls in which one thing comes long before all others, however the processor rounds.
FALLS = {
    "slip": {"segments": walk_at(0.6), "ground": GroundParameters(friction=0.04)},
    "no reachable foothold": {
        "segments": walk_at(0.3),
        "pushes": [PushParameters(time=2.0, impulse=40.0)],
    },
}


@pytest.mark.slow
@pytest.mark.parametrize("expected", FALLS)
def test_simulated_fall_has_its_cause(expected):
    run = simulate(build_closed_loop(Scenario(**FALLS[expected])))
    assert run.fell
    found = judge(run)
    assert found["cause"] == expected
    assert expected in found["fall_indicators"]
    assert found["onset"] < found["fall_time"]
