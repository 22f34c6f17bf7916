"""Arms that swing with the feet: which joints do, how far, and that the MPC counts with it."""

import numpy as np
import pytest

from drake_linefoot import Scenario, Segment, build_closed_loop, simulate
from drake_linefoot.gait.arms import arm_motion
from drake_linefoot.gait.parameters import GaitParameters
from drake_linefoot.gait.schedule import feet_motion
from drake_linefoot.mpc.parameters import MpcParameters
from drake_linefoot.mpc.reference import ReferenceGenerator
from drake_linefoot.robot.arms import arm_turns
from drake_linefoot.robot.humanoid import load_humanoid
from tests.helpers.walking import dynamics_of, recorded_walk

SWING = 0.5  # [rad/m]


def test_the_arm_goes_ahead_with_the_foot_of_the_other_side(humanoid):
    """By Drake: where the forearm is after its shoulder has turned a little."""
    plant, turns = humanoid.plant, arm_turns(humanoid)
    context = plant.CreateDefaultContext()
    names = [humanoid.description.actuated_joints[i] for i in humanoid.arm_joints]
    assert [n for n, turn in zip(names, turns, strict=True) if turn] == [
        "left_shoulder_pitch",
        "right_shoulder_pitch",
    ]
    for side, goes in (("left", 1.0), ("right", -1.0)):
        elbow = humanoid.names.joint(f"{side}_elbow").child_body()
        places = []
        for angle in (0.0, 0.1):
            q = humanoid.q_nominal.copy()
            q[humanoid.arm_q] += angle * turns
            plant.SetPositions(context, q)
            places.append(elbow.EvalPoseInWorld(context).translation()[0])
        assert goes * (places[1] - places[0]) > 0.005


def test_a_robot_without_arms_swings_none(sole_biped):
    assert arm_turns(sole_biped).size == 0


def test_the_angle_is_a_share_of_how_far_one_foot_is_ahead():
    """Of a swing that is moved along, by central differences of its place; feet may be far away."""
    h, yaw = 1e-4, 2.0
    ahead, left = np.array([np.cos(yaw), np.sin(yaw)]), np.array([-np.sin(yaw), np.cos(yaw)])
    feet = np.zeros((2, 4))
    feet[0, :2] = [100.0, -50.0] + 0.1 * left

    def at(t):
        targets = np.zeros((2, 6, 3))
        way, rate = 0.3 * np.sin(3.0 * t) - 0.1, 0.9 * np.cos(3.0 * t)
        targets[1, 0, :2] = feet[0, :2] - 0.2 * left + way * ahead
        targets[1, 1, :2], targets[1, 2, :2] = rate * ahead, -2.7 * np.sin(3.0 * t) * ahead
        return arm_motion(SWING, np.array([1.0, 0.0]), feet, targets, yaw)

    before, now, after = at(0.2 - h), at(0.2), at(0.2 + h)
    assert now[0] == pytest.approx(SWING * (0.3 * np.sin(0.6) - 0.1))
    assert now[1] == pytest.approx((after[0] - before[0]) / (2 * h), rel=1e-5)
    assert now[2] == pytest.approx((after[1] - before[1]) / (2 * h), rel=1e-5)
    feet[1, :2] = feet[0, :2] - 0.2 * left
    both = arm_motion(SWING, np.ones(2), feet, np.full((2, 6, 3), 9.0), yaw)
    np.testing.assert_allclose(both, 0.0, atol=1e-12)


@pytest.mark.parametrize("model", ["ecd", "contact_consistent"])
def test_the_reference_has_the_momentum_of_the_arms(humanoid, model):
    """What Drake says that they add when the shoulders turn as the planned feet have them do."""
    ticks = [r for r in recorded_walk().mpc if r.horizon.contact[0].min() == 0.0][5::12]
    generator = ReferenceGenerator(humanoid, MpcParameters(model=model))
    plant, turns, most = humanoid.plant, arm_turns(humanoid), 0.0
    context = plant.CreateDefaultContext()
    for tick in ticks:
        d = dynamics_of(tick.x)
        held, swung = (
            generator.generate(tick.horizon._replace(arm_swing=swing), d) for swing in (0.0, SWING)
        )
        for k in range(8):
            h, moved = 1e-5, []
            at = 0.5 * (held.times[k] + held.times[k + 1])
            for t in (at - h, at + h):
                p = [line_at(tick.horizon, side, t) for side in range(2)]
                moved.append((p[1] - p[0]) @ held.R_mid[k, :2, 0])
            v = np.zeros(humanoid.nv)
            v[humanoid.arm_v] = SWING * turns * (moved[1] - moved[0]) / (2 * h)
            plant.SetPositionsAndVelocities(context, [*d.q, *v])
            r = plant.CalcCenterOfMassPositionInWorld(context)
            L = plant.CalcSpatialMomentumInWorldAboutPoint(context, r).rotational()
            turned = held.R_mid[k] @ d.R_WB.T @ L
            np.testing.assert_allclose(swung.L_mid[k] - held.L_mid[k], turned, atol=2e-4)
            most = max(most, float(np.abs(turned).max()))
        same = held._replace(L=swung.L, L_mid=swung.L_mid)
        for name, value in same._asdict().items():
            np.testing.assert_array_equal(value, getattr(swung, name), err_msg=name)
    assert len(ticks) > 2 and most > 0.02


def line_at(horizon, side, time):
    """Where a foot is planned to be [m], shape (2,)."""
    return feet_motion(horizon, np.array([time])).position[side, 0, :2]


@pytest.mark.slow
@pytest.mark.parametrize("swing", [0.0, SWING])
def test_a_fast_walk_turns_less_with_arms_that_swing(swing):
    scenario = Scenario(
        segments=[Segment("go", 4.0, walk=True, velocity=[1.2, 0.0])],
        gait=GaitParameters(arm_swing=swing),
    )
    run = simulate(build_closed_loop(scenario))
    late, humanoid = run.time > 2.5, load_humanoid(scenario.robot)
    shoulder = run.q[late][:, humanoid.arm_q[arm_turns(humanoid) != 0.0]]
    yaw, width = np.ptp(run.rpy[late, 2]), np.ptp(shoulder, axis=0)
    assert not run.fell
    if swing:
        assert yaw < 0.05 and (width > 0.2).all()
        assert np.corrcoef(shoulder.T)[0, 1] < -0.9
    else:
        assert yaw > 0.05 and (width < 0.05).all()
