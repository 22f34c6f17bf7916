"""What is drawn over the robot: footholds, where it plans to step, and its centre of mass."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from pydrake.common.value import AbstractValue
from pydrake.geometry import Box, Cylinder, Meshcat, Rgba, Sphere
from pydrake.math import RigidTransform, RollPitchYaw, RotationMatrix
from pydrake.systems.framework import Context, LeafSystem

from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.simulation.feet import contact_points
from drake_linefoot.systems import weak

Array = NDArray[np.float64]

PERIOD = 1.0 / 32.0  # [s] a power of two, so that drawings fall on frames of the recording
ROOT = "/overlays"
COM_PATH = f"{ROOT}/com/now"
SIDES = ("left", "right")
FOOTHOLD_COLOURS = (Rgba(0.70, 0.10, 0.16, 1.0), Rgba(0.10, 0.32, 0.62, 1.0))  # as the legs
PLANNED_COLOUR = Rgba(0.95, 0.62, 0.10, 1.0)
COM_COLOUR = Rgba(0.10, 0.55, 0.30, 1.0)
PLANNED = 3  # coming footholds that are drawn
WIDTH, THICKNESS = 0.02, 0.004  # [m] of a foothold
TRAIL_RADIUS = 0.004  # [m]
TRAIL_PIECE = 0.125  # [s] of the trail in one piece


class OverlayPainter:
    """Draws overlays so that a Meshcat recording has them.

    A recording keeps transforms and properties over time but no objects. So an object is made
    once, wherever it first appears, and only moved, shown and hidden from then on.
    """

    def __init__(self, meshcat: Meshcat, line_length: float) -> None:
        """Prepare to draw; `line_length` [m] is that of a foot's contact line."""
        self._meshcat, self._length = meshcat, line_length
        self._time = np.inf

    def draw(
        self, time: float, com: Array, contact_points: Array, standing: Array, planned: Array
    ) -> None:
        """Draw one instant; going back in time starts afresh.

        Args:
            time: of the simulation [s].
            com: centre of mass [m], shape (3,).
            contact_points: heel and toe of each foot [m], shape (2, 2, 3).
            standing: flags of the feet, shape (2,); NaN when not known.
            planned: coming footholds [x, y, z, yaw], shape (n, 4); rows of NaN are left out.
        """
        if time <= self._time:
            self._start(time, com)
        self._time = time
        for side in range(2):
            if standing[side] == 1.0 and not self._standing[side]:
                self._add_foothold(time, side, contact_points[side])
            self._standing[side] = standing[side] == 1.0
        self._move_planned(time, planned)
        self._place(COM_PATH, RigidTransform(com), time)
        ground = RigidTransform([com[0], com[1], THICKNESS])
        self._place(f"{ROOT}/com/on_ground", ground, time)
        if time - self._trail_time > TRAIL_PIECE - 1e-9:
            self._add_trail(time, com)

    def _start(self, time: float, com: Array) -> None:
        """Delete what there was and make what will be moved about."""
        meshcat = self._meshcat
        meshcat.Delete(ROOT)
        self._standing = [False, False]
        self._footholds = [0, 0]
        self._trail_time, self._trail_end, self._trail_pieces = time, com.copy(), 0
        self._first_time = time
        meshcat.SetObject(COM_PATH, Sphere(0.025), COM_COLOUR)
        meshcat.SetObject(f"{ROOT}/com/on_ground", Cylinder(0.02, THICKNESS), COM_COLOUR)
        box = Box(self._length, WIDTH, THICKNESS)
        for k in range(PLANNED):
            meshcat.SetObject(f"{ROOT}/planned/{k}", box, PLANNED_COLOUR)

    def _place(self, path: str, pose: RigidTransform, time: float) -> None:
        self._meshcat.SetTransform(path, pose, time_in_recording=time)

    def _show(self, path: str, visible: bool, time: float) -> None:
        self._meshcat.SetProperty(path, "visible", visible, time_in_recording=time)

    def _appear(self, path: str, pose: RigidTransform, time: float) -> None:
        """Show an object from now on; a recording hides it before."""
        self._meshcat.SetTransform(path, pose)
        self._show(path, False, self._first_time)
        self._show(path, True, time)

    def _add_foothold(self, time: float, side: int, points: Array) -> None:
        path = f"{ROOT}/footholds/{SIDES[side]}/{self._footholds[side]}"
        self._footholds[side] += 1
        line = points[1] - points[0]
        pose = _on_ground(points.mean(axis=0), float(np.arctan2(line[1], line[0])))
        box = Box(self._length, WIDTH, THICKNESS)
        self._meshcat.SetObject(path, box, FOOTHOLD_COLOURS[side])
        self._appear(path, pose, time)

    def _move_planned(self, time: float, planned: Array) -> None:
        known = planned[np.isfinite(planned).all(axis=1)][:PLANNED]
        for k in range(PLANNED):
            path = f"{ROOT}/planned/{k}"
            self._show(path, k < len(known), time)
            if k < len(known):
                self._place(path, _on_ground(known[k, :3], known[k, 3]), time)

    def _add_trail(self, time: float, com: Array) -> None:
        step = com - self._trail_end
        length = float(np.linalg.norm(step))
        if length > 1e-4:  # standing still leaves no trail
            path = f"{ROOT}/com/trail/{self._trail_pieces}"
            self._trail_pieces += 1
            R = RotationMatrix.MakeFromOneVector(step, 2)
            pose = RigidTransform(R, 0.5 * (com + self._trail_end))
            self._meshcat.SetObject(path, Cylinder(TRAIL_RADIUS, length), COM_COLOUR)
            self._appear(path, pose, time)
        self._trail_time, self._trail_end = time, com.copy()


