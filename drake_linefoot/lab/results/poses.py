"""Pictures of a robot: poses of a run from its side, and one posture from side and front.

Each link is the hull of its shapes. Left is red, right is blue.
"""

from collections.abc import Iterator
from io import BytesIO

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Polygon
from pydrake.math import RigidTransform
from pydrake.multibody.tree import BodyIndex
from scipy.spatial import ConvexHull, QhullError
from scipy.spatial.transform import Rotation

from drake_linefoot.lab.results.panels import BLUE, GREEN, RED
from drake_linefoot.lab.simulation.recording import Run
from drake_linefoot.lab.simulation.run_view import robot_of
from drake_linefoot.math.rotation import roll_pitch_yaw
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.robot.model_file import read_model_file
from drake_linefoot.robot.shapes import Cloud, cloud_of, drawn_plant
from drake_linefoot.types import Array

POSES, PACE = 9, 0.62  # of a run; [-] of the height of the CoM between two in the picture
STRIDE = 0.64  # [s] that poses are over, of a robot whose CoM is 0.65 m high
RIM = 8  # points around a ball
SIZE, DOTS_PER_INCH = (9.0, 2.6), 110  # [inches], [1/inch]
HULL, EDGE = "0.82", "0.25"  # greys
LEGS = ("#e3a7a7", "#8fb1dc")
SIDE, FRONT = (0, 2), (1, 2)  # axes that are seen


def draw_walk(run: Run, segment: str | None = None) -> Figure:
    """Return poses of a run, from its right, at equal times over about two steps.

    Poses are as far apart as is good to look at, not as far as the robot went. Shown is the end of
    the segment of that name, else of the longest one, or of the run if that was before.
    """
    humanoid, segments = robot_of(run), run.scenario.segments
    ends = np.cumsum([s.duration for s in segments])
    longest = max(range(len(ends)), key=lambda k: (segments[k].walk, segments[k].duration))
    shown = longest if segment is None else [s.name for s in segments].index(segment)
    end = min(float(ends[shown]), float(run.time[-1]))
    height = humanoid.com_height
    times = end - STRIDE * np.sqrt(height / 0.65) * np.linspace(1.0, 0.0, POSES)
    rows = np.searchsorted(run.time, np.maximum(times, 0.0)).clip(max=len(run.time) - 1)
    clouds = link_clouds(humanoid)
    figure = Figure(figsize=SIZE, layout="constrained")
    ax = figure.subplots()
    for k, q in enumerate(np.array(run.q[rows])):
        turn = Rotation.from_euler("z", -roll_pitch_yaw(q[:4])[2])
        q[:4] = (turn * Rotation.from_quat(q[:4], scalar_first=True)).as_quat(scalar_first=True)
        q[4:6] = 0.0  # seen from where its right is, whatever way it goes
        _add_robot(ax, outlines(humanoid, clouds, q, SIDE), [PACE * k * height, 0.0])
    ax.axhline(0.0, color=EDGE, lw=1.0)
    ax.set_xlim(-0.6 * height, PACE * (POSES - 1) * height + 0.6 * height)
    ax.set_axis_off()
    return figure


def draw_robot(humanoid: Humanoid) -> Figure:
    """Return a robot in its nominal posture from side and front: links, contact points, CoM."""
    figure = Figure(figsize=(6.4, 4.6), layout="constrained")
    d, q, clouds = humanoid.description, humanoid.q_nominal, link_clouds(humanoid)
    plant, context = humanoid.plant, humanoid.scratch
    figure.suptitle(
        f"{d.name}: {humanoid.mass:.1f} kg, {humanoid.na} joints, feet as a {d.contact}"
    )
    for ax, axes, title in zip(
        figure.subplots(1, 2), (SIDE, FRONT), ("side", "front"), strict=True
    ):
        _add_robot(ax, outlines(humanoid, clouds, q, axes), [0.0, 0.0])
        com = plant.CalcCenterOfMassPositionInWorld(context)
        for frame, points, colour in zip(
            humanoid.foot_frames, humanoid.contact_points, (RED, BLUE), strict=True
        ):
            at = frame.CalcPoseInWorld(context).multiply(np.asarray(points).T)
            ax.plot(*at[list(axes)], "o", color=colour, ms=5, label="contact point")
        ax.plot(*com[list(axes)], "P", color=GREEN, ms=8, label="centre of mass")
        ax.axhline(0.0, color=EDGE, lw=1.0)
        ax.set_aspect("equal")
        ax.autoscale_view()
        ax.set_xlabel(f"{'xyz'[axes[0]]} [m], {title}")
        ax.grid(color="0.9", lw=0.5)
    figure.axes[0].set_ylabel("z [m]")
    figure.axes[1].invert_xaxis()  # as it is seen: its left is on the right
    return figure


def png(figure: Figure) -> bytes:
    """Return a figure as the content of a PNG file."""
    file = BytesIO()
    figure.savefig(file, format="png", dpi=DOTS_PER_INCH)
    return file.getvalue()


def link_clouds(humanoid: Humanoid) -> dict[str, Cloud]:
    """Return the points of each link that has a form, in its frame."""
    d = humanoid.description
    plant, scene_graph = drawn_plant(read_model_file(d.model, d.file), d.file)
    bodies = [plant.get_body(BodyIndex(i)) for i in range(1, plant.num_bodies())]
    found = {b.name(): cloud_of(plant, scene_graph, {b: RigidTransform()}) for b in bodies}
    return {name: cloud[0] for name, cloud in found.items() if cloud is not None}


def outlines(
    humanoid: Humanoid, clouds: dict[str, Cloud], q: Array, axes: tuple[int, int]
) -> Iterator[tuple[Array, str]]:
    """Yield the outline of each link of a robot in `q`, shape (n, 2), and its colour.

    Seen are two `axes` of the world; the farthest link comes first. The robot's scratch context is
    left in `q`.
    """
    plant, context = humanoid.plant, humanoid.scratch
    plant.SetPositions(context, q)
    angle = 2.0 * np.pi * np.arange(RIM) / RIM
    rim = np.column_stack([np.cos(angle), np.sin(angle)])
    legs = [
        plant.GetBodiesKinematicallyAffectedBy(
            [humanoid.names.joint(joint).index() for joint in foot.leg_joints]
        )
        for foot in humanoid.description.feet
    ]
    depth = {SIDE: -1.0, FRONT: 1.0}[axes]  # of y towards who looks from the right, of x likewise
    found = []
    for name, cloud in clouds.items():
        body = plant.GetBodyByName(name)
        p = plant.EvalBodyPoseInWorld(context, body) @ cloud.p.T
        p = p.reshape(3, -1).T
        points = (p[:, None, axes] + cloud.radius[:, None, None] * rim).reshape(-1, 2)
        try:
            outline = points[ConvexHull(points).vertices]
        except QhullError:
            continue  # it has no extent
        side = next((k for k in (0, 1) if body.index() in legs[k]), None)
        near = depth * float(p[:, 1 - axes[0]].mean())
        found.append((near, outline, HULL if side is None else LEGS[side]))
    for _, outline, colour in sorted(found, key=lambda each: each[0]):
        yield outline, colour


def _add_robot(ax: Axes, links: Iterator[tuple[Array, str]], offset: list[float]) -> None:
    for outline, colour in links:
        at = np.add(outline, offset)
        ax.add_patch(Polygon(at, closed=True, fc=colour, ec=EDGE, lw=0.5))
    ax.set_aspect("equal")
    ax.autoscale_view()
