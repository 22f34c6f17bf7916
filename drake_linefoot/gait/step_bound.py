"""What a step onto a patch of ground costs at least, so that few patches have to be solved."""

import math

from drake_linefoot.gait.patches import span
from drake_linefoot.gait.state import GaitConstants
from drake_linefoot.gait.step_program import StepProblem
from drake_linefoot.gait.step_times import TIME_STEP, ticks, time_cost
from drake_linefoot.math.compiled import compiled

_SAME = 1e-6  # [m]


@compiled
def may_cost_less(x: StepProblem, limit: float, c: GaitConstants) -> bool:
    """Return whether a step may cost less than a limit; `solve_step` would tell, but later.

    No step costs less than its time does, together with how far the foothold that its offset asks
    for is from the box that holds the room of the foot.

    Args:
        x: the swing.
        limit: of the cost.
        c: constants of the gait.
    """
    ahead = span(x.room, 0)
    for time in (x.nominal, x.planned):  # which may cost no time
        if _least_cost(x, time, ahead, c) < limit:
            return True
    first, last = ticks(x.nominal, x.shortest, max(x.longest, x.latest))
    for k in range(first, last + 1):
        now = x.nominal + k * TIME_STEP
        cost = time_cost(now - x.nominal, c.omega)
        if cost < limit and cost + _least_cost(x, now, ahead, c) < limit:
            return True
    return False


@compiled
def _least_cost(x: StepProblem, time: float, ahead: tuple[float, float], c: GaitConstants) -> float:
    tau, cost = math.exp(c.omega * (time + x.switch)), 0.0
    for i in range(2):
        least, most = ahead if i == 0 else (x.aside[0], x.aside[1])
        nominal, given = x.dcm[i] * tau - x.offset[i], x.pressure * (tau - 1.0) if i == 0 else 0.0
        miss = max(least - nominal, nominal - most) - given - _SAME
        cost += (max(miss, 0.0) / c.com_height) ** 2
    return cost
