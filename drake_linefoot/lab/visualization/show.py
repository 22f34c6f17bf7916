"""A robot to look at: contact points, a slider for every joint; frames and inertia ellipsoids.

A page of it is drawn by a process of its own, see `replay`:
`python -m drake_linefoot.lab.visualization.show DESCRIPTION PAGE`.
"""

import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from pydrake.geometry import Meshcat, SceneGraphInspector, Sphere
from pydrake.math import RigidTransform
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import BodyIndex, PrismaticJoint
from pydrake.visualization import ModelVisualizer

from drake_linefoot.axes import FEET, points_of_foot
from drake_linefoot.files import write_file
from drake_linefoot.lab.plants.scene import draw_floor
from drake_linefoot.lab.scenario.scene import Scene
from drake_linefoot.lab.simulation.drake_logging import silence_drake
from drake_linefoot.lab.visualization.controls import Button, Slider, page_setup
from drake_linefoot.lab.visualization.drawing import Drawing
from drake_linefoot.lab.visualization.live import Live
from drake_linefoot.lab.visualization.replay import replay_html
from drake_linefoot.lab.visualization.view import open_meshcat, set_up_view
from drake_linefoot.page import Page
from drake_linefoot.robot.humanoid import Humanoid, load_humanoid
from drake_linefoot.robot.scaling import units_of

# Lengths for the MIT Humanoid; another robot's are in its size.
TRIAD_LENGTH, TRIAD_RADIUS = 0.1, 0.003  # [m] of a frame's axes
POINT_RADIUS = 0.014  # [m] of a contact point, a little more than the foot's own rounding
CONTACT_POINT = "contact_point"
COLOURS = ((0.88, 0.48, 0.0, 1.0), (0.10, 0.55, 0.30, 1.0))  # heel, toe: red, green, blue, alpha
HEIGHT = "torso_height"  # the slider
ILLUSTRATION, INERTIA = "/drake/illustration", "/drake/inertia"
CAMERA, TARGET = (0.8, -1.0, 0.65), (0.0, 0.0, 0.38)  # [m]
PROGRAM = (sys.executable, "-P", "-m", __spec__.name if __spec__ else __name__)
SHAPES_SEEN, INERTIA_SEEN = 0.4, 0.5  # [-] opacity of the robot's shapes and of the ellipsoids
PERIOD, STEP = 1.0 / 32.0, 0.01  # [s] between two looks at the page; [rad], [m] of a slider
FARTHEST = 10.0  # [rad], [m] of a joint without limits
POSTURE, INSIDE, QUIT = "posture", "inside", "quit"
BUTTONS = {
    POSTURE: Button("nominal posture", "KeyR"),
    INSIDE: Button("see-through", "KeyI"),
    QUIT: Button("quit", "Escape"),
}


def show(humanoid: Humanoid, page: Live, inside: bool = False, once: bool = False) -> None:
    """Show a robot on a live page with its controls until it says quit, or only `once`.

    The `page` was opened by the calling thread; for the rest see `make_visualizer`.
    """
    visualizer, meshcat = make_visualizer(humanoid, page.meshcat, inside), page.meshcat
    visualizer.Run(loop_once=True)
    nominal = {name: meshcat.GetSliderValue(name) for name in meshcat.GetSliderNames()}
    sliders = {k: slider for k, slider in _sliders(humanoid).items() if k in nominal}
    for name, slider in sliders.items():
        slider.value = nominal[name]
    title = f"{humanoid.description.name}, the robot"
    page.link.show("setup", page_setup(title, humanoid, sliders, BUTTONS))
    while not once:
        orders = page.link.orders()
        pressed = [order["press"] for order in orders if "press" in order]
        if QUIT in pressed:
            return
        wanted = dict(order["set"] for order in orders if "set" in order)
        wanted = nominal if POSTURE in pressed else wanted
        for name in wanted.keys() & sliders.keys():
            sliders[name].move(wanted[name])
        values = {name: slider.value for name, slider in sliders.items()}
        if turned := pressed.count(INSIDE) % 2:
            inside = not inside
            visualizer = make_visualizer(humanoid, meshcat, inside)
        if wanted or turned:
            for name, value in values.items():
                meshcat.SetSliderValue(name, value)
            visualizer.Run(loop_once=True)
        page.link.show("state", {"values": values, "on": [INSIDE] * inside})
        time.sleep(PERIOD)


def _sliders(humanoid: Humanoid) -> dict[str, Slider]:
    """Return a slider for the torso's height and for every joint, by name."""
    height = float(humanoid.q_nominal[6])
    found = {HEIGHT: Slider("height of the torso m", 0.0, 2.0 * height, STEP, height)}
    for index in humanoid.plant.GetJointIndices():
        joint = humanoid.plant.get_joint(index)
        if joint.num_positions() == 1:
            lower, upper = joint.position_lower_limits()[0], joint.position_upper_limits()[0]
            span = max(float(lower), -FARTHEST), min(float(upper), FARTHEST)
            unit = "m" if joint.type_name() == "prismatic" else "rad"
            words = f"{humanoid.names.name_of(joint)} {unit}".replace("_", " ")
            found[joint.name()] = Slider(words, *span, STEP, 0.0)
    return found


