"""Simulating a closed loop to its end, or to the robot's fall."""

import math
import time as clock
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from pydrake.systems.framework import Context, EventStatus

from drake_linefoot import __version__
from drake_linefoot.errors import EstimateError, SignalError
from drake_linefoot.lab.simulation.closed_loop import ClosedLoop
from drake_linefoot.lab.simulation.log import LogFile
from drake_linefoot.lab.simulation.recording import CHANNELS, LOG, Run
from drake_linefoot.lab.simulation.velocity import recent_velocity
from drake_linefoot.lab.simulation.warnings import warnings_of
from drake_linefoot.math.linear import all_finite
from drake_linefoot.math.rotation import from_quaternion
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.types import Array

LOWEST_TORSO = 0.6  # [-] of the nominal height of the torso; below it the robot has fallen
LARGEST_TILT = 1.0  # [rad] of the torso from upright; beyond it the robot has fallen
CHUNK = 0.125  # [s] of simulated time between two reports of progress
LARGEST_DRIFT = 2e-3  # [-] of a quaternion's norm, after 40 s; shorter runs keep their bits
FALLS = {  # words of Drake's errors, and why the robot has fallen then
    "failed to converge": "the simulator found no solution (contact solver failed to converge)",
    "did not converge": "the simulator found no solution (contact solver did not converge)",
    "Detected NaN in the actuation": "torque not finite",
    "positive-definite": "the simulator found no solution (mass matrix not positive-definite)",
    "positive definite": "the simulator found no solution (mass matrix not positive definite)",
}


class Progress(NamedTuple):
    """How far a simulation is."""

    time: float  # simulated so far [s]
    duration: float  # of the whole run [s]
    realtime_rate: float  # simulated seconds per second of wall time so far
    commanded: Array  # v_x, v_y [m/s] and turn rate [rad/s], shape (3,)
    measured: Array  # the same over the last half second, in the heading frame, shape (3,)
    warnings: Sequence[str]  # what the robot does otherwise than it was told, see `warnings_of`


def simulate(
    loop: ClosedLoop,
    progress: Callable[[Progress], None] | None = None,
    realtime_rate: float = 0.0,
    look: Callable[[Context], None] | None = None,
    stop: Callable[[], object] = bool,
) -> Run:
    """Simulate a loop from its initial state until its scenario ends or the robot falls.

    The robot has fallen when its torso is low or tilted (`fall_reason`), when a number is not
    finite any more, or when simulator or controller find no solution (`fall_of`); the run then
    ends there.

    Args:
        loop: what `build_closed_loop` returned.
        progress: called every 1/8 s of simulated time, and at the end.
        realtime_rate: 1 holds the simulation back to real time; 0 is as fast as possible.
        look: called with the root context at the beginning and after every step.
        stop: asked every 1/8 s of simulated time; the run ends when it returns something true.

    Returns:
        The recorded run. Same scenario, same machine: same arrays, but for wall times.
    """
    simulator = loop.make_simulator()
    simulator.set_target_realtime_rate(realtime_rate)
    watch = FallWatch(loop, look)
    simulator.set_monitor(watch)
    start, duration, chunk = clock.perf_counter(), loop.scenario.duration, 0
    now = simulator.get_context().get_time
    try:
        simulator.Initialize()
        while now() < duration and not watch.reason and not stop():
            chunk += 1
            simulator.AdvanceTo(min(chunk * CHUNK, duration))
            keep_unit_norm(loop, simulator.get_mutable_context())
            if progress is not None:
                progress(_progress(loop, duration, clock.perf_counter() - start))
    except (SignalError, RuntimeError, np.linalg.LinAlgError) as error:
        watch.reason = fall_of(error)
    return finished_run(loop, watch.reason, float(now()), clock.perf_counter() - start)


def keep_unit_norm(loop: ClosedLoop, root: Context) -> None:
    """Normalise the torso's quaternion when it has drifted away, as it does by 5e-5 a second.

    Drake takes its direction alone, so nothing but roundings changes; but one that goes on
    drifting loses digits.
    """
    x = loop.plant.state(root)
    norm = float(np.linalg.norm(x[:4]))
    if abs(norm - 1.0) > LARGEST_DRIFT:
        x[:4] /= norm
        loop.plant.place(root, x)


