"""When joints of the legs were at their stops."""

from collections.abc import Iterator

from drake_linefoot.lab.results.thresholds import Thresholds
from drake_linefoot.lab.simulation.recording import Run
from drake_linefoot.lab.simulation.run_view import robot_of
from drake_linefoot.lab.simulation.warnings import joints_at_stops
from drake_linefoot.types import Flags

LONG = 0.05  # [-] of a run, for which a joint is at its stop


def at_stops(
    run: Run, limits: Thresholds, first: int, end: int
) -> Iterator[tuple[str, Flags, Flags]]:
    """Yield each joint of the legs, when it was at its stop, and when its foot was loaded.

    Args:
        run: what was recorded.
        limits: of its robot.
        first: sample.
        end: sample after the last one.

    Yields:
        Its name and flags, shapes (end - first,).
    """
    humanoid = robot_of(run)
    loaded = run.true_normal[first:end].sum(axis=2) > limits.load
    there = joints_at_stops(humanoid, run.q[first:end][:, humanoid.actuated_q], loaded)
    for side, leg in enumerate(humanoid.leg_joints):
        for j, k in enumerate(leg):
            yield run.joint_names[k], there[:, side, j], loaded[:, side]


def long_at_stops(run: Run, limits: Thresholds) -> dict[str, float]:
    """Return for which share of a run joints were at their stops, of those where it was `LONG`."""
    found = {name: there for name, there, _ in at_stops(run, limits, 0, len(run.time))}
    shares = {name: float(there.mean()) for name, there in found.items() if len(there)}
    return {name: share for name, share in shares.items() if share >= LONG}
