"""The plans of the MPC at the times of the samples."""

from typing import Annotated, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_linefoot.axes import XYZ
from drake_linefoot.centroidal import interval_at, sample_plan
from drake_linefoot.layout import Layout, Part, filler
from drake_linefoot.math.compiled import compiled
from drake_linefoot.parts import in_world, wrenches
from drake_linefoot.signals import CentroidalPlan, open_plan
from drake_linefoot.types import Array


class SampledPlan(NamedTuple):
    """What a plan says of one time."""

    r: Annotated[Array, in_world("centre of mass", "m", XYZ)]
    v: Annotated[Array, in_world("its velocity", "m/s", XYZ)]
    a: Annotated[Array, in_world("its acceleration", "m/s^2", XYZ)]
    L: Annotated[Array, in_world("angular momentum about it", "kg m^2/s", XYZ)]
    L_dot: Annotated[Array, in_world("its rate", "N m", XYZ)]
    wrench: Annotated[Array, wrenches("of each foot")]
    eta: Annotated[Array, Part("of the torso from the desired orientation", "rad", XYZ)]
    milliseconds: Annotated[float, Part("wall time, where a plan is new; else NaN", "ms")]


fill_sample = filler(SampledPlan, "nw")


def sample_plans(
    plans: NDArray[np.void], times: Array, layout: Layout[CentroidalPlan], before: Array | None
) -> NDArray[np.void]:
    """Return what plans say at times, as records of `SampledPlan`, shape (n,).

    Args:
        plans: of each tick, as records, shape (n,).
        times: of the ticks [s], shape (n,).
        layout: of the plans.
        before: the plan of the tick before these, as it travels; None without.
    """
    vectors = np.ascontiguousarray(plans).view(np.float64).reshape(len(plans), layout.size)
    of_sample, sizes = (
        Layout(SampledPlan, layout.sizes),
        (layout.sizes["knots"], layout.sizes["nw"]),
    )
    flat = np.empty((len(times), of_sample.size))
    sample_plans_at(vectors, *sizes, times, flat)
    samples: NDArray[np.void] = flat.view(of_sample.dtype).ravel()
    is_new = np.ones(len(plans), dtype=bool)
    is_new[1:] = (vectors[1:] != vectors[:-1]).any(axis=1)
    is_new[0] = before is None or bool((vectors[0] != before).any())
    # A plan that was given, and not solved for, took no time.
    taken = plans["milliseconds"]
    samples["milliseconds"] = np.where(is_new & (taken > 0.0), taken, np.nan)
    return samples


@compiled
def sample_plans_at(vectors: Array, knots: int, nw: int, times: Array, samples: Array) -> None:
    """Write plans, as they travel, each at one time [s]; rows are `SampledPlan` as it travels."""
    for i in range(len(times)):
        plan = open_plan(vectors[i], knots, nw)
        now, k = sample_plan(plan, times[i]), interval_at(plan.times, times[i])
        share = (times[i] - plan.times[k]) / (plan.times[k + 1] - plan.times[k])
        share = min(max(share, 0.0), 1.0)
        eta = (1.0 - share) * plan.states[k, 9:] + share * plan.states[k + 1, 9:]
        sample = SampledPlan(now.r, now.v, now.a, now.L, now.L_dot, now.wrench, eta, 0.0)
        fill_sample(samples[i], sample, nw)
