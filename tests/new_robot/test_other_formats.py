"""A robot described from SDF and MJCF is the one described from URDF."""

import numpy as np
import pytest
from pydrake.geometry import SceneGraph
from pydrake.multibody.plant import MultibodyPlant

from drake_linefoot.new_robot.analysis import analyse
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
