"""The state estimator through its ports alone, and the sensors on board through theirs."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from pydrake.systems.analysis import Simulator
from scipy.spatial.transform import Rotation

from drake_linefoot.centroidal import NO_WRENCH
from drake_linefoot.constants import GRAVITY
from drake_linefoot.errors import EstimateError, SignalError
from drake_linefoot.estimation.estimate import contact_points, point_loads, robot_state, track
from drake_linefoot.estimation.filter_state import CONTACT, ERRORS, filter_of, new_filter
from drake_linefoot.estimation.parameters import OnboardParameters, StateEstimatorParameters
from drake_linefoot.estimation.state_estimator import StateEstimator, constants_of
from drake_linefoot.layout import flat
from drake_linefoot.robot.dynamics import robot_dynamics
from drake_linefoot.robot.legs import read_legs
from drake_linefoot.robot.scaling import scaled
from drake_linefoot.signals import ContactEstimate
from tests.helpers.ports import look
from tests.helpers.walk_on_soles import robot_on_soles

PITCH = 0.05  # [rad] of the robot at rest below


class Bench:
    """An estimator with fixed inputs, of a robot at rest that leans forward."""

    def __init__(self, robot, **onboard):
        self.robot = robot
        p = StateEstimatorParameters()
        self.system = StateEstimator(robot, OnboardParameters(**onboard), p)
        self.simulator = Simulator(self.system)
        self.context = self.simulator.get_mutable_context()
        self.imu = np.concatenate([np.zeros(3), -Rotation.from_euler("Y", -PITCH).apply(GRAVITY)])
        self.feed("imu", self.imu)
        self.feed("encoders", robot.q_nominal[robot.actuated_q])
        self.contact(1.0)

    def feed(self, name, value):
        self.system.GetInputPort(name).FixValue(self.context, value)

    def contact(self, share, aside=0.0):
        wrench = np.zeros((2, self.robot.contact.size))
        wrench[:, 2] = share * 0.5 * self.robot.mass * 9.81
        wrench[:, 5:] = aside * self.robot.half_width * wrench[:, 2:3]
        stands, residual = np.full(2, float(share > 0.0)), np.zeros(self.robot.nv)
        self.feed("contact", flat(ContactEstimate(wrench, stands, residual, NO_WRENCH)))

    def read(self, name):
        return self.system.GetOutputPort(name).Eval(self.context)

    def report(self):
        return look(self.system.GetOutputPort("report"), self.context, self.robot, "estimate")


@pytest.fixture
def bench(humanoid):
    return Bench(humanoid)


def test_at_rest_it_is_level_and_stays_where_it_is(bench, humanoid):
    bench.simulator.AdvanceTo(0.6)
    x = bench.read("state")
    assert len(x) == humanoid.nq + humanoid.nv
    R = Rotation.from_quat(x[:4], scalar_first=True)
    np.testing.assert_allclose(R.as_rotvec(), [0.0, PITCH, 0.0], atol=1e-3)
    np.testing.assert_allclose(x[25:], 0.0, atol=1e-3)
    posture = humanoid.x_nominal
    posture[:4], posture[4:7] = x[:4], x[4:7]
    d = robot_dynamics(humanoid, humanoid.plant.CreateDefaultContext(), posture)
    ends = d.p_WC[:, 2, None] + humanoid.half_length * d.R_WC[:, 2, :1] * [[-1.0, 1.0]]
    assert ends.min() == pytest.approx(0.0, abs=2e-3)


def test_a_robot_rests_on_soles_until_they_may_tip():
    """Nine tenths aside both feet hold; at the edge nothing does, but the weight is borne."""
    robot = robot_on_soles()[0]
    for aside, hold in ((0.9, 1.0), (1.0, 0.0)):
        bench = Bench(robot)
        bench.contact(1.0, aside)
        bench.simulator.AdvanceTo(0.2)
        np.testing.assert_array_equal(bench.report().stands, hold)
    bench = Bench(robot)
    bench.contact(1.0, 0.9)
    bench.simulator.AdvanceTo(0.6)  # beyond the rest at the beginning
    R = Rotation.from_quat(bench.read("state")[:4], scalar_first=True)
    np.testing.assert_allclose(R.as_rotvec(), [0.0, PITCH, 0.0], atol=1e-3)


def test_at_rest_it_finds_the_bias_of_the_gyroscope(bench):
    bias = np.array([2e-3, -3e-3, 1e-3])
    bench.simulator.Initialize()
    bench.feed("imu", bench.imu + np.concatenate([bias, np.zeros(3)]))
    bench.simulator.AdvanceTo(4.0)
    report = bench.report()
    np.testing.assert_allclose(report.biases[:2], bias[:2], atol=3e-4)
    np.testing.assert_allclose(report.velocity[:2], 0.0, atol=3e-4)
    assert report.stands.all() and report.measured.all() and (report.nis > 0.0).all()


def test_covariance_is_that_of_a_filter(bench):
    bench.simulator.AdvanceTo(0.2)
    P = bench.read("covariance").reshape(ERRORS, ERRORS)
    np.testing.assert_allclose(P, P.T, atol=1e-12)
    assert np.linalg.eigvalsh(P).min() > -1e-12
    assert bench.report().sigma.shape == (CONTACT,)


@pytest.mark.parametrize("port", ["imu", "encoders"])
def test_a_reading_that_is_not_finite_names_the_port(bench, port):
    bench.simulator.Initialize()
    value = bench.system.GetInputPort(port).Eval(bench.context)
    value[1] = np.nan
    bench.feed(port, value)
    with pytest.raises(SignalError, match=f"state_estimator.{port}: element 1 is nan"):
        bench.simulator.AdvanceTo(0.01)


def test_a_contact_that_is_not_finite_is_refused_by_name(bench):
    bench.simulator.Initialize()
    contact = bench.system.GetInputPort("contact").Eval(bench.context)
    contact[7] = np.inf
    bench.feed("contact", contact)
    with pytest.raises(SignalError, match=r"state_estimator\.contact: wrench\[1, 2\] is inf: must"):
        bench.simulator.AdvanceTo(0.01)


def test_a_signal_of_another_size_is_refused(bench):
    with pytest.raises(RuntimeError, match="contact"):
        bench.feed("contact", np.zeros(49))


def test_in_the_air_it_does_not_begin(bench):
    bench.feed("imu", np.zeros(6))
    with pytest.raises(EstimateError, match="nothing carries"):
        bench.simulator.Initialize()


def test_a_robot_that_does_not_rest_at_the_beginning_is_refused(bench):
    bench.simulator.Initialize()
    bench.contact(0.3)
    with pytest.raises(EstimateError, match=r"did not rest .* off the weight by 70%"):
        bench.simulator.AdvanceTo(0.6)


def test_without_contact_it_is_lost(bench):
    bench.simulator.AdvanceTo(0.6)
    bench.contact(0.0)
    bench.simulator.AdvanceTo(0.85)
    with pytest.raises(EstimateError, match=r"no contact has agreed with the IMU for 0\.3 s"):
        bench.simulator.AdvanceTo(1.0)


def test_a_jump_of_the_kinematics_is_counted_and_held_anew(bench, humanoid):
    bench.simulator.AdvanceTo(0.6)
    encoders = humanoid.q_nominal[humanoid.actuated_q]
    encoders[humanoid.description.actuated_joints.index("left_hip_pitch")] += 0.1
    bench.feed("encoders", encoders)
    before = bench.read("state")
    bench.simulator.AdvanceTo(0.65)
    report = bench.report()
    assert report.refused >= 20 and report.slips == 2.0
    np.testing.assert_allclose(bench.read("state")[4:7], before[4:7], atol=2e-3)


def test_with_a_late_imu_encoders_wait_for_it_and_joints_do_not(humanoid):
    """A jump of the kinematics is refused when the IMU's sample of that tick has come."""
    encoders = humanoid.q_nominal[humanoid.actuated_q]
    encoders[humanoid.description.actuated_joints.index("left_hip_pitch")] += 0.1
    ticks = {}
    for late in (0, 3):
        bench = Bench(humanoid, imu_delay=1e-3 * late)
        bench.simulator.AdvanceTo(0.6)
        assert bench.report().refused == 0.0
        bench.feed("encoders", encoders)
        for tick in range(10):
            bench.simulator.AdvanceTo(0.601 + 1e-3 * tick)
            if tick == 1:
                angles = bench.read("state")[humanoid.actuated_q]
                np.testing.assert_array_equal(angles, encoders)
            if bench.report().refused:
                ticks[late] = tick
                break
    assert ticks[3] == ticks[0] + 3


