"""MuJoCo as the plant: the same robot as Drake's, in a step, on its ground, and in a walk."""

import importlib.util
from dataclasses import replace

import numpy as np
import pytest
from pydrake.geometry import Meshcat
from pydrake.multibody.tree import MultibodyForces
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from scipy.spatial.transform import Rotation

from drake_linefoot.constants import GRAVITY
from drake_linefoot.errors import MissingPackageError, ModelError, ScenarioError
from drake_linefoot.lab.plants.scene import apply_error
from drake_linefoot.lab.scenario import Scenario, Segment
from drake_linefoot.lab.scenario.disturbances import (
    ErrorParameters,
    GroundParameters,
    PushParameters,
)
from drake_linefoot.lab.scenario.load import load_scenario
from drake_linefoot.lab.scenario.schema import MujocoParameters, PlantParameters
from drake_linefoot.lab.simulation.run import fall_of, simulate
from drake_linefoot.lab.wiring import closed_loop
from drake_linefoot.lab.wiring.closed_loop import build_closed_loop
from drake_linefoot.math.rotation import from_quaternion
from drake_linefoot.robot.scaling import scaled
from drake_linefoot.wbc.control import WholeBodyControl

mujoco = pytest.importorskip("mujoco", reason="MuJoCo is not installed: the extra mujoco")

from drake_linefoot.lab.plants.mujoco import MujocoPlant  # noqa: E402
from drake_linefoot.lab.plants.mujoco_robot import check_same_robot  # noqa: E402
from drake_linefoot.lab.plants.mujoco_step import MujocoStep  # noqa: E402

MUJOCO = PlantParameters(simulator="mujoco")
STAND = Scenario(segments=[Segment("stand", 0.3)], plant=MUJOCO)


def made(humanoid, scenario=STAND):
    """The plant, in a diagram of its own, and MuJoCo's robot in it."""
    plant = MujocoPlant(DiagramBuilder(), humanoid, scaled(scenario, humanoid), drawn=False)
    return plant, plant.system.robot


def test_the_mass_matrix_is_drakes(robot, walking_state):
    _, theirs = made(robot)
    context = robot.plant.CreateDefaultContext()
    for seed in range(5):
        x = walking_state(robot, seed)
        robot.plant.SetPositionsAndVelocities(context, x)
        wanted = robot.plant.CalcMassMatrix(context)
        np.testing.assert_allclose(theirs.mass_matrix(x), wanted, atol=1e-9 * np.abs(wanted).max())


def test_a_state_goes_there_and_back(robot, walking_state):
    _, theirs = made(robot)
    x = walking_state(robot, 3)
    theirs.put(x)
    np.testing.assert_allclose(theirs.taken(), x, atol=1e-12)


def accelerations_in_drake(humanoid, x, torque):
    """What Drake's equations of motion say, shape (nv,)."""
    plant, context = humanoid.plant, humanoid.plant.CreateDefaultContext()
    plant.SetPositionsAndVelocities(context, x)
    forces = MultibodyForces(plant)
    plant.CalcForceElementsContribution(context, forces)  # weight and damping
    total = -plant.CalcInverseDynamics(context, np.zeros(humanoid.nv), forces)
    total[humanoid.actuated_v] += torque
    return np.linalg.solve(plant.CalcMassMatrix(context), total)


def test_in_the_air_it_accelerates_as_in_drake(robot, walking_state):
    """Weight, Coriolis forces, damping, torques, all velocities: over a millionth of a second."""
    _, theirs = made(robot)
    h = theirs.model.opt.timestep = 1e-7
    x = walking_state(robot, 4, speed=0.5)
    x[6] += 3.0
    torque = 0.3 * robot.effort_limits * np.random.default_rng(0).uniform(-1, 1, robot.na)
    mujoco.mj_resetData(theirs.model, theirs.data)
    theirs.put(x)
    theirs.data.ctrl[theirs.motors] = torque
    before = theirs.taken()
    mujoco.mj_step(theirs.model, theirs.data)
    rate = (theirs.taken() - before)[robot.nq :] / h
    wanted = accelerations_in_drake(robot, x, torque)
    np.testing.assert_allclose(rate, wanted, rtol=1e-4, atol=1e-4 * np.abs(wanted).max())


