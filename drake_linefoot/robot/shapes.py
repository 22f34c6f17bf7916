"""The form of a robot's feet: points of the collision shapes and drawings in its model."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from pydrake.geometry import (
    Box,
    Capsule,
    Convex,
    Cylinder,
    Ellipsoid,
    Mesh,
    SceneGraph,
    Shape,
    Sphere,
)
from pydrake.math import RigidTransform
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import RigidBody

from drake_linefoot.robot.meshes import mesh_triangles
from drake_linefoot.robot.model import drake_warnings, parse, parser_errors
from drake_linefoot.robot.model_file import DRAWN, ModelFile
from drake_linefoot.types import Array

ROUND = 32  # points around a rim
SOLE = 0.04  # [-] of a foot's length: how far above its lowest point a sole may be


@dataclass(frozen=True)
class Cloud:
    """Points that span the shapes of a foot, each a ball.

    Attributes:
        p: [m], shape (n, 3).
        radius: [m], shape (n,).
    """

    p: Array
    radius: Array

    def reach(self, direction: Array) -> float:
        """Return how far it reaches along a unit vector [m]."""
        return float((self.p @ direction + self.radius).max())

    def sole(self) -> Cloud:
        """Return its points at the bottom; along x is its length, z is up."""
        bottom = self.p[:, 2] - self.radius
        low = bottom <= bottom.min() + SOLE * np.ptp(self.p[:, 0])
        return Cloud(self.p[low], self.radius[low])


def drawn_plant(model: ModelFile, file: Path) -> tuple[MultibodyPlant, SceneGraph]:
    """Return a model as its file has it, with what feet are made of as drawings, finalized.

    Raises:
        ModelError: Drake refuses it; names `file`.
    """
    plant, scene_graph = MultibodyPlant(0.0), SceneGraph()
    plant.RegisterAsSourceForSceneGraph(scene_graph)
    with parser_errors(file, "model", model.path.name), drake_warnings():
        parse(plant, model, model.drawn_shapes())
        plant.Finalize()
    return plant, scene_graph


def cloud_of(
    plant: MultibodyPlant, scene_graph: SceneGraph, poses: Mapping[RigidBody, RigidTransform]
) -> tuple[Cloud, bool] | None:
    """Return what bodies of a `drawn_plant` consist of, whose poses in one frame are given.

    Returns:
        Points in that frame, of collision shapes or, where there are none, of drawings, and whether
        of shapes; None where there is nothing, or only what cannot be read.
    """
    inspector = scene_graph.model_inspector()
    geometries = [
        (
            DRAWN in inspector.GetName(geometry)
            or inspector.GetProximityProperties(geometry) is not None,
            X @ inspector.GetPoseInFrame(geometry),
            inspector.GetShape(geometry),
        )
        for body, X in poses.items()
        for geometry in [
            *plant.GetVisualGeometriesForBody(body),
            *plant.GetCollisionGeometriesForBody(body),
        ]
    ]
    from_shapes = any(collides for collides, *_ in geometries)
    used: list[tuple[Array, Array]] = []
    for collides, X_shape, shape in geometries:
        if collides == from_shapes:  # meshes that are not used are not read
            points, radius = shape_points(shape)
            if len(points):
                used.append(((X_shape @ points.T).T.reshape(-1, 3), np.full(len(points), radius)))
    if not used:
        return None
    return Cloud(np.vstack([p for p, _ in used]), np.concatenate([r for _, r in used])), from_shapes


def shape_points(shape: Shape) -> tuple[Array, float]:
    """Return points that span a shape, shape (n, 3), and the radius of a ball around each [m]."""
    signs = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1.0, 1.0)])
    angle = 2.0 * np.pi * np.arange(ROUND) / ROUND
    rim = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(ROUND)])
    z = np.array([0.0, 0.0, 1.0])
    points, radius = np.zeros((0, 3)), 0.0
    if isinstance(shape, Sphere):
        points, radius = np.zeros((1, 3)), shape.radius()
    elif isinstance(shape, Box):
        points = 0.5 * signs * shape.size()
    elif isinstance(shape, Capsule):
        points, radius = 0.5 * shape.length() * np.array([z, -z]), shape.radius()
    elif isinstance(shape, Cylinder):
        ends = [shape.radius() * rim + sign * 0.5 * shape.length() * z for sign in (-1.0, 1.0)]
        points = np.vstack(ends)
    elif isinstance(shape, Ellipsoid):
        rows = [np.cos(t) * rim + np.sin(t) * z for t in np.linspace(-1.5, 1.5, ROUND)]
        points = np.vstack(rows) * [shape.a(), shape.b(), shape.c()]
    elif isinstance(shape, Mesh | Convex):
        with suppress(ValueError):
            points = mesh_triangles(shape.source().path())[0] * shape.scale3()
    return points, radius
