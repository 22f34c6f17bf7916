"""Where and when the swing foot lands, as one program (after Khadiv and others, 1704.01271).

Forward and outward from the stance foot, with zeta the DCM now and ``tau = exp(w t)`` for a switch
of the CoP in t, the DCM is then at ``zeta tau``, and a foot that leaves it the offset b lands at
``u = zeta tau - b``. Chosen are tau and b; every length counts in heights of the CoM::

    min  w_T (tau / tau_n - 1)^2 + |b - b_n|^2 + w_s sum_k s_k^2
    s.t. tau_min <= tau <= tau_max,  u where the foot can be by then,
         u_min - s_1 <= u <= u_max + s_2,  b_min - s_3 <= b <= b_max + s_4

u_min and u_max are the reach of the stance foot and of the CoM at touchdown; the bounds of b,
`offset_limits`, count towards the next foot, on the side of the stance foot. Where no bound is
active it is the step of the time that is planned, with the offset b_n of a steady walk. The slacks
come last: beyond the bounds of b no steps that legs can make save the pendulum.

Where the steps on its own side leave the bounds of b, a foot may cross to the far side of the
stance foot, ahead of it or behind it: see `passing_bound`. Legs must not meet: until it is back
its reach has no slack, and on its own side none nearer than `crossing_gap`.

For a given tau both coordinates have a best place each, see `yielding_place`. So to go through
the times is exact, where a quadratic program would want foot and CoM linear in tau.
"""

import math
from typing import NamedTuple

import numpy as np

from drake_linefoot.gait.crossing import AHEAD, BEHIND, OWN_SIDE, is_beside, passing_bound
from drake_linefoot.gait.patches import chord
from drake_linefoot.gait.state import GaitConstants
from drake_linefoot.gait.step_times import TIME_STEP, ticks, time_cost
from drake_linefoot.math.compiled import compiled
from drake_linefoot.types import Array

PEAK = 10.0 / math.sqrt(3.0)  # acceleration of a quintic from rest to rest, times T^2 / d
_BRAKING = 1.5  # [-] of v / T: what a quintic needs at least that comes to rest from v
_SLACK_WEIGHT, _PRESSURE_WEIGHT = 100.0, 0.05
_MOVED, _SAME = 1e-6, 1e-6  # [-] of the height of the CoM; [m] of a place


class StepProblem(NamedTuple):
    """A swing, seen from the stance foot: forward and outward [m], shape (2,) each.

    Attributes:
        dcm, com, com_velocity: of the pendulum now; the last in m/s.
        foot, foot_velocity, target: of the swing foot; where it is on its way to.
        offset: b_n.
        acceleration: most of the swing foot [m/s^2].
        planned: time to the touchdown at the target [s].
        nominal: time to the touchdown of a step that nothing disturbs [s].
        shortest, longest: bounds of the time [s].
        latest: bound of the time where steps that are not late are lost [s].
        switch: from the touchdown to when the weight comes onto the foot [s].
        settle: how long before the touchdown the foot is there but for its height [s].
        lean: how far the CoM of the pendulum is from that of the robot.
        room: edges ``n . u <= b`` of the ground that it may land on, without end where there are
            none, shape (m, 3).
        aside: the least and the greatest outward place inside them, shape (2,).
        pressure: so far the centre of pressure may be ahead of or behind the middle of the stance
            foot until then.
    """

    dcm: Array
    com: Array
    com_velocity: Array
    foot: Array
    foot_velocity: Array
    target: Array
    offset: Array
    acceleration: Array
    planned: float
    nominal: float
    shortest: float
    longest: float
    latest: float
    switch: float
    settle: float
    lean: Array
    room: Array
    aside: Array
    pressure: float


class Step(NamedTuple):
    """What is chosen.

    Attributes:
        time: to the touchdown [s].
        foothold: forward and outward from the stance foot [m], shape (2,).
        moved: whether a bound moved it from where its offset is nominal.
        cost: of time, place and slack.
        lost: whether no steps after it save the pendulum, or legs would meet in it.
    """

    time: float
    foothold: Array
    moved: bool
    cost: float
    lost: bool