def test_over_the_delay_the_base_moves_on_as_its_last_sample_says(humanoid):
    """Against an integration in a thousand steps; the error is of third order in the delay."""
    w, f, v = np.array([2.0, -3.0, 1.0]), np.array([3.0, -2.0, 12.0]), np.array([0.5, -0.2, 0.1])
    bias = np.array([0.02, -0.01, 0.03]), np.array([0.1, 0.2, -0.1])
    R_0 = Rotation.from_rotvec([0.1, -0.2, 0.7])
    joints, errors = np.zeros((3, humanoid.na)), []
    for delay in (0.005, 0.01):
        s = filter_of(new_filter())
        s.R, s.p, s.v, s.w = R_0.as_matrix(), [1.0, 2.0, 0.7], v, R_0.apply(w)
        s.gyro_bias, s.accelerometer_bias = bias
        onboard, parameters = OnboardParameters(imu_delay=delay), StateEstimatorParameters()
        constants = constants_of(scaled(parameters, humanoid), onboard, humanoid, 0.001)
        x = robot_state(s, joints, np.concatenate([w + bias[0], f + bias[1]]), constants)
        R, p, u, h = R_0, s.p.copy(), v, delay / 1000
        for _ in range(1000):
            a = (R * Rotation.from_rotvec(0.5 * h * w)).apply(f) + GRAVITY
            R, p, u = R * Rotation.from_rotvec(h * w), p + h * u + 0.5 * h**2 * a, u + h * a
        turn = Rotation.from_quat(x[:4], scalar_first=True) * R.inv()
        assert turn.magnitude() < 1e-9
        np.testing.assert_allclose(x[humanoid.nq :][:3], R.apply(w), atol=1e-9)
        place, velocity = np.abs(x[4:7] - p).max(), np.abs(x[humanoid.nq :][3:6] - u).max()
        assert place < 1e-5 and velocity < 1e-5
        errors.append((place, velocity))
    assert (np.array(errors[0]) < np.array(errors[1]) / 6.0).all()


