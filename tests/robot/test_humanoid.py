"""The robot: indices and limits against the plant, mirroring, a second robot."""

import numpy as np
import pytest
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import BodyIndex, JointIndex

from drake_linefoot.errors import ModelError
from drake_linefoot.robot.dynamics import robot_dynamics
from drake_linefoot.robot.humanoid import load_humanoid
from tests.helpers.feet import feet_of
from tests.helpers.small_biped import copied

MIRROR = np.diag([1.0, -1.0, 1.0])  # the plane y = 0
AXIAL = np.diag([-1.0, 1.0, -1.0])  # what it does to moments and angular velocities
SEEDS = range(4)


# --- what is read from the model --------------------------------------------------------------


def test_sizes(humanoid):
    assert (humanoid.nq, humanoid.nv, humanoid.na) == (25, 24, 18)
    assert humanoid.mass == pytest.approx(24.86855, abs=1e-9)
    assert humanoid.half_length == pytest.approx(0.075, abs=1e-15)
    np.testing.assert_allclose(humanoid.p_FC, [[0.025, 0.0, -0.041]] * 2, rtol=0, atol=1e-15)


def test_mass_is_the_sum_over_bodies(robot):
    plant = robot.plant
    bodies = [plant.get_body(BodyIndex(i)) for i in range(1, plant.num_bodies())]
    assert robot.mass == pytest.approx(sum(body.default_mass() for body in bodies), rel=1e-14)


def test_indices_find_the_joints_they_name(robot):
    plant, d = robot.plant, robot.description
    groups = [
        (d.actuated_joints, robot.actuated_q, robot.actuated_v),
        (d.feet[0].leg_joints, robot.leg_q[0], robot.leg_v[0]),
        (d.feet[1].leg_joints, robot.leg_q[1], robot.leg_v[1]),
        (d.arm_joints, robot.arm_q, robot.arm_v),
    ]
    context = plant.CreateDefaultContext()
    q, v = np.arange(robot.nq) / 100.0, np.arange(robot.nv) / 10.0
    q[:4] = [1.0, 0.0, 0.0, 0.0]
    plant.SetPositions(context, q)
    plant.SetVelocities(context, v)
    for names, index_q, index_v in groups:
        assert len(names) == len(index_q) == len(index_v)
        for name, i, j in zip(names, index_q, index_v, strict=True):
            joint = plant.GetJointByName(name)
            assert joint.get_angle(context) == q[i]
            assert joint.get_angular_rate(context) == v[j]


def test_torques_reach_the_joints_they_are_named_for(robot):
    """The plant's own actuation matrix says where each actuator acts."""
    B = np.zeros((robot.nv, robot.na))
    B[robot.actuated_v, np.arange(robot.na)] = 1.0
    np.testing.assert_array_equal(robot.plant.MakeActuationMatrix(), B)


def test_limits_are_those_of_the_joints(robot):
    plant = robot.plant
    motors = {
        plant.get_joint_actuator(i).joint().name(): plant.get_joint_actuator(i)
        for i in plant.GetJointActuatorIndices()
    }
    for k, name in enumerate(robot.description.actuated_joints):
        joint = plant.GetJointByName(name)
        assert robot.position_lower[k] == joint.position_lower_limit()
        assert robot.position_upper[k] == joint.position_upper_limit()
        assert robot.velocity_limits[k] == joint.velocity_upper_limit()
        assert robot.velocity_limits[k] == -joint.velocity_lower_limit()
        assert robot.effort_limits[k] == motors[name].effort_limit()
    assert np.all(robot.position_lower < robot.position_upper)
    assert np.all(robot.effort_limits > 0.0)


def test_nominal_posture_stands_on_the_ground(robot):
    q = robot.q_nominal
    context = robot.plant.CreateDefaultContext()
    np.testing.assert_array_equal(robot.x_nominal, np.concatenate([q, np.zeros(robot.nv)]))
    robot.plant.SetPositionsAndVelocities(context, robot.x_nominal)
    points = np.vstack(
        [
            robot.plant.CalcPointsPositions(
                context, frame, foot.contact_points.T, robot.plant.world_frame()
            ).T
            for frame, foot in zip(robot.foot_frames, robot.description.feet, strict=True)
        ]
    )
    np.testing.assert_allclose(points[:, 2], 0.0, rtol=0, atol=1e-12)
    assert points[:2, 1].min() > 0.0 > points[2:, 1].max()  # left is left
    assert points[1, 0] > points[0, 0]  # the toe is in front
    com = robot.plant.CalcCenterOfMassPositionInWorld(context)
    assert points[:, 0].min() < com[0] < points[:, 0].max()
    assert com[1] == pytest.approx(0.0, abs=1e-12)


def test_a_robot_can_be_added_to_another_plant(humanoid):
    plant = MultibodyPlant(1e-3)
    humanoid.add_to(plant)
    plant.Finalize()
    names = [plant.get_joint(JointIndex(i)).name() for i in range(plant.num_joints())]
    assert set(humanoid.description.actuated_joints) < set(names)
    assert plant.GetStateNames() == humanoid.plant.GetStateNames()


