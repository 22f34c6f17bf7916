"""The closed loop as one Diagram: plant, command, controller, recorder, pictures."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from importlib.util import find_spec

from pydrake.geometry import Meshcat, MeshcatVisualizer, MeshcatVisualizerParams, SceneGraph
from pydrake.systems.framework import DiagramBuilder, OutputPort, System
from pydrake.systems.primitives import RandomSource

from drake_linefoot.errors import InputError, MissingPackageError
from drake_linefoot.estimation.state_estimator import StateEstimator
from drake_linefoot.lab.plants.drake import DrakePlant
from drake_linefoot.lab.plants.plant import Plant
from drake_linefoot.lab.plants.terrain_map import TerrainMap
from drake_linefoot.lab.scenario import Scenario, Segment
from drake_linefoot.lab.scenario.load import check_limits, validate
from drake_linefoot.lab.simulation.actuators import Actuators
from drake_linefoot.lab.simulation.closed_loop import ClosedLoop
from drake_linefoot.lab.simulation.command import CommandSchedule
from drake_linefoot.lab.simulation.push import Push
from drake_linefoot.lab.simulation.recorder import Recorder
from drake_linefoot.lab.simulation.sensors import (
    IMU_NOISE,
    Onboard,
    Sensors,
    noise_source,
    state_noise,
)
from drake_linefoot.lab.visualization.map_outlines import outlines_of
from drake_linefoot.lab.visualization.overlay_system import Overlays
from drake_linefoot.lab.visualization.overlays import PERIOD
from drake_linefoot.lab.visualization.view import set_up_view
from drake_linefoot.robot.humanoid import Humanoid, load_humanoid
from drake_linefoot.robot.scaling import scaled
from drake_linefoot.robot.state_dynamics import StateDynamics
from drake_linefoot.wiring.controller import build_controller, connect_by_name
from drake_linefoot.wiring.warm_up import compile_first, says_by_itself

# What the controller gets, by port; then source of noise, sensors on board, and estimator, or None.
Measured = tuple[dict[str, OutputPort], RandomSource | None, Onboard | None, StateEstimator | None]


def build_closed_loop(
    scenario: Scenario,
    meshcat: Meshcat | None = None,
    controller: System | None = None,
    *,
    command: System | None = None,
    pushes: bool = False,
    extend: Callable[[DiagramBuilder, Mapping[str, OutputPort]], object] | None = None,
) -> ClosedLoop:
    """Wire robot, ground, command, controller and recorder into one diagram.

    Args:
        scenario: what will be run.
        meshcat: shows the robot, contact forces and overlays when given.
        controller: used instead of the one of this package. It needs the output port `torque`
            (na). Its input ports `state`, `command`, `applied_torque`, and `angular_velocity` and
            `specific_force` of an IMU, are connected, its output ports `contact`, `targets`,
            `plan`, `report` recorded, whichever of them it has.
        command: used instead of the scenario's segments; needs the output port `command` (4).
        pushes: adds a `Push` of the torso, the loop's `push`, even when the scenario has none.
        extend: called before the diagram is built, with the builder and the ports by name
            (`state`, `torque`, `plan`, ...): adds and connects systems and logs, exports ports.

    Returns:
        The loop, for `drake_linefoot.lab.simulation.run.simulate`, or its own `make_simulator`.

    Raises:
        InputError: robot, scene, controller, command or model error cannot be used.
    """
    scenario = _check_and_compile(scenario)
    humanoid, builder = load_humanoid(scenario.robot), DiagramBuilder()
    check_limits(scenario := scaled(scenario, humanoid), humanoid.description)
    plant = _plant(builder, humanoid, scenario, meshcat is not None)
    controller = controller or build_controller(humanoid, _of_its_state(scenario))
    command = command or CommandSchedule(scenario.segments)
    _add_with_output(builder, "controller", controller, "torque")
    _add_with_output(builder, "command", command, "command")
    measured, noise, onboard, estimator = _sense(builder, plant, humanoid, scenario, controller)
    knots = scenario.mpc.knots
    known = _add_map(builder, plant, humanoid, scenario, controller)
    sources = _connect(builder, plant, controller, command, measured | known)
    # The controller's dynamics are those of another state when it is measured with noise.
    if noise is not None or "dynamics" not in sources:
        dynamics = builder.AddNamedSystem("true_dynamics", StateDynamics(humanoid))
        connect_by_name(builder, dynamics, sources)
        sources["dynamics"] = dynamics.get_dynamics_output_port()
    actuators = _add_actuators(builder, plant, humanoid, scenario, sources["torque"])
    push = _add_push(builder, plant, humanoid, scenario) if pushes or scenario.pushes else None
    if push is not None:
        sources["push"] = push.GetOutputPort("push")
    recorder = _add_recorder(builder, plant, humanoid, scenario, sources)
    if meshcat is not None and plant.scene_graph is not None:
        map_ = outlines_of(scenario, humanoid, plant.ground)
        overlays = Overlays(humanoid, meshcat, scenario.mpc.friction, plant.ground, knots, map_)
        _add_pictures(builder, plant.scene_graph, meshcat, overlays, sources)
        set_up_view(meshcat, humanoid, plant.ground)
    if extend is not None:
        extend(builder, sources)
    systems = controller, command, push, actuators, noise, onboard, estimator, recorder
    return ClosedLoop(builder, plant, *systems, plant.ground, humanoid, scenario, meshcat)


def _of_its_state(scenario: Scenario) -> Scenario:
    """Let the controller know how late the joint rates of an estimate of the state are."""
    estimator, bandwidth = scenario.estimator, scenario.state_estimator.rate_bandwidth
    if not scenario.estimation or estimator.rate_bandwidth is not None:
        return scenario
    return replace(scenario, estimator=replace(estimator, rate_bandwidth=bandwidth))


def _check_and_compile(scenario: Scenario) -> Scenario:
    """Refuse what cannot be used before anything is compiled; return it in its usual form."""
    scenario = validate(scenario)
    if says_by_itself():
        warm_up()
    return scenario


def warm_up() -> None:
    """Compile all that a walk needs, with a bar on stderr, when there is no machine code of it.

    The first `build_closed_loop` of a process does so, but in workers of a pool and in tests.
    """
    compile_first(_walk_a_little)


def _walk_a_little() -> None:
    """Walk through the shift and a step with each foot; stand on an estimate of the state."""
    segments = [Segment("stand", 0.02), Segment("walk", 2.0, walk=True, velocity=[0.3, 0.0])]
    for estimation, until in ((False, 0.9), (True, 0.05)):
        scenario = Scenario(segments=segments, estimation=estimation)
        build_closed_loop(scenario).make_simulator().AdvanceTo(until)


def _plant(builder: DiagramBuilder, humanoid: Humanoid, scenario: Scenario, drawn: bool) -> Plant:
    """Add the simulator that the scenario names.

    Raises:
        MissingPackageError: MuJoCo is not installed.
    """
    if scenario.plant.simulator == "drake":
        return DrakePlant(builder, humanoid, scenario, drawn)
    if find_spec("mujoco") is None:
        raise MissingPackageError("plant.simulator: mujoco", "mujoco", "mujoco")
    from drake_linefoot.lab.plants.mujoco import MujocoPlant

    return MujocoPlant(builder, humanoid, scenario, drawn)


def _add_with_output(builder: DiagramBuilder, role: str, system: System, port: str) -> None:
    """Add a system; raise InputError when it lacks the output port that its role needs."""
    if not system.HasOutputPort(port):
        raise InputError(role, "", system.get_name(), f"lacks the output port {port}")
    builder.AddSystem(system)


def _add_recorder(
    builder: DiagramBuilder,
    plant: Plant,
    humanoid: Humanoid,
    scenario: Scenario,
    sources: dict[str, OutputPort],
) -> Recorder:
    """Add the recorder and what says how the feet touch the ground, as one more source."""
    sources["foot_contacts"] = plant.add_contacts(builder, sources)
    recorder = Recorder(humanoid, scenario.plant.time_step, scenario.mpc.knots)
    connect_by_name(builder, builder.AddSystem(recorder), sources)
    return recorder


def _add_pictures(
    builder: DiagramBuilder,
    scene_graph: SceneGraph,
    meshcat: Meshcat,
    overlays: Overlays,
    sources: Mapping[str, OutputPort],
) -> None:
    """Add what shows robot, ground and overlays in Meshcat."""
    parameters = MeshcatVisualizerParams(publish_period=PERIOD)
    MeshcatVisualizer.AddToBuilder(builder, scene_graph, meshcat, parameters)
    connect_by_name(builder, builder.AddSystem(overlays), sources)


def _connect(
    builder: DiagramBuilder,
    plant: Plant,
    controller: System,
    command: System,
    measured: dict[str, OutputPort],
) -> dict[str, OutputPort]:
    """Connect the controller to what is measured; return the ports that can be recorded."""
    sources = {
        "state": plant.outputs["state"],
        "command": command.GetOutputPort("command"),
        "applied_torque": plant.outputs["net_actuation"],
    }
    imu = plant.add_imu(builder) if controller.HasInputPort("specific_force") else {}
    connect_by_name(builder, controller, sources | imu | measured)
    if "report" in measured:
        sources["estimate"] = measured["report"]
    outputs = [controller.get_output_port(i) for i in range(controller.num_output_ports())]
    return {port.get_name(): port for port in outputs} | sources


def _add_map(
    builder: DiagramBuilder,
    plant: Plant,
    humanoid: Humanoid,
    scenario: Scenario,
    controller: System,
) -> dict[str, OutputPort]:
    """Add what tells the controller of the ground, if it is told anything."""
    if scenario.terrain.source == "felt" or not controller.HasInputPort("terrain"):
        return {}
    told = TerrainMap(humanoid, plant.ground, scenario)
    builder.AddSystem(told)
    builder.Connect(plant.outputs["state"], told.GetInputPort("state"))
    return {"terrain": told.GetOutputPort("terrain")}


def _add_push(
    builder: DiagramBuilder, plant: Plant, humanoid: Humanoid, scenario: Scenario
) -> Push:
    """Add what pushes the torso."""
    push = builder.AddSystem(Push(humanoid, scenario.pushes, scenario.plant.time_step))
    builder.Connect(plant.outputs["state"], push.GetInputPort("state"))
    plant.add_push(builder, push.GetOutputPort("push"))
    return push


def _sense(
    builder: DiagramBuilder,
    plant: Plant,
    humanoid: Humanoid,
    scenario: Scenario,
    controller: System,
) -> Measured:
    """Add the sensors, unless they are perfect; those of the estimation, if there is one."""
    if scenario.estimation:
        return _add_estimation(builder, plant, humanoid, scenario, controller)
    state = plant.outputs["state"]
    if scenario.sensors.are_perfect:
        return {"state": state}, None, None, None
    noise = builder.AddSystem(noise_source(state_noise(humanoid), scenario.plant.time_step))
    sensors = builder.AddSystem(Sensors(humanoid, scenario.sensors))
    connect_by_name(builder, sensors, {"state": state, "noise": noise.get_output_port()})
    return {"state": sensors.GetOutputPort("measured")}, noise, None, None


def _add_estimation(
    builder: DiagramBuilder,
    plant: Plant,
    humanoid: Humanoid,
    scenario: Scenario,
    controller: System,
) -> Measured:
    """Add the sensors on board and the estimator that goes by them.

    Raises:
        InputError: the controller does not say which feet stand.
    """
    if not controller.HasOutputPort("contact"):
        allowed = "lacks the output port contact, which the estimation needs"
        raise InputError("controller", "", controller.get_name(), allowed)
    imu, tick = plant.add_imu(builder), scenario.plant.time_step
    noise = builder.AddSystem(noise_source(humanoid.na + IMU_NOISE, tick))
    onboard = builder.AddSystem(Onboard(humanoid, scenario.onboard, tick))
    sources = {**imu, **plant.outputs, "noise": noise.get_output_port()}
    connect_by_name(builder, onboard, sources)
    estimator = StateEstimator(humanoid, scenario.onboard, scenario.state_estimator, tick)
    builder.AddSystem(estimator)
    says = {name: onboard.GetOutputPort(name) for name in ("imu", "encoders")}
    connect_by_name(builder, estimator, says | {"contact": controller.GetOutputPort("contact")})
    measured = {name: estimator.GetOutputPort(name) for name in ("state", "report")}
    measured["applied_torque"] = onboard.GetOutputPort("applied_torque")
    return measured, noise, onboard, estimator


def _add_actuators(
    builder: DiagramBuilder,
    plant: Plant,
    humanoid: Humanoid,
    scenario: Scenario,
    torque: OutputPort,
) -> Actuators | None:
    """Connect the controller's torque to the plant, through actuators unless they are perfect."""
    parameters, friction = scenario.actuators, scenario.error.joint_friction
    if not (parameters.torque_speed or parameters.delay or friction):
        builder.Connect(torque, plant.actuation)
        return None
    period = scenario.plant.time_step
    actuators = builder.AddSystem(Actuators(humanoid, parameters, friction, period))
    connect_by_name(builder, actuators, {"torque": torque, "state": plant.outputs["state"]})
    builder.Connect(actuators.GetOutputPort("actuation"), plant.actuation)
    return actuators
