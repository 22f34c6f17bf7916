"""Made-up robots, each described from its URDF alone, against what was put into them."""

import numpy as np
import pytest
from pydrake.multibody.tree import JacobianWrtVariable, MultibodyForces

from drake_linefoot.gait.parameters import GaitParameters
from drake_linefoot.lab.new_robot.analysis import analyse
from drake_linefoot.lab.new_robot.posture import com_in_base, place_feet, under_com
from drake_linefoot.lab.scenario import Scenario
from drake_linefoot.lab.scenario.load import check_limits
from drake_linefoot.resources import models_dir
from drake_linefoot.robot.description import LINE, SIDES, SURFACE, load_description
from drake_linefoot.robot.dynamics import robot_dynamics
from drake_linefoot.robot.leg_inertia import LegInertia
from drake_linefoot.robot.leg_kinematics import forward
from drake_linefoot.robot.legs import read_legs
from drake_linefoot.robot.scaling import scaled
from drake_linefoot.robot.standing import standing_torques
from tests.helpers import made_up_robots as made_up

pytestmark = pytest.mark.slow  # together; files of robots are read in test_other_formats.py
SHIPPED = load_description(models_dir() / "mit_humanoid" / "mit_humanoid.yaml")


def turn_torso(tree):
    made_up.turn_frame(tree, "torso", made_up.TURNED)


def everything(tree):
    for change in (
        made_up.box_feet,
        turn_torso,
        made_up.turn_feet,
        made_up.add_roll,
        made_up.add_waist,
    ):
        change(tree)
    for change in (made_up.shuffle, made_up.drop_transmissions, made_up.lose_meshes):
        change(tree)


ON_LINES = "everything, on lines"
ROBOTS = {
    "as it is": lambda tree: None,
    "short legs": lambda tree: made_up.scale_legs(tree, 0.5),
    "long legs": lambda tree: made_up.scale_legs(tree, 2.0),
    "knees the other way": made_up.turn_knees,
    "y up in the feet": made_up.turn_feet,
    "x to the left in the torso": turn_torso,
    "ankle rolls": made_up.add_roll,
    "a waist": made_up.add_waist,
    "no arms": made_up.drop_arms,
    "no transmissions": made_up.drop_transmissions,
    "no meshes": made_up.lose_meshes,
    "box feet": made_up.box_feet,
    "another order": made_up.shuffle,
    "everything": everything,
    ON_LINES: everything,
}
SAME = [  # whose legs and feet are those of the MIT Humanoid
    *("as it is", "y up in the feet", "x to the left in the torso", "no transmissions"),
    *("no meshes", "another order"),
]
LOCKED = {
    "ankle rolls": {"left_ankle_roll", "right_ankle_roll"},
    "a waist": {"waist_yaw"},
    "everything": {"waist_yaw"},
    ON_LINES: {"left_ankle_roll", "right_ankle_roll", "waist_yaw"},
}
WITH_ROLL = {"everything"}  # whose feet are wide enough to keep it
WIDE = {"box feet", "everything", ON_LINES}


@pytest.fixture(scope="module")
def findings(tmp_path_factory):
    """What is found of each robot."""
    found = {}
    for i, (name, change) in enumerate(ROBOTS.items()):
        tree = made_up.mit()
        change(tree)
        file = made_up.write(tree, tmp_path_factory.mktemp("robot"), f"robot_{i}")
        found[name] = analyse(file, contact=LINE if name == ON_LINES else None)
    return found


@pytest.fixture(params=ROBOTS)
def finding(request, findings):
    return findings[request.param]


@pytest.fixture(params=ROBOTS)
def name(request):
    return request.param


def test_what_is_locked(findings, name):
    assert findings[name].data["lock"].keys() == LOCKED.get(name, set())
    assert set(findings[name].data["lock"].values()) <= {0.0}


def test_legs_arms_and_signs_are_those_of_the_shipped_description(findings, name):
    d = findings[name].humanoid.description
    roll = name in WITH_ROLL
    rolls = [(f"{side}_ankle_roll",) * roll for side in SIDES]
    legs = [foot.leg_joints for foot in SHIPPED.feet]
    assert [foot.leg_joints for foot in d.feet] == [a + b for a, b in zip(legs, rolls, strict=True)]
    assert d.contact == (SURFACE if roll else LINE)
    arms = set() if name == "no arms" else set(SHIPPED.arm_joints)
    assert set(d.arm_joints) == arms
    kept = {*d.actuated_joints}
    mirror = SHIPPED.mirror | {"left_ankle_roll": ("right_ankle_roll", -1.0)}
    assert d.mirror == {left: pair for left, pair in mirror.items() if left in kept}