@compiled
def yielding_place(nominal: float, low: tuple[float, float], high: tuple[float, float]) -> float:
    """Return where ``(u - u_n)^2 + w_s sum_k s_k^2`` is least, with a slack for each bound of u.

    Its derivative is linear between the bounds and grows. With the slacks of n bounds alone it is
    zero at their weighted mean ``(u_n + w_s sum_k u_k) / (1 + w_s n)``. The slack of one more lower
    bound only lowers it, that of an upper one only raises it: of none, the higher and both lower
    bounds those count that give the largest place, and of the upper ones those that then give the
    least.

    Args:
        nominal: u_n [m].
        low: two lower bounds [m].
        high: two upper bounds [m].

    Returns:
        u [m].
    """
    if max(low) <= nominal <= min(high):
        return nominal
    lower, upper = (0.0, max(low), sum(low)), (0.0, min(high), sum(high))
    place = math.inf
    for i in range(3):
        farthest = -math.inf
        for j in range(3):
            pulled = nominal + _SLACK_WEIGHT * (upper[i] + lower[j])
            farthest = max(farthest, pulled / (1.0 + _SLACK_WEIGHT * (i + j)))
        place = min(place, farthest)
    return place


@compiled
def in_reach(
    x: StepProblem, i: int, grown: float, where: float, c: GaitConstants
) -> tuple[float, float]:
    """Return between which places the stance foot and the CoM at touchdown reach a foothold [m].

    Args:
        x: the swing.
        i: 0 forward, 1 outward.
        grown: ``exp(w t)`` of the time to touchdown.
        where: as of `best_foothold`.
        c: constants of the gait.
    """
    # The CoM is on its pendulum until then, but for the lean.
    com = 0.5 * (x.com[i] + x.com_velocity[i] / c.omega) * grown - x.lean[i]
    com += 0.5 * (x.com[i] - x.com_velocity[i] / c.omega) / grown
    if i == 0:
        length, reach = c.step_limits[0], c.reach_limits[0]
        return max(-length, com - reach), min(length, com + reach)
    nearest = c.step_limits[1] if where == OWN_SIDE else -c.crossing_max
    return nearest, min(c.step_limits[2], com + c.reach_limits[1])


@compiled
def in_the_time(x: StepProblem, i: int, left: float, on_its_way: bool) -> tuple[float, float]:
    """Return between which places a quintic gets with what acceleration the joints can give [m].

    Args:
        x: the swing.
        i: 0 forward, 1 outward.
        left: until it has to be there [s].
        on_its_way: whether there is so much time as it takes to where it is on its way to.

    Returns:
        The first above the second where it cannot stop by then.
    """
    drift, room = x.foot_velocity[i] * left, x.acceleration[i] * left * left
    middle, way = x.foot[i] + 0.5 * drift, (room - abs(drift)) / PEAK
    near, far = middle - way, middle + way
    if _BRAKING * abs(drift) > room:
        if not on_its_way:
            return math.inf, -math.inf
        near, far = x.target[i], x.target[i]
    elif on_its_way:
        near, far = min(near, x.target[i]), max(far, x.target[i])
    return near, far


