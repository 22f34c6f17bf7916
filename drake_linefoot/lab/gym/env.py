"""The closed loop as a Gymnasium environment, through Drake's own `DrakeGymEnv`."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import replace
from typing import Any

import numpy as np
from gymnasium.spaces import Box
from pydrake.geometry import Meshcat
from pydrake.gym import DrakeGymEnv
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Context, Diagram, DiagramBuilder, OutputPort, System
from pydrake.systems.primitives import (
    Adder,
    ConstantVectorSource,
    Demultiplexer,
    Gain,
    Multiplexer,
)

from drake_linefoot.errors import InputError, SignalError
from drake_linefoot.lab.gym.observation import Observation, entries_of, tilt_of
from drake_linefoot.lab.gym.rendering import MODES, add_camera, drawn_for
from drake_linefoot.lab.gym.reward import Moment, tracking
from drake_linefoot.lab.plants.initial_state import initial_state
from drake_linefoot.lab.scenario import Perturbation, Scenario
from drake_linefoot.lab.scenario.load import validate
from drake_linefoot.lab.simulation.closed_loop import ClosedLoop
from drake_linefoot.lab.simulation.recording import Run
from drake_linefoot.lab.simulation.run import FallWatch, fall_of, run_so_far
from drake_linefoot.lab.simulation.velocity import recent_velocity
from drake_linefoot.lab.wiring.closed_loop import build_closed_loop
from drake_linefoot.late import late
from drake_linefoot.robot.humanoid import Humanoid, load_humanoid
from drake_linefoot.robot.scaling import scaled
from drake_linefoot.types import Array
from drake_linefoot.wiring.controller import EXPORTS, INPUTS, build_controller, connect_by_name

TIME_STEP = 0.02  # [s] of an action, a period of the MPC
GOALS = (0.3, 0.5, 0.5)  # [-] shares of the limits of the gait within which goals are drawn: walks
PERTURBATION = Perturbation(joint_position=0.02, joint_velocity=0.1, base_velocity=0.05)


class LinefootEnv(DrakeGymEnv):
    """A robot that walks under its controller, which a policy commands and helps.

    An action is a velocity command, forward, left and turn as shares of the limits of the gait,
    and, with `residual`, a torque for each motor on top of the controller's, as shares of
    `residual` times its limit. All in [-1, 1]. Observations are those of `entries`. The goal, a
    velocity, is drawn anew for each episode, which ends when the robot has fallen.

    Attributes:
        entries: name, unit and bound of each number of an observation.
        actions: name of each number of an action.
        loop: the closed loop, with its recorder.
        why: the robot has fallen; empty while it has not.
    """

    metadata: dict[str, Any] = {"render_modes": [*MODES], "render_fps": 50}  # noqa: RUF012

    def __init__(
        self,
        scenario: Scenario | None = None,
        *,
        residual: float = 0.0,
        goal: Sequence[float] | None = None,
        reward: Callable[[Moment], float] = tracking,
        render_mode: str | None = None,
    ) -> None:
        """Build the closed loop once; episodes begin anew in it.

        Args:
            scenario: robot, ground, disturbances and parameters of every block, those of the
                steps among them; its segments are not used. None takes the MIT Humanoid on flat
                ground, with a random initial state.
            residual: share of the motors' limits that a policy may add [-], from 0 to 1.
            goal: forward, left [m/s] and turn rate [rad/s]; None draws them for each episode.
            reward: of each step.
            render_mode: "human" shows it in real time on a page, whose address is printed;
                "rgb_array" has `render` return a picture, shape (480, 640, 3). What happened is
                shown by `run` as well.

        Raises:
            InputError: the scenario, the residual, the goal or the mode cannot be used.
        """
        _check(residual, goal)
        scenario = validate(scenario or Scenario(perturbation=PERTURBATION))
        humanoid = load_humanoid(scenario.robot)
        gait = scaled(scenario, humanoid).gait
        limits = np.array([gait.forward_max, gait.lateral_max, gait.turn_max])
        self._goal, self._goals, self._reward = goal, np.array(GOALS) * limits, reward
        self._scenario, self.why = scenario, ""
        self.entries, observation = entries_of(humanoid), Observation(humanoid)
        self.actions = ["forward", "left", "turn_rate"]
        if residual:
            self.actions += humanoid.description.actuated_joints
        self.metadata = {**type(self).metadata}  # which DrakeGymEnv writes to
        self._until = ExitStack()
        (meshcat, link), camera = drawn_for(render_mode, self._until), render_mode == "rgb_array"
        self.loop = _build(scenario, humanoid, limits, residual, observation, meshcat, camera)
        self._observation, self._watch = observation, FallWatch(self.loop)
        self._look = link and late("lab.drive.telemetry", "follow")(self.loop, link, "Linefoot-v0")
        simulator, self._fresh = self.loop.make_simulator(), self.loop.CreateDefaultContext()
        simulator.set_monitor(self._watch)
        most, ones = np.array([e.most for e in self.entries]), np.ones(len(self.actions))
        super().__init__(
            simulator,
            TIME_STEP,
            Box(-ones, ones, dtype=np.float64),
            Box(-most, most, dtype=np.float64),
            self._rewarded,
            "action",
            "observation",
            reset_handler=self._begin,
            render_rgb_port_id="image" if camera else None,
        )
        self.metadata, self.render_mode = {**type(self).metadata}, render_mode
        if render_mode == "human":
            simulator.set_target_realtime_rate(1.0)
        self.action_port.FixValue(simulator.get_mutable_context(), 0.0 * ones)

    def step(self, action: Array) -> tuple[Array, float, bool, bool, dict[str, Any]]:
        """Simulate 0.02 s under an action; a robot without a finite state has fallen."""
        self.why = ""
        before = self.observation_port.Eval(self.simulator.get_context())
        try:
            seen = super().step(np.clip(np.asarray(action, dtype=float), -1.0, 1.0))
        except (SignalError, np.linalg.LinAlgError) as error:
            self.why = fall_of(error)
            return before, 0.0, True, False, {"fall": self.why}
        self.why = self._watch.reason
        if self._look:
            self._look(self.simulator.get_context())
        return (*seen[:4], {"fall": self.why} if self.why else {})

    def render(self) -> Array | None:
        """Return a picture in the mode "rgb_array", None in the others; a page draws by itself."""
        picture: Array | None = super().render() if self.render_mode == "rgb_array" else None
        return picture

    def close(self) -> None:
        """Close the page."""
        self._until.close()

    def run(self) -> Run:
        """Return what was recorded of the episode so far, as any other run."""
        run = run_so_far(self.loop)
        assert run is not None  # reset records the first sample
        return run

    def _begin(self, simulator: Simulator, context: Context, seed: int | None) -> None:
        """Put the robot where an episode begins, and draw its goal; all from `np_random`."""
        loop = self.loop
        # Drake's SetDefaultContext leaves the plant's sampled outputs as the last step left them.
        context.SetTimeStateAndParametersFrom(self._fresh)
        loop.prepare(context)
        drawn = self.np_random.uniform(-1.0, 1.0, 3) * self._goals
        goal = drawn if self._goal is None else np.array(self._goal, dtype=float)
        parameter = self._observation.GetMyMutableContextFromRoot(context)
        parameter.get_mutable_numeric_parameter(0).SetFromVector(goal)
        # The perturbation of a scenario goes by its seed.
        seeded = replace(self._scenario, seed=int(self.np_random.integers(2**31)))
        loop.plant.place(context, initial_state(loop.humanoid, seeded))
        self._watch.reason = self.why = ""
        self.action_port.FixValue(context, np.zeros(len(self.actions)))  # not that of before
        simulator.Initialize()
        if self._look:
            self._look(context)

    def _rewarded(self, system: System, context: Context) -> float:
        loop = self.loop
        goal = self._observation.GetMyContextFromRoot(context).get_numeric_parameter(0).value()
        torque = loop.recorder.samples("applied_torque", 1).sum(axis=0)
        return self._reward(
            Moment(
                goal=goal.copy(),
                velocity=recent_velocity(loop.recorder),
                tilt=tilt_of(loop.plant.state(context)),
                torque=torque / loop.humanoid.effort_limits,
                fell=bool(self._watch.reason),
            )
        )


def _check(residual: float, goal: Sequence[float] | None) -> None:
    """Raise InputError when residual or goal cannot be used."""
    if not 0.0 <= residual <= 1.0:
        raise InputError("Linefoot-v0", "residual", residual, "must lie in [0, 1]")
    if goal is not None and not (np.shape(goal) == (3,) and np.isfinite(goal).all()):
        raise InputError("Linefoot-v0", "goal", goal, "must be three finite numbers")


def _build(
    scenario: Scenario,
    humanoid: Humanoid,
    limits: Array,
    residual: float,
    observation: Observation,
    meshcat: Meshcat | None,
    camera: bool,
) -> ClosedLoop:
    """Return a closed loop with an input port `action` and an output port `observation`."""
    controller: Diagram = build_controller(humanoid, scenario)
    if residual:
        controller = _with_residual(controller, residual * humanoid.effort_limits)

    def extend(builder: DiagramBuilder, ports: Mapping[str, OutputPort]) -> None:
        parts = builder.AddSystem(Demultiplexer([3, humanoid.na] if residual else [3]))
        command = builder.GetSubsystemByName("command")
        builder.Connect(parts.get_output_port(0), command.GetInputPort("action"))
        if residual:
            builder.Connect(parts.get_output_port(1), controller.GetInputPort("residual"))
        connect_by_name(builder, builder.AddSystem(observation), ports)
        builder.ExportInput(parts.get_input_port(), "action")
        builder.ExportOutput(observation.GetOutputPort("observation"), "observation")
        if camera:
            builder.ExportOutput(add_camera(builder, humanoid), "image")

    command = _command(limits)
    return build_closed_loop(scenario, meshcat, controller, command=command, extend=extend)


def _command(limits: Array) -> Diagram:
    """Return what makes a command that walks of three shares of the limits of the gait."""
    builder = DiagramBuilder()
    scaled = builder.AddSystem(Gain(limits))
    walk = builder.AddSystem(ConstantVectorSource([1.0]))
    joined = builder.AddSystem(Multiplexer([3, 1]))
    builder.Connect(scaled.get_output_port(), joined.get_input_port(0))
    builder.Connect(walk.get_output_port(), joined.get_input_port(1))
    builder.ExportInput(scaled.get_input_port(), "action")
    builder.ExportOutput(joined.get_output_port(), "command")
    (diagram := builder.Build()).set_name("command")
    return diagram


def _with_residual(controller: Diagram, limits: Array) -> Diagram:
    """Return a controller with an input port `residual`, shares of `limits` [N m] on top."""
    builder = DiagramBuilder()
    builder.AddNamedSystem("inner", controller)
    total, scaled = builder.AddSystem(Adder(2, len(limits))), builder.AddSystem(Gain(limits))
    builder.Connect(controller.GetOutputPort("torque"), total.get_input_port(0))
    builder.Connect(scaled.get_output_port(), total.get_input_port(1))
    for name in INPUTS:
        builder.ExportInput(controller.GetInputPort(name), name)
    builder.ExportInput(scaled.get_input_port(), "residual")
    builder.ExportOutput(total.get_output_port(), "torque")
    for name in EXPORTS:
        if name != "torque":
            builder.ExportOutput(controller.GetOutputPort(name), name)
    (diagram := builder.Build()).set_name("controller")
    return diagram