def test_contact_lines(findings, name):
    share = {"short legs": 0.5, "long legs": 2.0}.get(name, 1.0)
    length, height = (0.2, -0.06) if name in WIDE else (0.15, -0.041)
    for foot in findings[name].data["feet"]:
        heel, toe = np.array(foot["contact_points"])
        assert toe[0] - heel[0] == pytest.approx(share * length, abs=1e-4)
        if name in SAME:
            np.testing.assert_allclose([heel, toe], SHIPPED.feet[0].contact_points, atol=1e-5)
        elif share == 1.0:
            assert heel[2] == pytest.approx(height, abs=1e-5)
    said = [line for line in findings[name].lines if line.startswith("soles")]
    assert ("0.060 m wide" in said[0]) == (name in WIDE)


def test_the_robot_stands_on_flat_soles_with_its_mass_over_their_middles(finding):
    """By the plant, from the description alone."""
    h = finding.humanoid
    context = h.plant.CreateDefaultContext()
    h.plant.SetPositions(context, h.q_nominal)
    com = h.plant.CalcCenterOfMassPositionInWorld(context)
    middles = []
    for frame, foot in zip(h.foot_frames, h.description.feet, strict=True):
        X = frame.CalcPoseInWorld(context)
        points = (X @ foot.ground_points.T).T
        assert abs(points[:, 2]).max() < 1e-4
        assert points[-1, 0] > points[0, 0] + 0.05
        middles.append(points.mean(axis=0))
    assert middles[0][1] > 0.02 and middles[1][1] < -0.02
    np.testing.assert_allclose(com[:2], np.mean(middles, axis=0)[:2], atol=1e-3)
    assert com[2] == pytest.approx(finding.reach.height, abs=1e-3)


def test_knees_bend_as_their_stops_let_them(findings):
    for name, found in findings.items():
        knee = found.data["nominal_posture"]["left_knee"]
        assert np.sign(knee) == (-1.0 if name == "knees the other way" else 1.0)


def test_the_mit_humanoid_gets_its_own_posture_and_limits(findings):
    """Within what was rounded or chosen by hand there, see its README."""
    found = findings["as it is"]
    for name, angle in SHIPPED.nominal_posture.items():
        assert found.data["nominal_posture"][name] == pytest.approx(angle, abs=0.01)
    limits = found.data["limits"]
    for name in ("step_width_max", "com_height_min", "com_height_max"):
        assert limits[name] == pytest.approx(getattr(SHIPPED.limits, name), rel=0.02)
    assert limits["step_length"] == pytest.approx(SHIPPED.limits.step_length, rel=0.1)


def test_other_frames_give_the_same_robot(findings):
    """What differs by frames alone walks the same."""
    plain = findings["as it is"]
    for name in ("y up in the feet", "x to the left in the torso"):
        other = findings[name]
        assert other.data["nominal_posture"] == pytest.approx(plain.data["nominal_posture"])
        assert other.data["limits"] == plain.data["limits"]
        same = [found.humanoid for found in (plain, other)]
        d = [robot_dynamics(h, h.plant.CreateDefaultContext(), moving(h)) for h in same]
        np.testing.assert_allclose(d[1].M, d[0].M, atol=1e-9)
        np.testing.assert_allclose(d[1].J, d[0].J, atol=1e-9)
        np.testing.assert_allclose(d[1].Cv, d[0].Cv, atol=1e-9)


def moving(humanoid):
    """A state in which everything moves, the same for robots with the same joints."""
    random = np.random.default_rng(5)
    q, v = humanoid.q_nominal.copy(), random.normal(size=humanoid.nv)
    q[7:] += random.uniform(-0.2, 0.2, humanoid.nq - 7)
    return np.concatenate([q, v])


