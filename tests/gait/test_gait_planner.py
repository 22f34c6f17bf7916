"""The gait as a LeafSystem, through its ports only."""

import numpy as np
import pytest

from drake_linefoot.errors import SignalError
from drake_linefoot.gait import gait_planner
from drake_linefoot.gait.constants import constants_of
from drake_linefoot.gait.horizon import plan_horizon
from drake_linefoot.gait.measurement import measure_gait
from drake_linefoot.gait.parameters import GaitParameters
from drake_linefoot.gait.schedule import feet_motion
from drake_linefoot.layout import flat
from drake_linefoot.parts import KNOTS
from drake_linefoot.robot.dynamics import dynamics_layout
from drake_linefoot.statuses import Mode
from drake_linefoot.terrain import TERRAIN
from tests.helpers.gait_bench import LENGTH, WALK, Bench, estimate
from tests.helpers.horizons import phases_of
from tests.helpers.phases import named, swing_of
from tests.helpers.ports import layout_of, put
from tests.helpers.walking import (
    dynamics_of,
    mirror_horizon,
    mirror_places,
    mirror_targets,
    recorded_walk,
)

# A force at the toe end of the left line, 0.02 m behind the middle of the right one.
WRENCH = np.array([[0.0, 0.0, 10.0, -5.0, 0.0], [1.0, 2.0, 100.0, 2.0, 0.0]])


@pytest.fixture
def bench(humanoid):
    return Bench(humanoid)


