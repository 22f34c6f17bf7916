"""Steps after an insufficient one: recovery steps, or the same foot makes them."""

from itertools import pairwise

import numpy as np
import pytest

from drake_linefoot.gait.footsteps import heading_vector, settle_time, weight_shift
from drake_linefoot.gait.next_stance import coming_step, next_stance
from drake_linefoot.gait.parameters import GaitParameters
from drake_linefoot.gait.pendulum import switch_time
from drake_linefoot.gait.planner import lift
from drake_linefoot.gait.step_program import Step
from drake_linefoot.gait.touchdown import is_insufficient, step_problem
from drake_linefoot.statuses import Mode
from tests.helpers.horizons import horizon_at, phases_of, pieces_of
from tests.helpers.pendulum_robot import DT, PendulumRobot, dcm_on
from tests.helpers.phases import mode_of, phase_end, phase_start, repeats_swing, swing_of

COMMANDS = [[0.4, -0.1, -0.3, 1.0], [0.4, 0.1, 0.3, 1.0]]  # mirror images, by `side`
BEYOND = 0.65  # [m/s] of a push towards the foot that is just about to land
SIDES = [0, 1]


def until(robot, reached):
    """Tick until a state is reached; the states on the way."""
    states = []
    while not states or not reached(robot.state):
        states += [t.state for t in robot.run(robot.command, DT)]
        assert len(states) < 3000
    return states


def before_landing(side, **parameters):
    """A robot that walks, so short before the foot `side` lands that its foothold stays."""
    robot = PendulumRobot(GaitParameters(first_swing=("left", "right")[side], **parameters))
    robot.command = COMMANDS[side]
    robot.run(robot.command, 1.5)

    def about_to_land(s):
        return (
            mode_of(s) == Mode.SWING
            and s.clock.side != side
            and phase_end(s) - s.clock.time < 0.045
        )

    until(robot, lambda s: not about_to_land(s))
    until(robot, about_to_land)
    return robot


def pushed(side, speed=BEYOND, **parameters):
    """The same after a push to that side, at its touchdown; the states after it for 1.2 s."""
    robot = before_landing(side, **parameters)
    outward = speed if side == 0 else -speed
    robot.com_velocity[:2] += heading_vector(robot.state.command.yaw, 0.0, outward)
    steps = robot.state.clock.steps
    until(robot, lambda s: s.clock.steps > steps)
    at = robot.state
    return robot, at, until(robot, lambda s: s.clock.time > at.clock.time + 1.2)


@pytest.mark.parametrize("side", SIDES)
def test_the_coming_step_is_the_swing_that_then_begins(side):
    """At lift-off to the bit; from a touchdown what the pendulum makes of it meanwhile."""
    robot = before_landing(side)
    until(robot, lambda s: mode_of(s) == Mode.DOUBLE)
    c, s, wait = robot.constants, robot.state, robot.constants.double_support
    s = s.copy()
    s.clock.side = 1 - side  # the weight is still there
    foreseen = coming_step(s, side, wait, c)
    until(robot, lambda s: s.clock.time > phase_end(s) - 1.5 * DT)
    now = robot.state.copy()
    at_lift = coming_step(now, side, 0.0, c)
    lift(now, 1 - side, c)
    assert (mode_of(now), now.clock.side) == (Mode.SWING, side)
    heading = now.command.yaw + now.command.turn_rate * (
        c.single_support + 0.5 * (c.single_support + wait)
    )
    for name, value in step_problem(now, 1 - side, heading, 0, c)._asdict().items():
        np.testing.assert_allclose(getattr(at_lift, name), value, atol=1e-12, err_msg=name)
    for name in ("dcm", "foot", "offset"):
        np.testing.assert_allclose(
            getattr(foreseen, name), getattr(at_lift, name), atol=2e-3, err_msg=name
        )


@pytest.mark.parametrize("side", SIDES)
def test_a_foot_that_landed_too_near_swings_again(side):
    """The push comes when its foothold is decided: the DCM goes beyond it."""
    robot, at, states = pushed(side)
    assert (mode_of(at), at.clock.side, repeats_swing(at)) == (Mode.DOUBLE, 1 - side, True)
    assert phase_end(at) - at.clock.time == pytest.approx(robot.constants.double_support_min)
    swing = next(s for s in states if mode_of(s) == Mode.SWING)
    assert swing.clock.side == 1 - side
    landed = next(s for s in states if mode_of(s) == Mode.DOUBLE and s.clock.side == side)
    way = heading_vector(-at.command.yaw, *(landed.robot.feet[side] - at.robot.feet[side])[:2])
    assert way[1] * (1, -1)[side] > 0.15  # farther out than it was
    assert states[-1].recovery.steps == 0  # saved


def test_a_walk_that_nothing_disturbs_never_recovers_nor_steps_twice_with_a_foot():
    robot = PendulumRobot()
    states = [t.state for t in robot.run(COMMANDS[0], 4.0)]
    assert not any(repeats_swing(s) or s.recovery.steps for s in states)
    lifted = [a.clock.side for b, a in pairwise(states) if mode_of(a) == Mode.SWING != mode_of(b)]
    assert len(lifted) > 8
    assert all(a != b for a, b in pairwise(lifted))


