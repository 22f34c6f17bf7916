"""What stands between the simulated robot and its controller, where the scenario says so."""

from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import DiagramBuilder, OutputPort
from pydrake.systems.primitives import RandomSource

from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.scenario import Scenario
from drake_linefoot.simulation.actuators import Actuators
from drake_linefoot.simulation.sensors import Sensors, noise_source


def add_sensors(
    builder: DiagramBuilder, plant: MultibodyPlant, humanoid: Humanoid, scenario: Scenario
) -> tuple[OutputPort, RandomSource | None]:
    """Add the sensors, unless they are perfect.

    Returns:
        The state for the controller, and the source of the noise; None without.
    """
    state: OutputPort = plant.get_state_output_port()
    if scenario.sensors.are_perfect:
        return state, None
    noise = builder.AddSystem(noise_source(humanoid, scenario.plant.time_step))
    sensors = builder.AddSystem(Sensors(humanoid, scenario.sensors))
    builder.Connect(state, sensors.GetInputPort("state"))
    builder.Connect(noise.get_output_port(), sensors.GetInputPort("noise"))
    return sensors.GetOutputPort("measured"), noise


def add_actuators(
    builder: DiagramBuilder,
    plant: MultibodyPlant,
    humanoid: Humanoid,
    scenario: Scenario,
    torque: OutputPort,
) -> Actuators | None:
    """Connect the controller's torque to the plant, through actuators unless they are perfect."""
    parameters, friction = scenario.actuators, scenario.error.joint_friction
    target = plant.get_actuation_input_port()
    if not (parameters.torque_speed or parameters.delay or friction):
        builder.Connect(torque, target)
        return None
    period = scenario.plant.time_step
    actuators = builder.AddSystem(Actuators(humanoid, parameters, friction, period))
    builder.Connect(torque, actuators.GetInputPort("torque"))
    builder.Connect(plant.get_state_output_port(), actuators.GetInputPort("state"))
    builder.Connect(actuators.GetOutputPort("actuation"), target)
    return actuators