def make_visualizer(humanoid: Humanoid, meshcat: Meshcat, inside: bool = False) -> ModelVisualizer:
    """Return Drake's ModelVisualizer of a robot, finalized, in the nominal posture.

    The torso is kept upright, and there is a slider for its height and for every joint.

    Args:
        humanoid: the robot.
        meshcat: where it is shown; what it showed is removed.
        inside: whether it is see-through, with frames and ellipsoids; else these are hidden.
    """
    m = units_of(humanoid)["m"]
    visualizer = ModelVisualizer(
        meshcat=meshcat,
        visualize_frames=True,
        triad_length=TRIAD_LENGTH * m,
        triad_radius=TRIAD_RADIUS * m,
        publish_contacts=False,
    )
    plant, scene_graph = visualizer.parser().plant(), visualizer.parser().scene_graph()
    humanoid.add_to(plant)
    # The torso moves up and down only; were it welded, Drake would not show its inertia.
    torso, height = humanoid.names_in(plant).frame(humanoid.base.name()), humanoid.q_nominal[6]
    up = PrismaticJoint(HEIGHT, plant.world_frame(), torso, [0.0, 0.0, 1.0], 0.0, 2.0 * height)
    plant.AddJoint(up).set_default_translation(height)
    for index in humanoid.plant.GetJointIndices():
        joint = humanoid.plant.get_joint(index)
        if joint.num_positions() == 1:
            angle = humanoid.q_nominal[joint.position_start()]
            humanoid.names_in(plant).joint(humanoid.names.name_of(joint)).set_default_angle(angle)
    names = points_of_foot(humanoid.sizes["nc"])
    colours = np.repeat(COLOURS, len(names) // 2, axis=0)
    feet = zip(FEET, humanoid.foot_frames, humanoid.contact_points, strict=True)
    for foot, frame, points in feet:
        body, X_BF = (
            humanoid.names_in(plant).body(frame.body().name()),
            frame.GetFixedPoseInBodyFrame(),
        )
        for name, point, colour in zip(names, points, colours, strict=True):
            label = f"{CONTACT_POINT}_{foot}_{name}"
            plant.RegisterVisualGeometry(
                body, RigidTransform(X_BF @ point), Sphere(POINT_RADIUS * m), label, colour
            )
    draw_floor(plant, Scene())
    visualizer.Finalize()
    set_up_view(meshcat, humanoid, camera=(CAMERA, TARGET))
    # Meshcat's own shadows are coarse, and throw stripes onto the floor
    meshcat.SetProperty("/Lights/FillLight/<object>", "castShadow", False)
    _show_inside(plant, scene_graph.model_inspector(), meshcat, inside)
    return visualizer


def show_robot(humanoid: Humanoid, height: int) -> Page:
    """Return a robot in its nominal posture as a page, see `Humanoid.show`."""
    with tempfile.TemporaryDirectory() as folder:
        page = Path(folder, "robot.html")
        with Drawing([*PROGRAM, str(humanoid.description.file), str(page)], page) as drawing:
            drawing.wait()
        return Page(page.name, page.read_text(encoding="utf-8"), height).presented()


def main(description: str, page: str) -> None:
    """Draw it in this process."""
    silence_drake()
    humanoid, meshcat = load_humanoid(description), open_meshcat()
    make_visualizer(humanoid, meshcat).Run(loop_once=True)
    write_file(page, replay_html(meshcat, humanoid.description.name).encode())


def _show_inside(
    plant: MultibodyPlant, shapes: SceneGraphInspector, meshcat: Meshcat, inside: bool
) -> None:
    """Let frames and ellipsoids of the robot be seen through it, or hide them.

    An opacity holds for what is there when the page reads it, so each shape gets its own.
    """
    meshcat.SetProperty(INERTIA, "visible", inside)
    for index in range(1, plant.num_bodies()):  # all but the world
        body = plant.get_body(BodyIndex(index))
        at = f"{plant.GetModelInstanceName(body.model_instance())}/{body.name()}"
        meshcat.SetProperty(f"{ILLUSTRATION}/{at}/_frames", "visible", inside)
        if not inside:
            continue
        opacities = {f"{INERTIA}/InertiaVisualizer/{at}/$inertia({index})": INERTIA_SEEN}
        for shape in plant.GetVisualGeometriesForBody(body):
            name = shapes.GetName(shape).replace("::", "/")
            if CONTACT_POINT not in name:
                opacities[f"{ILLUSTRATION}/{at}/{name}"] = SHAPES_SEEN
        for path, opacity in opacities.items():
            meshcat.SetProperty(path, "modulated_opacity", opacity)


if __name__ == "__main__":
    main(*sys.argv[1:])
