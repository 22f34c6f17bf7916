"""A user's own MJCF: its actuators make way for motors, its locked joints for welds."""

from dataclasses import replace

import numpy as np
import pytest
from pydrake.systems.framework import DiagramBuilder

from drake_linefoot.errors import ModelError, ScenarioError
from drake_linefoot.lab.scenario import Scenario, Segment
from drake_linefoot.lab.scenario.disturbances import ErrorParameters
from drake_linefoot.lab.scenario.schema import MujocoParameters, PlantParameters
from drake_linefoot.lab.simulation.run import simulate
from drake_linefoot.lab.wiring.closed_loop import build_closed_loop
from drake_linefoot.robot.humanoid import load_humanoid
from tests.robot.test_loading import load, without_lists

mujoco = pytest.importorskip("mujoco", reason="MuJoCo is not installed: the extra mujoco")

from drake_linefoot.lab.plants.mujoco import MujocoPlant  # noqa: E402
from drake_linefoot.lab.plants.mujoco_model import make_spec  # noqa: E402

LOCKED = {
    "left_elbow": -0.4,
    "right_elbow": -0.7,
    "left_shoulder_yaw": 0.3,
    "right_shoulder_yaw": 0.2,
}
KEY = '<keyframe><key name="home" qpos="{}"/></keyframe></mujoco>'


def written(folder, humanoid, work=lambda spec: None):
    """A scenario with the MJCF of a robot, as its makers might publish it.

    Joints have servos instead of motors, and there is a keyframe.
    """
    spec = make_spec(humanoid, Scenario())
    spec.option.timestep = 0.004
    for actuator in spec.actuators:
        actuator.set_to_position(kp=300.0)
        actuator.name += "_servo"
    work(spec)
    model = spec.compile()
    text = spec.to_xml().replace("</mujoco>", KEY.format(" ".join(map(str, model.qpos0))))
    file = folder / "scene.xml"
    file.write_text(text, encoding="utf-8")
    plant = PlantParameters(simulator="mujoco", mujoco=MujocoParameters(mjcf=str(file)))
    return Scenario(segments=[Segment("stand", 0.3)], plant=plant)


def step_of(humanoid, scenario):
    return MujocoPlant(DiagramBuilder(), humanoid, scenario, drawn=False).system


def test_its_actuators_are_motors_of_the_description(tmp_path, humanoid):
    scenario = written(tmp_path, humanoid)
    robot = step_of(humanoid, scenario).robot
    assert robot.model.opt.timestep == 0.001
    assert robot.model.nu == humanoid.na and robot.model.nkey == 0
    torque = np.linspace(-500.0, 500.0, humanoid.na)
    robot.put(humanoid.x_nominal)
    robot.data.ctrl[robot.motors] = torque
    mujoco.mj_forward(robot.model, robot.data)
    wanted = np.clip(torque, -humanoid.effort_limits, humanoid.effort_limits)
    np.testing.assert_allclose(robot.data.qfrc_actuator[robot.dofs], wanted)


def test_joints_that_are_locked_are_welded_at_their_angles(tmp_path, humanoid):
    """Masses at random postures are compared when the plant is built."""

    def work(data):
        without_lists(data)
        data["lock"] = LOCKED

    locked = load(tmp_path, work=work)
    robot = step_of(locked, written(tmp_path, humanoid)).robot
    assert robot.model.nv == locked.nv == humanoid.nv - len(LOCKED)
    robot.put(locked.x_nominal)
    mujoco.mj_forward(robot.model, robot.data)
    context = locked.plant.CreateDefaultContext()
    locked.plant.SetPositions(context, locked.q_nominal)
    com = locked.plant.CalcCenterOfMassPositionInWorld(context)
    np.testing.assert_allclose(robot.data.subtree_com[robot.base], com, atol=1e-6)


def test_a_base_that_is_turned_in_its_body_is_found(tmp_path, humanoid, walking_state):
    """Description and model agree on B, which is not the body that floats."""

    def work(data):
        data["floating_base_pose"] = {"rpy": [0.0, 0.02, 0.0], "xyz": [0.01, 0.0, -0.03]}

    turned = load(tmp_path, work=work)
    system = step_of(turned, written(tmp_path, humanoid))
    x = walking_state(turned, 2)
    system.robot.put(x)
    np.testing.assert_allclose(system.robot.taken(), x, atol=1e-12)


def test_another_robot_is_refused_by_name(tmp_path, humanoid):
    def lighter(spec):
        spec.body("left_knee").mass *= 0.9

    def without_rotor(spec):
        spec.joint("right_knee").armature = 0.0

    def without_joint(spec):
        spec.delete(spec.actuators[3])
        spec.joint("left_knee").name = "knee"
        for actuator in spec.actuators:
            if actuator.target == "left_knee":
                actuator.target = "knee"

    with pytest.raises(ModelError, match="the controller's robot weighs 24"):
        step_of(humanoid, written(tmp_path, humanoid, lighter))
    with pytest.raises(ModelError, match="'right_knee': joint has no reflected inertia"):
        step_of(humanoid, written(tmp_path, humanoid, without_rotor))
    with pytest.raises(ScenarioError, match=r"plant.mujoco.mjcf = .*: must have the joint left_kn"):
        step_of(humanoid, written(tmp_path, humanoid, without_joint))


def test_what_is_no_model_is_refused(tmp_path, humanoid):
    scenario = written(tmp_path, humanoid)
    error = replace(scenario, error=ErrorParameters(torso_mass=1.0))
    with pytest.raises(ScenarioError, match=r"error = .*: must change nothing of"):
        step_of(humanoid, error)
    file = tmp_path / "scene.xml"
    file.write_text("<mujoco><worldbody><body><joint/></worldbody></mujoco>", encoding="utf-8")
    with pytest.raises(ScenarioError, match=r"plant.mujoco.mjcf = .*: MuJoCo refuses it: "):
        step_of(humanoid, scenario)
    file.unlink()
    with pytest.raises(ScenarioError, match=r"plant.mujoco.mjcf = .*: MuJoCo refuses it: "):
        step_of(humanoid, scenario)


@pytest.mark.slow
def test_it_walks_as_in_the_model_that_is_made_of_the_description(tmp_path):
    """The file holds fewer digits than the model, so the bits are others."""
    humanoid, segments = load_humanoid("mit_humanoid"), [Segment("walk", 2.0, True, [0.4, 0.0])]
    scenario = replace(written(tmp_path, humanoid), segments=segments)
    run = simulate(build_closed_loop(scenario))
    made = replace(scenario, plant=PlantParameters(simulator="mujoco"))
    other = simulate(build_closed_loop(made))
    assert not run.fell
    np.testing.assert_allclose(run.com[-1], other.com[-1], atol=0.05)
    early = run.time < 0.2
    np.testing.assert_allclose(run.q[early], other.q[early], atol=1e-3)