@pytest.mark.parametrize("side", SIDES)
def test_the_plan_keeps_the_weight_on_the_foot_that_goes_on_standing(side):
    robot, at, _ = pushed(side)
    horizon = horizon_at(at, robot.constants, 0.5)
    phases, pieces = phases_of(horizon), pieces_of(horizon)
    np.testing.assert_array_equal(pieces[0].centre, at.robot.feet[1 - side, :2])
    swings = [p.swing_side for p in phases if p.swing is not None]
    assert swings[:2] == [side, 1 - side]
    lengths = [p.end - p.start for p in phases if p.swing is None]
    np.testing.assert_allclose(lengths, robot.constants.double_support_min, atol=1e-9)
    later = at.clock.time + 0.1
    piece = next(p for p in pieces if later <= p.end)
    p, w = at.robot.feet[1 - side, :2], horizon.omega
    xi = at.robot.com[:2] + at.robot.com_velocity[:2] / w
    np.testing.assert_allclose(dcm_on(piece, later), p + (xi - p) * np.exp(0.1 * w), atol=1e-9)


def test_recovery_steps_go_on_until_as_many_are_sufficient():
    robot, at, states = pushed(0)
    c = robot.constants
    assert at.recovery.steps == c.recovery_steps == 3
    shifts = [
        s for s in [at, *states] if mode_of(s) == Mode.DOUBLE and s.clock.time == phase_start(s)
    ]
    for s in shifts:
        support = c.double_support_min if s.recovery.steps else c.double_support
        assert phase_end(s) - s.clock.time == pytest.approx(support, abs=1e-9)
    counts = [int(s.recovery.steps) for s in shifts]
    assert counts[0] == 3
    assert counts[-1] == 0
    assert all(b >= a - 1 for a, b in pairwise(counts))  # a swing that comes short begins anew


def test_without_recovery_steps_every_double_support_is_as_long():
    robot, at, states = pushed(1, recovery_steps=0)
    shifts = [
        s for s in [at, *states] if mode_of(s) == Mode.DOUBLE and s.clock.time == phase_start(s)
    ]
    for s in shifts:
        assert phase_end(s) - s.clock.time == pytest.approx(
            robot.constants.double_support, abs=1e-9
        )


@pytest.mark.parametrize("longest", [0.03, 0.008])
def test_the_double_support_of_a_recovery_step_is_never_the_longer_one(longest):
    c = PendulumRobot(GaitParameters(double_support=longest)).constants
    state = PendulumRobot().state
    for recovering in (0, 2):
        state.recovery.steps = recovering
        length, switch = weight_shift(state, c)
        assert length == (min(0.012, longest) if recovering else longest)
        assert switch == switch_time(length, c.omega)


@pytest.mark.parametrize("way", [[1.0, 0.5], [-1.0, 0.5], [0.5, 1.0], [0.5, -1.0]])
def test_a_step_comes_short_that_lands_four_centimetres_off(way):
    robot = before_landing(0)
    c = robot.constants
    x = coming_step(robot.state.copy(), 0, 0.0, c)
    tau = np.exp(c.omega * (0.15 + x.switch))
    for off, short in ((0.039, False), (0.041, True)):
        foothold = x.dcm * tau - x.offset + off * np.array(way)
        assert is_insufficient(x, Step(0.15, foothold, True, 0.0, False), c) == short


@pytest.mark.parametrize(("recovering", "share"), [(3, 0.2), (0, 1.0)])
def test_a_foot_of_a_recovery_step_is_above_its_place_later(recovering, share):
    """All but its height arrives 6 ms before the touchdown, not 30."""
    robot, at, states = pushed(1, recovery_steps=recovering)
    settle = share * robot.constants.settle_time
    for s in states:
        if mode_of(s) == Mode.SWING and s.clock.steps == at.clock.steps:
            there = np.allclose(swing_of(s).reference[0, :2], swing_of(s).target[:2], atol=1e-6)
            assert there == (phase_end(s) - s.clock.time <= settle + 1e-6)


def test_on_uneven_ground_a_foot_of_a_recovery_step_waits_above_its_place_too():
    c, state = PendulumRobot().constants, PendulumRobot().state
    state.recovery.steps = 2
    assert settle_time(state, c) == c.settle_time_min < c.settle_time
    state.ground.unevenness = 1.01 * c.unevenness_max
    assert settle_time(state, c) == c.settle_time


def test_a_mirrored_push_is_answered_by_the_mirrored_foot():
    (robot, left, lefts), (_, right, rights) = pushed(0), pushed(1)
    for a, b in zip([left, *lefts], [right, *rights], strict=True):
        assert (mode_of(a), a.clock.side, repeats_swing(a), a.recovery.steps) == (
            mode_of(b),
            1 - b.clock.side,
            repeats_swing(b),
            b.recovery.steps,
        )
        np.testing.assert_allclose(a.robot.com * [1, -1, 1], b.robot.com, atol=1e-9)
    for state in (left, right):
        assert (
            next_stance(state.copy(), int(state.clock.side), 0.0, robot.constants)[0]
            == state.clock.side
        )