@pytest.mark.parametrize(
    "error",
    [
        ErrorParameters(torso_mass=2.0, torso_com=[0.02, 0.0, 0.01]),
        ErrorParameters(leg_mass_scale=1.1),
        ErrorParameters(joint_damping=0.2),
    ],
    ids=["torso", "legs", "damping"],
)
def test_a_model_error_is_that_of_drakes_plant(humanoid, error, walking_state):
    _, theirs = made(humanoid, replace(STAND, error=error))
    context = humanoid.plant.CreateDefaultContext()
    apply_error(humanoid.plant, context, humanoid, error)
    x = walking_state(humanoid, 1)
    humanoid.plant.SetPositionsAndVelocities(context, x)
    wanted = humanoid.plant.CalcMassMatrix(context)
    np.testing.assert_allclose(theirs.mass_matrix(x), wanted, atol=1e-9 * np.abs(wanted).max())
    damping = [
        humanoid.names.joint(name).default_damping_vector()[0] + error.joint_damping
        for name in humanoid.description.actuated_joints
    ]
    np.testing.assert_allclose(theirs.model.dof_damping[theirs.dofs], damping)


def test_a_torso_without_mass_is_refused(humanoid):
    with pytest.raises(ScenarioError, match=r"error.torso_mass = .*: must be above"):
        made(humanoid, replace(STAND, error=ErrorParameters(torso_mass=-100.0)))


def test_a_robot_that_differs_is_refused_by_name(humanoid):
    def refused(change, words):
        _, theirs = made(humanoid)
        change(theirs.model)
        with pytest.raises(ModelError, match=words):
            check_same_robot(theirs, humanoid.plant.CreateDefaultContext())

    def no_rotors(model):
        model.dof_armature[:] = 0.0

    def one_rotor(model):
        model.dof_armature[model.jnt_dofadr[model.joint("left_knee").id]] = 0.0

    def heavier(model):
        model.body_mass[model.jnt_bodyid[model.joint("left_knee").id]] += 0.2

    def other_link(model):
        model.body_inertia[model.jnt_bodyid[model.joint("right_knee").id]] *= 1.5

    refused(no_rotors, "no reflected inertia")
    refused(one_rotor, "'left_knee': joint has no reflected inertia")
    refused(heavier, r"kg in MuJoCo': the controller's robot weighs 24")
    refused(other_link, "'right_knee': joint moves a link of another inertia")


def test_at_rest_the_imu_feels_its_weight_and_the_feet_bear_it(humanoid):
    loop = build_closed_loop(STAND)
    run = simulate(loop)
    assert not run.fell
    weight = -humanoid.mass * GRAVITY[2]
    late = run.time > 0.2
    assert run.true_force[late, :, 2].sum(axis=1).mean() == pytest.approx(weight, rel=0.03)
    np.testing.assert_allclose(
        run.true_normal[late].sum(axis=2), run.true_force[late][..., 2], rtol=1e-12
    )


def test_the_imu_feels_what_the_base_does(humanoid, walking_state):
    """Over one step in the air, where the base accelerates as Drake says."""
    plant, _ = made(humanoid)
    context = plant.system.CreateDefaultContext()
    x = walking_state(humanoid, 6, speed=0.3)
    x[6] += 3.0
    plant.system.put(context, x)
    torque = np.zeros(humanoid.na)
    plant.system.GetInputPort("actuation").FixValue(context, torque)
    simulator = Simulator(plant.system, context)
    simulator.AdvanceTo(1e-3)
    simulator.AdvancePendingEvents()
    after = plant.system.GetOutputPort("state").Eval(context)
    gyro = plant.system.GetOutputPort("angular_velocity").Eval(context)
    R = from_quaternion(after[:4])
    np.testing.assert_allclose(gyro, R.T @ after[humanoid.nq : humanoid.nq + 3], atol=1e-12)
    felt = plant.system.GetOutputPort("specific_force").Eval(context)
    wanted = accelerations_in_drake(humanoid, x, torque)[3:6] - GRAVITY
    assert np.linalg.norm(R @ felt - wanted) < 0.05 * np.linalg.norm(wanted)


