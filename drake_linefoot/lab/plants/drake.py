"""Drake's MultibodyPlant as the plant of a closed loop."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike
from pydrake.common.value import AbstractValue, Value
from pydrake.math import RigidTransform
from pydrake.multibody.math import SpatialForce
from pydrake.multibody.plant import ExternallyAppliedSpatialForce
from pydrake.multibody.tree import RigidBody
from pydrake.systems.framework import Context, DiagramBuilder, OutputPort
from pydrake.systems.sensors import Accelerometer, Gyroscope

from drake_linefoot.constants import GRAVITY
from drake_linefoot.lab.plants.contact_forces import ContactForces
from drake_linefoot.lab.plants.initial_state import initial_state
from drake_linefoot.lab.plants.scene import add_plant, apply_error
from drake_linefoot.lab.scenario import Scenario
from drake_linefoot.leaf_system import Block, weak
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.types import Array
from drake_linefoot.wiring.controller import check_plant, connect_by_name


class DrakePlant:
    """The robot of a scenario on its ground in a MultibodyPlant; see `Plant`.

    Attributes:
        system: the MultibodyPlant, finalized.
        scene_graph: what shows and collides.
    """

    def __init__(
        self, builder: DiagramBuilder, humanoid: Humanoid, scenario: Scenario, drawn: bool = True
    ) -> None:
        """Add it to a diagram; `drawn` is whether somebody looks at it.

        Raises:
            ScenarioError: see `add_plant`.
        """
        self._humanoid, self._error = humanoid, scenario.error
        self.system, self.scene_graph, self.ground = add_plant(builder, humanoid, scenario, drawn)
        check_plant(self.system, scenario.plant.time_step)
        # Of velocities a MultibodyPlant has no default but 0.
        self.system.SetDefaultPositions(initial_state(humanoid, scenario)[: humanoid.nq])
        self.actuation = self.system.get_actuation_input_port()
        self.outputs = {
            "state": self.system.get_state_output_port(),
            "net_actuation": self.system.get_net_actuation_output_port(),
        }

    def add_imu(self, builder: DiagramBuilder) -> dict[str, OutputPort]:
        """Add Drake's gyroscope and accelerometer, see `Plant`."""
        base = self._humanoid.names_in(self.system).body(self._humanoid.base.name())
        gyroscope = builder.AddSystem(Gyroscope(base, RigidTransform()))
        accelerometer = builder.AddSystem(Accelerometer(base, RigidTransform(), GRAVITY))
        motion = {
            "body_poses": self.system.get_body_poses_output_port(),
            "body_spatial_velocities": self.system.get_body_spatial_velocities_output_port(),
            "body_spatial_accelerations": self.system.get_body_spatial_accelerations_output_port(),
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
        contacts = builder.AddSystem(ContactForces(self._humanoid, self.system))
        results = {"contact_results": self.system.get_contact_results_output_port()}
        connect_by_name(builder, contacts, {**sources, **results})
        return contacts.GetOutputPort("foot_contacts")

    def add_push(self, builder: DiagramBuilder, force: OutputPort) -> None:
        """Add what makes of a force on the torso what Drake takes, see `Plant`."""
        torso = self._humanoid.names_in(self.system).body(self._humanoid.torso.name())
        applied = builder.AddSystem(TorsoForce(torso))
        builder.Connect(force, applied.GetInputPort("push"))
        port = self.system.get_applied_spatial_force_input_port()
        builder.Connect(applied.GetOutputPort("force"), port)

    def prepare(self, root: Context) -> None:
        """Apply the model error, see `Plant`."""
        if self._error.changes_the_model:
            context = self.system.GetMyMutableContextFromRoot(root)
            apply_error(self.system, context, self._humanoid, self._error)

    def state(self, root: Context) -> Array:
        """Return the state, see `Plant`."""
        x: Array = self.system.GetPositionsAndVelocities(self.system.GetMyContextFromRoot(root))
        return x

    def place(self, root: Context, x: ArrayLike) -> None:
        """Put the robot into a state, see `Plant`."""
        context = self.system.GetMyMutableContextFromRoot(root)
        self.system.SetPositionsAndVelocities(context, np.asarray(x, dtype=float))


class TorsoForce(Block):
    """Makes of a force what a MultibodyPlant takes: one that acts at the torso's centre of mass.

    .. pydrake_system::

        name: TorsoForce
        input_ports:
        - push
        output_ports:
        - force

    The list that comes out has one force, without a torque; nothing, while there is none.
    """

    def __init__(self, torso: RigidBody) -> None:
        """Declare the ports; `torso` is the body in the plant that is simulated."""
        super().__init__()
        self.set_name("torso_force")
        self._body, self._p_BoBcm_B = torso.index(), torso.default_com()
        self._push = self.DeclareVectorInputPort("push", 3)
        self.DeclareAbstractOutputPort(
            "force",
            Value[list[ExternallyAppliedSpatialForce]],
            weak(self, self._calc),
            prerequisites_of_calc={self._push.ticket()},
        )

    def _calc(self, context: Context, output: AbstractValue) -> None:
        push = self._push.Eval(context)
        if not push.any():
            output.set_value([])
            return
        applied = ExternallyAppliedSpatialForce()
        applied.body_index = self._body
        applied.p_BoBq_B = self._p_BoBcm_B
        applied.F_Bq_W = SpatialForce(tau=np.zeros(3), f=push)
        output.set_value([applied])