def fall_of(error: Exception) -> str:
    """Return why an error of a simulation counts as a fall; raise it again when it does not."""
    if isinstance(error, SignalError):
        return f"state not finite: {error}"
    if isinstance(error, EstimateError):
        return f"state estimate lost: {error}"
    if isinstance(error, np.linalg.LinAlgError):
        return f"the controller found no solution ({error})"
    for words, reason in FALLS.items():
        if words in str(error):
            return reason
    raise error


def finished_run(
    loop: ClosedLoop, reason: str, time: float, wall: float, ended: bool = True
) -> Run:
    """Return what a loop has recorded as a run.

    Args:
        loop: that was simulated.
        reason: why it counts as a fall; empty when it does not.
        time: of its end [s].
        wall: how long the simulation took [s].
        ended: whether it came to its end.
    """
    channels: dict[str, Any] = {**loop.recorder.arrays()}
    return Run(
        scenario=loop.scenario,
        version=__version__,
        joint_names=loop.humanoid.description.actuated_joints,
        effort_limits=loop.humanoid.effort_limits.copy(),
        fell=bool(reason),
        fall_time=time if reason else None,
        fall_reason=reason,
        wall_seconds=wall,
        ended=ended,
        **channels,
    )


def run_so_far(loop: ClosedLoop) -> Run | None:
    """Return what a loop has recorded of a run that broke off; None without a sample.

    How long it took is not known; it counts as real time.
    """
    if not loop.recorder.count:
        return None
    end = float(loop.recorder.samples("time", 1)[0])
    return finished_run(loop, "", end, max(end, 1e-3), ended=False)


def keep_on_disk(loop: ClosedLoop, folder: Path) -> None:
    """Let what a loop records go to the disk as it comes, where `Run.load` reads it any time.

    Args:
        loop: before it is simulated.
        folder: exists; the log is made in it.

    Raises:
        OutputError: it cannot be written.
    """
    begin, _ = finished_run(loop, "", 0.0, math.nan).facts()
    loop.recorder.keep_in(LogFile(folder / LOG, loop.recorder.dtype, CHANNELS, begin))


class FallWatch:
    """Monitor of a simulator that ends it when the robot has fallen.

    Attributes:
        reason: why it counts as fallen; empty while it does not.
    """

    def __init__(self, loop: ClosedLoop, look: Callable[[Context], None] | None = None) -> None:
        """Watch the plant of `loop`; `look` is called with each root context before."""
        self._loop, self._look = loop, look
        self.reason = ""

    def __call__(self, root: Context) -> EventStatus:
        """Look at the state after a step; `root` is the diagram's context."""
        if self._look is not None:
            self._look(root)
        q = self._loop.plant.state(root)[: self._loop.humanoid.nq]
        ground = self._loop.ground.plane(q[4], q[5])
        self.reason = fall_reason(self._loop.humanoid, q, ground)
        if self.reason:
            return EventStatus.ReachedTermination(self._loop, self.reason)
        return EventStatus.DidNothing()


def fall_reason(humanoid: Humanoid, q: Array, ground: float = 0.0) -> str:
    """Return why a configuration counts as fallen, or nothing when it does not.

    Args:
        humanoid: the robot.
        q: positions, shape (nq,).
        ground: height of the ground below the torso [m].
    """
    if not all_finite(q):
        return "state not finite"
    lowest = LOWEST_TORSO * humanoid.q_nominal[6]
    height = q[6] - ground
    if height < lowest:
        return f"torso {height:.3f} m high, below {lowest:.3f} m"
    tilt = math.acos(min(max(from_quaternion(q[:4])[2, 2], -1.0), 1.0))
    if tilt > LARGEST_TILT:
        return f"torso tilted by {tilt:.3f} rad, beyond {LARGEST_TILT:.1f} rad"
    return ""


def _progress(loop: ClosedLoop, duration: float, wall: float) -> Progress:
    recorder = loop.recorder
    time = float(recorder.samples("time", 1).sum())  # 0 before there is one
    return Progress(
        time=time,
        duration=duration,
        realtime_rate=time / wall,
        commanded=recorder.samples("command", 1)[:, :3].sum(axis=0),
        measured=recent_velocity(recorder),
        warnings=warnings_of(loop.recorder, loop.humanoid),
    )