def test_momentum_changes_by_the_impulses_of_push_contact_and_weight(humanoid):
    """Of the whole robot, to a hundredth of the push's 4 N s."""
    pushes = [PushParameters(time=0.3, impulse=4.0, direction=0.7)]
    segments = [Segment("stand", 0.2), Segment("walk", 0.4, True, [0.1, 0.0])]
    run = simulate(build_closed_loop(Scenario(segments=segments, pushes=pushes, plant=MUJOCO)))
    assert not run.fell
    context, momentum = humanoid.plant.CreateDefaultContext(), []
    for q, v in zip(run.q, run.v, strict=True):
        humanoid.plant.SetPositionsAndVelocities(context, np.concatenate([q, v]))
        velocity = humanoid.plant.CalcCenterOfMassTranslationalVelocityInWorld(context)
        momentum.append(humanoid.mass * velocity)
    # the contact forces of a sample belong to the step that ended there
    forces = run.true_force[1:].sum(axis=1) + run.push[:-1] + humanoid.mass * GRAVITY
    begin, end = 250, 450
    change = momentum[end] - momentum[begin]
    np.testing.assert_allclose(1e-3 * forces[begin:end].sum(axis=0), change, atol=0.04)


def test_a_push_acts_at_the_torsos_centre_of_mass(humanoid):
    """There is no torque about it."""
    plant, theirs = made(humanoid)
    x = humanoid.x_nominal
    wrench = plant.system.wrench(x, np.array([0.0, 40.0, 0.0]))
    X_BT = humanoid.torso.body_frame().CalcPose(humanoid.scratch, humanoid.base.body_frame())
    at = X_BT @ humanoid.torso.default_com() + x[4:7]
    about = wrench[3:] + np.cross(theirs.data.xipos[theirs.base] - at, wrench[:3])
    np.testing.assert_allclose(about, 0.0, atol=1e-9)


def test_a_run_goes_on_from_its_context_with_the_same_bits():
    scenario = Scenario(segments=[Segment("walk", 1.0, True, [0.4, 0.0])], plant=MUJOCO)
    loop = build_closed_loop(scenario)
    simulator = loop.make_simulator()
    simulator.AdvanceTo(0.4)
    context = simulator.get_mutable_context()
    before = context.Clone()

    def walked():
        simulator.AdvanceTo(0.6)
        return loop.plant.state(context)

    first = walked()
    context.SetTimeStateAndParametersFrom(before)
    simulator.Initialize()
    np.testing.assert_array_equal(walked(), first)
    other = build_closed_loop(scenario)
    simulator = other.make_simulator()
    simulator.AdvanceTo(0.6)
    np.testing.assert_array_equal(other.plant.state(simulator.get_context()), first)


@pytest.mark.parametrize("cone", ["elliptic", "pyramidal"])
def test_it_stands_on_tiles(cone):
    """Which are boxes: its feet are at their tops, and hardly slip."""
    plant = replace(MUJOCO, mujoco=MujocoParameters(cone=cone))
    ground = GroundParameters(step_height=0.01, friction=0.5)
    loop = build_closed_loop(replace(STAND, plant=plant, ground=ground))
    run = simulate(loop)
    assert not run.fell
    points = run.contact_points[-1].reshape(-1, 3)
    heights = loop.ground.height(*points[:, :2].T)
    np.testing.assert_allclose(points[:, 2], heights, atol=1e-3)
    assert (run.true_normal[-1] > 0.0).all()
    assert run.slip_speed[-100:].max() < 0.02


