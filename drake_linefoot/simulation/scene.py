"""The ground a robot walks on, read from a scene file."""

import logging
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from pydrake.common.yaml import yaml_load_typed
from pydrake.geometry import (
    AddContactMaterial,
    Box,
    HalfSpace,
    ProximityProperties,
    Role,
    SceneGraph,
)
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.plant import CoulombFriction, MultibodyPlant

from drake_linefoot.errors import ScenarioError
from drake_linefoot.resources import models_dir
from drake_linefoot.scenario import Scenario
from drake_linefoot.simulation.ground import Ground

MOST_TILES = 2500  # already some seconds to build
STEEPEST = 0.8  # [rad]
SHADES = (1.0, 0.95, 0.9)  # [-] of the drawn boxes in turn, so that they can be told apart


@dataclass
class Scene:
    """The ground: flat at z = 0 where the robot starts. Units in brackets.

    Its shape is that of `drake_linefoot.simulation.ground`.
    """

    friction: float = 0.8  # [-] of a foot on it
    point_contact_stiffness: float = 5.0e5  # [N/m] of the ground alone
    hunt_crossley_dissipation: float = 20.0  # [s/m]
    slope: float = 0.0  # [rad] of the plane that begins at x = 0.5 m
    slope_heading: float = 0.0  # [rad] direction of its steepest ascent, 0 is x
    step_height: float = 0.0  # [m] largest difference of neighbouring tiles, random; 0: none
    tile: float = 0.5  # [m] edge of the tiles
    tiled: list[float] = field(default_factory=lambda: [16.0, 8.0])  # [m] in x and y, around 0
    ledge_height: float = 0.0  # [m] of the ground beyond a step across the path; 0: none
    ledge_at: float = 1.0  # [m] where that begins in x
    visual_size: list[float] = field(
        default_factory=lambda: [20.0, 20.0, 0.02]
    )  # [m] drawn slab; pad and slope reach as far again
    rgba: list[float] = field(default_factory=lambda: [0.8, 0.8, 0.8, 1.0])  # [-]

    def validate(self, file: str | Path, prefix: str = "") -> None:
        """Raise ScenarioError for a value that makes no ground; `prefix` goes before its name."""
        rules = {
            "friction": (self.friction > 0.0, "must be positive"),
            "point_contact_stiffness": (self.point_contact_stiffness > 0.0, "must be positive"),
            "hunt_crossley_dissipation": (
                self.hunt_crossley_dissipation >= 0.0,
                "must not be negative",
            ),
            "slope": (0.0 <= self.slope <= STEEPEST, f"must lie in [0, {STEEPEST}] rad"),
            "slope_heading": (True, "must be finite"),
            "step_height": (self.step_height >= 0.0, "must not be negative"),
            "tile": (self.tile > 0.0, "must be positive"),
            "ledge_height": (
                self.ledge_height == 0.0 or (self.slope == 0.0 and self.step_height == 0.0),
                "must be 0 with a slope or tiles",
            ),
            "ledge_at": (
                0.0 < self.ledge_at < self.visual_size[0],
                f"must lie between 0 and {self.visual_size[0]}, the end of the ground",
            ),
        }
        for name, (holds, allowed) in rules.items():
            value = getattr(self, name)
            if not (np.isfinite(value) and holds):
                raise ScenarioError(file, prefix + name, value, allowed)
        if (len(self.visual_size), len(self.rgba), len(self.tiled)) != (3, 4, 2):
            allowed = "needs 3 numbers, rgba 4, tiled 2"
            raise ScenarioError(file, "visual_size", self.visual_size, allowed)
        tiles = self.tiled[0] * self.tiled[1] / self.tile**2
        if self.step_height > 0.0 and not tiles <= MOST_TILES:
            allowed = f"gives {tiles:.0f} tiles, which must be at most {MOST_TILES}"
            raise ScenarioError(file, prefix + "tile", self.tile, allowed)

    def ground(self, seed: int) -> Ground:
        """Return the shape of the ground; the heights of its tiles follow the seed."""
        return Ground(
            slope=self.slope,
            slope_heading=self.slope_heading,
            step_height=self.step_height,
            tile=self.tile,
            extent=self.visual_size[:2],
            tiled=self.tiled,
            seed=seed,
            ledge_height=self.ledge_height,
            ledge_at=self.ledge_at,
        )


