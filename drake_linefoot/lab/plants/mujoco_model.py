"""The robot of a description on its ground as a model of MuJoCo."""

from typing import Any, NamedTuple

import mujoco
import numpy as np
from pydrake.geometry import SceneGraph, Sphere
from pydrake.math import RigidTransform
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import Context

from drake_linefoot.constants import GRAVITY
from drake_linefoot.errors import ModelError
from drake_linefoot.lab.plants.ground import Ground
from drake_linefoot.lab.plants.scene import add_ground, apply_error, check_error
from drake_linefoot.lab.scenario import Scenario
from drake_linefoot.lab.scenario.scene import scene_of
from drake_linefoot.lab.scenario.schema import MujocoParameters
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.robot.tree import IN_V, PARENT, SLIDES, Tree
from drake_linefoot.types import Array

INTEGRATORS = {
    "euler": mujoco.mjtIntegrator.mjINT_EULER,
    "implicit": mujoco.mjtIntegrator.mjINT_IMPLICIT,
    "implicitfast": mujoco.mjtIntegrator.mjINT_IMPLICITFAST,
    "rk4": mujoco.mjtIntegrator.mjINT_RK4,
}
CONES = {
    "elliptic": mujoco.mjtCone.mjCONE_ELLIPTIC,
    "pyramidal": mujoco.mjtCone.mjCONE_PYRAMIDAL,
}
GROUND = "ground"  # and a number, where it is of boxes
_RGBA = [0.8, 0.8, 0.8, 1.0]

FootSphere = tuple[int, Array, float]  # side, centre in the body of the foot [m], radius [m]


class Geometry(NamedTuple):
    """The robot on its ground as Drake has it: what feet touch with, and what is drawn."""

    plant: MultibodyPlant  # finalized; it is not simulated
    scene_graph: SceneGraph
    ground: Ground


def geometry_of(humanoid: Humanoid, scenario: Scenario, drawn: bool = False) -> Geometry:
    """Return the geometry of a robot on its ground, with its drawings where somebody looks.

    Raises:
        ScenarioError: see `ground_of` and `add_ground`.
    """
    plant, scene_graph = MultibodyPlant(scenario.period), SceneGraph()
    plant.RegisterAsSourceForSceneGraph(scene_graph)
    humanoid.add_to(plant, drawn)
    ground = add_ground(plant, scene_of(scenario), scenario.seed, scene_graph)
    plant.Finalize()
    return Geometry(plant, scene_graph, ground)


def context_with_error(humanoid: Humanoid, scenario: Scenario) -> Context:
    """Return a context of the humanoid's own plant, with the model error of a scenario.

    Raises:
        ScenarioError: see `check_error`.
    """
    check_error(humanoid.plant, humanoid, scenario.error)
    context = humanoid.plant.CreateDefaultContext()
    apply_error(humanoid.plant, context, humanoid, scenario.error)
    return context


def make_spec(humanoid: Humanoid, scenario: Scenario, geometry: Geometry | None = None) -> Any:
    """Return an MjSpec of the robot on its ground, to be compiled, or saved as MJCF.

    Bodies are links: what is welded together is one. Joints have the names, limits, damping and
    reflected inertias of the model, each with a motor of its name and effort limit, in the order of
    torques. Feet touch with the spheres they have in Drake.

    Args:
        humanoid: the robot.
        scenario: time step, scene, model error and what MuJoCo is told of contacts.
        geometry: of both; made here without it.

    Raises:
        ModelError: the model is not a tree of revolute and prismatic joints, or feet touch with
            other shapes than spheres.
        ScenarioError: see `geometry_of` and `context_with_error`.
    """
    context = context_with_error(humanoid, scenario)
    plant, scene_graph, ground = geometry or geometry_of(humanoid, scenario)
    tree, p, friction = humanoid.tree(context), scenario.plant.mujoco, scene_of(scenario).friction
    if tree is None:
        d = humanoid.description
        raise d.refuse("model", str(d.model), "must be a tree of revolute and prismatic joints")
    spec = mujoco.MjSpec()
    spec.modelname, spec.compiler.degree = humanoid.description.name, False
    spec.option.gravity, spec.option.timestep = GRAVITY, scenario.period
    spec.option.cone, spec.option.impratio = CONES[p.cone], p.impratio
    spec.option.integrator = INTEGRATORS[p.integrator]
    forgive(spec)
    for k, (size, pose) in enumerate(_slabs(ground)):
        kind = mujoco.mjtGeom.mjGEOM_PLANE if ground.is_flat else mujoco.mjtGeom.mjGEOM_BOX
        geom = spec.worldbody.add_geom(name=f"{GROUND}_{k}", type=kind, size=size, rgba=_RGBA)
        _touches(geom, p, friction)
        geom.pos, geom.quat = _placed(pose)
    for k, corners in enumerate(ground.prisms):
        spec.add_mesh(name=f"patch_{k}", uservert=corners.ravel())
        geom = spec.worldbody.add_geom(name=f"{GROUND}_{k}", meshname=f"patch_{k}", rgba=_RGBA)
        geom.type = mujoco.mjtGeom.mjGEOM_MESH
        _touches(geom, p, friction)
    links = _add_links(spec, humanoid, tree, context, p)
    add_motors(spec, humanoid)
    spheres = spheres_of_feet(humanoid, plant, scene_graph)
    for k, (side, centre, radius) in enumerate(spheres):
        frame = humanoid.foot_frames[side]
        X_LC = RigidTransform(tree.X_LF[side])
        X_BC = frame.GetFixedPoseInBodyFrame() @ RigidTransform(humanoid.p_FC[side])
        link = links[tree.feet[side]]
        geom = link.add_geom(name=f"foot_{k}", size=[radius, 0.0, 0.0])
        geom.type, geom.pos = mujoco.mjtGeom.mjGEOM_SPHERE, X_LC @ X_BC.inverse() @ centre
        geom.mass = 0.0
        _touches(geom, p, friction)
    return spec