# --- mirroring ----------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", SEEDS)
def test_mirroring_twice_changes_nothing(robot, walking_state, seed):
    x = walking_state(robot, seed)
    kept = x.copy()
    np.testing.assert_array_equal(robot.mirror_state(robot.mirror_state(x)), x)
    np.testing.assert_array_equal(x, kept)
    joints = x[robot.actuated_q]
    np.testing.assert_array_equal(robot.mirror_joints(robot.mirror_joints(joints)), joints)
    assert np.abs(robot.mirror_state(x) - x).max() > 0.1


def test_nominal_posture_and_limits_are_symmetric(robot):
    np.testing.assert_array_equal(robot.mirror_state(robot.x_nominal), robot.x_nominal)
    np.testing.assert_array_equal(
        robot.mirror_joints(robot.effort_limits) ** 2, robot.effort_limits**2
    )
    ends = np.array(
        [robot.mirror_joints(robot.position_lower), robot.mirror_joints(robot.position_upper)]
    )
    np.testing.assert_array_equal(ends.min(axis=0), robot.position_lower)
    np.testing.assert_array_equal(ends.max(axis=0), robot.position_upper)


@pytest.mark.parametrize("seed", SEEDS)
def test_a_mirrored_state_is_the_mirror_image(robot, walking_state, seed):
    """Feet, CoM, momenta and energy of the mirrored state, each from the plant."""
    plant, context = robot.plant, robot.plant.CreateDefaultContext()
    x = walking_state(robot, seed)
    plain = robot_dynamics(robot, context, x)
    plant.SetPositionsAndVelocities(context, x)
    kinetic = plant.CalcKineticEnergy(context)
    potential = plant.CalcPotentialEnergy(context)
    mirrored = robot_dynamics(robot, context, robot.mirror_state(x))
    plant.SetPositionsAndVelocities(context, robot.mirror_state(x))
    assert plant.CalcKineticEnergy(context) == pytest.approx(kinetic, rel=1e-12)
    assert plant.CalcPotentialEnergy(context) == pytest.approx(potential, rel=1e-12)
    near = {"rtol": 0, "atol": 1e-11}
    np.testing.assert_allclose(mirrored.R_WB, MIRROR @ plain.R_WB @ MIRROR, **near)
    np.testing.assert_allclose(mirrored.p_WG, MIRROR @ plain.p_WG, **near)
    np.testing.assert_allclose(mirrored.v_WG, MIRROR @ plain.v_WG, **near)
    np.testing.assert_allclose(mirrored.L_G, AXIAL @ plain.L_G, **near)
    for foot, other in zip(feet_of(mirrored), feet_of(plain)[::-1], strict=True):
        np.testing.assert_allclose(foot.p_WC, MIRROR @ other.p_WC, **near)
        np.testing.assert_allclose(foot.v_WC, MIRROR @ other.v_WC, **near)
        np.testing.assert_allclose(foot.w_WF, AXIAL @ other.w_WF, **near)
        np.testing.assert_allclose(foot.R_WC, MIRROR @ other.R_WC @ MIRROR, **near)


@pytest.mark.parametrize("seed", SEEDS)
def test_the_mass_matrix_mirrors(robot, walking_state, seed):
    """M(mirrored q) = T' M(q) T, with T the mirroring of velocities."""
    context = robot.plant.CreateDefaultContext()
    x = walking_state(robot, seed)
    zero = np.zeros(robot.nv)
    T = np.array(
        [
            robot.mirror_state(np.concatenate([x[: robot.nq], zero + row]))[robot.nq :]
            for row in np.eye(robot.nv)
        ]
    ).T
    np.testing.assert_array_equal(T @ T, np.eye(robot.nv))
    M = robot_dynamics(robot, context, x).M
    mirrored = robot_dynamics(robot, context, robot.mirror_state(x)).M
    np.testing.assert_allclose(mirrored, T.T @ M @ T, rtol=0, atol=1e-12)


# --- a second robot -----------------------------------------------------------------------------


def test_the_second_robot_is_what_its_files_say(small_biped):
    arms = small_biped.na == 14
    assert small_biped.mass == pytest.approx(20.0 if arms else 16.0)
    assert small_biped.half_length == pytest.approx(0.07)
    assert small_biped.leg_v.shape == (2, 5)
    assert len(small_biped.arm_v) == (4 if arms else 0)
    # Its motors are not in the order of its velocities.
    assert np.any(np.diff(small_biped.actuated_v) < 0)


def test_errors_of_the_second_robot_name_its_file(small_biped_files, tmp_path):
    source = copied(small_biped_files["small biped"], tmp_path / "copied")
    file = source.with_name("changed.yaml")
    file.write_text(source.read_text().replace("ankle_R_link", "ankle_X_link"))
    with pytest.raises(ModelError, match=r"changed\.yaml: feet\[1\]\.frame = 'ankle_X_link'"):
        load_humanoid(file)


def test_a_base_that_is_welded_is_refused(small_biped_files, tmp_path):
    source = copied(small_biped_files["small biped"], tmp_path / "copied")
    world = '<link name="world"/><joint name="weld" type="fixed"><parent link="world"/>'
    urdf = source.with_name("small.urdf").read_text()
    welded = urdf.replace("</robot>", world + '<child link="pelvis"/></joint></robot>')
    source.with_name("welded.urdf").write_text(welded)
    file = source.with_name("welded.yaml")
    file.write_text(source.read_text().replace("small.urdf", "welded.urdf"))
    with pytest.raises(ModelError, match="floating_base = 'pelvis': is not a floating body"):
        load_humanoid(file)
