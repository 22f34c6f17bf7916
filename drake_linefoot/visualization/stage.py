"""Objects in Meshcat that a recording can keep: made once, then moved, stretched and hidden."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydrake.geometry import Cylinder, Meshcat, MeshcatCone, Rgba, Shape
from pydrake.math import RigidTransform, RollPitchYaw, RotationMatrix

Array = NDArray[np.float64]

HEAD_LENGTH, HEAD_RADIUS = 0.03, 2.2  # [m]; [-] of the shaft's radius
_DOWN = RotationMatrix(RollPitchYaw(np.pi, 0.0, 0.0))


class Stage:
    """Moves and hides objects at a time, live and in a recording.

    A recording keeps transforms and properties over time but no objects, so each object is
    made once. `time` [s] is that of the simulation and must not decrease.
    """

    def __init__(self, meshcat: Meshcat, root: str) -> None:
        """Work under the path `root`."""
        self.meshcat, self._root = meshcat, root
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
        self.hide(name)

    def place(self, name: str, pose: RigidTransform) -> None:
        """Show an object at a pose in W."""
        self.meshcat.SetTransform(self.path(name), pose, time_in_recording=self.time)
        self._show(name, True)

    def hide(self, name: str) -> None:
        """Hide an object."""
        self._show(name, False)

    def appear(self, name: str, shape: Shape, colour: Rgba, pose: RigidTransform) -> None:
        """Make an object that stays where it is, from now on; a recording hides it before."""
        path = self.path(name)
        self.meshcat.SetObject(path, shape, colour)
        self.meshcat.SetTransform(path, pose)
        self.meshcat.SetProperty(path, "visible", False, time_in_recording=self._first_time)
        self.meshcat.SetProperty(path, "visible", True, time_in_recording=self.time)

    def add_arrow(self, name: str, radius: float, colour: Rgba) -> None:
        """Make an arrow of a shaft with `radius` [m]; hidden until it is pointed."""
        shaft, tube, head = (
            self.path(f"{name}/{part}") for part in ("shaft", "shaft/tube", "head")
        )
        self.meshcat.SetObject(tube, Cylinder(radius, 1.0), colour)
        self.meshcat.SetTransform(tube, RigidTransform([0.0, 0.0, 0.5]))
        cone = MeshcatCone(HEAD_LENGTH, HEAD_RADIUS * radius, HEAD_RADIUS * radius)
        self.meshcat.SetObject(f"{head}/cone", cone, colour)
        self.meshcat.SetTransform(f"{head}/cone", RigidTransform(_DOWN, [0, 0, HEAD_LENGTH]))
        self.meshcat.SetProperty(shaft, "scale", [1.0, 1.0, 1.0])
        self.hide(name)

    def point(self, name: str, begin: ArrayLike, vector: ArrayLike) -> None:
        """Let an arrow point from `begin` along `vector` [m], shape (3,); hide a short one."""
        length = float(np.linalg.norm(vector))
        if not length > 1e-3:  # nor one of NaN
            self.hide(name)
            return
        R = RotationMatrix.MakeFromOneVector(np.asarray(vector, dtype=float), 2)
        self.place(name, RigidTransform(R, begin))
        self._stretch(f"{name}/shaft", 2, length)
        head = [0.0, 0.0, length]
        path = self.path(f"{name}/head")
        self.meshcat.SetProperty(path, "position", head, time_in_recording=self.time)

    def add_bar(self, name: str, radius: float, colour: Rgba) -> None:
        """Make a bar of any length with `radius` [m]; hidden until it is spanned."""
        tube = self.path(f"{name}/tube")
        self.meshcat.SetObject(tube, Cylinder(radius, 1.0), colour)
        self.meshcat.SetTransform(tube, RigidTransform([0.0, 0.0, 0.5]))
        self.hide(name)

    def span(self, name: str, begin: Array, end: Array) -> None:
        """Let a bar reach from `begin` to `end` [m], shape (3,)."""
        length = float(np.linalg.norm(end - begin))
        if not length > 1e-3:
            self.hide(name)
            return
        R = RotationMatrix.MakeFromOneVector(end - begin, 2)
        self.place(name, RigidTransform(R, begin))
        self._stretch(name, 2, length)

    def _stretch(self, name: str, axis: int, factor: float) -> None:
        scale = [1.0, 1.0, 1.0]
        scale[axis] = factor
        self.meshcat.SetProperty(self.path(name), "scale", scale, time_in_recording=self.time)

    def _show(self, name: str, visible: bool) -> None:
        """Say whether an object is visible, when that is new."""
        if self._visible.get(name) is not visible:
            self._visible[name] = visible
            path = self.path(name)
            self.meshcat.SetProperty(path, "visible", visible, time_in_recording=self.time)
