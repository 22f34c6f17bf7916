"""A robot described from SDF and MJCF is the one described from URDF."""

import numpy as np
import pytest
from pydrake.geometry import SceneGraph
from pydrake.multibody.plant import MultibodyPlant

from drake_linefoot.lab.new_robot.analysis import analyse
from drake_linefoot.robot.dynamics import robot_dynamics
from tests.helpers import made_up_robots as made_up
from tests.helpers.other_formats import as_mjcf, as_sdf

WRITTEN = {"sdf": as_sdf, "xml": as_mjcf}


@pytest.mark.parametrize("kind", WRITTEN)
def test_another_format_gives_the_same_robot(tmp_path, humanoid, kind):
    file = tmp_path / f"biped.{kind}"
    file.write_text(WRITTEN[kind](made_up.mit()), encoding="utf-8")
    found = analyse(file)
    plain = analyse(made_up.write(made_up.mit(), tmp_path))
    assert found.data["nominal_posture"] == pytest.approx(plain.data["nominal_posture"], abs=2e-5)
    assert found.data["limits"] == plain.data["limits"]
    robot = found.humanoid
    assert set(robot.description.actuated_joints) == set(humanoid.description.actuated_joints)
    names = robot.description.actuated_joints
    order = [names.index(name) for name in humanoid.description.actuated_joints]
    np.testing.assert_allclose(robot.effort_limits[order], humanoid.effort_limits)
    np.testing.assert_allclose(robot.position_lower[order], humanoid.position_lower)
    rows, mine = (
        [*range(6), *humanoid.actuated_v],
        [*range(6), *robot.actuated_v[order]],
    )
    x = humanoid.x_nominal
    y = np.zeros(robot.nq + robot.nv)
    y[:7] = x[:7]
    y[robot.actuated_q[order]] = x[humanoid.actuated_q]
    M = robot_dynamics(humanoid, humanoid.scratch, x).M
    other = robot_dynamics(robot, robot.scratch, y).M
    rotors = np.diag(np.diag(M)[rows] - np.diag(other)[mine])  # the URDF's reflected inertia
    assert np.abs(rotors[:6]).max() < 1e-9
    np.testing.assert_allclose(other[np.ix_(mine, mine)] + rotors, M[np.ix_(rows, rows)], atol=1e-9)


@pytest.mark.parametrize("kind", WRITTEN)
def test_only_heels_and_toes_collide(tmp_path, kind):
    file = tmp_path / f"biped.{kind}"
    file.write_text(WRITTEN[kind](made_up.mit()), encoding="utf-8")
    plant, scene_graph = MultibodyPlant(1e-3), SceneGraph()
    plant.RegisterAsSourceForSceneGraph(scene_graph)
    robot = analyse(file).humanoid
    robot.add_to(plant)
    plant.Finalize()
    feet = {plant.GetBodyByName(foot.frame).index() for foot in robot.description.feet}
    assert plant.num_collision_geometries() == 4
    for index in feet:
        assert len(plant.GetCollisionGeometriesForBody(plant.get_body(index))) == 2


def found_in(folder, kind, text):
    file = folder / f"biped.{kind}"
    file.write_text(text, encoding="utf-8")
    return analyse(file)


@pytest.mark.parametrize("kind", WRITTEN)
def test_joints_that_turn_without_end_are_bounded(tmp_path, kind):
    text = WRITTEN[kind](made_up.mit())
    ends = "<lower>-1</lower><upper>1</upper>" if kind == "sdf" else ' limited="true" range="-1 1"'
    assert text.count(ends) == 2  # of the hips' yaws
    endless = "<lower>-1e16</lower><upper>1e16</upper>" if kind == "sdf" else ""
    h = found_in(tmp_path, kind, text.replace(ends, "", 1).replace(ends, endless)).humanoid
    assert h.position_lower[h.leg_joints[:, 0]] == pytest.approx(-np.pi)
    assert h.position_upper[h.leg_joints[:, 0]] == pytest.approx(np.pi)
    assert "2 joints: continuous, bounded by half a turn either way" in h.notes


MESH = """solid torso
facet normal 0 0 1
outer loop
vertex 0 0 0.3
vertex 0.1 0 0.3
vertex 0 0.1 0.35
endloop
endfacet
facet normal 0 0 -1
outer loop
vertex 0 0 0.3
vertex 0.1 0.1 0.3
vertex 0.1 0 0.35
endloop
endfacet
endsolid torso
"""


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("torso.stl", MESH, None),
        ("torso.stl", "nothing", "1 meshes: cannot be read, left out"),
        ("none.stl", None, "1 drawings and shapes: of meshes that are lost, left out"),
    ],
)
def test_mjcf_with_stl_meshes_is_the_robot_without(tmp_path, name, content, said):
    plain = as_mjcf(made_up.mit())
    if content is not None:
        (tmp_path / "meshes").mkdir()
        (tmp_path / "meshes" / name).write_text(content, encoding="utf-8")
    text = plain.replace("<compiler ", '<compiler meshdir="meshes" ')
    text = text.replace("<worldbody>", f'<asset><mesh name="m" file="{name}"/></asset><worldbody>')
    text = text.replace("<freejoint/>", '<freejoint/><geom type="mesh" mesh="m"/>')
    found = found_in(tmp_path, "xml", text)
    assert said is None or said in found.humanoid.notes
    alone = found_in(tmp_path, "xml", plain)
    assert found.data["nominal_posture"] == alone.data["nominal_posture"]
    assert found.humanoid.mass == pytest.approx(alone.humanoid.mass)


@pytest.mark.parametrize(
    "drawn", ['rgba="255 0 0 1"', 'rgba="red"', 'material="skin"', 'material="none"']
)
def test_drawings_of_mjcf_that_are_wrong_are_left_out(tmp_path, drawn):
    asset = '<asset><texture name="t" file="t.png" type="2d"/><material name="skin" texture="t"/>'
    text = as_mjcf(made_up.mit()).replace("<worldbody>", f"{asset}</asset><worldbody>")
    text = text.replace("<freejoint/>", f'<freejoint/><geom type="sphere" size="0.1" {drawn}/>')
    assert found_in(tmp_path, "xml", text).humanoid.mass > 20.0
