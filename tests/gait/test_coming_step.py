"""Which foot stands next, and the step in which it does, from one state: no walk is needed."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from drake_linefoot.gait.footsteps import StepCommand, heading_vector, nominal_strides
from drake_linefoot.gait.next_stance import coming_step, next_stance, own_side_step
from drake_linefoot.gait.pendulum import dcm_offset
from drake_linefoot.gait.step_program import OWN_SIDE, best_step, solve_step
from drake_linefoot.gait.touchdown import foot_acceleration, is_insufficient
from drake_linefoot.parts import FOREVER
from tests.helpers.steps import OFFSET, OMEGA, SCALE, SHAPE, T, constants, swing_state

SIDES = [0, 1]
YAW = 0.4
CROSSING = constants(SHAPE, half_length=0.075)


def standing(side, velocity=(0.4, 0.1), pushed=(0.0, 0.0), ahead=0.05):
    """Both feet are on the ground, the weight still on the one that is not `side`."""
    command = StepCommand(np.array(velocity), 0.3, T)
    apart = heading_vector(YAW, ahead, (0.16, -0.16)[side])
    stance = np.array([0.3, -0.2])
    com = stance + 0.5 * apart
    way = np.array([0.3, 0.05]) + heading_vector(YAW, *pushed)
    s = swing_state((com, way, stance, YAW, side, command), slope=np.zeros(2))
    s.clock.lift_off[side] = FOREVER
    s.clock.touchdown[side] = -0.1
    s.robot.pendulum_velocity[:2] += [0.02, -0.03]
    s.robot.feet[side, :2], s.robot.feet[side, 3] = stance + apart, YAW
    return s


@pytest.mark.parametrize("side", SIDES)
@pytest.mark.parametrize("stays", [False, True])
@pytest.mark.parametrize("wait", [0.0, 0.01, 0.03])
@pytest.mark.parametrize("recovering", [0, 2])
def test_the_coming_step_begins_where_the_pendulum_is_then(side, stays, wait, recovering):
    """The weight goes from the old foot to `side` at the switch, if it is not there already."""
    s, c = standing(side), constants(SHAPE, step_length=0.28)
    s.recovery.steps, s.swing.height[:] = recovering, 0.09
    s.robot.lean[:] = [0.03, -0.05]  # into a force
    s.robot.pendulum_com[:2] = s.robot.com[:2] + s.robot.lean
    stands = 1 - side if stays else side
    x = coming_step(s, stands, wait, c)
    switch = c.switch_min if recovering else c.switch
    old, new = s.robot.feet[1 - side, :2], s.robot.feet[stands, :2]
    com = s.robot.com[:2] + s.robot.lean
    xi = com + s.robot.pendulum_velocity[:2] / OMEGA
    before = 0.0 if stays else min(switch, wait)
    for cop, length in ((old, before), (new, wait - before)):
        if length > 0.0:
            fall = solve_ivp(lambda _, y, p=cop: OMEGA * (y - p), (0.0, length), xi, rtol=1e-11)
            xi = fall.y[:, -1]
    yaw = YAW + s.command.turn_rate * (wait + 0.2 + 0.5 * T)
    turned = Rotation.from_euler("z", yaw).as_matrix()[:2, :2]
    turned = turned @ np.diag([1.0, (-1.0, 1.0)[stands]])  # outward to the foot that swings
    command = StepCommand(s.command.velocity * SCALE + OFFSET, s.command.turn_rate, T)
    offset = dcm_offset(nominal_strides(command, c, yaw, 1 - stands), OMEGA, T)
    expected = {
        "dcm": (xi - new) @ turned,
        "com": (com + wait * s.robot.com_velocity[:2] - new) @ turned,
        "com_velocity": s.robot.com_velocity[:2] @ turned,
        "foot": (s.robot.feet[1 - stands, :2] - new) @ turned,
        "foot_velocity": np.zeros(2),
        "target": (s.robot.feet[1 - stands, :2] - new) @ turned,
        "offset": offset @ turned,
        "acceleration": foot_acceleration(s, c),
        "planned": 0.2,
        "nominal": 0.2,
        "shortest": c.swing_time_min * np.sqrt(0.09 / c.swing_height),
        "longest": 0.2,
        "latest": 1.3 * 0.2,
        "switch": switch,
        "settle": c.settle_time_min if recovering else c.settle_time,
        "lean": s.robot.lean @ turned,
        "room": np.empty((0, 3)),  # it may land anywhere
        "aside": [-np.inf, np.inf],
        "pressure": 0.0,
    }
    for name, value in x._asdict().items():
        np.testing.assert_allclose(value, expected[name], atol=1e-8, err_msg=name)


def test_a_swing_that_is_shorter_than_lifting_takes_is_not_made_longer():
    s, c = standing(0), constants(SHAPE, single_support=0.08)
    assert SHAPE.swing_time_min > 0.08
    assert coming_step(s, 0, 0.0, c).shortest == pytest.approx(0.08)
    s.command.velocity[:] = [1.6, 0.0]
    fast = coming_step(s, 0, 0.0, constants(SHAPE, step_length=0.28))
    assert fast.planned == fast.nominal == fast.longest < 0.15


speeds = st.tuples(st.floats(-2.4, 2.4), st.floats(-2.4, 2.4))


@given(speeds, st.sampled_from(SIDES), st.sampled_from([0.0, 0.012]))
def test_the_other_foot_stands_only_where_that_saves_more(pushed, side, wait):
    """A step that does not cross, of the other foot, against any of the one whose turn it is."""
    s, c = standing(side, pushed=pushed), CROSSING
    mine, others = (coming_step(s, foot, wait, c) for foot in (side, 1 - side))
    u = np.empty(2)
    lost = best_step(mine, OWN_SIDE, mine.latest, c, u)[3]
    cost, time, _, others_lost = best_step(others, OWN_SIDE, others.latest, c, u)
    again, step = own_side_step(others, c), solve_step(mine, c)
    assert (again.cost, again.time, again.lost) == (cost, time, others_lost)
    np.testing.assert_array_equal(again.foothold, u)
    stands, short = next_stance(s, side, wait, c)
    saves = lost and (not others_lost or (step.lost and cost < step.cost))
    assert stands == (1 - side if saves else side)
    if saves:
        assert short == is_insufficient(others, again, c)
    else:
        assert short == is_insufficient(mine, step if lost else own_side_step(mine, c), c)


def test_pushes_of_every_kind_of_answer_are_among_them():
    """Calm; a narrow step; one that crosses; the same foot again; lost either way."""
    found = set()
    for forward in np.linspace(-2.4, 2.4, 5):
        for outward in np.linspace(-2.4, 2.4, 13):
            s = standing(0, pushed=(forward, outward))
            mine, others = (coming_step(s, foot, 0.012, CROSSING) for foot in (0, 1))
            own, again = own_side_step(mine, CROSSING), own_side_step(others, CROSSING)
            kind = (own.lost, solve_step(mine, CROSSING).lost, again.lost)
            found.add((*kind, *next_stance(s, 0, 0.012, CROSSING)))
    assert {stands for *_, stands, _ in found} == {0, 1}
    assert {(own, again) for own, _, again, *_ in found} == {
        (a, b) for a in (False, True) for b in (False, True)
    }