def test_names_and_sizes_of_the_ports(humanoid, bench):
    s = bench.system
    assert s.get_name() == "gait_planner"
    inputs = [s.get_input_port(i) for i in range(s.num_input_ports())]
    assert [p.get_name() for p in inputs] == ["dynamics", "command", "contact", "terrain"]
    nv = humanoid.nv
    sizes = [dynamics_layout(humanoid).size, 4, 10 + 2 + nv + 6, TERRAIN.size]
    assert [p.size() for p in inputs] == sizes
    outputs = [s.get_output_port(i) for i in range(s.num_output_ports())]
    assert [p.get_name() for p in outputs] == ["targets", "horizon"]
    assert all(p.size() == layout_of(p).size for p in outputs)
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
        measured = measure_gait(dynamics_of(x), np.array([1.0, 0.0]), WRENCH, constants)
        humanoid.plant.SetPositionsAndVelocities(context, x)
        np.testing.assert_array_equal(measured.contact, [1.0, 0.0])
        np.testing.assert_allclose(measured.presses, [humanoid.half_length, -0.02], atol=1e-15)
        m, plant = humanoid.mass, humanoid.plant
        H = plant.CalcSpatialMomentumInWorldAboutPoint(context, measured.com - down)
        L = m * np.cross(down, measured.pendulum_velocity)
        np.testing.assert_allclose(m * measured.com_velocity, H.translational(), atol=1e-11)
        np.testing.assert_allclose(L[:2], H.rotational()[:2], atol=1e-11)
        assert measured.pendulum_velocity[2] == measured.com_velocity[2]
        lines = zip(
            humanoid.description.feet,
            measured.feet,
            measured.line_slope,
            measured.vertical_speed,
            strict=True,
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
    assert (named(targets), *targets.contact, *targets.swings) == (Mode.STAND, 1.0, 1.0, 0.0, 0.0)
    assert not targets.swing.any()
    assert not targets.foothold.any()
    assert targets.time == 0.0
    feet = bench.horizon().feet[0]
    np.testing.assert_allclose(feet[:, 1].mean(), -2.0, atol=1e-12)
    assert feet[0, 1] > feet[1, 1]


def test_a_constant_state_is_walked_on_the_spot_of_the_schedule(bench):
    """Stand, 0.4 s of shift, 0.03 s double support, then the right foot swings."""
    bench.command(WALK)
    assert named(bench.until(0.2)) == Mode.SHIFT
    assert named(bench.until(0.41)) == Mode.DOUBLE
    targets = bench.until(0.5)
    assert (named(targets), *targets.contact, *targets.swings) == (Mode.SWING, 1.0, 0.0, 0.0, 1.0)
    assert targets.foothold[1].any() and not targets.foothold[0].any()
    assert np.isfinite(flat(targets)).all()
    assert np.linalg.norm(targets.swing_target(1).d_W) == pytest.approx(1.0, abs=1e-12)


def test_it_updates_every_millisecond_and_holds_in_between(bench):
    bench.command(WALK)
    bench.until(0.4501)
    first = bench.targets()
    bench.until(0.4509)
    np.testing.assert_array_equal(flat(bench.targets()), flat(first))
    bench.until(0.4511)
    assert bench.targets().time == pytest.approx(first.time + 0.001, abs=1e-12)


def test_time_alone_recomputes_nothing(bench, monkeypatch):
    calls = []
    for name in ("present_targets", "horizon_vector"):
        function = getattr(gait_planner, name)

        def counted(*args, name=name, function=function):
            calls.append(name)
            return function(*args)

        monkeypatch.setattr(gait_planner, name, counted)
    bench.until(0.01)
    targets, horizon = flat(bench.targets()), flat(bench.horizon())
    made = len(calls)
    bench.context.SetTime(0.0105)
    np.testing.assert_array_equal(flat(bench.targets()), targets)
    np.testing.assert_array_equal(flat(bench.horizon()), horizon)
    assert len(calls) == made == 2
    bench.context.SetTime(0.01)
    bench.until(0.012)
    assert bench.targets().time == bench.horizon().time == pytest.approx(0.012)
    assert sorted(calls[made:]) == ["horizon_vector", "present_targets"]


def test_targets_and_horizon_describe_the_same_swing(humanoid, bench):
    bench.command(WALK)
    bench.until(0.55)
    targets, horizon = bench.targets(), bench.horizon()
    now, swing = np.array([targets.time]), targets.swing_target(1)
    foot = feet_motion(horizon, now)
    np.testing.assert_allclose(swing.p_WC, foot.position[1, 0, :3], atol=1e-14)
    np.testing.assert_allclose(swing.v_WC, foot.velocity[1, 0, :3], atol=1e-14)
    np.testing.assert_allclose(targets.foothold[1], horizon.footholds[0], atol=1e-14)
    assert phases_of(horizon)[-1].end >= targets.time + LENGTH


def test_contact_in_the_late_swing_ends_it(bench):
    bench.command(WALK)
    bench.until(0.43)
    bench.contact(True, False)
    assert named(bench.until(0.6)) == Mode.SWING
    bench.contact(True, True)
    assert named(bench.until(0.6021)) == Mode.DOUBLE
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
    again = plan_horizon(np.array([state]), constants, LENGTH, KNOTS)
    assert again.coming >= 2
    for name, value in again._asdict().items():
        np.testing.assert_array_equal(getattr(bench.horizon(), name), value, err_msg=name)
    np.testing.assert_allclose(
        bench.targets().command, [*state.command.velocity, state.command.turn_rate]
    )


def test_mirrored_input_gives_mirrored_output(humanoid):
    x = recorded_walk().mpc[-1].x
    flip = np.array([1.0, -1.0, -1.0, 1.0])
    one = Bench(humanoid, x, GaitParameters(first_swing="right"), WALK)
    other = Bench(
        humanoid, humanoid.mirror_state(x), GaitParameters(first_swing="left"), WALK * flip
    )
    for time in (0.3, 0.42, 0.55):
        a, b = mirror_targets(one.until(time)), other.until(time)
        assert (named(a), *a.contact, a.steps) == (named(b), *b.contact, b.steps)
        np.testing.assert_allclose(b.foothold, a.foothold, atol=1e-10)
        np.testing.assert_allclose([*b.command, b.yaw], [*a.command, a.yaw], atol=1e-10)
        ha, hb = mirror_horizon(one.horizon()), other.horizon()
        np.testing.assert_allclose(hb.footholds, ha.footholds, atol=1e-9)
        for p, q in zip(phases_of(ha), phases_of(hb), strict=True):
            assert p.contact == q.contact
            np.testing.assert_allclose(q.feet, p.feet, atol=1e-9)
    np.testing.assert_array_equal(b.swings, a.swings)
    assert a.swings.sum() == 1.0
    np.testing.assert_allclose(b.swing, a.swing, atol=1e-7)
    np.testing.assert_allclose(mirror_places(mirror_places(a.foothold)), a.foothold)


def test_what_was_put_out_does_not_change_when_the_state_does(bench):
    bench.command(WALK)
    bench.until(0.55)
    targets, horizon = bench.targets(), bench.horizon()
    state = bench.system.gait_state(bench.context)
    parts = [*targets, *horizon, state.robot.com, swing_of(state).reference]
    before = [np.array(a) for a in parts]
    assert bench.until(0.57).time > targets.time
    assert not np.array_equal(bench.targets().swing, targets.swing)
    for a, b in zip(parts, before, strict=True):
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
    assert (targets.time, named(targets), targets.swings.sum()) == (0.0, Mode.STAND, 0.0)
    assert np.isfinite(flat(targets)).all()
    assert np.isfinite(flat(bench.horizon())).all()
    assert not bench.system.gait_state(bench.context).clock.initialized
    bench.simulator.Initialize()
    assert bench.system.gait_state(bench.context).clock.initialized


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_an_input_that_is_not_finite_is_refused_by_name(humanoid, bench, value):
    bench.simulator.Initialize()
    bench.command([0.0, 0.0, value, 0.0])
    with pytest.raises(SignalError, match=rf"gait_planner\.command: element 2 is {value}"):
        bench.until(0.01)
    bench.command(np.zeros(4))
    for name in ("q", "v"):
        d = dynamics_of(humanoid.x_nominal)
        bad = getattr(d, name).copy()
        bad[5] = value
        bench.dynamics(d._replace(**{name: bad}))
        with pytest.raises(SignalError, match=rf"gait_planner\.dynamics: {name}\[5\] is {value}"):
            bench.until(0.01)
    bench.state(humanoid.x_nominal)
    wrench = np.zeros((2, 5))
    wrench[1, 3] = value
    put(bench.system, bench.context, "contact", estimate()._replace(wrench=wrench))
    with pytest.raises(SignalError, match=rf"gait_planner\.contact: wrench\[1, 3\] is {value}"):
        bench.until(0.01)


@pytest.mark.parametrize("port", ["dynamics", "command", "contact"])
def test_a_signal_of_another_size_is_refused_when_it_is_put_on_a_port(bench, port):
    size = bench.system.GetInputPort(port).size()
    for wrong in (1, size - 1, size + 1):
        with pytest.raises((RuntimeError, ValueError), match=port):
            bench.system.GetInputPort(port).FixValue(bench.context, np.zeros(wrong))
