"""The ground a robot walks on, read from a scene file."""

import logging
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from pydrake.common.yaml import yaml_load_typed
from pydrake.geometry import AddContactMaterial, Box, HalfSpace, ProximityProperties
from pydrake.math import RigidTransform
from pydrake.multibody.plant import CoulombFriction, MultibodyPlant

from drake_linefoot.errors import ScenarioError
from drake_linefoot.resources import models_dir


@dataclass
class Scene:
    """Flat ground at z = 0. Units in brackets."""

    friction: float = 0.8  # [-] static and dynamic; discrete plants use the dynamic one
    point_contact_stiffness: float = 5.0e5  # [N/m]
    hunt_crossley_dissipation: float = 20.0  # [s/m]
    visual_size: list[float] = field(
        default_factory=lambda: [20.0, 20.0, 0.02]
    )  # [m] slab below z = 0
    rgba: list[float] = field(default_factory=lambda: [0.8, 0.8, 0.8, 1.0])  # [-]

    def validate(self, file: Path) -> None:
        """Raise ScenarioError for a value that makes no ground."""
        for name in ("friction", "point_contact_stiffness"):
            value = getattr(self, name)
            if not (np.isfinite(value) and value > 0.0):
                raise ScenarioError(file, name, value, "must be positive")
        if not self.hunt_crossley_dissipation >= 0.0:
            value = self.hunt_crossley_dissipation
            raise ScenarioError(file, "hunt_crossley_dissipation", value, "must not be negative")
        if len(self.visual_size) != 3 or len(self.rgba) != 4:
            raise ScenarioError(file, "visual_size", self.visual_size, "needs 3 numbers, rgba 4")


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


def add_ground(plant: MultibodyPlant, scene: Scene) -> None:
    """Add the ground to a plant that is not finalized yet."""
    logging.getLogger("drake").addFilter(_concerns_us)  # added once, however often called
    properties = ProximityProperties()
    AddContactMaterial(
        dissipation=scene.hunt_crossley_dissipation,
        point_stiffness=scene.point_contact_stiffness,
        friction=CoulombFriction(scene.friction, scene.friction),
        properties=properties,
    )
    world = plant.world_body()
    plant.RegisterCollisionGeometry(world, RigidTransform(), HalfSpace(), "ground", properties)
    box = Box(*scene.visual_size)
    below = RigidTransform([0.0, 0.0, -0.5 * scene.visual_size[2]])
    plant.RegisterVisualGeometry(world, below, box, "ground_visual", np.array(scene.rgba))
