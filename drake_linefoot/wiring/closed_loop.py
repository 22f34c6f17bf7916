"""The closed loop as one Diagram: plant, command, controller, recorder, pictures."""

from __future__ import annotations

from dataclasses import dataclass

from pydrake.geometry import Meshcat, MeshcatVisualizer, MeshcatVisualizerParams, SceneGraph
from pydrake.multibody.plant import AddMultibodyPlant, MultibodyPlant, MultibodyPlantConfig
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Context, Diagram, DiagramBuilder, OutputPort, System
from pydrake.systems.primitives import RandomSource

from drake_linefoot.errors import InputError
from drake_linefoot.robot.dynamics import SharedDynamics
from drake_linefoot.robot.humanoid import Humanoid, load_humanoid
from drake_linefoot.scenario import Scenario
from drake_linefoot.simulation.actuators import Actuators
from drake_linefoot.simulation.command import CommandSchedule
from drake_linefoot.simulation.ground import Ground
from drake_linefoot.simulation.initial_state import initial_state
from drake_linefoot.simulation.model_error import apply_error, check_error
from drake_linefoot.simulation.push import Push
from drake_linefoot.simulation.recorder import Recorder
from drake_linefoot.simulation.scene import Scene, add_ground, scene_of
from drake_linefoot.simulation.sensors import seed_noise
from drake_linefoot.visualization.overlay_system import PERIOD, Overlays
from drake_linefoot.visualization.view import set_up_view
from drake_linefoot.wiring.controller import build_controller
from drake_linefoot.wiring.hardware import add_actuators, add_sensors

INPUTS = ("state", "command", "applied_torque")  # connected when there
OPTIONAL_OUTPUTS = ("contact", "targets", "plan", "report")  # recorded when there
DRAWN = (
    "state",
    "contact_results",
    "contact",
    "targets",
    "plan",
    "push",
)  # as overlays, when there


@dataclass(frozen=True)
class ClosedLoop:
    """A closed loop, ready to be simulated.

    Attributes:
        diagram: everything; its systems are named.
        plant: the robot on its ground.
        controller: state in, torque out.
        command: plays the scenario's command, or what was given for it.
        push: pushes the torso; None when nothing can push.
        actuators: make of the torque what motors do; None when they apply it as it is.
        noise: of the sensors; None when they are perfect.
        recorder: keeps what happens.
        ground: where the ground is.
        humanoid: the robot's facts.
        scenario: what will be run.
        meshcat: where it is shown; None when it is not.
    """

    diagram: Diagram
    plant: MultibodyPlant
    controller: System
    command: System
    push: Push | None
    actuators: Actuators | None
    noise: RandomSource | None
    recorder: Recorder
    ground: Ground
    humanoid: Humanoid
    scenario: Scenario
    meshcat: Meshcat | None

    def make_simulator(self) -> Simulator:
        """Return a simulator at time 0 in the scenario's initial state."""
        simulator = Simulator(self.diagram)
        self.prepare(simulator.get_mutable_context())
        context = self.plant.GetMyMutableContextFromRoot(simulator.get_mutable_context())
        self.plant.SetPositionsAndVelocities(context, initial_state(self.humanoid, self.scenario))
        return simulator

    def prepare(self, root: Context) -> None:
        """Put what the scenario says of the hardware into a context of the diagram."""
        if self.noise is not None:
            context = self.noise.GetMyMutableContextFromRoot(root)
            seed_noise(self.noise, context, self.scenario.seed)
        if self.scenario.error.changes_the_model:
            context = self.plant.GetMyMutableContextFromRoot(root)
            apply_error(self.plant, context, self.humanoid, self.scenario.error)


