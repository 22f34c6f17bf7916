"""When joints of the legs were at their stops."""

from collections.abc import Iterator

import numpy as np

from drake_linefoot.results.clearance import humanoid_named
from drake_linefoot.results.thresholds import Thresholds
from drake_linefoot.simulation.recording import Run
from drake_linefoot.types import Flags

STOP = 0.01  # [rad] from a joint's stop
LONG = 0.05  # [-] of a run, for which a joint is at its stop


def at_stops(
    run: Run, limits: Thresholds, first: int, end: int
) -> Iterator[tuple[str, Flags, Flags]]:
    """Yield each joint of the legs, when it was at its stop, and when its foot was loaded.

    The ankle of a foot in the air does not count: every long step takes it there.

    Args:
        run: what was recorded.
        limits: of its robot.
        first: sample.
        end: sample after the last one.

    Yields:
        Its name and flags, shapes (end - first,).
    """
    humanoid = humanoid_named(run.scenario.robot)
    angles = run.q[first:end][:, humanoid.actuated_q]
    margin = np.minimum(angles - humanoid.position_lower, humanoid.position_upper - angles)
    loaded = run.true_normal[first:end].sum(axis=2) > limits.load
    for side, leg in enumerate(humanoid.leg_joints):
        for k in leg:
            there = margin[:, k] < STOP
            if k == leg[-1]:
                there &= loaded[:, side]
            yield run.joint_names[k], there, loaded[:, side]


def long_at_stops(run: Run, limits: Thresholds) -> dict[str, float]:
    """Return for which share of a run joints were at their stops, of those where it was `LONG`."""
    found = {name: there for name, there, _ in at_stops(run, limits, 0, len(run.time))}
    shares = {name: float(there.mean()) for name, there in found.items() if len(there)}
    return {name: share for name, share in shares.items() if share >= LONG}
