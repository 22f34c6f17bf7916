"""Drake's MultibodyPlant as the plant of a closed loop."""

from collections.abc import Mapping

from pydrake.math import RigidTransform
from pydrake.systems.framework import DiagramBuilder, OutputPort
from pydrake.systems.sensors import Accelerometer, Gyroscope

from drake_linefoot.constants import GRAVITY
from drake_linefoot.lab.scenario import Scenario
from drake_linefoot.lab.simulation.contact_forces import ContactForces
from drake_linefoot.lab.simulation.scene import add_plant
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.wiring.controller import check_plant, connect_by_name


class DrakePlant:
    """The robot of a scenario on its ground in a MultibodyPlant; see `Plant`.

    Attributes:
        plant: finalized.
        scene_graph: what shows and collides.
    """

    def __init__(
        self, builder: DiagramBuilder, humanoid: Humanoid, scenario: Scenario, drawn: bool = True
    ) -> None:
        """Add it to a diagram; `drawn` is whether somebody looks at it.

        Raises:
            ScenarioError: see `add_plant`.
        """
        self._humanoid = humanoid
        self.plant, self.scene_graph, self.ground = add_plant(builder, humanoid, scenario, drawn)
        check_plant(self.plant, scenario.plant.time_step)
        self.actuation = self.plant.get_actuation_input_port()
        self.forces = self.plant.get_applied_spatial_force_input_port()
        self.outputs = {
            "state": self.plant.get_state_output_port(),
            "net_actuation": self.plant.get_net_actuation_output_port(),
        }

    def add_imu(self, builder: DiagramBuilder) -> dict[str, OutputPort]:
        """Add Drake's gyroscope and accelerometer, see `Plant`."""
        base = self._humanoid.names_in(self.plant).body(self._humanoid.base.name())
        gyroscope = builder.AddSystem(Gyroscope(base, RigidTransform()))
        accelerometer = builder.AddSystem(Accelerometer(base, RigidTransform(), GRAVITY))
        motion = {
            "body_poses": self.plant.get_body_poses_output_port(),
            "body_spatial_velocities": self.plant.get_body_spatial_velocities_output_port(),
            "body_spatial_accelerations": self.plant.get_body_spatial_accelerations_output_port(),
        }
        for sensor in (gyroscope, accelerometer):
            connect_by_name(builder, sensor, motion)
        return {
            "angular_velocity": gyroscope.get_measurement_output_port(),
            "specific_force": accelerometer.get_measurement_output_port(),
        }

    def add_contacts(
        self, builder: DiagramBuilder, sources: Mapping[str, OutputPort]
    ) -> OutputPort:
        """Add what sums the point contacts of each foot, see `Plant`."""
        contacts = builder.AddSystem(ContactForces(self._humanoid, self.plant))
        results = {"contact_results": self.plant.get_contact_results_output_port()}
        connect_by_name(builder, contacts, {**sources, **results})
        return contacts.GetOutputPort("foot_contacts")
