"""The gait as a LeafSystem, through its ports only."""

import numpy as np
import pytest
from pydrake.common.value import AbstractValue
from pydrake.systems.analysis import Simulator

from drake_linefoot.centroidal import NO_WRENCH
from drake_linefoot.errors import SignalError
from drake_linefoot.gait.constants import constants_of
from drake_linefoot.gait.gait_planner import GaitPlanner
from drake_linefoot.gait.horizon import plan_horizon
from drake_linefoot.gait.measurement import measure_gait
from drake_linefoot.gait.parameters import GaitParameters
from drake_linefoot.signals import ContactEstimate
from tests.helpers.walking import (
    dynamics_of,
    mirror_horizon,
    mirror_places,
    mirror_targets,
    recorded_walk,
)

LENGTH = 0.56
WALK = np.array([0.4, 0.1, 0.5, 1.0])


def estimate(left=True, right=True):
    return AbstractValue.Make(
        ContactEstimate(np.zeros((2, 5)), (left, right), np.zeros(24), NO_WRENCH)
    )


class Bench:
    """A gait planner whose inputs are set by hand."""

    def __init__(self, humanoid, x=None, parameters=None, command=(0.0, 0.0, 0.0, 0.0)):
        self.system = GaitPlanner(humanoid, parameters or GaitParameters(), LENGTH)
        self.simulate()
        self.state(humanoid.x_nominal if x is None else x)
        self.command(command)
        self.contact(True, True)

    def simulate(self, context=None):
        """Start a simulation; from a context that was saved, it goes on."""
        self.simulator = Simulator(self.system, context)
        self.context = self.simulator.get_mutable_context()

    def state(self, x):
        self.dynamics(dynamics_of(x))

    def dynamics(self, d):
        self.system.get_dynamics_input_port().FixValue(self.context, AbstractValue.Make(d))

    def command(self, c):
        self.system.get_command_input_port().FixValue(self.context, c)

    def contact(self, left, right):
        self.system.get_contact_input_port().FixValue(self.context, estimate(left, right))

    def targets(self):
        return self.system.get_targets_output_port().Eval(self.context)

    def horizon(self):
        return self.system.get_horizon_output_port().Eval(self.context)

    def until(self, time):
        self.simulator.AdvanceTo(time)
        return self.targets()


@pytest.fixture
def bench(humanoid):
    return Bench(humanoid)


def test_names_and_sizes_of_the_ports(humanoid, bench):
    s = bench.system
    assert s.get_name() == "gait_planner"
    inputs = [s.get_input_port(i) for i in range(s.num_input_ports())]
    assert [p.get_name() for p in inputs] == ["dynamics", "command", "contact"]
    assert [p.size() for p in inputs] == [0, 4, 0]
    outputs = [s.get_output_port(i).get_name() for i in range(s.num_output_ports())]
    assert outputs == ["targets", "horizon"]
    assert s.get_dynamics_input_port().get_name() == "dynamics"
    assert s.get_targets_output_port().get_name() == "targets"
    assert not s.HasAnyDirectFeedthrough()


def test_it_measures_com_and_contact_lines(humanoid, walking_state):
    """Against heel and toe themselves, at any posture; headings are those of heel to toe.

    The pendulum has the robot's angular momentum about the point below the CoM where it stands.
    """
    context = humanoid.plant.CreateDefaultContext()
    constants = constants_of(GaitParameters(), humanoid)[0]
    down = np.array([0.0, 0.0, GaitParameters().com_height])
    for seed in range(5):
        x = walking_state(humanoid, seed)
        measured = measure_gait(dynamics_of(x), (True, False), constants)
        humanoid.plant.SetPositionsAndVelocities(context, x)
        assert measured.contact == (True, False)
        m, plant = humanoid.mass, humanoid.plant
        H = plant.CalcSpatialMomentumInWorldAboutPoint(context, measured.com - down)
        L = m * np.cross(down, measured.pendulum_velocity)
        np.testing.assert_allclose(m * measured.com_velocity, H.translational(), atol=1e-11)
        np.testing.assert_allclose(L[:2], H.rotational()[:2], atol=1e-11)
        assert measured.pendulum_velocity[2] == measured.com_velocity[2]
        lines = zip(
            humanoid.description.feet, measured.feet, measured.rise, measured.climb, strict=True
        )
        for foot, line, rise, climb in lines:
            frame = plant.GetFrameByName(foot.frame)
            X_WF = frame.CalcPoseInWorld(context)
            V_WF = frame.CalcSpatialVelocityInWorld(context)
            heel, toe = (X_WF @ p for p in foot.contact_points)
            ends = [V_WF.Shift(end - X_WF.translation()).translational()[2] for end in (heel, toe)]
            assert climb == pytest.approx(max(ends), abs=1e-12)
            np.testing.assert_allclose(line[:3], 0.5 * (heel + toe), atol=1e-12)
            along = (toe - heel)[:2] / np.linalg.norm((toe - heel)[:2])
            assert rise == pytest.approx((toe - heel)[2] / ((toe - heel)[:2] @ along), abs=1e-12)
            np.testing.assert_allclose([np.cos(line[3]), np.sin(line[3])], along, atol=1e-12)


