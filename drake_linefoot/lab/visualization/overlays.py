"""What is drawn over the robot: forces, footholds, plans, and its centre of mass."""

from typing import Any

import numpy as np
from pydrake.geometry import Box, Cylinder, Meshcat, MeshcatCone, Rgba, Sphere
from pydrake.math import RigidTransform, RollPitchYaw, RotationMatrix

from drake_linefoot.axes import FEET, points_of_foot
from drake_linefoot.constants import GRAVITY
from drake_linefoot.lab.plants.ground import Ground
from drake_linefoot.lab.scenario import Scenario
from drake_linefoot.lab.simulation.channels import HORIZON
from drake_linefoot.lab.simulation.foot_points import (
    centre_of_pressure,
    ends_of,
    forces_at_points,
    hull_of,
    place_in,
)
from drake_linefoot.lab.visualization.ghost import COLOUR as GHOST_COLOUR
from drake_linefoot.lab.visualization.ghost import GHOST, Ghost
from drake_linefoot.lab.visualization.map_outlines import MAP_COLOURS, MapOutlines
from drake_linefoot.lab.visualization.stage import Stage
from drake_linefoot.lab.visualization.view import MOVED
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.robot.scaling import units_of
from drake_linefoot.types import Array, Flags

ROOT = "/overlays"
PERIOD = 1.0 / 32.0  # [s] a power of two, so that drawings fall on frames of the recording
# Left is red and right is blue, as the legs are.
FOOTHOLD_COLOURS = (Rgba(0.70, 0.10, 0.16, 1.0), Rgba(0.10, 0.32, 0.62, 1.0))
TRUE_COLOURS = (Rgba(0.90, 0.15, 0.20, 1.0), Rgba(0.15, 0.40, 0.90, 1.0))
ESTIMATED_COLOURS = (Rgba(1.00, 0.65, 0.10, 0.5), Rgba(0.10, 0.80, 0.85, 0.5))
CONE_COLOURS = (Rgba(0.90, 0.15, 0.20, 0.18), Rgba(0.15, 0.40, 0.90, 0.18))
PLANNED_COLOUR = Rgba(0.55, 0.25, 0.75, 1.0)
COM_COLOUR = Rgba(0.10, 0.55, 0.30, 1.0)
PREDICTED_COLOUR = Rgba(0.45, 0.85, 0.20, 1.0)
CAPTURE_COLOUR = Rgba(0.95, 0.10, 0.65, 1.0)
SUPPORT_COLOUR = Rgba(0.95, 0.85, 0.15, 1.0)
PUSH_COLOUR = Rgba(0.95, 0.45, 0.05, 1.0)

COM, COM_ON_GROUND, COM_TRAIL = (f"centre of mass/{name}" for name in ("now", "on ground", "trail"))
PREDICTED, CAPTURE = "predicted centre of mass", "capture point/point"
FOOTHOLDS, PLANNED, SWING = "footholds", "planned footholds", "swing path"
SUPPORT, CONE, PRESSURE = "support", "friction cone", "centre of pressure"
TRUE, ESTIMATED, PUSH = "true contact force", "estimated contact force", "push/force"

OVERLAYS = (  # as they are called in Meshcat, and their colours, left before right
    (TRUE, TRUE_COLOURS),
    (ESTIMATED, ESTIMATED_COLOURS),
    (FOOTHOLDS, FOOTHOLD_COLOURS),
    (PLANNED, [PLANNED_COLOUR]),
    (SWING, FOOTHOLD_COLOURS),
    (SUPPORT, [SUPPORT_COLOUR]),
    (PRESSURE, TRUE_COLOURS),
    (CONE, TRUE_COLOURS),
    (COM, [COM_COLOUR]),
    (PREDICTED, [PREDICTED_COLOUR]),
    (CAPTURE, [CAPTURE_COLOUR]),
    (PUSH, [PUSH_COLOUR]),
    (GHOST, [GHOST_COLOUR]),
    *((name, [colour]) for name, colour in MAP_COLOURS.items()),
)

