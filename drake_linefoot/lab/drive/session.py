"""A closed loop that is simulated piece by piece, pushed, retuned and begun again."""

import math
import time as clock
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike
from pydrake.geometry import Meshcat
from pydrake.systems.analysis import InitializeParams, Simulator
from pydrake.systems.framework import Context

from drake_linefoot.errors import InputError, SignalError
from drake_linefoot.lab.drive.ragdoll import Ragdoll
from drake_linefoot.lab.drive.teleop import Tuning
from drake_linefoot.lab.scenario import Scenario, Segment
from drake_linefoot.lab.scenario.load import validate
from drake_linefoot.lab.simulation.closed_loop import ClosedLoop
from drake_linefoot.lab.simulation.command import HeldCommand
from drake_linefoot.lab.simulation.recording import Run
from drake_linefoot.lab.simulation.run import FallWatch, fall_of, finished_run, keep_unit_norm
from drake_linefoot.lab.wiring.closed_loop import build_closed_loop
from drake_linefoot.math.rotation import roll_pitch_yaw
from drake_linefoot.robot.scaling import scaled
from drake_linefoot.types import Array

LENGTHS = ("single_support", "swing_height", "com_height")  # of the gait, that are tuned
PUSH_DURATION = 0.1  # [s]
KEPT = 1000  # samples that are kept when nothing is recorded
KEPT_AT_MOST = 10000  # samples; then all but the last `KEPT` are forgotten


class Session:
    """The simulation of a drive; knows no display but the Meshcat that is drawn into.

    Attributes:
        scenario: what is simulated, with the tuning in force.
        loop: the closed loop.
        record: whether everything is kept, for `run`.
        fall: why the robot counts as fallen; empty while it does not.
        clip: whether a part of it is recorded, from `begin_clip` on.
    """

    def __init__(self, scenario: Scenario, meshcat: Meshcat | None, record: bool) -> None:
        scenario = replace(scenario, pushes=[])  # nor are its segments played
        self.scenario, self.record, self.fall = scenario, record, ""
        self._meshcat, self.clip = meshcat, False
        self._ragdoll: Ragdoll | None = None
        self._start = clock.perf_counter()
        self._loops: dict[tuple[str, bool], ClosedLoop] = {}  # by model, and whether it estimates
        self.loop = self._loop_of(scenario)
        self._gait = scaled(scenario.gait, self.loop.humanoid)  # what of it is tuned is in force
        self.reset()

    @property
    def time(self) -> float:
        """Simulated time since the last reset [s]."""
        return float(self._simulator.get_context().get_time())

    @property
    def tuning(self) -> Tuning:
        """What is in force."""
        g, scenario = self._gait, self.scenario
        lengths = g.single_support, g.swing_height, g.com_height
        return Tuning(*lengths, scenario.mpc.model, scenario.estimation)

    def reset(self) -> None:
        """Begin again at time 0; what was recorded is forgotten."""
        self.fall, self._lying = "", False
        if self._meshcat is not None:
            self._meshcat.SetProperty("/overlays", "visible", True)
        self._simulator = self.loop.make_simulator()
        self._tune()
        self._watched()
        self._simulator.Initialize()
        self._start = clock.perf_counter()

    def advance(self, length: float) -> None:
        """Simulate `length` [s] more, or until the robot falls; nothing when it has fallen.

        Raises:
            InputError: the length is negative, or no finite number.
        """
        if not 0.0 <= length < math.inf:
            raise InputError("session", "length", length, "must be a time that is not negative")
        if self.fall:
            return
        try:
            self._simulator.AdvanceTo(self.time + length)
            keep_unit_norm(self.loop, self._context)
        except (SignalError, RuntimeError, np.linalg.LinAlgError) as error:
            self._watch.reason = fall_of(error)
        self.fall = self._watch.reason
        if not (self.record or self.clip) and self.loop.recorder.count > KEPT_AT_MOST:
            self.loop.recorder.keep_last(KEPT)

    def lie_down(self, length: float) -> None:
        """Let a robot that fell lie down for `length` [s]; it is drawn, not recorded."""
        if not self._lying:
            if self._ragdoll is None:
                self._ragdoll = Ragdoll(self.loop.humanoid, self.scenario, self._meshcat)
            q, v = np.split(self.loop.plant.state(self._context), [self.loop.humanoid.nq])
            self._lying = self._ragdoll.fall(q, v)
            if self._meshcat is not None:
                self._meshcat.SetProperty("/overlays", "visible", False)
        if self._lying and self._ragdoll is not None:
            self._ragdoll.advance(length)

    def command(self, command: ArrayLike) -> None:
        """Command v_x, v_y [m/s], turn rate [rad/s], walk (0 or 1) from now on, shape (4,)."""
        system = self.loop.command
        system.hold(system.GetMyMutableContextFromRoot(self._context), command)

    def push(self, force: ArrayLike) -> None:
        """Push the torso for 0.1 s; `force` [N] is forward and left of the torso, shape (2,)."""
        yaw = roll_pitch_yaw(self.loop.plant.state(self._context)[:4])[2]
        c, s = np.cos(yaw), np.sin(yaw)
        x, y = np.asarray(force, dtype=float)
        self.pull([c * x - s * y, s * x + c * y, 0.0], PUSH_DURATION)

    def pull(self, force: ArrayLike, duration: float) -> None:
        """Push the torso for `duration` [s] with `force` in W [N], shape (3,)."""
        push = self.loop.push
        assert push is not None
        push.push(push.GetMyMutableContextFromRoot(self._context), force, duration)

    def retune(self, tuning: Tuning) -> None:
        """Change gait, MPC and where the state comes from without a break in the motion.

        Lengths are parameters of the gait in the loop's context. For another model or source of
        the state the loop is built anew, and takes over time, state of the robot, and state and
        parameters of every block. All holds from the next step and plan on. An estimator that is
        switched on begins with the true state, and the IMU with its biases.

        Raises:
            ScenarioError: the tuning is not usable; the old one goes on.
        """
        lengths = {name: getattr(tuning, name) for name in LENGTHS}
        mpc, now = replace(self.scenario.mpc, model=tuning.model), self.tuning
        gait = replace(self.scenario.gait, **lengths)
        scenario = replace(self.scenario, gait=gait, mpc=mpc, estimation=tuning.estimation)
        validate(scenario)
        is_built = (tuning.model, tuning.estimation) == (now.model, now.estimation)
        self.scenario, self._gait = scenario, replace(self._gait, **lengths)
        if not is_built:
            self._rebuild()
        self._tune()

    def _rebuild(self) -> None:
        """Go on in a loop of the scenario's model and source of the state."""
        before = self._context
        old, self.loop = self.loop, self._loop_of(self.scenario)
        self._simulator = Simulator(self.loop)
        self.loop.prepare(self._context)
        _carry_over(old, before, self.loop, self._context)
        self._watched()
        self._simulator.Initialize(InitializeParams(suppress_initialization_events=True))

    def _tune(self) -> None:
        """Put the lengths of the tuning into the context of the gait."""
        planner = self.loop.controller.GetSubsystemByName("gait_planner")
        context = planner.GetMyMutableContextFromRoot(self._context)
        planner.set_parameters(context, **{name: getattr(self._gait, name) for name in LENGTHS})

    def run(self) -> Run:
        """Return what was recorded since the last reset.

        Its scenario has the tuning in force at the end, and the commands as segments, so that
        `linefoot walk` can repeat them.
        """
        run = finished_run(self.loop, self.fall, self.time, clock.perf_counter() - self._start)
        scenario = replace(self.scenario, segments=segments(run.time, run.command))
        return Run(**{**vars(run), "scenario": scenario})  # arrays on the disk stay there

    def begin_clip(self) -> None:
        """Keep everything from now on, for `end_clip`; what was kept goes unless it is recorded."""
        self.clip = True
        if not self.record:
            self.loop.recorder.keep_last(0)

    def end_clip(self) -> Run:
        """Return what was kept, as a run that begins at 0; all of a session that is recorded."""
        self.clip = False
        run = self.run()
        if self.record or not len(run.time):
            return run
        return replace(run, time=run.time - run.time[0])

    @property
    def _context(self) -> Context:
        return self._simulator.get_mutable_context()

    def _loop_of(self, scenario: Scenario) -> ClosedLoop:
        """Return a loop, each built once: on Python 3.11 none that was built is ever freed."""
        key = scenario.mpc.model, scenario.estimation
        if key not in self._loops:
            made = build_closed_loop(scenario, self._meshcat, command=HeldCommand(), pushes=True)
            self._loops[key] = made
        return self._loops[key]

    def _watched(self) -> None:
        self._watch = FallWatch(self.loop)
        self._simulator.set_monitor(self._watch)