@pytest.mark.parametrize("delay", [0.0, 0.004])
def test_a_saved_context_goes_on_with_the_same_bits(humanoid, delay):
    bench = Bench(humanoid, imu_delay=delay)
    bench.simulator.AdvanceTo(0.3)
    bench.feed("encoders", humanoid.q_nominal[humanoid.actuated_q] + 1e-4)  # some wait
    bench.simulator.AdvanceTo(0.302)
    saved = bench.context.Clone()
    bench.simulator.AdvanceTo(0.4)
    other = Simulator(bench.system, saved)
    other.AdvanceTo(0.4)
    again = bench.system.GetOutputPort("state").Eval(other.get_context())
    np.testing.assert_array_equal(bench.read("state"), again)


@pytest.mark.parametrize("kind", ["line", "sole"])
def test_contact_points_are_those_of_the_plant(humanoid, walking_state, kind):
    """Heel and toe against Drake's frames, their Jacobians against differences."""
    humanoid = humanoid if kind == "line" else robot_on_soles()[0]
    x = walking_state(humanoid, 3)
    angles, legs = x[humanoid.leg_q], read_legs(humanoid)
    points, J = contact_points(legs, angles, humanoid.half_length)
    context = humanoid.plant.CreateDefaultContext()
    humanoid.plant.SetPositions(context, x[: humanoid.nq])
    B = humanoid.base.body_frame()
    for side, foot in enumerate(humanoid.description.feet):
        X_BF = humanoid.foot_frames[side].CalcPose(context, B)
        wanted = (X_BF @ foot.contact_points.T).T
        np.testing.assert_allclose(points[2 * side : 2 * side + 2], wanted, atol=1e-12)
    for joint in range(angles.shape[1]):
        step = np.zeros_like(angles)
        step[:, joint] = 1e-6
        ahead, behind = (
            contact_points(legs, angles + sign * step, humanoid.half_length)[0]
            for sign in (1.0, -1.0)
        )
        np.testing.assert_allclose(J[:, :, joint], (ahead - behind) / 2e-6, atol=1e-9)


def test_loads_of_heel_and_toe_add_up_to_the_wrench():
    wrench = np.zeros((2, 5))
    wrench[0, 2:4], wrench[1, 2] = [100.0, 2.0], 50.0
    load = point_loads(wrench, np.array([1.0, 0.0]), 0.075, 0.0)
    assert load[:2].sum() == pytest.approx(100.0)
    assert 0.075 * (load[0] - load[1]) == pytest.approx(2.0)  # heel force pitches it forward
    np.testing.assert_array_equal(load[2:], 0.0)


@given(st.floats(-1.2, 1.2), st.floats(-1.2, 1.2))
def test_a_sole_is_loaded_as_a_line_unless_it_may_tip_about_its_side(ahead, left):
    assume(abs(abs(left) - 0.95) > 1e-9)  # where rounding decides
    X, Y, f_z = 0.1, 0.03, 200.0
    wrench = np.zeros((2, 6))
    wrench[1, [2, 3, 5]] = f_z * np.array([1.0, -ahead * X, left * Y])
    found = point_loads(wrench, np.ones(2), X, Y)
    as_line = point_loads(wrench[:, :5], np.ones(2), X, 0.0)
    assert as_line[3] - as_line[2] == pytest.approx(ahead * f_z)
    np.testing.assert_array_equal(found, as_line if abs(left) < 0.95 else np.zeros(4))


def test_rates_of_joints_follow_a_steady_turn():
    joints, h = np.zeros((3, 1)), 1e-3
    for k in range(50):
        track(joints, np.array([2.0 * k * h]), h, 1000.0)
    assert joints[2, 0] == pytest.approx(2.0, rel=1e-9)
    assert joints[0, 0] == pytest.approx(0.098)
