"""The step program as docs/mathematics.md states it, by going through places and times.

Nothing here is taken from the code but the numbers of the robot: every place of a fine grid, at
every tick that may be chosen, is given its cost by the statement, and none may cost less than what
`solve_step` returns.
"""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.optimize import minimize_scalar

from drake_linefoot.gait.patches import span
from drake_linefoot.gait.step_bound import may_cost_less
from drake_linefoot.gait.step_program import StepProblem, solve_step, yielding_place
from tests.helpers.steps import ANYWHERE, OMEGA, SHAPE, constants

OWN = constants(SHAPE, crossing_max=0.0)  # no foot crosses here
W_TIME, W_SLACK, TICKS = 0.01, 100.0, 0.002
GRID, FINER = np.linspace(-1.5, 1.5, 1501), np.linspace(-2e-3, 2e-3, 401)  # [m]
REACH_OF_FOOT = np.sqrt(3.0) / 10.0


def interval(x, time, i):
    """Where the swing foot can be by then; empty where it cannot stop.

    Beside the stance foot it keeps the gap that legs need, if it can.
    """
    left, v, a = max(time - x.settle, 0.0), x.foot_velocity[i], x.acceleration[i]
    low, high = np.inf, -np.inf
    if 1.5 * abs(v) <= a * left:
        way = REACH_OF_FOOT * (a * left**2 - abs(v) * left)
        low, high = (x.foot[i] + 0.5 * v * left + sign * way for sign in (-1.0, 1.0))
    if time > x.planned - 0.5 * TICKS:  # where it is on its way to
        low, high = min(low, x.target[i]), max(high, x.target[i])
    if i == 1:
        low = max(low, min(OWN.step_limits[1], OWN.crossing_gap, high))
    return low, high


def place_cost(x, time, i, u, c):
    """The cost of places u of coordinate i [m^2], infinite where the foot cannot be."""
    t, tau = OMEGA * time, np.exp(OMEGA * (time + x.switch))
    com = x.com[i] * np.cosh(t) + x.com_velocity[i] / OMEGA * np.sinh(t) - x.lean[i]
    length, narrow, wide = c.step_limits
    forward, outward = c.reach_limits
    lows = [[-length, com - forward], [narrow]][i]
    highs = [[length, com + forward], [wide, com + outward]][i]
    b = (x.dcm[i] * tau - u) * (1.0, -1.0)[i]  # towards the next foot
    slacks = [np.maximum(max(lows) - u, 0.0), np.maximum(u - min(highs), 0.0)]
    bound = c.offset_limits[i]
    slacks += [np.maximum(bound[0] - b, 0.0), np.maximum(b - bound[1], 0.0)]
    off = x.dcm[i] * tau - u - x.offset[i]
    cost = off**2 + W_SLACK * sum(s**2 for s in slacks)
    low, high = interval(x, time, i)
    inside = (low - 1e-9 <= u) & (u <= high + 1e-9)
    return np.where(inside, cost, np.inf), slacks


def time_cost(x, time):
    switch = x.switch
    tau, nominal = np.exp(OMEGA * (np.array([time, x.nominal]) + switch))
    return W_TIME * (tau / nominal - 1.0) ** 2


def ticks(x, longest):
    """The times that may be chosen: a phase ends at a tick [s]."""
    first = np.ceil((x.shortest - x.nominal) / TICKS - 1e-6)
    last = np.floor((longest - x.nominal) / TICKS + 1e-6)
    return x.nominal + TICKS * np.arange(first, last + 1)


def best_of_grid(x, times, c):
    """The least cost of any place and time, and how far it is outside the bounds of b [m]."""
    best, beyond = np.inf, 0.0
    for time in times:
        cost, out = time_cost(x, time), 0.0
        for i in range(2):
            low, high = interval(x, time, i)
            some = np.concatenate([GRID, [low, high, max(x.target[i], low)]])
            near_best = some[np.argmin(place_cost(x, time, i, some, c)[0])] + FINER
            some = np.concatenate([near_best, some[-3:]])
            costs, slacks = place_cost(x, time, i, some, c)
            k = int(np.argmin(costs))
            cost += costs[k] / c.com_height**2
            out = max(out, slacks[2][k], slacks[3][k])
        if cost < best:
            best, beyond = cost, out
    return best, beyond


def near(forward, outward):
    return st.tuples(st.floats(*forward), st.floats(*outward)).map(np.array)


