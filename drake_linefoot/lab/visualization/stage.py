"""Objects in Meshcat that a recording can keep: made once, then moved, stretched and hidden."""

from typing import Any

import numpy as np
from pydrake.geometry import Cylinder, Meshcat, MeshcatCone, Rgba, Shape
from pydrake.math import RigidTransform, RollPitchYaw, RotationMatrix

from drake_linefoot.types import Array

HEAD_LENGTH, HEAD_RADIUS = 0.03, 2.2  # [m] in the size of the robot; [-] of the shaft's radius
_DOWN = RotationMatrix(RollPitchYaw(np.pi, 0.0, 0.0))


class Stage:
    """Moves and hides objects at a time, live and in a recording.

    A recording keeps transforms and properties over time but no objects, so each object is
    made once. `time` [s] is that of the simulation and must not decrease.
    """

    def __init__(self, meshcat: Meshcat, root: str, metre: float) -> None:
        """Work under the path `root`; `metre` is what a metre of the MIT Humanoid is here [m]."""
        self.meshcat, self._root, self._head = meshcat, root, HEAD_LENGTH * metre
        self.time = 0.0
        self._first_time = 0.0
        self._visible: dict[str, bool] = {}

    def clear(self, time: float) -> None:
        """Delete everything and begin anew at `time` [s]."""
        self.meshcat.Delete(self._root)
        self.time = self._first_time = time
        self._visible = {}

    def path(self, name: str) -> str:
        """Return the path of an object."""
        return f"{self._root}/{name}"

    def add(self, name: str, shape: Shape, colour: Rgba) -> None:
        """Make an object; hidden until it is placed."""
        self.meshcat.SetObject(self.path(name), shape, colour)
        self.show(name, False)

    def place(self, name: str, pose: RigidTransform, visible: bool = True) -> None:
        """Show an object at a pose in W, or hide it."""
        if visible:
            self.move(name, pose)
        self.show(name, visible)

    def move(self, name: str, pose: RigidTransform) -> None:
        """Put an object, or all that are below a name, at a pose in W, seen or not."""
        self.meshcat.SetTransform(self.path(name), pose, time_in_recording=self.time)

    def show(self, name: str, visible: bool) -> None:
        """Say whether an object is visible, when that is new."""
        if self._visible.get(name) is not visible:
            self._visible[name] = visible
            self._set(name, "visible", visible)

    def appear(self, name: str, shape: Shape, colour: Rgba, pose: RigidTransform) -> None:
        """Make an object that stays where it is, from now on; a recording hides it before."""
        path = self.path(name)
        self.meshcat.SetObject(path, shape, colour)
        self.meshcat.SetTransform(path, pose)
        self.meshcat.SetProperty(path, "visible", False, time_in_recording=self._first_time)
        self.meshcat.SetProperty(path, "visible", True, time_in_recording=self.time)

    def add_line(self, name: str, corners: Array, colour: Rgba) -> None:
        """Make a closed line through points, shape (n, 3) [m]; hidden until it is shown."""
        path = self.path(name)
        self.meshcat.SetLine(path, np.vstack([corners, corners[:1]]).T, 1.0, colour)
        self.meshcat.SetProperty(path, "visible", False, time_in_recording=self._first_time)

    def add_arrow(self, name: str, radius: float, colour: Rgba) -> None:
        """Make an arrow of a shaft with `radius` [m]; hidden until it is pointed."""
        self._add_tube(f"{name}/shaft", radius, colour)
        cone = MeshcatCone(self._head, HEAD_RADIUS * radius, HEAD_RADIUS * radius)
        path = self.path(f"{name}/head/cone")
        self.meshcat.SetObject(path, cone, colour)
        self.meshcat.SetTransform(path, RigidTransform(_DOWN, [0, 0, self._head]))
        self.meshcat.SetProperty(self.path(f"{name}/shaft"), "scale", [1.0, 1.0, 1.0])
        self.show(name, False)

    def point(self, name: str, begin: Array, vector: Array, visible: bool = True) -> None:
        """Let an arrow point from `begin` along `vector` [m], shape (3,); hide a short one."""
        if length := self._turn(name, begin, vector, visible):
            self._set(f"{name}/shaft", "scale", [1.0, 1.0, length])
            self._set(f"{name}/head", "position", [0.0, 0.0, length])

    def add_rod(self, name: str, radius: float, colour: Rgba) -> None:
        """Make a rod of any length with `radius` [m]; hidden until it is spanned."""
        self._add_tube(name, radius, colour)
        self.show(name, False)

    def span(self, name: str, begin: Array, end: Array, visible: bool = True) -> None:
        """Let a rod reach from `begin` to `end` [m], shape (3,); hide a short one."""
        if length := self._turn(name, begin, end - begin, visible):
            self._set(name, "scale", [1.0, 1.0, length])

    def stretch(self, name: str, factors: Array) -> None:
        """Stretch an object along the axes of its pose, shape (3,)."""
        self._set(name, "scale", factors.tolist())

    def _add_tube(self, name: str, radius: float, colour: Rgba) -> None:
        """Make a cylinder of 1 m that begins at the origin of `name`."""
        path = self.path(f"{name}/tube")
        self.meshcat.SetObject(path, Cylinder(radius, 1.0), colour)
        self.meshcat.SetTransform(path, RigidTransform([0.0, 0.0, 0.5]))

    def _turn(self, name: str, begin: Array, vector: Array, visible: bool) -> float:
        """Let the z axis of an object begin at a place and point along a vector; return its length.

        Returns:
            0 for an object that is hidden: a vector that is short, or NaN.
        """
        length = float(np.linalg.norm(vector))
        if not (visible and length > 1e-3):
            self.show(name, False)
            return 0.0
        self.place(name, RigidTransform(RotationMatrix.MakeFromOneVector(vector, 2), begin))
        return length

    def _set(self, name: str, what: str, value: Any) -> None:
        self.meshcat.SetProperty(self.path(name), what, value, time_in_recording=self.time)