def test_leg_chains_are_the_plants(finding):
    """Lines and Jacobians in B, across welds and turned frames."""
    h = finding.humanoid
    q = moving(h)[: h.nq]
    p, R, J = forward(read_legs(h), np.ascontiguousarray(q[h.leg_q][:, None]))
    context = h.plant.CreateDefaultContext()
    h.plant.SetPositions(context, q)
    d = robot_dynamics(h, context, np.concatenate([q, np.zeros(h.nv)]))
    for side, frame in enumerate(h.foot_frames):
        X = frame.CalcPose(context, h.base.body_frame())
        np.testing.assert_allclose(p[side, 0], X @ h.p_FC[side], atol=1e-12)
        np.testing.assert_allclose(R[side, 0], X.rotation().matrix(), atol=1e-12)
        rates = np.random.default_rng(0).normal(size=len(h.leg_v[side]))
        v = np.zeros(h.nv)
        v[h.leg_v[side]] = rates
        np.testing.assert_allclose(d.R_WB @ J[side, 0, :3] @ rates, d.J[side, :3] @ v, atol=1e-12)


def test_inertia_and_momentum_of_the_legs_are_the_plants(finding):
    h = finding.humanoid
    x = moving(h)
    x[:4], x[h.nq : h.nq + 6] = [1.0, 0.0, 0.0, 0.0], 0.0
    x[h.nq + h.arm_v] = 0.0
    d = robot_dynamics(h, h.plant.CreateDefaultContext(), x)
    q, v = x[: h.nq], x[h.nq :]
    angles, rates = (np.ascontiguousarray(a[:, None]) for a in (q[h.leg_q], v[h.leg_v]))
    other = x.copy()  # the same but for the legs
    other[h.leg_q] = h.q_nominal[h.leg_q]
    elsewhere = robot_dynamics(h, h.plant.CreateDefaultContext(), other)
    maps = LegInertia(h, read_legs(h))(elsewhere, angles)
    np.testing.assert_allclose(maps.I_B[0], d.A[:3, :3], atol=1e-10)
    np.testing.assert_allclose(maps.momentum(rates, np.zeros((1, 3)))[0], d.L_G, atol=1e-10)


def test_torques_on_one_leg_are_those_of_inverse_dynamics(finding):
    """Leaning over its left line, the robot needs no force but the ground's to stay."""
    h = finding.humanoid
    context = h.plant.CreateDefaultContext()
    h.plant.SetPositions(context, h.q_nominal)
    over = h.plant.CalcCenterOfMassPositionInWorld(context)
    frame = h.foot_frames[0]
    over = over - frame.CalcPoseInWorld(context) @ h.p_FC[0]
    half = 0.5 * np.arctan2(over[1], over[2])
    q = h.q_nominal.copy()
    q[:4] = np.cos(half), np.sin(half), 0.0, 0.0
    h.plant.SetPositions(context, q)
    force = MultibodyForces(h.plant)
    h.plant.CalcForceElementsContribution(context, force)
    J = h.plant.CalcJacobianTranslationalVelocity(
        context,
        JacobianWrtVariable.kV,
        frame,
        h.p_FC[0],
        h.world,
        h.world,
    )
    weight = np.array([0.0, 0.0, h.mass * 9.81])
    force.mutable_generalized_forces()[:] += J.T @ weight
    tau = h.plant.CalcInverseDynamics(context, np.zeros(h.nv), force)
    assert abs(tau[:6]).max() < 0.02 * h.mass * 9.81 * h.half_length
    expected = tau[h.leg_v[0]]
    np.testing.assert_allclose(standing_torques(h, h.q_nominal)[1][0], expected, atol=1e-9)


def test_limits_of_height_are_reached_and_straight_legs_not_passed(finding):
    h, limits, width = finding.humanoid, finding.data["limits"], finding.reach.width
    q = finding.reach.q
    for height in (limits["com_height_min"], limits["com_height_max"]):
        found, _ = under_com(h, q, height, width)
        h.plant.SetPositions(h.scratch, found)
        com = h.plant.CalcCenterOfMassPositionInWorld(h.scratch)
        for side, frame in enumerate(h.foot_frames):
            X = frame.CalcPose(h.scratch, h.base.body_frame())
            away = [0.0, (0.5, -0.5)[side] * width, -height]
            np.testing.assert_allclose(X @ h.p_FC[side] - com, away, atol=5e-3)
            level = X.rotation().matrix()[2, : 1 if h.half_width == 0.0 else 2]
            assert abs(level).max() < 5e-3  # the line, or the sole
    assert under_com(h, q, 1.01 * finding.reach.straight, width)[1] > 2e-3


# --- what is no part of the robot, and frames that are elsewhere ----------------------------------


def changed(folder, change, *values):
    """What is found of the MIT Humanoid with a change."""
    tree = made_up.mit()
    change(tree, *values)
    return analyse(made_up.write(tree, folder, "changed"))


