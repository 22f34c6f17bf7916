"""The plans of the MPC at the times of the samples."""

from collections.abc import Sequence
from itertools import groupby
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_linefoot.centroidal import Trajectory, interval_at, sample_plan
from drake_linefoot.math.compiled import compiled
from drake_linefoot.signals import CentroidalPlan
from drake_linefoot.simulation.recording import CHANNELS
from drake_linefoot.types import Array


class PlanSamples(NamedTuple):
    """A centroidal plan at n times, held at its end; see `CentroidalPlan`.

    Attributes:
        r, v, a: CoM position, velocity, acceleration [m, s], shape (n, 3).
        L, L_dot: angular momentum about the CoM and its rate, shape (n, 3).
        wrench: wrench of each foot, shape (n, 2, 5).
        eta: rotation vector of the torso from the desired one [rad], even between two knots,
            shape (n, 3).
    """

    r: Array
    v: Array
    a: Array
    L: Array
    L_dot: Array
    wrench: Array
    eta: Array


def write_plans(
    plans: Sequence[CentroidalPlan], rows: NDArray[np.void], before: CentroidalPlan | None
) -> None:
    """Write what the MPC planned; after the times.

    Args:
        plans: of each tick, n of them.
        rows: of the channels, shape (n,).
        before: plan of the tick before these.
    """
    rows["mpc_ms"] = np.nan
    begin = 0
    for _, same in groupby(plans, key=id):
        count = len(list(same))
        plan, part = plans[begin], rows[begin : begin + count]
        samples = sample_plan_at(plan.trajectory, part["time"].copy())
        for name, channel in CHANNELS.items():
            if channel.signal == "plan":
                part[name] = channel.read(plan)
            elif channel.signal == "plan_sample":
                part[name] = channel.read(samples)
        # A plan that was given, and not solved for, took no time.
        if plan is not before and plan.report.milliseconds > 0.0:
            part["mpc_ms"][0] = plan.report.milliseconds
        before, begin = plan, begin + count


@compiled
def sample_plan_at(plan: Trajectory, times: Array) -> PlanSamples:
    """Return a plan at times [s], shape (n,)."""
    n = len(times)
    r, v, a = np.empty((n, 3)), np.empty((n, 3)), np.empty((n, 3))
    L, L_dot, eta = np.empty((n, 3)), np.empty((n, 3)), np.empty((n, 3))
    wrench = np.empty((n, 2, 5))
    for i in range(n):
        r[i], v[i], a[i], L[i], L_dot[i], wrench[i] = sample_plan(plan, times[i])
        k = interval_at(plan.times, times[i])
        begin, end = plan.times[k], plan.times[k + 1]
        share = (min(times[i], plan.times[-1]) - begin) / (end - begin)
        eta[i] = (1.0 - share) * plan.states[k, 9:] + share * plan.states[k + 1, 9:]
    return PlanSamples(r, v, a, L, L_dot, wrench, eta)
