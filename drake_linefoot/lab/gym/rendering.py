"""How an environment is looked at: a page of Meshcat, or pictures of a camera."""

import sys
from contextlib import ExitStack

import numpy as np
from pydrake.geometry import (
    ClippingRange,
    ColorRenderCamera,
    DepthRange,
    DepthRenderCamera,
    LightParameter,
    MakeRenderEngineVtk,
    Meshcat,
    RenderCameraCore,
    RenderEngineVtkParams,
)
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.systems.framework import DiagramBuilder, OutputPort
from pydrake.systems.sensors import CameraInfo, RgbdSensor

from drake_linefoot.errors import InputError
from drake_linefoot.lab.visualization.live import VIEW, Link, live_page
from drake_linefoot.lab.visualization.view import open_meshcat
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.robot.scaling import units_of

MODES = ("human", "rgb_array")
WIDTH, HEIGHT, ANGLE = 640, 480, 0.9  # [px], [px], [rad]
EYE, TARGET = (1.3, -1.5, 0.3), (0.0, 0.0, -0.15)  # [m] in B; another robot's are in its size
NEAR, FAR = 0.05, 60.0  # [m]
SUN = (-0.4, 0.5, -0.8)  # direction of the light in W


def drawn_for(mode: str | None, until: ExitStack) -> tuple[Meshcat | None, Link | None]:
    """Return what a mode needs to draw with, and for humans what tells their page how it goes.

    The address of the page is printed.

    Args:
        mode: "human", "rgb_array" or None.
        until: closes the page.

    Raises:
        InputError: there is no such mode.
    """
    if mode == "human":
        page = until.enter_context(live_page())
        print(f"Live at {page.url}{VIEW}", file=sys.stderr)
        return page.meshcat, page.link
    if mode not in (None, *MODES):
        allowed = f"must be one of {list(MODES)}, or None"
        raise InputError("Linefoot-v0", "render_mode", mode, allowed)
    return None if mode is None else open_meshcat(), None  # with it shapes are there to be seen


def add_camera(builder: DiagramBuilder, humanoid: Humanoid) -> OutputPort:
    """Add a camera that goes along with the base of the robot; return its picture.

    Args:
        builder: of the closed loop, with a `scene_graph`.
        humanoid: the robot.
    """
    scene_graph = builder.GetSubsystemByName("scene_graph")
    light = LightParameter(type="directional", direction=SUN, frame="world", intensity=0.8)
    fill = LightParameter(type="directional", frame="camera", intensity=0.4)
    engine = MakeRenderEngineVtk(RenderEngineVtkParams(lights=[light, fill]))
    scene_graph.AddRenderer("vtk", engine)
    shapes, base = scene_graph.model_inspector(), humanoid.base.name()
    frames = shapes.GetAllFrameIds()
    frame = next(f for f in frames if shapes.GetName(f).rpartition("::")[2] == base)
    eye, target = units_of(humanoid)["m"] * np.array([EYE, TARGET])
    z = (target - eye) / np.linalg.norm(target - eye)  # of a camera z is ahead, y down
    x = np.cross(z, [0.0, 0.0, 1.0])
    x /= np.linalg.norm(x)
    X_BC = RigidTransform(RotationMatrix(np.column_stack([x, np.cross(z, x), z])), eye)
    core = RenderCameraCore(
        "vtk", CameraInfo(WIDTH, HEIGHT, ANGLE), ClippingRange(NEAR, FAR), RigidTransform()
    )
    cameras = ColorRenderCamera(core), DepthRenderCamera(core, DepthRange(2 * NEAR, FAR / 2))
    sensor = builder.AddNamedSystem("camera", RgbdSensor(frame, X_BC, *cameras))
    builder.Connect(scene_graph.get_query_output_port(), sensor.query_object_input_port())
    return sensor.color_image_output_port()
