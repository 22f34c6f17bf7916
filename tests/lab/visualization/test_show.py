"""The robot to look at: where it stands, what is drawn, which sliders there are."""

import numpy as np
import pytest
from pydrake.geometry import Meshcat, MeshcatParams

from drake_linefoot.axes import CORNERS
from drake_linefoot.lab.visualization.show import HEIGHT, make_visualizer
from drake_linefoot.lab.visualization.show import show as show_robot
from drake_linefoot.robot.humanoid import load_humanoid
from tests.helpers.driven import fake_live
from tests.helpers.walk_on_soles import robot_on_soles


@pytest.fixture(scope="module")
def meshcat():
    return Meshcat(MeshcatParams(host="localhost", show_stats_plot=False))


def show(humanoid, meshcat):
    """Show a robot; return its scene as the page gets it, and the names of the sliders."""
    visualizer = make_visualizer(humanoid, meshcat)
    visualizer.Run(loop_once=True)
    return visualizer, meshcat.GetSliderNames()


def joints_of(humanoid):
    joints = map(humanoid.plant.get_joint, humanoid.plant.GetJointIndices())
    return {j.name(): j.position_start() for j in joints if j.num_positions() == 1}


def test_there_is_a_slider_for_every_joint_at_its_nominal_angle(humanoid, meshcat):
    _, sliders = show(humanoid, meshcat)
    joints = joints_of(humanoid)
    assert {*joints, HEIGHT} <= set(sliders)
    assert not any("qw" in name or "_q" in name for name in sliders)
    for name, at in joints.items():
        assert meshcat.GetSliderValue(name) == pytest.approx(humanoid.q_nominal[at], abs=0.02)
    assert meshcat.GetSliderValue(HEIGHT) == pytest.approx(humanoid.q_nominal[6], abs=0.02)


def test_contact_points_frames_and_every_inertia_are_drawn(humanoid, meshcat):
    show(humanoid, meshcat)
    feet = [foot.frame for foot in humanoid.description.feet]
    for side, frame in zip(("left", "right"), feet, strict=True):
        for end in ("heel", "toe"):
            at = f"/drake/illustration/mit_humanoid/{frame}/mit_humanoid"
            assert meshcat.HasPath(f"{at}/contact_point_{side}_{end}")
    plant = humanoid.plant
    links = [plant.get_body(i).name() for i in plant.GetBodyIndices(humanoid.base.model_instance())]
    for link in links:
        assert meshcat.HasPath(f"/drake/inertia/InertiaVisualizer/mit_humanoid/{link}"), link
        assert meshcat.HasPath(f"/drake/illustration/mit_humanoid/{link}/_frames"), link


def test_it_opens_plain_and_is_seen_through_when_asked_for(humanoid, meshcat):
    for inside in (False, True):
        make_visualizer(humanoid, meshcat, inside)
        hidden = meshcat._GetPackedProperty("/drake/inertia", "visible")
        assert (b"\xc3" in hidden) == inside  # true in msgpack


def test_feet_are_on_the_ground(humanoid, meshcat):
    visualizer, _ = show(humanoid, meshcat)
    plant = visualizer._diagram.plant()
    context = plant.GetMyContextFromRoot(visualizer._context)
    for foot in humanoid.description.feet:
        X_WF = plant.GetFrameByName(foot.frame).CalcPoseInWorld(context)
        heights = X_WF.multiply(np.asarray(foot.contact_points).T)[2]
        np.testing.assert_allclose(heights, 0.0, atol=0.0055)  # half a step of the slider


def test_another_robot_is_shown_too(small_biped_files, meshcat):
    small = load_humanoid(next(iter(small_biped_files.values())))
    _, sliders = show(small, meshcat)
    assert {*joints_of(small), HEIGHT} <= set(sliders)


def test_the_corners_of_soles_are_drawn(meshcat):
    robot, _ = robot_on_soles()
    show(robot, meshcat)
    model = robot.plant.GetModelInstanceName(robot.names.root)
    for side, foot in zip(("left", "right"), robot.description.feet, strict=True):
        for corner in CORNERS:
            at = f"/drake/illustration/{model}/{foot.frame}/{model}"
            assert meshcat.HasPath(f"{at}/contact_point_{side}_{corner}")


def test_a_page_moves_its_joints_within_their_limits_and_ends_it(humanoid, meshcat, tmp_path):
    page, seen = fake_live(meshcat, tmp_path), []
    orders = [[{"set": ["left_knee", 1.2]}, {"set": ["right_knee", -9.0]}]]
    orders += [[{"press": "inside"}], [{"press": "quit"}]]

    def keep(kind, content):
        seen.append((content, meshcat.GetSliderValue("left_knee")))

    page.link.orders, page.link.show = lambda: orders.pop(0), keep
    show_robot(humanoid, page)
    (setup, _), (first, knee), (second, still) = seen
    assert {slider["name"] for slider in setup["sliders"]} == {*joints_of(humanoid), HEIGHT}
    assert setup["legend"] == []  # there is no run
    lower = humanoid.plant.GetJointByName("right_knee").position_lower_limits()[0]
    assert first["values"]["left_knee"] == knee == still == pytest.approx(1.2)
    assert first["values"]["right_knee"] == pytest.approx(max(lower, -9.0))
    assert (first["on"], second["on"]) == ([], ["inside"])
