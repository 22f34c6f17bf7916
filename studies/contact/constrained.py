"""The constrained form (22) against the pseudoinverse: error and time, side by side."""

import time as clock
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from drake_linefoot.errors import SolverError
from drake_linefoot.estimation.contact_parameters import EstimatorParameters
from drake_linefoot.estimation.wrench_estimate import ConstrainedEstimate, estimate_wrenches
from drake_linefoot.lab.results.contact_events import standing, touchdowns
from drake_linefoot.lab.results.thresholds import thresholds_of
from drake_linefoot.robot.humanoid import Humanoid
from studies.common.types import Array, Flags
from studies.contact.replayed import Observed, estimate
from studies.contact.walks import Walk

FORMS = ("pseudoinverse", "constrained")
COMPONENTS = ("f_x", "f_y", "f_z", "tau_y", "tau_z")  # [N], [N m]
SETTLED = 0.05  # [s] after a touchdown, when impact and filter are over
EVERY = 5  # samples from one that is compared to the next


class Compared(NamedTuple):
    """Both forms at some samples of a walk, m of them."""

    errors: Array  # [N, N m], NaN where unsolved; shape (m, 2 forms, 2 feet, 5)
    times: Array  # [ms], shape (m, 2 forms)
    stands: Flags  # of each foot, shape (m, 2)
    settled: Flags  # stands, and has for `SETTLED`, likewise
    in_air: Flags  # likewise


def compare(
    humanoid: Humanoid, walk: Walk, seen: Observed, parameters: EstimatorParameters
) -> Compared:
    """Compare both forms on the same residuals of a walk, those of the filter of `parameters`.

    These have the friction of the cone, too.
    """
    end, run = len(seen.momentum), walk.run
    residual = estimate(humanoid, seen, parameters, run.scenario.plant.time_step)[0]
    program = ConstrainedEstimate(humanoid.mass, humanoid.contact)
    chosen = np.arange(1, end, EVERY)
    errors, times = np.full((len(chosen), 2, 2, 5), np.nan), np.empty((len(chosen), 2))
    for k, i in enumerate(chosen):
        for form in (0, 1) if k % 2 else (1, 0):  # in turns, so that caches favour neither
            start = clock.perf_counter()
            try:
                if form:
                    wrench = program.solve(
                        residual[i], seen.J[i], seen.R_WC[i], parameters.friction
                    )
                else:
                    wrench = estimate_wrenches(residual[i], seen.J[i])
            except SolverError:
                wrench = np.full((2, 5), np.nan)
            times[k, form] = 1e3 * (clock.perf_counter() - start)
            errors[k, form] = wrench - walk.wrench[i]
    normal, limits, sides = run.true_normal[:end].sum(axis=2), thresholds_of(run), (0, 1)
    stands: Flags = np.column_stack([standing(run.time[:end], normal[:, i], limits) for i in sides])
    ticks = round(SETTLED / run.scenario.plant.time_step)
    settled = stands.copy()
    for side in sides:
        for begin in touchdowns(stands[:, side]):
            settled[begin : begin + ticks, side] = False
    in_air: Flags = ~stands & ~np.any(walk.wrench[:end] != 0.0, axis=2)
    return Compared(errors, times, stands[chosen], settled[chosen], in_air[chosen])


def forms(walks: Sequence[tuple[str, Compared]]) -> dict[str, Any]:
    """Return what came of the comparison in each kind of walk, given with the walks.

    Returns:
        For each kind: `samples` and `unsolved` ones, which are left out; and for each form
        `rms`: of the error of each component over the feet that stand, `rms_settled`: the
        same `SETTLED` after touchdown, `rms_swing`: of a foot in the air, whose wrench is zero;
        `median_ms` and `p95_ms` of the time of a sample.
    """
    result = {}
    for kind in dict.fromkeys(kind for kind, _ in walks):
        parts = zip(*(found for of, found in walks if of == kind), strict=True)
        all_of = Compared(*map(np.concatenate, parts))
        known = np.asarray(np.isfinite(all_of.errors).all(axis=(1, 2, 3)))
        phases = zip(("rms", "rms_settled", "rms_swing"), all_of[2:], strict=True)
        feet = [(name, chosen & known[:, None]) for name, chosen in phases]
        result[kind] = {
            "samples": len(known),
            "unsolved": int((~known).sum()),
            **{
                form: {
                    **{name: _rms(all_of.errors[:, f], chosen) for name, chosen in feet},
                    "median_ms": float(np.median(all_of.times[:, f])),
                    "p95_ms": float(np.percentile(all_of.times[:, f], 95)),
                }
                for f, form in enumerate(FORMS)
            },
        }
    return result


def _rms(errors: Array, chosen: Flags) -> list[float | None]:
    """Return the root mean square of each component over the chosen samples and feet."""
    some = errors[chosen]
    if not len(some):
        return [None] * len(COMPONENTS)
    values: list[float | None] = np.sqrt(np.mean(some**2, axis=0)).tolist()
    return values