def add_motors(spec: Any, humanoid: Humanoid) -> None:
    """Add a motor of each joint of the description, of its name and within its effort limit."""
    names = humanoid.description.actuated_joints
    for name, effort in zip(names, humanoid.effort_limits, strict=True):
        motor = spec.add_actuator(name=name, target=name)
        motor.trntype = mujoco.mjtTrn.mjTRN_JOINT
        motor.set_to_motor()
        motor.ctrllimited, motor.ctrlrange = mujoco.mjtLimited.mjLIMITED_TRUE, [-effort, effort]


def forgive(spec: Any) -> None:
    """Let a state that is not finite be a fall, not a robot that stands at the origin again."""
    spec.option.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_AUTORESET)


def _touches(geom: Any, p: MujocoParameters, friction: float) -> None:
    """Let a geometry touch others, with forces along three axes."""
    geom.contype = geom.conaffinity = 1
    geom.condim, geom.friction[0] = 3, friction
    geom.solref, geom.solimp = p.solref, p.solimp


def _slabs(ground: Ground) -> list[tuple[list[float], RigidTransform]]:
    """Return size as MuJoCo has it, and pose, of what the ground is made of."""
    if ground.is_flat:
        return [([0.0, 0.0, 1.0], RigidTransform())]
    return [
        ((0.5 * size).tolist(), RigidTransform(np.column_stack([R, p])))
        for R, p, size in ground.blocks
    ]


def _placed(X: RigidTransform) -> tuple[Array, Array]:
    """Return a pose as MuJoCo has it: origin [m], and quaternion (w, x, y, z)."""
    return X.translation(), X.rotation().ToQuaternion().wxyz()


def _add_links(
    spec: Any, humanoid: Humanoid, tree: Tree, context: Context, p: MujocoParameters
) -> list[Any]:
    """Add bodies and joints; return the bodies, in the order of the tree."""
    names, links = humanoid.description.actuated_joints, list[Any]()
    at = {int(v): k for k, v in enumerate(humanoid.actuated_v)}
    for i, (joint, X, mass, inertia) in enumerate(
        zip(tree.joints, tree.X_PL, tree.mass, tree.inertia, strict=True)
    ):
        on = links[joint[PARENT]] if i else spec.worldbody
        name = names[at[int(joint[IN_V])]] if i else humanoid.description.floating_base
        pos, quat = _placed(RigidTransform(X))
        link = on.add_body(name=name, pos=pos, quat=quat)
        links.append(link)
        I = inertia[:, :3]  # noqa: E741  as in every textbook
        link.explicitinertial, link.mass, link.ipos = True, mass[0], inertia[:, 3]
        link.fullinertia = [I[0, 0], I[1, 1], I[2, 2], I[0, 1], I[0, 2], I[1, 2]]
        if not i:
            link.add_freejoint(name="floating_base")
            continue
        k = at[int(joint[IN_V])]
        slides = joint[SLIDES] == 1
        kind = mujoco.mjtJoint.mjJNT_SLIDE if slides else mujoco.mjtJoint.mjJNT_HINGE
        moves = link.add_joint(name=name, type=kind, axis=[0.0, 0.0, 1.0], armature=mass[1])
        moves.damping[0] = float(humanoid.names.joint(name).GetDampingVector(context)[0])
        moves.limited = mujoco.mjtLimited.mjLIMITED_TRUE
        moves.range = [humanoid.position_lower[k], humanoid.position_upper[k]]
        moves.solref_limit, moves.solimp_limit = p.solref, p.solimp
    return links


def spheres_of_feet(
    humanoid: Humanoid, plant: MultibodyPlant, scene_graph: SceneGraph
) -> list[FootSphere]:
    """Return what the feet touch with.

    Args:
        humanoid: the robot.
        plant: finalized, with it.
        scene_graph: of `plant`.

    Raises:
        ModelError: a collision shape of a foot is not a sphere.
    """
    inspector, found = scene_graph.model_inspector(), list[FootSphere]()
    for side, foot in enumerate(humanoid.description.feet):
        body = humanoid.names_in(plant).frame(foot.frame).body()
        for geometry in plant.GetCollisionGeometriesForBody(body):
            shape = inspector.GetShape(geometry)
            if not isinstance(shape, Sphere):
                where = humanoid.description.file
                name = inspector.GetName(geometry)
                raise ModelError(where, "model", name, "must be a sphere, as feet touch in MuJoCo")
            centre = inspector.GetPoseInFrame(geometry).translation()
            found.append((side, centre, float(shape.radius())))
    return found
