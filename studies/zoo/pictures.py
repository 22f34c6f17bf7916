"""Pictures of robots that walk, from the side."""

from collections.abc import Iterator

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Polygon
from pydrake.math import RigidTransform
from pydrake.multibody.tree import BodyIndex
from scipy.spatial import ConvexHull, QhullError

from drake_linefoot.lab.simulation.recording import Run
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.robot.model_file import read_model_file
from drake_linefoot.robot.shapes import Cloud, cloud_of, drawn_plant
from studies.common.types import Array

POSES = 5
PACE = 0.9  # [-] of the height of the CoM: between two poses in the picture
STRIDE = 0.55  # [s] that poses are over, of a robot whose CoM is 0.65 m high
RIM = 8  # points around a ball
SIZE = (7.5, 2.6)  # [inches]
HULL, EDGE = "0.82", "0.25"  # greys
LEFT, RIGHT = "#9db8d2", "#2f6ea5"  # legs


def draw_walk(humanoid: Humanoid, run: Run, segment: str) -> Figure:
    """Return poses of a walk, from its right: each link is the hull of its shapes.

    Poses are as far apart as is good to look at, not as far as the robot went. Shown is the segment
    of that name, or the end of the run, if that was before.
    """
    names = [s.name for s in run.scenario.segments]
    ends = np.cumsum([s.duration for s in run.scenario.segments])
    end = min(float(ends[names.index(segment)]), float(run.time[-1]))
    height = humanoid.com_height
    times = end - STRIDE * np.sqrt(height / 0.65) * np.linspace(1.0, 0.0, POSES)
    clouds = link_clouds(humanoid)
    figure = Figure(figsize=SIZE, layout="constrained")
    ax = figure.subplots()
    for k, time in enumerate(times):
        i = min(int(np.searchsorted(run.time, max(time, 0.0))), len(run.time) - 1)
        for outline, colour in outlines(humanoid, clouds, run.q[i], PACE * k * height):
            ax.add_patch(Polygon(outline, closed=True, fc=colour, ec=EDGE, lw=0.5))
    ax.axhline(0.0, color=EDGE, lw=1.0)
    ax.set_aspect("equal")
    ax.autoscale_view()
    ax.set_xticks([])
    ax.set_ylabel("z [m]")
    return figure


def link_clouds(humanoid: Humanoid) -> dict[str, Cloud]:
    """Return the points of each link that has a form, in its frame."""
    d = humanoid.description
    plant, scene_graph = drawn_plant(read_model_file(d.model, d.file), d.file)
    bodies = [plant.get_body(BodyIndex(i)) for i in range(1, plant.num_bodies())]
    found = {b.name(): cloud_of(plant, scene_graph, {b: RigidTransform()}) for b in bodies}
    return {name: cloud[0] for name, cloud in found.items() if cloud is not None}


def outlines(
    humanoid: Humanoid, clouds: dict[str, Cloud], q: Array, x: float
) -> Iterator[tuple[Array, str]]:
    """Yield the outline of each link in the plane of x and z, the farthest first, and its colour.

    The robot is in `q`, but its torso at `x` [m].
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
    found = []
    for name, cloud in clouds.items():
        body = plant.GetBodyByName(name)
        p = plant.EvalBodyPoseInWorld(context, body) @ cloud.p.T
        p = p.reshape(3, -1).T
        points = (p[:, None, ::2] + cloud.radius[:, None, None] * rim).reshape(-1, 2)
        try:
            outline = points[ConvexHull(points).vertices]
        except QhullError:
            continue  # it has no extent
        colour = LEFT if body.index() in legs[0] else RIGHT if body.index() in legs[1] else HULL
        found.append((float(p[:, 1].mean()), np.add(outline, [x - q[4], 0.0]), colour))
    for _, outline, colour in sorted(found, key=lambda each: -each[0]):
        yield outline, colour