def _carry_over(old: ClosedLoop, before: Context, new: ClosedLoop, after: Context) -> None:
    """Copy time, states, command and push from one loop's context to another's, and the record.

    Not wholesale: the scene graph keeps geometry in its parameters, which is each loop's own.
    """
    new.recorder.go_on_from(old.recorder)
    after.SetTime(before.get_time())
    x = old.plant.state(before)
    new.plant.place(after, x)
    for name in ("controller", "command", "push", "actuators", "onboard", "estimator"):
        source, target = getattr(old, name), getattr(new, name)
        if source is not None and target is not None:
            there = source.GetMyContextFromRoot(before)
            here = target.GetMyMutableContextFromRoot(after)
            here.SetStateAndParametersFrom(there)
    if new.estimator is not None and new.onboard is not None and old.estimator is None:
        port = old.plant.outputs["net_actuation"]
        torque = port.Eval(old.plant.system.GetMyContextFromRoot(before))
        here = new.onboard.GetMyMutableContextFromRoot(after)
        new.onboard.switch_on(here, new.scenario.seed, torque)
        new.estimator.go_on_from(new.estimator.GetMyMutableContextFromRoot(after), x)


def segments(time: Array, command: Array) -> list[Segment]:
    """Return commands that were given as segments of a scenario.

    Args:
        time: of the samples [s], shape (n,), n at least 1.
        command: v_x, v_y [m/s], turn rate [rad/s], walk (0 or 1), shape (n, 4).
    """
    change = 1 + np.flatnonzero(np.any(command[1:] != command[:-1], axis=1))
    begins = np.concatenate([[0], change])
    ends = np.append(time[change], max(float(time[-1]), 1e-3))
    return [
        Segment(
            name=str(k + 1),
            duration=float(end - time[begin]),
            walk=bool(command[begin, 3] > 0.5),
            velocity=[float(v) for v in command[begin, :2]],
            turn_rate=float(command[begin, 2]),
        )
        for k, (begin, end) in enumerate(zip(begins, ends, strict=True))
        if end > time[begin]
    ]