# Lengths and forces of the MIT Humanoid; another robot's are in its size.
NEWTONS_PER_METER = 400.0  # standing, 0.15 m at each of heel and toe
PUSH_NEWTONS_PER_METER = 200.0  # so that it reaches out of the torso
LEAST_FORCE = 3.0  # [N] that is drawn
MOST_PLANNED = 3  # coming footholds that are drawn
SWING_DOTS = 10  # places of a swing that are drawn, for each foot
WIDTH, THICKNESS = 0.02, 0.004  # [m] of a foothold; a sole has its own width
TRAIL_RADIUS, CONE_HEIGHT = 0.004, 0.10  # [m]
TRAIL_PIECE = 0.125  # [s] of the trail in one piece


def legend_of(scenario: Scenario) -> list[tuple[str, list[str]]]:
    """Return the overlays of a run as a page has them: names and their colours."""
    known = scenario.terrain.source != "felt"
    shown = {name.split("/")[0]: k for name, k in OVERLAYS if known or name not in MAP_COLOURS}
    return [
        (name, [f"rgb{tuple(round(255 * c) for c in (k.r(), k.g(), k.b()))}" for k in colours])
        for name, colours in shown.items()
    ]


class OverlayPainter:
    """Draws overlays so that a Meshcat recording has them, and keeps the robot in view."""

    def __init__(
        self,
        humanoid: Humanoid,
        meshcat: Meshcat,
        friction: float,
        ground: Ground | None = None,
        outlines: MapOutlines | None = None,
    ) -> None:
        """Prepare to draw.

        Args:
            humanoid: the robot.
            meshcat: where.
            friction: half-angle of the friction cones as its tangent [-].
            ground: where the ground is; without, z = 0.
            outlines: of what is known of it, if something is.
        """
        self._humanoid, self._scratch = humanoid, humanoid.plant.CreateDefaultContext()
        units = units_of(humanoid)
        self._m, self._N = units["m"], units["N"]
        self._width = 2.0 * humanoid.half_width or WIDTH * self._m
        self._thickness, self._points = THICKNESS * self._m, points_of_foot(humanoid.sizes["nc"])
        self._stage, self._meshcat = Stage(meshcat, ROOT, self._m), meshcat
        self._ghost = Ghost(humanoid, self._stage, self._m)
        self._length, self._friction = 2.0 * humanoid.half_length, friction
        self._ground = Ground() if ground is None else ground
        self._outlines, self._time = outlines, np.inf

    def draw(self, sample: Any) -> None:
        """Draw one instant; going back in time starts afresh.

        Args:
            sample: of the channels of a `Run`, by name: a row of a recorder, or `Run.sample`.
                What is not known of it is NaN, and is not drawn.
        """
        time, com, points = float(sample["time"]), sample["com"], sample["contact_points"]
        if time <= self._time:
            self._start(time, com)
        self._time = self._stage.time = time
        plant = self._humanoid.plant
        plant.SetPositionsAndVelocities(self._scratch, np.concatenate([sample["q"], sample["v"]]))
        self._draw_com(sample)
        self._draw_swing(sample)
        self._draw_footholds(sample)
        self._ghost.draw(sample)
        if self._outlines is not None:
            self._outlines.draw(self._stage, sample)
        known = np.fmin(sample["reference_friction"] / self._friction, 1.0)  # of what is counted on
        self._draw_support(points, sample["planned_contact"] == 1.0, float(known))
        normal = sample["true_normal"]
        share = normal / np.maximum(normal.sum(axis=1, keepdims=True), 1e-9)  # of each point
        self._draw_forces(TRUE, share[:, :, None] * sample["true_force"][:, None, :], points)
        feet = zip(sample["contact_wrench"], points, strict=True)
        self._draw_forces(ESTIMATED, np.array([forces_at_points(*foot) for foot in feet]), points)
        for name, foot, at in zip(FEET, points, centre_of_pressure(normal), strict=True):
            self._place_known([f"{PRESSURE}/{name}"], place_in(foot, at)[None])
        torso = self._humanoid.base
        pushed = plant.EvalBodyPoseInWorld(self._scratch, torso) @ torso.default_com()
        self._draw_force(PUSH, pushed, sample["push"], PUSH_NEWTONS_PER_METER)
        # Everything moves so that the CoM is over the origin: the camera stays for the mouse.
        beneath = np.array([com[0], com[1], self._ground.plane(com[0], com[1])])
        for path in MOVED:
            self._meshcat.SetTransform(path, RigidTransform(0.0 - beneath), time_in_recording=time)

    def _start(self, time: float, com: Array) -> None:
        """Delete what there was and make what will be moved about."""
        stage, m, thick = self._stage, self._m, self._thickness
        stage.clear(time)
        self._standing = [False, False]
        self._footholds = [0, 0]
        self._swung: list[list[Array]] = [[], []]
        self._trail_time, self._trail_end = time, com.copy()
        self._trail_pieces = 0
        stage.add(COM, Sphere(0.025 * m), COM_COLOUR)
        stage.add(COM_ON_GROUND, Cylinder(0.02 * m, thick), COM_COLOUR)
        stage.add(CAPTURE, Cylinder(0.02 * m, 2.0 * thick), CAPTURE_COLOUR)
        for name in HORIZON:
            stage.add(f"{PREDICTED}/{name}", Sphere(0.009 * m), PREDICTED_COLOUR)
        for k in range(MOST_PLANNED):
            for part, shape in (
                ("line", Box(self._length, self._width, thick)),
                ("toe", Cylinder(WIDTH * m, thick)),
            ):
                stage.add(f"{PLANNED}/{k}/{part}", shape, PLANNED_COLOUR)
        self._ghost.start()
        if self._outlines is not None:
            self._outlines.start(stage)
        stage.add_arrow(PUSH, 0.012 * m, PUSH_COLOUR)
        for edge in range(2 * len(self._points)):
            stage.add_rod(f"{SUPPORT}/{edge}", 0.005 * m, SUPPORT_COLOUR)
        for side, name in enumerate(FEET):
            height = CONE_HEIGHT * m
            radius = self._friction * height
            cone = MeshcatCone(height, radius, radius)
            stage.add(f"{CONE}/{name}", cone, CONE_COLOURS[side])
            for k in range(SWING_DOTS):
                stage.add(f"{SWING}/{name}/{k}", Sphere(0.007 * m), FOOTHOLD_COLOURS[side])
            stage.add(f"{PRESSURE}/{name}", Sphere(0.010 * m), TRUE_COLOURS[side])
            for point in self._points:
                stage.add_arrow(f"{TRUE}/{name} {point}", 0.005 * m, TRUE_COLOURS[side])
                stage.add_arrow(f"{ESTIMATED}/{name} {point}", 0.010 * m, ESTIMATED_COLOURS[side])

    def _draw_com(self, sample: Any) -> None:
        """Draw the centre of mass, where it was, where it will be, and the capture point."""
        stage, com = self._stage, sample["com"]
        stage.place(COM, RigidTransform(com))
        height = float(self._ground.height(com[0], com[1]))
        stage.place(COM_ON_GROUND, RigidTransform([com[0], com[1], height + self._thickness]))
        flies = bool((sample["planned_contact"] == 0.0).all())
        lowest = height if flies else sample["contact_points"][..., 2].min()
        omega = np.sqrt(-GRAVITY[2] / max(com[2] - lowest, 1e-2))
        velocity = self._humanoid.floating.com_velocity(self._scratch)
        capture_point = np.array([*(com + velocity / omega)[:2], lowest])
        self._place_known([CAPTURE], self._above_ground(capture_point)[None])
        self._place_known([f"{PREDICTED}/{name}" for name in HORIZON], sample["mpc_horizon"])
        if self._time - self._trail_time > TRAIL_PIECE - 1e-9:
            self._add_trail(self._time, com)

    def _above_ground(self, p: Array) -> Array:
        """Return a place lifted to the ground that would hide it, as on a slope [m], shape (3,)."""
        if self._ground.is_flat or not np.isfinite(p).all():
            return p
        return np.array([p[0], p[1], max(p[2], float(self._ground.height(p[0], p[1])))])

    def _place_known(self, names: list[str], points: Array) -> None:
        """Place objects at points, shape (m, 3); hide those without one."""
        known = np.full((len(names), 3), np.nan)
        known[: len(points)] = points[: len(names)]
        for name, p in zip(names, known, strict=True):
            self._stage.place(name, RigidTransform(p), bool(np.isfinite(p).all()))

    def _add_trail(self, time: float, com: Array) -> None:
        step = com - self._trail_end
        length = float(np.linalg.norm(step))
        if length > 1e-4:  # standing still leaves no trail
            R = RotationMatrix.MakeFromOneVector(step, 2)
            pose = RigidTransform(R, 0.5 * (com + self._trail_end))
            shape = Cylinder(TRAIL_RADIUS * self._m, length)
            self._stage.appear(f"{COM_TRAIL}/{self._trail_pieces}", shape, COM_COLOUR, pose)
            self._trail_pieces += 1
        self._trail_time, self._trail_end = time, com.copy()

    def _draw_swing(self, sample: Any) -> None:
        """Draw where a swing foot should have been in this swing, until its next one."""
        for side, place in enumerate(sample["swing_position"]):
            if not np.isfinite(place).all():
                continue
            if self._standing[side]:
                self._swung[side] = []
            if len(self._swung[side]) < SWING_DOTS:
                self._swung[side].append(place)
            names = [f"{SWING}/{FEET[side]}/{k}" for k in range(SWING_DOTS)]
            self._place_known(names, np.array(self._swung[side]))

    def _draw_footholds(self, sample: Any) -> None:
        """Draw a foothold at each touchdown, and those that are planned."""
        stage = self._stage
        for side, name in enumerate(FEET):
            stands = bool(sample["planned_contact"][side] == 1.0)
            if stands and not self._standing[side]:
                heel, toe = ends_of(sample["contact_points"][side])
                x, y, z = toe - heel
                pitch = -float(np.arctan2(z, np.hypot(x, y)))
                pose = self._on_ground(0.5 * (heel + toe), float(np.arctan2(y, x)), pitch)
                box = Box(self._length, self._width, self._thickness)
                path = f"{FOOTHOLDS}/{name}/{self._footholds[side]}"
                stage.appear(path, box, FOOTHOLD_COLOURS[side], pose)
                self._footholds[side] += 1
            self._standing[side] = stands
        planned = sample["mpc_footholds"]
        known = planned[np.isfinite(planned).all(axis=1)]
        for k in range(MOST_PLANNED):
            pose = RigidTransform()
            if k < len(known):
                pose = self._on_ground(self._above_ground(known[k, :3]), known[k, 3])
            toe = pose @ RigidTransform([0.5 * self._length, 0.0, 0.0])
            stage.place(f"{PLANNED}/{k}/line", pose, k < len(known))
            stage.place(f"{PLANNED}/{k}/toe", toe, k < len(known))

    def _draw_support(self, points: Array, stands: Flags, grip: float) -> None:
        """Draw the line or the polygon of support, and the friction cone of each standing foot."""
        above = np.add(points[stands], [0.0, 0.0, 2.0 * self._thickness]).reshape(-1, 3)
        corners = above[hull_of(above)]
        edges = list(zip(corners, np.roll(corners, -1, axis=0), strict=True))
        edges = edges[:1] if len(corners) == 2 else edges
        nowhere = [(np.zeros(3), np.zeros(3))] * (2 * len(self._points) - len(edges))
        for k, (begin, end) in enumerate([*edges, *nowhere]):
            self._stage.span(f"{SUPPORT}/{k}", begin, end, k < len(edges))
        for side, name in enumerate(FEET):
            middle = RigidTransform(points[side].mean(axis=0))
            self._stage.place(f"{CONE}/{name}", middle, bool(stands[side]))
            self._stage.stretch(f"{CONE}/{name}", np.array([grip, grip, 1.0]))

    def _draw_forces(self, kind: str, force: Array, points: Array) -> None:
        """Draw the forces on the points of each foot, shape (2, nc, 3)."""
        for side, name in enumerate(FEET):
            for k, point in enumerate(self._points):
                self._draw_force(f"{kind}/{name} {point}", points[side, k], force[side, k])

    def _draw_force(
        self, name: str, point: Array, force: Array, scale: float = NEWTONS_PER_METER
    ) -> None:
        """Draw a force [N] at a point [m], shape (3,) each, unless it is small."""
        visible = bool(np.linalg.norm(force) > LEAST_FORCE * self._N)
        self._stage.point(name, point, force / (scale * self._N / self._m), visible)

    def _on_ground(self, p: Array, yaw: float, pitch: float = 0.0) -> RigidTransform:
        """Return the pose of a foothold's box that lies on the ground at `p` [m]."""
        z = p[2] + 0.5 * self._thickness
        return RigidTransform(RollPitchYaw(0.0, pitch, yaw), [p[0], p[1], z])
