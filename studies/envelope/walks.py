"""The walks of the study: commands along rays, what counts as followed, and what stopped one."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace

import numpy as np

from drake_linefoot.lab.results.fall_indicators import fall_indicators
from drake_linefoot.lab.results.falls import diagnose
from drake_linefoot.lab.scenario import Scenario
from drake_linefoot.lab.simulation.recording import Run
from drake_linefoot.lab.simulation.run import simulate
from drake_linefoot.lab.wiring.closed_loop import build_closed_loop
from studies.common.runs import paper_scenario
from studies.common.trial import OFTEN, judge_walk, lost_walk, walk
from studies.common.types import Array, Data

SHARE, LEAST = 0.1, 0.05  # [-] and [m/s, rad/s] that a command may be missed by
NAMES = ("forward speed", "sideways speed", "turn rate")
BEFORE = 1.0  # [s] before the onset of a fall in which cut torques count
LIMIT = 3600.0  # [s] of wall time of a walk


@dataclass(frozen=True)
class Axis:
    """A ray of commands: `fixed` plus the size times `direction`."""

    title: str  # in words
    direction: tuple[float, float, float]  # of forward, left, turn rate
    fixed: tuple[float, float, float]  # what does not grow, likewise
    start: float  # size that is tried first
    end: float  # largest size that is tried
    tolerance: float  # of the bisection
    aim: float  # size that the controller is to walk

    def command(self, size: float) -> tuple[float, float, float]:
        """Return forward, left [m/s] and turn rate [rad/s]."""
        vx, vy, turn = np.round(np.array(self.fixed) + size * np.array(self.direction), 4).tolist()
        return vx, vy, turn


NONE = (0.0, 0.0, 0.0)
AXES = {
    "forward": Axis("forward [m/s]", (1.0, 0.0, 0.0), NONE, 2.4, 3.2, 0.05, 2.4),
    "backward": Axis("backward [m/s]", (-1.0, 0.0, 0.0), NONE, 0.8, 1.6, 0.05, 1.4),
    "sideways": Axis("sideways [m/s]", (0.0, 1.0, 0.0), NONE, 0.5, 1.0, 0.05, 0.5),
    "turning": Axis("turning in place [rad/s]", (0.0, 0.0, 1.0), NONE, 2.0, 4.0, 0.1, 2.0),
    "forward_and_turning": Axis(
        "turning at 0.8 m/s [rad/s]", (0.0, 0.0, 1.0), (0.8, 0.0, 0.0), 0.8, 2.0, 0.1, 0.8
    ),
    "running_and_turning": Axis(
        "turning in a run of 1.5 m/s [rad/s]", (0.0, 0.0, 1.0), (1.5, 0.0, 0.0), 1.0, 2.0, 0.1, 1.0
    ),
}


@dataclass(frozen=True)
class Attempt:
    """A walk with a command of an axis."""

    model: str  # of the MPC
    axis: str  # of `AXES`
    size: float  # of the command
    seed: int
    duration: float  # [s]

    @property
    def key(self) -> str:
        """What makes it one walk."""
        return f"{self.model} {self.axis} {self.size:g} {self.seed} {self.duration:g}"

    @property
    def command(self) -> tuple[float, float, float]:
        """Forward, left [m/s] and turn rate [rad/s]."""
        return AXES[self.axis].command(self.size)

    def scenario(self) -> Scenario:
        """Return what is simulated."""
        base = replace(unlimited(paper_scenario(False, self.model)), seed=self.seed)
        return walk(base, self.command, self.duration)


def tracked(command: Sequence[float], measured: Sequence[float] | None) -> bool:
    """Return whether a command was followed."""
    return measured is not None and bool(np.all(np.abs(missed(command, measured)) <= 1.0))


def missed(command: Sequence[float], measured: Sequence[float]) -> Array:
    """Return by how much a command was missed, in what is allowed [-], shape (3,)."""
    error: Array = np.subtract(measured, command)
    return error / np.maximum(SHARE * np.abs(command), LEAST)


def unlimited(scenario: Scenario) -> Scenario:
    """Return a scenario whose gait takes every command of the axes."""
    ends = np.abs([axis.command(axis.end) for axis in AXES.values()]).max(axis=0)
    names = ("forward_max", "lateral_max", "turn_max")
    limits = {n: max(float(e), getattr(scenario.gait, n)) for n, e in zip(names, ends, strict=True)}
    return replace(scenario, gait=replace(scenario.gait, **limits))


def attempted(attempt: Attempt) -> Data:
    """Walk; return what was seen, whether it `held`, and what it was `stopped_by`."""
    run = simulate(build_closed_loop(attempt.scenario()))
    row = {**about(attempt), **judge_walk(run)}
    held = row["upright"] and tracked(attempt.command, row["measured"])
    return {**row, "held": held, "stopped_by": "" if held else reason(run, row["measured"])}


def lost(attempt: Attempt, error: str) -> Data:
    """Return what stands for `attempted` of a walk whose process crashed or took too long."""
    return {**about(attempt), **lost_walk(error), "held": False, "stopped_by": error}


def about(attempt: Attempt) -> Data:
    """Return which walk a row is of."""
    told = {"key": attempt.key, "attempt": asdict(attempt)}
    return {**told, "seed": attempt.seed, "command": list(attempt.command)}


def limit(_: Attempt) -> float:
    """Return how long a walk may take [s]."""
    return LIMIT


def reason(run: Run, measured: Sequence[float] | None) -> str:
    """Return in words what stopped a walk: how it ended, and what was seen before.

    That is the cause of a fall and what came with it, or what there was in the second half of a
    walk that did not follow its command; the most severe first. `measured` is forward, left [m/s]
    and turn rate [rad/s]; None after a fall.
    """
    if run.fell or measured is None:
        said, found = f"fell at {run.time[-1]:.2f} s: {run.fall_reason}", diagnose(run)
        cause, seen, begin, end = found.cause, found.indicators, found.onset - BEFORE, found.onset
    else:
        last = run.scenario.segments[-1]
        command = [*last.velocity, last.turn_rate]
        worst = int(np.argmax(np.abs(missed(command, measured))))
        said = f"tracking: {NAMES[worst]} off by {measured[worst] - command[worst]:+.2f}"
        if tracked(command, measured):
            said = "legs inside each other"
        cause, begin, end = "", 0.5 * float(run.time[-1]), float(run.time[-1])
        seen = tuple(fall_indicators(run, int(np.searchsorted(run.time, begin)), len(run.time)))
    gravest = sorted(seen, key=lambda s: (s.name != cause, -s.severity))
    words = list(dict.fromkeys(one.name for one in gravest))
    within = (run.time >= begin) & (run.time < end)
    cut = float(np.mean(run.clipped_torques[within] > 0.0)) if within.any() else 0.0
    if cut > OFTEN:
        words.append(f"torques cut in {100.0 * cut:.0f} % of the ticks")
    return said + (f"; before: {', '.join(words[:3])}" if words else "")