def same_walker(found, plain):
    """Check that a robot is that one: masses, posture, limits, and dynamics in motion."""
    assert found.humanoid.mass == pytest.approx(plain.humanoid.mass)
    assert found.data["nominal_posture"] == pytest.approx(plain.data["nominal_posture"], abs=2e-4)
    assert found.data["limits"] == pytest.approx(plain.data["limits"], abs=2e-3)
    both = [f.humanoid for f in (found, plain)]
    d = [robot_dynamics(h, h.scratch, h.x_nominal) for h in both]
    np.testing.assert_allclose(d[0].p_WG - d[0].p_WC[0], d[1].p_WG - d[1].p_WC[0], atol=1e-3)
    np.testing.assert_allclose(d[0].A[:3, :3], d[1].A[:3, :3], atol=0.02)
    inertias = [
        LegInertia(h, read_legs(h))(now, h.q_nominal[h.leg_q][:, None])
        for h, now in zip(both, d, strict=True)
    ]
    np.testing.assert_allclose(inertias[0].I_B[0], inertias[1].I_B[0], atol=0.02)


def test_what_is_fixed_to_the_world_is_no_part_of_the_robot(tmp_path, findings):
    found, plain = changed(tmp_path, made_up.add_table), findings["as it is"]
    same_walker(found, plain)
    assert [line for line in found.lines if line.startswith("mass")] == [
        line for line in plain.lines if line.startswith("mass")
    ]
    h = found.humanoid
    x = np.concatenate([h.q_nominal, np.ones(h.nv)])
    h.plant.SetPositionsAndVelocities(h.scratch, x)
    d = robot_dynamics(h, h.scratch, x)
    np.testing.assert_allclose(h.floating.com_velocity(h.scratch), d.v_WG, atol=1e-12)


@pytest.mark.parametrize(
    "place",
    [(0.0, 0.0, -0.7), (0.0, 0.0, -0.35), (0.0, 0.0, -0.15), (0.0, 0.2, 0.0), (0.9, -0.1, 1.5)],
)
def test_where_the_frame_of_the_root_is_changes_nothing(tmp_path, findings, place):
    same_walker(changed(tmp_path, made_up.move_root, *place), findings["as it is"])


def test_legs_under_a_waist_are_found_below_a_chest_with_arms(tmp_path, findings):
    found, plain = changed(tmp_path, made_up.legs_under_waist), findings["as it is"]
    assert set(found.data["lock"]) == {"waist_yaw"}
    assert found.data["feet"] == plain.data["feet"]
    assert found.humanoid.description.arm_joints == plain.humanoid.description.arm_joints
    assert found.humanoid.mass == pytest.approx(plain.humanoid.mass + 1.0)


# --- joints that turn little ----------------------------------------------------------------------


def bounded(folder, kind, lower, upper):
    """What is found of the MIT Humanoid with other limits of a joint."""
    tree = made_up.mit()
    made_up.bound(tree, kind, lower, upper)
    return analyse(made_up.write(tree, folder, "bounded"))


@pytest.mark.parametrize("ankle", [0.35, 0.4, 0.45, 0.5, 0.55])
def test_ankles_that_turn_little_leave_room_for_stance_and_swing(tmp_path, ankle):
    found = bounded(tmp_path, "ankle", -ankle, 0.8)
    h, gait = found.humanoid, scaled(GaitParameters(), found.humanoid)
    check_limits(Scenario(gait=gait), h.description)
    assert gait.swing_height < 0.06 and gait.com_height > 0.95 * found.reach.straight
    step = 0.5 * gait.step_length
    for ahead, up in ((0.6 * step, 0.0), (-0.4 * step, 0.0), (0.0, gait.swing_height)):
        com = com_in_base(h, found.reach.q)
        p = com + np.array([[ahead, y, up - gait.com_height] for y in (0.1, -0.1)])
        assert place_feet(h, found.reach.q, p)[1] < 0.01


def test_a_robot_with_room_stands_and_swings_as_before(findings):
    found = findings["as it is"]
    assert found.reach.room == (1.0, 1.0) and "swing_height_max" not in found.data["limits"]
    assert found.reach.height == pytest.approx(0.93 * found.reach.straight)


def test_joints_that_hardly_turn_are_said(tmp_path):
    found = bounded(tmp_path, "ankle", -0.4, 0.4)
    assert [line for line in found.lines if "shorter steps and lower swings" in line]
