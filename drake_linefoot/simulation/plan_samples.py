"""The plans of the MPC at the times of the samples."""

from collections.abc import Sequence
from itertools import groupby

import numpy as np
from numpy.typing import NDArray

from drake_linefoot.centroidal import PlanSample, Trajectory, sample_plan
from drake_linefoot.math.compiled import compiled
from drake_linefoot.signals import CentroidalPlan
from drake_linefoot.simulation.recording import CHANNELS
from drake_linefoot.types import Array


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
        eta = [np.interp(part["time"], plan.times, plan.states[:, 9 + axis]) for axis in range(3)]
        part["mpc_orientation"] = np.transpose(eta)
        # A plan that was given, and not solved for, took no time.
        if plan is not before and plan.report.milliseconds > 0.0:
            part["mpc_ms"][0] = plan.report.milliseconds
        before, begin = plan, begin + count


@compiled
def sample_plan_at(plan: Trajectory, times: Array) -> PlanSample:
    """Return a plan at times [s], shape (n,); arrays of shape (n, ...)."""
    n = len(times)
    r, v, a = np.empty((n, 3)), np.empty((n, 3)), np.empty((n, 3))
    L, L_dot, wrench = np.empty((n, 3)), np.empty((n, 3)), np.empty((n, 2, 5))
    for i in range(n):
        r[i], v[i], a[i], L[i], L_dot[i], wrench[i] = sample_plan(plan, times[i])
    return PlanSample(r, v, a, L, L_dot, wrench)