@compiled
def best_foothold(
    x: StepProblem, time: float, where: float, c: GaitConstants, u: Array
) -> tuple[float, bool, bool]:
    """Choose the foothold of a step that lands after a time [s].

    Args:
        x: the swing.
        time: to touchdown [s].
        where: `OWN_SIDE`, or where the foot crosses the line of the stance foot.
        c: constants of the gait.
        u: forward and outward from the stance foot [m], shape (2,), written.

    Returns:
        (cost, moved, lost): without that of the time; whether a bound moves it; whether no steps
        after it save the pendulum, or legs would meet in it.
    """
    tau, grown = math.exp(c.omega * (time + x.switch)), math.exp(c.omega * time)
    left, on_its_way = max(time - x.settle, 0.0), time > x.planned - 0.5 * TIME_STEP
    passes = where
    if x.foot[1] < c.crossing_gap and c.crossing_max > 0.0:  # it has crossed already
        passes = AHEAD if x.foot[0] > 0.0 else BEHIND
    cost, moved, lost = 0.0, False, False
    for i in (1, 0):
        nearest, farthest = in_reach(x, i, grown, where, c)
        if i == 0 and passes != OWN_SIDE:
            passing = passing_bound(x.foot, u[1], passes, c)
            nearest = max(nearest, passing) if passes == AHEAD else nearest
            farthest = min(farthest, -passing) if passes == BEHIND else farthest
        landing, least, most = x.dcm[i] * tau, c.offset_limits[i, 0], c.offset_limits[i, 1]
        given = x.pressure * (tau - 1.0) if i == 0 else 0.0  # by the centre of pressure
        # The next foot swings on the side of the stance foot.
        saved = (landing - most, landing - least) if i == 0 else (landing + least, landing + most)
        saved = (saved[0] - given, saved[1] + given)
        nominal = landing - x.offset[i]
        place = yielding_place(nominal, (nearest, saved[0]), (farthest, saved[1]))
        first, last = chord(x.room, u[1]) if i == 0 else (x.aside[0], x.aside[1])
        place = min(max(place, first), last)
        if passes != OWN_SIDE:
            place = max(min(place, farthest), nearest)
        elif i == 1:
            place = max(place, min(nearest, c.crossing_gap))
        near, far = in_the_time(x, i, left, on_its_way)
        place = min(max(place, near), far)
        if where != OWN_SIDE and not nearest - _SAME <= place <= farthest + _SAME:
            return math.inf, True, True
        if near > far or not first - _SAME <= place <= last + _SAME:  # or there is no ground
            return math.inf, True, True
        u[i] = place
        beyond = max(saved[0] - place, place - saved[1], 0.0)
        lost = lost or beyond > 0.0
        away = max(nearest - place, 0.0) ** 2 + max(place - farthest, 0.0) ** 2
        miss = max(abs(nominal - place) - given, 0.0)
        cost += miss * miss + _SLACK_WEIGHT * (beyond * beyond + away)
        cost += _PRESSURE_WEIGHT * (abs(nominal - place) - miss) ** 2
        moved = moved or miss > _MOVED * c.com_height
    lost = lost or (where == OWN_SIDE and is_beside(u, c))  # it cannot stop before
    return cost / c.com_height**2, moved, lost


@compiled
def best_step(
    x: StepProblem, where: float, longest: float, c: GaitConstants, u: Array
) -> tuple[float, float, bool, bool]:
    """Choose time and foothold of a step.

    Args:
        x: the swing.
        where: as of `best_foothold`.
        longest: bound of the time [s].
        c: constants of the gait.
        u: forward and outward from the stance foot [m], shape (2,), written.

    Returns:
        (cost, time, moved, lost): time to touchdown [s], the rest as of `best_foothold`.
    """
    time, trial = x.nominal, np.empty(2)
    best, moved, lost = best_foothold(x, time, where, c, u)
    if not moved and x.shortest <= time:
        return best, time, moved, lost
    best += 1e9 * max(x.shortest - time, 0.0)  # a time that is given up for any other
    first, last = ticks(x.nominal, x.shortest, longest)
    for k in range(first, last + 1):
        now = x.nominal + k * TIME_STEP
        cost, changed, gone = best_foothold(x, now, where, c, trial)
        cost += time_cost(now - x.nominal, c.omega)
        if cost < best:
            best, time, moved, lost = cost, now, changed, gone
            u[:] = trial
    if best == math.inf and where == OWN_SIDE:  # what it is on its way to
        time = x.planned
        best, moved, lost = best_foothold(x, time, where, c, u)
    return best, time, moved, lost


@compiled
def solve_step(x: StepProblem, c: GaitConstants) -> Step:
    """Return when and where to step; across the line of the stance foot only if that saves more.

    Args:
        x: the swing.
        c: constants of the gait.
    """
    u, trial = np.empty(2), np.empty(2)
    best, time, moved, lost = best_step(x, OWN_SIDE, x.longest, c, u)
    if lost:
        best, time, moved, lost = best_step(x, OWN_SIDE, x.latest, c, u)
    if lost and c.crossing_max > 0.0:
        for where in (AHEAD, BEHIND):
            cost, now, changed, gone = best_step(x, where, x.latest, c, trial)
            if cost < best:
                best, time, moved, lost = cost, now, changed, gone
                u[:] = trial
    return Step(time, u, moved, best, lost)