class Overlays(LeafSystem):
    """Draws footholds, planned footholds and the centre of mass into Meshcat.

    .. pydrake_system::

        name: Overlays
        input_ports:
        - state
        - targets
        - plan

    | port | type | shape | unit |
    |---|---|---|---|
    | state | vector | nq + nv | Drake's order |
    | targets | GaitTargets | - | optional; which feet stand |
    | plan | CentroidalPlan | - | optional; coming footholds |

    Publishes every 1/32 s and has no output.
    """

    def __init__(self, humanoid: Humanoid, meshcat: Meshcat) -> None:
        """Declare ports and the event."""
        super().__init__()
        self.set_name("overlays")
        self._humanoid = humanoid
        self._scratch = humanoid.plant.CreateDefaultContext()
        self._painter = OverlayPainter(meshcat, 2.0 * humanoid.half_length)
        self._state = self.DeclareVectorInputPort("state", humanoid.nq + humanoid.nv)
        self._targets = self.DeclareAbstractInputPort("targets", AbstractValue.Make(object()))
        self._plan = self.DeclareAbstractInputPort("plan", AbstractValue.Make(object()))
        self.DeclarePeriodicPublishEvent(PERIOD, 0.0, weak(self, self._publish))

    def _publish(self, context: Context) -> None:
        h = self._humanoid
        h.plant.SetPositions(self._scratch, self._state.Eval(context)[: h.nq])
        standing, planned = np.full(2, np.nan), np.empty((0, 4))
        if self._targets.HasValue(context):
            standing = np.array(self._targets.Eval(context).contact, dtype=float)
        if self._plan.HasValue(context):
            planned = self._plan.Eval(context).footholds
        self._painter.draw(
            time=context.get_time(),
            com=h.plant.CalcCenterOfMassPositionInWorld(self._scratch),
            contact_points=contact_points(h, self._scratch),
            standing=standing,
            planned=planned,
        )


def _on_ground(p: Array, yaw: float) -> RigidTransform:
    """Return the pose of a foothold's box that lies on the ground at `p` [m]."""
    return RigidTransform(RollPitchYaw(0.0, 0.0, yaw), [p[0], p[1], p[2] + 0.5 * THICKNESS])