def build_closed_loop(
    scenario: Scenario,
    meshcat: Meshcat | None = None,
    controller: System | None = None,
    *,
    command: System | None = None,
    pushes: bool = False,
) -> ClosedLoop:
    """Wire robot, ground, command, controller and recorder into one diagram.

    Args:
        scenario: what will be run.
        meshcat: shows the robot, contact forces and overlays when given.
        controller: used instead of the one of this package. It needs the output port `torque`
            (na). Its input ports `state` (nq + nv), `command` (4) and `applied_torque` (na)
            are connected and its output ports `contact`, `targets`, `plan` and `report` are
            recorded, whichever of them it has.
        command: used instead of the scenario's segments; needs the output port `command` (4).
        pushes: adds a `Push` of the torso, which is then the loop's `push`, even when the
            scenario has none.

    Returns:
        The loop; simulate it with `drake_linefoot.simulation.run.simulate`, or with the
        `Simulator` of its `make_simulator`.

    Raises:
        InputError: robot, scene, controller, command or model error cannot be used.
    """
    humanoid, scene, builder = load_humanoid(scenario.robot), scene_of(scenario), DiagramBuilder()
    shared, ground = SharedDynamics(humanoid), scene.ground(scenario.seed)
    plant, scene_graph = _add_plant(builder, humanoid, scenario, scene)
    controller = controller or build_controller(humanoid, scenario, dynamics=shared)
    controller = _add_with_output(builder, "controller", controller, "torque")
    command = command or CommandSchedule(scenario.segments)
    command = _add_with_output(builder, "command", command, "command")
    measured, noise = add_sensors(builder, plant, humanoid, scenario)
    # the controller's states are others than those recorded when they are measured with noise
    true = shared if noise is None else None
    recorder = builder.AddSystem(Recorder(humanoid, plant, scenario.plant.time_step, true))

    sources = _connect(builder, plant, controller, command, measured)
    actuators = add_actuators(builder, plant, humanoid, scenario, sources["torque"])
    wanted = pushes or scenario.pushes
    push = _add_push(builder, plant, humanoid, scenario) if wanted else None
    if push is not None:
        sources["push"] = push.GetOutputPort("push")
    for name, port in sources.items():
        builder.Connect(port, recorder.GetInputPort(name))
    if meshcat is not None:
        overlays = Overlays(humanoid, plant, meshcat, scenario.mpc.friction, ground)
        _add_pictures(builder, scene_graph, meshcat, overlays, sources)
        set_up_view(meshcat, ground)
    diagram = builder.Build()
    diagram.set_name("closed_loop")
    systems = plant, controller, command, push, actuators, noise, recorder
    return ClosedLoop(diagram, *systems, ground, humanoid, scenario, meshcat)


def _add_with_output(builder: DiagramBuilder, role: str, system: System, port: str) -> System:
    """Add a system; raise InputError when it lacks the output port that its role needs."""
    if not system.HasOutputPort(port):
        raise InputError(role, "", system.get_name(), f"lacks the output port {port}")
    return builder.AddSystem(system)


def _connect(
    builder: DiagramBuilder,
    plant: MultibodyPlant,
    controller: System,
    command: System,
    measured: OutputPort,
) -> dict[str, OutputPort]:
    """Connect the controller; return the ports that can be recorded, by name.

    Args:
        builder: of the diagram.
        plant: the robot.
        controller: gets the `measured` state.
        command: what it is told.
        measured: the state as the sensors have it.
    """
    sources = {
        "state": plant.get_state_output_port(),
        "command": command.GetOutputPort("command"),
        "applied_torque": plant.get_net_actuation_output_port(),
    }
    for name in INPUTS:
        if controller.HasInputPort(name):
            source = measured if name == "state" else sources[name]
            builder.Connect(source, controller.GetInputPort(name))
    sources["torque"] = controller.GetOutputPort("torque")
    sources["contact_results"] = plant.get_contact_results_output_port()
    for name in OPTIONAL_OUTPUTS:
        if controller.HasOutputPort(name):
            sources[name] = controller.GetOutputPort(name)
    return sources


def _add_pictures(
    builder: DiagramBuilder,
    scene_graph: SceneGraph,
    meshcat: Meshcat,
    overlays: Overlays,
    sources: dict[str, OutputPort],
) -> None:
    """Add what draws the robot, and the overlays with what there is to draw."""
    parameters = MeshcatVisualizerParams(publish_period=PERIOD)
    MeshcatVisualizer.AddToBuilder(builder, scene_graph, meshcat, parameters)
    builder.AddSystem(overlays)
    for name in DRAWN:
        if name in sources:
            builder.Connect(sources[name], overlays.GetInputPort(name))


def _add_push(
    builder: DiagramBuilder, plant: MultibodyPlant, humanoid: Humanoid, scenario: Scenario
) -> Push:
    """Add what pushes the torso."""
    torso = plant.GetBodyByName(humanoid.base.name())
    push = builder.AddSystem(Push(plant, torso, scenario.pushes, scenario.plant.time_step))
    builder.Connect(plant.get_state_output_port(), push.GetInputPort("state"))
    builder.Connect(push.GetOutputPort("force"), plant.get_applied_spatial_force_input_port())
    return push


def _add_plant(
    builder: DiagramBuilder, humanoid: Humanoid, scenario: Scenario, scene: Scene
) -> tuple[MultibodyPlant, SceneGraph]:
    """Add the robot on its ground.

    The plant's output ports are sampled (Drake's default), which the contact estimator counts
    on: an update that runs after the plant's step sees state and torque of that step.
    """
    config = MultibodyPlantConfig(
        time_step=scenario.plant.time_step,
        contact_model="point",
        discrete_contact_approximation=scenario.plant.contact_approximation,
    )
    plant, scene_graph = AddMultibodyPlant(config, builder)
    humanoid.add_to(plant)
    add_ground(plant, scene, scenario.seed, scene_graph)
    plant.Finalize()
    check_error(plant, humanoid, scenario.error)
    return plant, scene_graph