def test_it_begins_standing_where_the_robot_stands(humanoid, bench):
    x = humanoid.x_nominal
    x[4:6] = [3.0, -2.0]
    bench.state(x)
    bench.simulator.Initialize()
    targets = bench.targets()
    assert (targets.mode, targets.contact, targets.swing) == ("stand", (True, True), None)
    assert np.isnan(targets.foothold).all()
    assert targets.time == 0.0
    feet = bench.horizon().schedule.phases[0].feet
    np.testing.assert_allclose(feet[:, 1].mean(), -2.0, atol=1e-12)
    assert feet[0, 1] > feet[1, 1]


def test_a_constant_state_is_walked_on_the_spot_of_the_schedule(bench):
    """Stand, 0.4 s of shift, 0.03 s double support, then the right foot swings."""
    bench.command(WALK)
    assert bench.until(0.2).mode == "shift"
    assert bench.until(0.41).mode == "double"
    targets = bench.until(0.5)
    assert (targets.mode, targets.contact) == ("swing", (True, False))
    assert targets.swing is not None
    assert np.isfinite(targets.foothold).all()
    assert np.linalg.norm(targets.swing.d_W) == pytest.approx(1.0, abs=1e-12)


def test_it_updates_every_millisecond_and_holds_in_between(bench):
    bench.command(WALK)
    bench.until(0.4501)
    first = bench.targets()
    bench.until(0.4509)
    assert bench.targets() is first
    bench.until(0.4511)
    assert bench.targets().time == pytest.approx(first.time + 0.001, abs=1e-12)


def test_time_alone_recomputes_nothing(bench):
    bench.until(0.01)
    targets, horizon = bench.targets(), bench.horizon()
    bench.context.SetTime(0.0105)
    assert bench.targets() is targets
    assert bench.horizon() is horizon


def test_targets_and_horizon_describe_the_same_swing(humanoid, bench):
    bench.command(WALK)
    bench.until(0.55)
    targets, horizon = bench.targets(), bench.horizon()
    now = np.array([targets.time])
    foot = horizon.schedule.feet_motion(now)
    np.testing.assert_allclose(targets.swing.p_WC, foot.position[1, 0, :3], atol=1e-14)
    np.testing.assert_allclose(targets.swing.v_WC, foot.velocity[1, 0, :3], atol=1e-14)
    np.testing.assert_allclose(targets.foothold, horizon.footholds[0], atol=1e-14)
    assert horizon.schedule.phases[-1].end >= targets.time + LENGTH


def test_contact_in_the_late_swing_ends_it(bench):
    bench.command(WALK)
    bench.until(0.43)
    bench.contact(True, False)
    assert bench.until(0.6).mode == "swing"
    bench.contact(True, True)
    assert bench.until(0.6021).mode == "double"
    assert bench.targets().steps == 1


def test_a_command_outside_the_limits_is_said(bench):
    bench.command([3.0, 0.0, 0.0, 1.0])
    bench.until(0.0095)
    assert bench.targets().clipped_commands == 10


def test_a_walk_of_the_robot_is_replayed_by_the_ports(humanoid):
    """The horizons that the closed loop saw come out of the gait's state alone."""
    constants = constants_of(GaitParameters(), humanoid)
    bench = Bench(humanoid)
    bench.command(WALK)
    bench.until(0.6)
    state = bench.system.gait_state(bench.context)
    again = plan_horizon(state, constants[0], LENGTH)
    np.testing.assert_array_equal(again.footholds, bench.horizon().footholds)
    np.testing.assert_allclose(bench.targets().command, [*state.velocity, state.turn_rate])


