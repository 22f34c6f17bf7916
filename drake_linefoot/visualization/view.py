"""How the scene is looked at: camera, grid, and what is left out."""

from __future__ import annotations

from pydrake.geometry import Meshcat
from pydrake.math import RigidTransform

CAMERA = (1.7, -2.1, 1.0)  # [m] in front of the robot, on its right
TARGET = (0.0, 0.0, 0.45)  # [m] what it looks at
GRID_HEIGHT = 0.001  # [m] above the ground, which would hide the lines


def set_up_view(meshcat: Meshcat) -> None:
    """Aim the camera at a robot that stands at the origin and looks along x."""
    meshcat.SetCameraPose(CAMERA, TARGET)
    meshcat.SetProperty("/Axes", "visible", False)
    meshcat.SetTransform("/Grid", RigidTransform([0.0, 0.0, GRID_HEIGHT]))