problems = st.builds(
    lambda com, velocity, foot, speed, target, offset, times, lean: StepProblem(
        com + velocity / OMEGA, com, velocity, foot, speed, target, offset,
        np.array([175.0, 114.0]), *times, OWN.switch, OWN.settle_time, lean, *ANYWHERE,
    ),
    near((-0.25, 0.25), (-0.1, 0.25)), near((-1.5, 1.5), (-1.2, 1.2)),
    near((-0.25, 0.25), (0.08, 0.35)), near((-4.0, 4.0), (-2.0, 2.0)),
    near((-0.3, 0.3), (0.1, 0.35)), near((-0.12, 0.12), (-0.12, 0.08)),
    st.sampled_from([
        (0.12, 0.12, 0.06, 0.12, 0.16), (0.1, 0.1, 0.05, 0.15, 0.15), (0.08, 0.14, 0.08, 0.14, 0.2),
        (0.16, 0.12, 0.1, 0.16, 0.18),
    ]),
    near((-0.1, 0.1), (-0.1, 0.1)),
)  # fmt: skip


@given(problems)
def test_no_place_and_time_costs_less_by_the_program_as_it_is_stated(x):
    best, beyond = best_of_grid(x, ticks(x, x.longest), OWN)
    assume(np.isfinite(best) and not 0.0 < beyond < 2e-5)  # of which the grid cannot tell
    step, longest = solve_step(x, OWN), x.longest
    if beyond > 0.0:  # lost: it may last longer
        longest = x.latest
        best = best_of_grid(x, ticks(x, longest), OWN)[0]
    cost, beyond, away = time_cost(x, step.time), 0.0, 0.0
    for i, u in enumerate(step.foothold):
        nominal = x.dcm[i] * np.exp(OMEGA * (step.time + x.switch)) - x.offset[i]
        away = max(away, abs(nominal - u))
        found, slacks = place_cost(x, step.time, i, np.array([u]), OWN)
        cost += found[0] / OWN.com_height**2
        beyond = max(beyond, slacks[2][0], slacks[3][0])
    assert step.cost == pytest.approx(cost, rel=1e-9, abs=1e-12)
    assert step.lost == (beyond > 1e-9)
    assert step.moved == (away > 1e-6 * OWN.com_height)
    assert x.shortest - 1e-9 <= step.time <= longest + 1e-9
    assert cost <= best * (1.0 + 1e-9) + 1e-12


bounds = st.tuples(st.floats(-0.5, 0.5), st.floats(-0.5, 0.5))


@given(st.floats(-0.5, 0.5), bounds, bounds)
def test_a_place_that_bounds_pull_at_is_where_they_balance(nominal, low, high):
    """Also of bounds that contradict each other."""
    place = yielding_place(nominal, low, high)

    def cost(u):
        slacks = [*(max(b - u, 0.0) for b in low), *(max(u - b, 0.0) for b in high)]
        return (u - nominal) ** 2 + W_SLACK * sum(s**2 for s in slacks)

    found = minimize_scalar(cost, bounds=(-0.6, 0.6), method="bounded", options={"xatol": 1e-10})
    assert place == pytest.approx(found.x, abs=1e-6)
    assert cost(place) <= found.fun * (1.0 + 1e-12)
    if max(low) <= nominal <= min(high):
        assert place == nominal


@given(
    problems, st.tuples(st.floats(-0.6, 0.6), st.floats(-0.4, 0.6)).map(np.array),
    st.floats(0.0, 0.6), st.sampled_from([0.0, 0.05]), st.sampled_from([1e-4, 1e-2, 0.3]),
)  # fmt: skip
def test_what_is_left_out_without_a_look_costs_no_less_than_the_limit(x, at, turn, cop, limit):
    """Of ground that is a turned rectangle of 0.3 x 0.2 m somewhere about; a foot may cross."""
    c, s = np.cos(turn), np.sin(turn)
    normals = np.array([[c, s], [-s, c], [-c, -s], [s, -c]])
    room = np.column_stack([normals, normals @ at + [0.15, 0.1, 0.15, 0.1]])
    y = x._replace(room=room, aside=np.array(span(room, 1)), pressure=cop)
    cost = solve_step(y, SHAPE).cost
    assert may_cost_less(y, limit, SHAPE) or cost >= limit
    assert may_cost_less(y, max(2.0 * cost, 1e-9), SHAPE)


def test_far_ground_is_left_out():
    x = StepProblem(
        np.array([0.01, 0.05]), np.array([0.0, 0.05]), np.zeros(2), np.array([0.0, 0.2]),
        np.zeros(2), np.array([0.0, 0.2]), np.array([0.0, -0.1]), np.array([175.0, 114.0]),
        0.12, 0.12, 0.06, 0.12, 0.16, OWN.switch, OWN.settle_time, np.zeros(2), *ANYWHERE,
    )  # fmt: skip
    assert may_cost_less(x, 0.01, OWN)
    far = np.array([[-1.0, 0.0, -0.4], [0.0, 1.0, 1.0], [1.0, 0.0, 0.6], [0.0, -1.0, 1.0]])
    assert not may_cost_less(x._replace(room=far, aside=np.array(span(far, 1))), 0.01, OWN)
