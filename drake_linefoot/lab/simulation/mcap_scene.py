"""The robot of a run and what is drawn of it, in Foxglove's schemas, for its 3D panel.

`/tf` has the pose of every body in the world, `/scene/robot` what the bodies and the ground look
like (once), `/scene/forces`, `/scene/plan` and `/scene/footholds` what the replay draws as well.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

import numpy as np
from foxglove_schemas_protobuf.FrameTransforms_pb2 import FrameTransforms
from foxglove_schemas_protobuf.SceneEntity_pb2 import SceneEntity
from foxglove_schemas_protobuf.SceneUpdate_pb2 import SceneUpdate
from pydrake.geometry import (
    Box,
    Capsule,
    Cylinder,
    Ellipsoid,
    Mesh,
    Rgba,
    SceneGraphInspector,
    Shape,
    Sphere,
)
from pydrake.math import RigidTransform, RollPitchYaw, RotationMatrix
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import BodyIndex, RigidBody
from pydrake.systems.framework import DiagramBuilder

from drake_linefoot.lab.plants.scene import add_plant
from drake_linefoot.lab.simulation.foot_points import ends_of
from drake_linefoot.lab.simulation.recording import Run
from drake_linefoot.lab.simulation.run_view import robot_of
from drake_linefoot.robot.meshes import mesh_triangles
from drake_linefoot.robot.scaling import units_of
from drake_linefoot.types import Array

if TYPE_CHECKING:
    from mcap.writer import Writer

FRAME_RATE = 32.0  # [Hz] of poses and drawings; the panel interpolates poses
NEWTONS_PER_METER = 400.0  # of the arrows, for the MIT Humanoid, as in the replay
LEAST_FORCE = 3.0  # [N] that is drawn, likewise
SIDES = (Rgba(0.90, 0.15, 0.20, 1.0), Rgba(0.15, 0.40, 0.90, 1.0))  # left, right
COM, PREDICTED = Rgba(0.10, 0.55, 0.30, 1.0), Rgba(0.45, 0.85, 0.20, 1.0)
PLANNED, PUSH, GREY = Rgba(0.55, 0.25, 0.75, 1.0), Rgba(0.95, 0.45, 0.05, 1.0), Rgba(0.7, 0.7, 0.7)
USED = ["time", "q", "com", "push", "contact_points", "true_force", "true_normal"]  # channels
USED += ["mpc_horizon", "mpc_footholds"]
FOOTHOLDS = 40  # that are shown
LINE, DOT, THICK = 0.02, 0.025, 0.004  # [m] of the MIT Humanoid


class Scene:
    """The topics of the scene of a run, in a log that is written block by block."""

    def __init__(self, writer: Writer, run: Run) -> None:
        """Register the topics.

        Args:
            writer: of the log.
            run: what was recorded, with at least one sample.

        Raises:
            InputError: the robot is not the one that was recorded any more.
        """
        from mcap_protobuf.schema import register_schema

        humanoid = robot_of(run)
        plant, scene_graph, _ = add_plant(DiagramBuilder(), humanoid, run.scenario)
        units = units_of(humanoid)
        self._m, self._N, self._length = units["m"], units["N"], 2.0 * humanoid.half_length
        self._width = 2.0 * humanoid.half_width or LINE * self._m
        self._bodies = [plant.get_body(BodyIndex(i)) for i in range(plant.num_bodies())]
        self._run, self._plant, self._context = run, plant, plant.CreateDefaultContext()
        self._touchdowns = _touchdowns(run)
        shapes = _shapes(plant, self._bodies, scene_graph.model_inspector())
        rows = np.searchsorted(run.time, np.arange(0.0, run.time[-1] + 1e-9, 1.0 / FRAME_RATE))
        steps = sorted({row for row, _ in self._touchdowns})
        topics: dict[str, tuple[type, Any, Callable[[SimpleNamespace, int], Any]]] = {
            "/scene/robot": (SceneUpdate, [0], lambda _, i: SceneUpdate(entities=shapes)),
            "/tf": (FrameTransforms, rows, self._poses),
            "/scene/forces": (SceneUpdate, rows, self._forces),
            "/scene/plan": (SceneUpdate, rows, self._plan),
            "/scene/footholds": (SceneUpdate, steps, self._footholds),
        }
        self._topics = [
            (writer.register_channel(name, "protobuf", register_schema(writer, kind)), at, make)
            for name, (kind, at, make) in topics.items()
        ]

    def messages(self, begin: int, end: int) -> list[tuple[int, int, bytes]]:
        """Return time [ns], topic and content of what belongs to samples `begin` to `end`."""
        run = SimpleNamespace(**{name: getattr(self._run, name) for name in USED})  # read once
        return [
            (round(1e9 * float(run.time[i])), number, make(run, int(i)).SerializeToString())
            for number, at, make in self._topics
            for i in at[slice(*np.searchsorted(at, (begin, end)))]
        ]

    def _poses(self, run: SimpleNamespace, i: int) -> FrameTransforms:
        """Return the pose of every body but the world, of one sample."""
        message, (world, *bodies) = FrameTransforms(), self._bodies
        self._plant.SetPositions(self._context, run.q[i])
        for body in bodies:
            X, pose = body.EvalPoseInWorld(self._context), message.transforms.add()
            pose.parent_frame_id, pose.child_frame_id = world.name(), body.name()
            pose.timestamp.FromNanoseconds(round(1e9 * float(run.time[i])))
            _put(pose.translation, pose.rotation, X)
        return message

    def _forces(self, run: SimpleNamespace, i: int) -> SceneUpdate:
        """Return arrows: the true force at the points of each foot, the push on the torso."""
        normal, arrows = run.true_normal[i], SceneEntity(frame_id="world", id="forces")
        share = normal / np.maximum(normal.sum(axis=1, keepdims=True), 1e-9)
        for side, colour in enumerate(SIDES):
            for part, point in zip(share[side], run.contact_points[i, side], strict=True):
                self._add_arrow(arrows, point, part * run.true_force[i, side], colour)
        self._add_arrow(arrows, run.com[i], run.push[i], PUSH)
        return SceneUpdate(entities=[arrows])

    def _add_arrow(self, entity: SceneEntity, point: Array, force: Array, colour: Rgba) -> None:
        """Add a force [N] at a point [m], unless it is small."""
        size = float(np.linalg.norm(force))
        if not size > LEAST_FORCE * self._N:
            return
        length, width = size / NEWTONS_PER_METER * self._m / self._N, 0.012 * self._m
        X = RigidTransform(RotationMatrix.MakeFromOneVector(force, 0), point)  # it points along x
        arrow = _add(entity.arrows, X, colour)
        arrow.head_length = min(3.0 * width, 0.5 * length)
        arrow.shaft_length = length - arrow.head_length
        arrow.shaft_diameter, arrow.head_diameter = width, 2.0 * width

    def _plan(self, run: SimpleNamespace, i: int) -> SceneUpdate:
        """Return the CoM, where the MPC predicts it, and the coming footholds."""
        entity = SceneEntity(frame_id="world", id="plan")
        horizon = run.mpc_horizon[i][np.isfinite(run.mpc_horizon[i]).all(axis=1)]
        for points, colour, size in ((run.com[i][None], COM, 2.0), (horizon, PREDICTED, 0.8)):
            for p in points:
                _add(entity.spheres, RigidTransform(p), colour, np.full(3, size * DOT * self._m))
        for place in run.mpc_footholds[i][np.isfinite(run.mpc_footholds[i]).all(axis=1)]:
            self._add_foothold(entity, place[:3], (0.0, place[3]), PLANNED)
        return SceneUpdate(entities=[entity])

    def _footholds(self, run: SimpleNamespace, until: int) -> SceneUpdate:
        """Return where the feet stood last until a sample; each time, as a panel may jump to it."""
        entity = SceneEntity(frame_id="world", id="footholds")
        last = bisect_right(self._touchdowns, (until, 1))
        for row, side in self._touchdowns[max(0, last - FOOTHOLDS) : last]:
            heel, toe = ends_of(run.contact_points[row, side])
            x, y, z = toe - heel
            turn = -float(np.arctan2(z, np.hypot(x, y))), float(np.arctan2(y, x))
            self._add_foothold(entity, 0.5 * (heel + toe), turn, SIDES[side])
        return SceneUpdate(entities=[entity])

    def _add_foothold(
        self, entity: SceneEntity, p: Array, turn: tuple[float, float], colour: Rgba
    ) -> None:
        """Add a foothold at a place [m] with a pitch and a yaw [rad]."""
        size = np.array([self._length, self._width, THICK * self._m])
        _add(entity.cubes, RigidTransform(RollPitchYaw(0.0, *turn), p), colour, size)


def _touchdowns(run: Run) -> list[tuple[int, int]]:
    """Return sample and foot of every touchdown, as the gait has planned the contact."""
    stands = run.planned_contact == 1.0
    begins = stands & ~np.vstack([np.zeros((1, 2), bool), stands[:-1]])
    return [(int(row), int(side)) for row, side in np.argwhere(begins)]


def _shapes(
    plant: MultibodyPlant, bodies: list[RigidBody], inspector: SceneGraphInspector
) -> list[SceneEntity]:
    """Return what bodies look like, each in its own frame, which it follows."""
    entities = []
    for body in bodies:
        entity = SceneEntity(frame_id=body.name(), id=body.name(), frame_locked=True)
        for geometry in plant.GetVisualGeometriesForBody(body):
            look = inspector.GetIllustrationProperties(geometry)
            colour = look.GetPropertyOrDefault("phong", "diffuse", GREY)
            pose = inspector.GetPoseInFrame(geometry)
            add_shape(entity, inspector.GetShape(geometry), pose, colour)
        entities.append(entity)
    return entities


def add_shape(entity: SceneEntity, shape: Shape, X: RigidTransform, colour: Rgba) -> None:
    """Add a shape of Drake's; one that is not known is left out."""
    if isinstance(shape, Box):
        _add(entity.cubes, X, colour, shape.size())
    elif isinstance(shape, Sphere):
        _add(entity.spheres, X, colour, np.full(3, 2.0 * shape.radius()))
    elif isinstance(shape, Ellipsoid):
        _add(entity.spheres, X, colour, 2.0 * np.array([shape.a(), shape.b(), shape.c()]))
    elif isinstance(shape, Cylinder | Capsule):
        width, length = 2.0 * shape.radius(), shape.length()
        tube = _add(entity.cylinders, X, colour, np.array([width, width, length]))
        tube.bottom_scale = tube.top_scale = 1.0
        if isinstance(shape, Capsule):
            for end in (-0.5, 0.5):
                at = X @ RigidTransform([0.0, 0.0, end * length])
                _add(entity.spheres, at, colour, np.full(3, width))
    elif isinstance(shape, Mesh):
        points, faces = mesh_triangles(shape.source().path())
        triangles = _add(entity.triangles, X, colour)
        for x, y, z in np.round(points * shape.scale3(), 4):
            triangles.points.add(x=x, y=y, z=z)
        triangles.indices.extend(faces.ravel().tolist())


def _add(shapes: Any, X: RigidTransform, colour: Rgba, size: Array | None = None) -> Any:
    """Add a primitive to a list of an entity; return it."""
    shape = shapes.add()
    _put(shape.pose.position, shape.pose.orientation, X)
    shape.color.r, shape.color.g, shape.color.b, shape.color.a = colour.rgba
    if size is not None:
        shape.size.x, shape.size.y, shape.size.z = size
    return shape


def _put(position: Any, orientation: Any, X: RigidTransform) -> None:
    """Write a pose."""
    position.x, position.y, position.z = X.translation()
    q = X.rotation().ToQuaternion().wxyz()
    orientation.w, orientation.x, orientation.y, orientation.z = q