@pytest.mark.parametrize("cone", ["elliptic", "pyramidal"])
def test_speed_of_slip_is_that_of_the_foot(humanoid, cone):
    """A robot that is put down while it moves: its feet slip as fast as their points move."""
    plant = replace(MUJOCO, mujoco=MujocoParameters(cone=cone))
    _, theirs = made(humanoid, replace(STAND, plant=plant))
    x = humanoid.x_nominal
    system = MujocoStep(theirs, x)
    context = system.CreateDefaultContext()
    x[6] -= 1e-4
    x[humanoid.nq + 3 : humanoid.nq + 6] = 0.3, -0.2, 0.0
    system.put(context, x)
    system.GetInputPort("actuation").FixValue(context, np.zeros(humanoid.na))
    simulator = Simulator(system, context)
    simulator.Initialize()
    simulator.AdvancePendingEvents()
    rows = system.GetOutputPort("contacts").Eval(context).reshape(-1, 8)
    rows = rows[rows[:, 0] != 0.0]
    assert sorted(rows[:, 0]) == [1.0, 1.0, 2.0, 2.0]
    np.testing.assert_allclose(rows[:, 7], np.hypot(0.3, 0.2), rtol=1e-9)
    assert (rows[:, 3] > 0.0).all()  # upwards
    sliding = np.linalg.norm(rows[:, 1:3], axis=1) / rows[:, 3]
    np.testing.assert_allclose(sliding, 0.8, rtol=0.3)
    assert (rows[:, 1:3] @ [0.3, -0.2] < 0.0).all()  # backwards


@pytest.mark.parametrize("cone", ["elliptic", "pyramidal"])
def test_contact_forces_are_what_mujoco_says_of_each(humanoid, cone):
    """Of a robot that slides to the side, without a torque in its joints."""
    plant = replace(MUJOCO, mujoco=MujocoParameters(cone=cone))
    _, robot = made(humanoid, replace(STAND, plant=plant))
    x, data = humanoid.x_nominal, robot.data
    x[6], x[humanoid.nq + 4] = x[6] - 1e-4, 0.5
    system, seen = MujocoStep(robot, x), 0
    simulator = Simulator(system)
    context = simulator.get_mutable_context()
    system.GetInputPort("actuation").FixValue(context, np.zeros(humanoid.na))
    for tick in range(1, 21):
        simulator.AdvanceTo(0.001 * tick)
        rows = system.GetOutputPort("contacts").Eval(context).reshape(-1, 8)
        wanted, force = [], np.empty(6)
        for k in range(data.ncon):
            mujoco.mj_contactForce(robot.model, data, k, force)
            axes = data.contact.frame[k].reshape(3, 3)
            wanted.append([*(force[:3] @ axes), *data.contact.pos[k]])
        seen += len(wanted)
        found = rows[rows[:, 0] != 0.0, 1:7].ravel()
        np.testing.assert_allclose(found, np.ravel(wanted), rtol=1e-9, atol=1e-9)
    assert seen > 40


def test_a_torque_that_is_not_finite_is_a_fall(monkeypatch):
    calls, compute = [], WholeBodyControl.compute

    def spoilt(self, *args):
        calls.append(1)
        report = compute(self, *args)
        return report * np.nan if len(calls) == 50 else report

    monkeypatch.setattr(WholeBodyControl, "compute", spoilt)
    run = simulate(build_closed_loop(STAND))
    assert run.fell and run.fall_reason == "torque not finite"


