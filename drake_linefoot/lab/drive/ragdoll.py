"""A robot that fell lies down without torques: drawn, but not recorded."""

import numpy as np
from pydrake.geometry import (
    AddContactMaterial,
    CollisionFilterDeclaration,
    GeometrySet,
    Meshcat,
    MeshcatVisualizer,
    MeshcatVisualizerParams,
    ProximityProperties,
    Role,
    Sphere,
)
from pydrake.math import RigidTransform
from pydrake.multibody.plant import AddMultibodyPlant, CoulombFriction, MultibodyPlantConfig
from pydrake.multibody.tree import BodyIndex
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

from drake_linefoot.lab.plants.scene import add_ground
from drake_linefoot.lab.scenario import Scenario
from drake_linefoot.lab.scenario.scene import scene_of
from drake_linefoot.lab.visualization.overlays import PERIOD
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.robot.scaling import units_of
from drake_linefoot.types import Array

DAMPING = 3.0  # [N m s] of every joint of the MIT Humanoid; another robot's is in its size
CORNER = 0.01  # [m] radius of the spheres at the corners of a body's box
FASTEST = 20.0  # [m/s, rad/s] with which it begins to fall
STEP = 1.0 / 512.0  # [s] of the plant


class Ragdoll:
    """A robot whose joints are damped and whose bodies cannot sink into the ground.

    Each body touches the ground with the corners of the boxes around its drawings, and no other
    body: the model that walks touches it with its feet only.
    """

    def __init__(self, humanoid: Humanoid, scenario: Scenario, meshcat: Meshcat | None) -> None:
        """Build the plant, which draws into `meshcat` where the robot was drawn."""
        units, builder = units_of(humanoid), DiagramBuilder()
        config = MultibodyPlantConfig(time_step=STEP, contact_model="point")
        plant, scene_graph = AddMultibodyPlant(config, builder)
        humanoid.add_to(plant)
        for index in plant.GetJointIndices():
            joint = plant.get_mutable_joint(index)
            if joint.num_velocities() == 1:
                joint.set_default_damping(DAMPING * units["N"] * units["m"] * units["s"])
        properties = ProximityProperties()
        AddContactMaterial(friction=CoulombFriction(0.8, 0.8), properties=properties)
        inspector, robot = scene_graph.model_inspector(), GeometrySet()
        for k in range(1, plant.num_bodies()):
            body = plant.get_body(BodyIndex(k))
            for shape in plant.GetVisualGeometriesForBody(body):
                box = inspector.GetObbInGeometryFrame(shape)
                if box is None:
                    continue
                X_BO = inspector.GetPoseInFrame(shape) @ box.pose()
                for c, signs in enumerate(np.ndindex(2, 2, 2)):
                    corner = (2.0 * np.array(signs) - 1.0) * box.half_width()
                    name = f"{inspector.GetName(shape)}_corner_{c}"
                    pose = RigidTransform(X_BO @ corner)
                    ball = Sphere(CORNER * units["m"])
                    plant.RegisterCollisionGeometry(body, pose, ball, name, properties)
            robot.Add(plant.GetBodyFrameIdOrThrow(body.index()))
        alone = CollisionFilterDeclaration().ExcludeWithin(robot)
        scene_graph.collision_filter_manager().Apply(alone)
        add_ground(plant, scene_of(scenario), scenario.seed)
        plant.Finalize()
        if meshcat is not None:
            drawing = MeshcatVisualizerParams(publish_period=PERIOD, role=Role.kIllustration)
            MeshcatVisualizer.AddToBuilder(builder, scene_graph, meshcat, drawing)
        self._plant, self._simulator = plant, Simulator(builder.Build())

    def fall(self, q: Array, v: Array) -> bool:
        """Begin to fall from a state; return whether it is one that can go on."""
        root = self._simulator.get_mutable_context()
        self._context = self._plant.GetMyMutableContextFromRoot(root)
        if not (np.isfinite(q).all() and np.isfinite(v).all()):
            return False
        state = np.concatenate([q, np.clip(v, -FASTEST, FASTEST)])
        self._plant.SetPositionsAndVelocities(self._context, state)
        torque = np.zeros(self._plant.num_actuators())
        self._plant.get_actuation_input_port().FixValue(self._context, torque)
        self._simulator.Initialize()
        return True

    def advance(self, length: float) -> None:
        """Fall on for `length` [s]."""
        time = self._simulator.get_context().get_time()
        self._simulator.AdvanceTo(time + length)

    @property
    def state(self) -> tuple[Array, Array]:
        """Positions and velocities now, shapes (nq,) and (nv,)."""
        return self._plant.GetPositions(self._context), self._plant.GetVelocities(self._context)