def test_mirrored_input_gives_mirrored_output(humanoid):
    x = recorded_walk().mpc[-1].x
    flip = np.array([1.0, -1.0, -1.0, 1.0])
    one = Bench(humanoid, x, GaitParameters(first_swing="right"), WALK)
    other = Bench(
        humanoid, humanoid.mirror_state(x), GaitParameters(first_swing="left"), WALK * flip
    )
    for time in (0.3, 0.42, 0.55):
        a, b = mirror_targets(one.until(time)), other.until(time)
        assert (a.mode, a.contact, a.steps) == (b.mode, b.contact, b.steps)
        np.testing.assert_allclose(b.foothold, a.foothold, atol=1e-10)
        np.testing.assert_allclose([*b.command, b.yaw], [*a.command, a.yaw], atol=1e-10)
        ha, hb = mirror_horizon(one.horizon()), other.horizon()
        np.testing.assert_allclose(hb.footholds, ha.footholds, atol=1e-9)
        for p, q in zip(ha.schedule.phases, hb.schedule.phases, strict=True):
            assert p.contact == q.contact
            np.testing.assert_allclose(q.feet, p.feet, atol=1e-9)
    for name in ("p_WC", "v_WC", "a_WC", "d_W", "w_W", "alpha_W"):
        np.testing.assert_allclose(getattr(b.swing, name), getattr(a.swing, name), atol=1e-7)
    np.testing.assert_allclose(mirror_places(mirror_places(a.foothold)), a.foothold)


def test_what_was_put_out_does_not_change_when_the_state_does(bench):
    bench.command(WALK)
    bench.until(0.55)
    targets, horizon, state = (
        bench.targets(),
        bench.horizon(),
        bench.system.gait_state(bench.context),
    )
    first = horizon.schedule.phases[0].swing
    arrays = [targets.foothold, targets.command, targets.slope, *targets.swing]
    arrays += [horizon.slope, horizon.ground, horizon.footholds, first.reference, first.target]
    before = [a.copy() for a in (*arrays, state.com, state.reference)]
    bench.until(0.57)
    for a, b in zip((*arrays, state.com, state.reference), before, strict=True):
        np.testing.assert_array_equal(a, b)


def test_a_saved_state_goes_on_with_the_same_bits(humanoid, walking_state):
    """Also in a simulation of its own, whose initialization is that of any other."""
    bench, states = Bench(humanoid, command=WALK), [walking_state(humanoid, k) for k in range(3)]
    bench.until(0.53)
    saved = bench.context.Clone()

    def go_on():
        for k, x in enumerate(states):
            bench.state(x)
            bench.contact(True, k == 2)
            bench.until(0.53 + 0.04 * (k + 1))
        return bench.context.get_discrete_state_vector().value().copy()

    first = go_on()
    bench.simulate(saved.Clone())
    np.testing.assert_array_equal(go_on(), first)
    bench.context.SetTimeStateAndParametersFrom(saved)
    bench.simulator.Initialize()
    np.testing.assert_array_equal(go_on(), first)


def test_a_state_that_was_never_begun_stands_in_the_nominal_posture(bench):
    targets = bench.targets()
    assert (targets.time, targets.mode, targets.swing) == (0.0, "stand", None)
    assert np.isfinite([*targets.command, targets.yaw, *targets.slope]).all()
    assert np.isfinite(bench.horizon().schedule.phases[0].feet).all()
    assert not bench.system.gait_state(bench.context).begun
    bench.simulator.Initialize()
    assert bench.system.gait_state(bench.context).begun


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_an_input_that_is_not_finite_is_refused_by_name(humanoid, bench, value):
    bench.simulator.Initialize()
    bench.command([0.0, 0.0, value, 0.0])
    with pytest.raises(SignalError, match=rf"gait_planner\.command: element 2 is {value}"):
        bench.until(0.01)
    bench.command(np.zeros(4))
    for name, what in (("q", "position"), ("v", "velocity")):
        d = dynamics_of(humanoid.x_nominal)
        bad = getattr(d, name).copy()
        bad[5] = value
        bench.dynamics(d._replace(**{name: bad}))
        with pytest.raises(SignalError, match=rf"gait_planner\.dynamics: {what} 5 is {value}"):
            bench.until(0.01)


@pytest.mark.parametrize("port", ["dynamics", "contact"])
def test_another_object_is_refused_by_name(bench, port):
    bench.simulator.Initialize()
    bench.system.GetInputPort(port).FixValue(bench.context, AbstractValue.Make([1.0]))
    with pytest.raises(SignalError, match=rf"gait_planner\.{port}: got a list: must be a "):
        bench.until(0.01)