def test_a_step_that_diverges_is_a_fall_and_leaves_no_file(humanoid, monkeypatch, tmp_path):
    """MuJoCo by itself puts the robot back to where its model has it, and writes a log."""
    monkeypatch.chdir(tmp_path)
    robot = made(humanoid)[1]
    step, x = MujocoStep(robot, humanoid.x_nominal), humanoid.x_nominal.copy()
    x[humanoid.nq + 3] = 1e12  # [m/s]
    simulator = Simulator(step)
    context = simulator.get_mutable_context()
    step.get_input_port(0).FixValue(context, np.zeros(humanoid.na))
    for state in (x, humanoid.x_nominal):
        step.put(context, state)
        if state is not x:
            simulator.AdvanceTo(0.01)  # it goes on from a state that is one
            continue
        with pytest.warns(RuntimeWarning, match="MuJoCo: Nan, Inf or huge value") as said:
            with pytest.raises(RuntimeError) as error:
                simulator.AdvanceTo(0.001)
        assert "did not converge" in fall_of(error.value)
    assert "\n" not in str(said[0].message)
    assert not list(tmp_path.iterdir())


def test_without_mujoco_it_says_what_to_install(monkeypatch):
    found = importlib.util.find_spec
    monkeypatch.setattr(
        closed_loop, "find_spec", lambda name: None if name == "mujoco" else found(name)
    )
    with pytest.raises(MissingPackageError, match=r"pip install 'drake_linefoot\[mujoco\]'"):
        build_closed_loop(STAND)


def test_a_simulator_that_there_is_not_is_refused():
    with pytest.raises(ScenarioError, match=r"plant.simulator = 'bullet': must be one of"):
        load_scenario("walk", {"plant.simulator": "bullet"})


@pytest.mark.slow
@pytest.mark.parametrize("period", [0.001, 0.002])
def test_it_walks_in_mujoco(period):
    segments = [Segment("stand", 0.3), Segment("walk", 4.0, True, [0.6, 0.0], 0.2)]
    plant = replace(MUJOCO, time_step=period)
    run = simulate(build_closed_loop(Scenario(segments=segments, plant=plant)))
    assert not run.fell, run.fall_reason
    assert Rotation.from_quat(run.q[-1, :4], scalar_first=True).as_rotvec()[2] > 0.5
    assert run.com[-1, :2] @ [1.0, 0.0] > 1.2


@pytest.mark.slow
def test_it_walks_on_an_estimate_in_mujoco():
    segments = [Segment("stand", 0.5), Segment("walk", 2.5, True, [0.4, 0.0])]
    run = simulate(build_closed_loop(Scenario(segments=segments, plant=MUJOCO, estimation=True)))
    assert not run.fell, run.fall_reason
    assert run.com[-1, 0] > 0.5


def test_it_is_drawn_where_it_is():
    """The pose that Drake's scene graph has of the torso is that of MuJoCo's robot."""
    loop = build_closed_loop(replace(STAND, ground=GroundParameters(slope=0.05)), Meshcat())
    simulator = loop.make_simulator()
    x = loop.plant.state(simulator.get_context())
    x[:7] = [
        *np.array([0.9, 0.1, -0.2, 0.3]) / np.linalg.norm([0.9, 0.1, -0.2, 0.3]),
        1.0,
        2.0,
        3.0,
    ]
    loop.plant.place(simulator.get_mutable_context(), x)
    graph = loop.plant.scene_graph
    query = graph.get_query_output_port().Eval(graph.GetMyContextFromRoot(simulator.get_context()))
    inspector, poses = graph.model_inspector(), {}
    for geometry in inspector.GetAllGeometryIds():
        frame = inspector.GetFrameId(geometry)
        poses[inspector.GetName(frame).rpartition("::")[2]] = query.GetPoseInWorld(frame)
    X_WB = poses[loop.humanoid.description.floating_base]
    np.testing.assert_allclose(X_WB.translation(), x[4:7], atol=1e-12)
    np.testing.assert_allclose(X_WB.rotation().matrix(), from_quaternion(x[:4]), atol=1e-12)
    simulator.AdvanceTo(0.002)
