"""MuJoCo as the plant of a closed loop."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike
from pydrake.geometry import SceneGraph
from pydrake.systems.framework import (
    BasicVector,
    Context,
    DiagramBuilder,
    OutputPort,
)
from pydrake.systems.rendering import MultibodyPositionToGeometryPose

from drake_linefoot.lab.plants.contact_forces import (
    contacts_layout,
    foot_contacts,
    places_of_points,
)
from drake_linefoot.lab.plants.ground import Ground
from drake_linefoot.lab.plants.initial_state import initial_state
from drake_linefoot.lab.plants.mjcf import pose_of_base, spec_of_file
from drake_linefoot.lab.plants.mujoco_model import context_with_error, geometry_of, make_spec
from drake_linefoot.lab.plants.mujoco_robot import MujocoRobot, check_same_robot
from drake_linefoot.lab.plants.mujoco_step import CONTACTS, EACH, MujocoStep
from drake_linefoot.lab.scenario import Scenario
from drake_linefoot.leaf_system import Block
from drake_linefoot.robot.dynamics import dynamics_layout
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.types import Array
from drake_linefoot.wiring.controller import connect_by_name


class MujocoPlant:
    """The robot of a scenario on its ground in MuJoCo; see `Plant`.

    Attributes:
        system: a `MujocoStep`.
        scene_graph: Drake's, which shows the robot; None when nobody looks.
    """

    def __init__(
        self, builder: DiagramBuilder, humanoid: Humanoid, scenario: Scenario, drawn: bool = True
    ) -> None:
        """Add it to a diagram; `drawn` is whether somebody looks at it.

        Raises:
            ModelError: MuJoCo does not take the robot, see `make_spec` and `check_same_robot`.
            ScenarioError: see `geometry_of`, `context_with_error` and `spec_of_file`.
        """
        self._humanoid, geometry = humanoid, geometry_of(humanoid, scenario, drawn)
        self.ground: Ground = geometry.ground
        if scenario.plant.mujoco.mjcf is None:
            robot = MujocoRobot(humanoid, make_spec(humanoid, scenario, geometry).compile())
        else:
            model = spec_of_file(humanoid, scenario).compile()
            robot = MujocoRobot(humanoid, model, pose_of_base(humanoid, model))
        check_same_robot(robot, context_with_error(humanoid, scenario))
        self.system = builder.AddSystem(MujocoStep(robot, initial_state(humanoid, scenario)))
        self.actuation = self.system.GetInputPort("actuation")
        self.outputs = {
            name: self.system.GetOutputPort(name) for name in ("state", "net_actuation")
        }
        self.scene_graph: SceneGraph | None = None
        if drawn:
            # Poses are asked of this plant, which has to stay.
            self._shown, self.scene_graph, _ = geometry
            plant, graph = self._shown, self.scene_graph
            builder.AddNamedSystem("scene_graph", graph)
            poses = MultibodyPositionToGeometryPose(plant, input_multibody_state=True)
            builder.AddNamedSystem("poses", poses)
            builder.Connect(self.outputs["state"], poses.get_input_port())
            port = graph.get_source_pose_port(plant.get_source_id())
            builder.Connect(poses.get_output_port(), port)

    def add_imu(self, builder: DiagramBuilder) -> dict[str, OutputPort]:
        """Return what the step says of the base, see `Plant`."""
        names = "angular_velocity", "specific_force"
        return {name: self.system.GetOutputPort(name) for name in names}

    def add_contacts(
        self, builder: DiagramBuilder, sources: Mapping[str, OutputPort]
    ) -> OutputPort:
        """Add what sums the contacts of each foot, see `Plant`."""
        contacts = builder.AddSystem(MujocoContacts(self._humanoid))
        seen = {"contacts": self.system.GetOutputPort("contacts")}
        connect_by_name(builder, contacts, {**sources, **seen})
        return contacts.GetOutputPort("foot_contacts")

    def add_push(self, builder: DiagramBuilder, force: OutputPort) -> None:
        """Connect a force on the torso, see `Plant`."""
        builder.Connect(force, self.system.GetInputPort("push"))

    def prepare(self, root: Context) -> None:
        """Do nothing: the model has the error of the scenario."""

    def state(self, root: Context) -> Array:
        """Return the state, see `Plant`."""
        x: Array = self.outputs["state"].Eval(self.system.GetMyContextFromRoot(root))
        return x

    def place(self, root: Context, x: ArrayLike) -> None:
        """Put the robot into a state, see `Plant`."""
        context = self.system.GetMyMutableContextFromRoot(root)
        self.system.put(context, np.asarray(x, dtype=float))


class MujocoContacts(Block):
    """Adds up the contacts of each foot, for the recorder.

    .. pydrake_system::

        name: MujocoContacts
        input_ports:
        - contacts
        - dynamics
        output_ports:
        - foot_contacts

    A contact between both feet counts for one of them.
    """

    def __init__(self, humanoid: Humanoid) -> None:
        """Declare the ports."""
        super().__init__()
        self.set_name("contact_forces")
        self._of_robot = humanoid.nv, humanoid.contact.size, places_of_points(humanoid)
        contacts = self.DeclareVectorInputPort("contacts", CONTACTS * EACH)
        dynamics = self.signal_input("dynamics", dynamics_layout(humanoid))
        self._in, layout = (contacts, dynamics), contacts_layout(humanoid)
        self._size = layout.size
        tickets = {contacts.ticket(), dynamics.ticket()}
        self.signal_output("foot_contacts", layout, self._calc, tickets)

    def _calc(self, context: Context, output: BasicVector) -> None:
        contacts, dynamics = (port.Eval(context) for port in self._in)
        rows = contacts.reshape(CONTACTS, EACH)
        rows, flat = rows[rows[:, 0] != 0.0], np.empty(self._size)
        at = np.ascontiguousarray(rows[:, 1:7]).reshape(-1, 2, 3)
        parts = rows[:, 0].copy(), at, rows[:, 7].copy()
        foot_contacts(flat, dynamics, *self._of_robot, *parts)
        output.SetFromVector(flat)
