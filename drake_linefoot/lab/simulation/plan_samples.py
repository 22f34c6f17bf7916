"""The plans of the MPC at the times of the samples."""

from collections.abc import Sequence
from itertools import groupby

import numpy as np
from numpy.typing import NDArray

from drake_linefoot.centroidal import PlanSample, sample_plan
from drake_linefoot.lab.simulation.recording import CHANNELS
from drake_linefoot.layout import Layout
from drake_linefoot.math.compiled import compiled
from drake_linefoot.signals import CentroidalPlan, open_plan
from drake_linefoot.types import Array


def write_plans(
    plans: Sequence[bytes],
    rows: NDArray[np.void],
    before: bytes | None,
    layout: Layout[CentroidalPlan],
) -> None:
    """Write what the MPC planned; after the times.

    Args:
        plans: of each tick as it travels, n of them; a plan that goes on is the same object.
        rows: of the channels, shape (n,).
        before: plan of the tick before these.
        layout: of the plans.
    """
    rows["mpc_ms"] = np.nan
    begin = 0
    for _, same in groupby(plans, key=id):
        count = len(list(same))
        content, part = plans[begin], rows[begin : begin + count]
        vector, record = np.frombuffer(content), np.frombuffer(content, layout.dtype)
        plan = layout.open(vector.copy())
        samples = sample_plan_at(
            vector.copy(), layout.sizes["knots"], layout.sizes["nw"], part["time"].copy()
        )
        for name, channel in CHANNELS.items():
            if channel.signal == "plan":
                part[name] = channel.read(record)
            elif channel.signal == "plan_sample":
                part[name] = getattr(samples, channel.attribute)
        eta = [np.interp(part["time"], plan.times, plan.states[:, 9 + axis]) for axis in range(3)]
        part["mpc_orientation"] = np.transpose(eta)
        # A plan that was given, and not solved for, took no time.
        if content is not before and plan.milliseconds > 0.0:
            part["mpc_ms"][0] = plan.milliseconds
        before, begin = content, begin + count


@compiled
def sample_plan_at(vector: Array, knots: int, nw: int, times: Array) -> PlanSample:
    """Return a plan, as it travels, at times [s], shape (n,); arrays of shape (n, ...)."""
    plan, n = open_plan(vector, knots, nw), len(times)
    r, v, a = np.empty((n, 3)), np.empty((n, 3)), np.empty((n, 3))
    L, L_dot, wrench = np.empty((n, 3)), np.empty((n, 3)), np.empty((n, 2, nw))
    for i in range(n):
        r[i], v[i], a[i], L[i], L_dot[i], wrench[i] = sample_plan(plan, times[i])
    return PlanSample(r, v, a, L, L_dot, wrench)
