"""The ground as the controller believes it to be, and where a foot may land, as outlines."""

from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydrake.geometry import Rgba
from pydrake.math import RigidTransform

from drake_linefoot.gait.constants import ankles_of
from drake_linefoot.gait.patches import clear_of_risers, edges_of, rises_beyond, room
from drake_linefoot.lab.plants.ground import Ground
from drake_linefoot.lab.plants.patch_ground import outlines
from drake_linefoot.lab.plants.terrain_map import nearest, told
from drake_linefoot.lab.scenario import Scenario
from drake_linefoot.lab.visualization.stage import Stage
from drake_linefoot.math.rotation import roll_pitch_yaw
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.robot.scaling import units_of
from drake_linefoot.types import Array

PATCHES, ROOM = "known ground", "room for a foot"
MAP_COLOURS = {PATCHES: Rgba(0.05, 0.45, 0.50, 1.0), ROOM: Rgba(0.85, 0.45, 0.0, 1.0)}
ABOVE = {PATCHES: 0.005, ROOM: 0.008}  # [m] the ground, so that neither hides the other
TURN = 0.1  # [rad] between two headings for which room is drawn
FARTHEST = 0.3  # [m] from a patch to a foothold that is on it
MOVED = 1e-3  # [m] of heights that are drawn anew


class MapOutlines:
    """Outlines of the patches that are told, and of the room of a foot with its heading on each.

    They are where the map has them, and as high as the controller has them: it says so with the
    foothold of each swing, since feet correct the height of the map.
    """

    def __init__(self, humanoid: Humanoid, ground: Ground, scenario: Scenario) -> None:
        """Find out what is told.

        Args:
            humanoid: the robot.
            ground: the true one.
            scenario: of a loop: each of its numbers has the size of the robot.
        """
        self._patches, self._known = told(ground, scenario), scenario.terrain
        self._foot = humanoid.half_length, humanoid.half_width
        self._margin, self._metre = scenario.gait.edge_margin, units_of(humanoid)["m"]
        toe = ankles_of(humanoid).toe
        self._shank = toe[0], toe[1], scenario.gait.shank_radius, scenario.gait.shank_lean
        self._outlines = outlines(self._patches)
        corners, sides = self._patches.corners, self._patches.sides
        self._edges = np.zeros((*corners.shape[:2], 3))
        for of_patch, at, m in zip(self._edges, corners, sides, strict=True):
            edges_of(at, int(m), of_patch)

    def start(self, stage: Stage) -> None:
        """Forget what was drawn."""
        self._made, self._shown, self._offset = set[str](), set[str](), 0.0
        for root in MAP_COLOURS:
            stage.move(root, RigidTransform())

    def draw(self, stage: Stage, sample: Any) -> None:
        """Draw one instant, see `OverlayPainter.draw`."""
        near = nearest(self._outlines, sample["q"][4:6], self._known.range)
        near = near[: None if self._known.is_known(float(sample["time"])) else 0]
        footholds = sample["foothold"][np.isfinite(sample["foothold"]).all(axis=1)]
        self._correct(stage, footholds, near)
        # The room of a foot that turns is another one: one for each heading, for what was
        # recorded cannot be changed.
        yaw = float(footholds[0, 3]) if len(footholds) else roll_pitch_yaw(sample["q"][:4])[2]
        turn = round(float(yaw) / TURN)
        wanted: dict[str, tuple[int, float | None]] = {f"{PATCHES}/{k}": (k, None) for k in near}
        wanted |= {f"{ROOM}/{k} at {turn}": (k, turn * TURN) for k in near}
        for name in self._shown - wanted.keys():
            stage.show(name, False)
        for name, (k, heading) in wanted.items():
            if name not in self._made:
                self._make(stage, name, int(k), heading)
                self._made.add(name)
            stage.show(name, True)
        self._shown = set(wanted)

    def _correct(self, stage: Stage, footholds: Array, near: NDArray[np.int64]) -> None:
        """Learn from a foothold how high the controller has the map."""
        for x, y, z, _ in footholds if len(near) else ():
            off = z - self._patches.plane[near] @ [1.0, x, y]
            away = [_beyond(self._edges_of(k), (x, y)) for k in near]
            miss = np.maximum(away, 0.0) + np.abs(off - self._offset)
            if miss.min() < FARTHEST and abs(off[miss.argmin()] - self._offset) > MOVED:
                self._offset = float(off[miss.argmin()])
                for root in MAP_COLOURS:
                    stage.move(root, RigidTransform([0.0, 0.0, self._offset]))

    def _make(self, stage: Stage, name: str, k: int, heading: float | None) -> None:
        """Make the outline of a patch, or of the room of a foot with a heading [rad] on it."""
        known, edges, root = self._patches, self._edges_of(k), PATCHES
        if heading is not None:
            margin, root = self._margin + known.sigma[k], ROOM
            rises = rises_beyond(k, known.sides, self._edges, known.corners[k], known.plane)
            edges = clear_of_risers(edges, rises, heading, self._shank, margin)
            edges = room(edges, heading, self._foot, margin)
        corners = corners_within(edges)
        plane = self._patches.plane[k]
        z = plane[0] + corners @ plane[1:] + ABOVE[root] * self._metre
        if len(corners):
            stage.add_line(name, np.column_stack([corners, z]), MAP_COLOURS[root])

    def _edges_of(self, k: int) -> Array:
        return self._edges[k, : int(self._patches.sides[k])]


def corners_within(edges: Array) -> Array:
    """Return the corners of what is inside edges, in turn.

    Args:
        edges: rows ``[n_x, n_y, b]`` of a convex polygon, counter-clockwise, shape (m, 3).

    Returns:
        Shape (k, 2) [m]; none where nothing is inside.
    """
    found = []
    for i, (n, b) in enumerate(zip(edges[:, :2], edges[:, 2], strict=True)):
        ends = []
        for other in np.delete(edges, i, axis=0):
            if abs(np.linalg.det(both := np.array([n, other[:2]]))) > 1e-9:
                p = np.linalg.solve(both, [b, other[2]])
                if _beyond(edges, p) < 1e-7:
                    ends.append(p)
        along = np.array([-n[1], n[0]])
        found += sorted(ends, key=lambda p: float(along @ p))
    corners = np.array(found).reshape(-1, 2)
    step = np.linalg.norm(corners - np.roll(corners, -1, axis=0), axis=1)
    return corners[step > 1e-6]  # each is an end of two edges


def _beyond(edges: Array, place: Any) -> float:
    return float((edges[:, :2] @ np.asarray(place) - edges[:, 2]).max())


def outlines_of(scenario: Scenario, humanoid: Humanoid, ground: Ground) -> MapOutlines | None:
    """Return the outlines of a loop, if its controller is told of the ground; see `MapOutlines`."""
    return None if scenario.terrain.source == "felt" else MapOutlines(humanoid, ground, scenario)