def load_scene(name: str) -> Scene:
    """Read a scene by name (of the shipped scenes) or by path.

    Raises:
        ScenarioError: there is no such scene, or it is not usable.
    """
    file = Path(name) if name.endswith((".yaml", ".yml")) else models_dir() / f"scenes/{name}.yaml"
    if not file.is_file():
        known = sorted(p.stem for p in (models_dir() / "scenes").glob("*.yaml"))
        raise ScenarioError("scene", "", name, f"unknown; shipped: {known}, or a .yaml file")
    try:
        scene: Scene = yaml_load_typed(schema=Scene, filename=str(file))
    except Exception as error:  # Drake raises many kinds for a file that does not fit
        reason = str(error).replace("\n", " ")
        raise ScenarioError(file, "", "scene", f"does not fit: {reason}") from error
    scene.validate(file)
    return scene


def _concerns_us(record: logging.LogRecord) -> bool:
    """Tell Drake's remark on half spaces and deformable bodies, of which there are none here."""
    return "deformable contact" not in record.getMessage()


def scene_of(scenario: Scenario) -> Scene:
    """Return the scene of a scenario, with the numbers that its entry `ground` gives.

    Raises:
        ScenarioError: there is no such scene, or it is not usable.
    """
    given = {name: value for name, value in vars(scenario.ground).items() if value is not None}
    return replace(load_scene(scenario.scene), **given)


def ground_of(scenario: Scenario) -> Ground:
    """Return the shape of the ground of a scenario.

    Raises:
        ScenarioError: there is no such scene, or it is not usable.
    """
    return scene_of(scenario).ground(scenario.seed)


def add_ground(
    plant: MultibodyPlant, scene: Scene, seed: int = 0, scene_graph: SceneGraph | None = None
) -> None:
    """Add the ground to a plant that is not finalized yet.

    Args:
        plant: the robot is already in it.
        scene: what the ground is like.
        seed: of the heights of tiles.
        scene_graph: that of `plant`, which knows the friction of the feet; without, theirs
            counts as equal to the ground's.

    Raises:
        ScenarioError: feet are too slippery for the friction of the scene.
    """
    logging.getLogger("drake").addFilter(_concerns_us)  # added once, however often called
    friction = scene.friction
    if scene_graph is not None:
        friction = own_friction(friction, friction_of_feet(scene_graph, friction))
    properties = ProximityProperties()
    AddContactMaterial(
        dissipation=scene.hunt_crossley_dissipation,
        point_stiffness=scene.point_contact_stiffness,
        friction=CoulombFriction(friction, friction),
        properties=properties,
    )
    world, ground = plant.world_body(), scene.ground(seed)
    if ground.is_flat:
        plant.RegisterCollisionGeometry(world, RigidTransform(), HalfSpace(), "ground", properties)
        box = Box(*scene.visual_size)
        below = RigidTransform([0.0, 0.0, -0.5 * scene.visual_size[2]])
        plant.RegisterVisualGeometry(world, below, box, "ground_visual", np.array(scene.rgba))
    blocks = ground.blocks
    for k, (R, p, size) in enumerate(zip(blocks.R_WB, blocks.p_WB, blocks.size, strict=True)):
        pose, box, name = RigidTransform(RotationMatrix(R), p), Box(*size), f"ground_{k}"
        plant.RegisterCollisionGeometry(world, pose, box, name, properties)
        shade = [*(SHADES[k % len(SHADES)] * np.array(scene.rgba[:3])), scene.rgba[3]]
        plant.RegisterVisualGeometry(world, pose, box, f"{name}_visual", np.array(shade))


def friction_of_feet(scene_graph: SceneGraph, otherwise: float) -> float:
    """Return the friction of what is in a scene graph; the largest, when it differs."""
    inspector = scene_graph.model_inspector()
    found = [
        inspector.GetProximityProperties(geometry)
        .GetPropertyOrDefault("material", "coulomb_friction", CoulombFriction(otherwise, otherwise))
        .dynamic_friction()
        for geometry in inspector.GetAllGeometryIds(Role.kProximity)
    ]
    return float(max(found, default=otherwise))


def own_friction(together: float, feet: float) -> float:
    """Return the ground's friction that gives `together` with that of the feet.

    Drake combines the two sides m1 and m2 of a contact to 2 m1 m2 / (m1 + m2).

    Raises:
        ScenarioError: no friction of the ground does.
    """
    if together == feet:
        return together
    if together >= 2.0 * feet:
        allowed = f"must be below {2.0 * feet:g}, twice the friction of the feet"
        raise ScenarioError("scene", "friction", together, allowed)
    return together * feet / (2.0 * feet - together)
