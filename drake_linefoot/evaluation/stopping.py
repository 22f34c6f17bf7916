"""What stopped a walk: a fall and what came before it, or a command that was not followed."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.simulation.recording import Run

Array = NDArray[np.float64]

BEFORE = 1.0  # [s] before a fall that is looked at; the last EXCLUDED of it is the fall itself
EXCLUDED = 0.3  # [s]
STOP = 0.01  # [rad] from a limit that counts as being there
OFTEN = 0.01  # [-] of the samples that make a sign
NAMES = ("forward speed", "sideways speed", "turn rate")


def signs(run: Run, humanoid: Humanoid) -> list[str]:
    """Return which limits the robot was at, the most frequent first.

    Looks at the second half of a walk, or at the last second before a fall.

    Args:
        run: what was recorded.
        humanoid: whose limits.
    """
    window = _window(run)
    q = run.q[window][:, humanoid.actuated_q]
    at_stop = (q < humanoid.position_lower + STOP) | (q > humanoid.position_upper - STOP)
    clipped = np.abs(run.torque[window]) >= run.effort_limits * (1.0 - 1e-9)
    found: dict[str, float] = {}
    for i, joint in enumerate(run.joint_names):
        name = joint.split("_", 1)[1].replace("_", " ")  # without the side
        for flags, words in ((at_stop, f"{name} at its stop"), (clipped, f"{name} torque limit")):
            found[words] = max(found.get(words, 0.0), float(np.mean(flags[:, i])))
    moved = np.diff(run.moved_footholds[window]) > 0.0
    found["foothold limit"] = float(np.mean(moved)) if len(moved) else 0.0
    kept = [words for words, share in found.items() if share > OFTEN]
    return sorted(kept, key=lambda words: -found[words])


def _window(run: Run) -> slice:
    """Return the samples to look at."""
    end = float(run.time[-1])
    if run.fell:
        first, last = end - BEFORE, end - EXCLUDED
    else:
        first, last = 0.5 * end, end
    return slice(*(int(i) for i in np.searchsorted(run.time, [first, last])))


def reason(
    run: Run, humanoid: Humanoid, command: Sequence[float], measured: Sequence[float] | None
) -> str:
    """Return in words what stopped a walk.

    Args:
        run: what was recorded.
        humanoid: whose limits.
        command: forward, left [m/s], turn rate [rad/s].
        measured: the same, measured; None after a fall.
    """
    if run.fell or measured is None:
        first = f"fell at {run.time[-1]:.2f} s: {run.fall_reason}"
    else:
        error = np.array(measured) - np.array(command)
        worst = int(np.argmax(np.abs(error) / np.maximum(0.1 * np.abs(command), 0.05)))
        first = f"tracking: {NAMES[worst]} off by {error[worst]:+.2f}"
    limits = signs(run, humanoid)
    return first + (f"; before: {', '.join(limits[:3])}" if limits else "")
