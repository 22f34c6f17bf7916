import numpy as np
import pytest
from pydrake.systems.analysis import Simulator

from drake_linefoot.constants import GRAVITY
from drake_linefoot.lab.simulation import recorder as recorder_module
from drake_linefoot.lab.simulation.channels import MODES
from drake_linefoot.lab.simulation.recorder import Recorder
from drake_linefoot.lab.simulation.recording import CHANNELS, WALL_TIMES
from drake_linefoot.lab.wiring.closed_loop import build_closed_loop
from drake_linefoot.robot.dynamics import dynamics_vector
from tests.helpers.recorded_runs import SHORT, Limp, short_run


def test_samples_are_1_ms_apart_and_reach_to_the_end():
    run = short_run()
    np.testing.assert_allclose(run.time, np.arange(401) * 1e-3, atol=1e-12)
    for name in CHANNELS:
        assert len(getattr(run, name)) == 401, name


def test_nothing_but_what_can_be_absent_is_nan():
    run = short_run()
    absent = {"swing_position", "foothold", "mpc_footholds", "mpc_ms"}
    absent |= {name for name, c in CHANNELS.items() if c.signal == "estimate"}
    assert {n for n in CHANNELS if np.isnan(getattr(run, n)).any()} <= absent


def test_recording_makes_the_controller_compute_nothing_twice(wbc_ticks):
    loop = build_closed_loop(SHORT)
    simulator = loop.make_simulator()
    simulator.Initialize()
    simulator.AdvanceTo(0.05)
    assert loop.recorder.count == 51
    assert len(wbc_ticks) == 51  # 50 steps of the plant, and the last sample


def test_true_forces_carry_the_robot():
    run = short_run()
    mass = build_closed_loop(SHORT).humanoid.mass
    late = (run.time > 0.05) & (run.time < 0.1)
    total = run.true_force[late].sum(axis=1)
    acceleration = np.diff(run.com, n=2, axis=0)[np.flatnonzero(late) - 2] / 1e-6
    np.testing.assert_allclose(total, mass * (acceleration - GRAVITY), atol=0.01 * mass * 9.81)
    np.testing.assert_allclose(run.true_normal.sum(axis=2), run.true_force[:, :, 2], atol=1e-9)
    assert (run.true_normal >= 0.0).all()
    assert (run.true_normal[late] > 5.0).all()  # both feet, heel and toe
    np.testing.assert_allclose(run.contact_points[late][..., 2], 0.0, atol=2e-3)
    assert (run.contact_points[:, :, 1, 0] > run.contact_points[:, :, 0, 0]).all()  # toe ahead
    assert (run.contact_points[:, 0, :, 1] > run.contact_points[:, 1, :, 1]).all()  # left of right


def test_the_sample_of_a_time_belongs_together():
    """Torque is applied in the step that follows; what was applied is seen one sample later."""
    run = short_run()
    np.testing.assert_allclose(run.applied_torque[1:], run.torque[:-1], atol=1e-12)
    np.testing.assert_allclose(
        run.contact_wrench[50:, :, 2].sum(axis=1),
        run.true_force[50:, :, 2].sum(axis=1),
        atol=60.0,
    )


def test_gait_and_plan_are_those_of_the_command():
    run = short_run()
    assert MODES[int(run.mode[50])] == "stand"
    assert MODES[int(run.mode[-1])] in ("shift", "swing")
    np.testing.assert_array_equal(run.command[50], [0.0, 0.0, 0.0, 0.0])
    np.testing.assert_array_equal(run.command[-1], [0.1, 0.0, 0.0, 1.0])
    assert np.isfinite(run.mpc_footholds[-1, 0]).all()


def test_a_plan_is_timed_once():
    run = short_run()
    updates = np.flatnonzero(~np.isnan(run.mpc_ms))
    assert len(updates) == pytest.approx(0.4 / SHORT.mpc.period, abs=1)
    assert (run.mpc_ms[updates] > 0.0).all()
    assert (run.wbc_ms > 0.0).all()


def test_the_plan_is_sampled_at_the_time_of_the_sample():
    """A new plan starts at the measured state; its parts are each other's derivatives."""
    run = short_run()
    updates = np.flatnonzero(~np.isnan(run.mpc_ms))
    np.testing.assert_allclose(run.mpc_com[updates], run.com[updates], atol=1e-5)
    between = np.setdiff1d(np.arange(1, len(run.time)), updates)
    step = np.diff(run.mpc_com, axis=0)[between - 1] / 1e-3
    np.testing.assert_allclose(step, run.mpc_velocity[between], atol=0.02)
    force = run.mpc_wrench[:, :, :3].sum(axis=1)
    mass = build_closed_loop(SHORT).humanoid.mass
    # What it counts on that pulls is that of when it was made.
    pull = np.maximum.accumulate(np.abs(run.reference_external[:, 3:]).max(axis=1))
    beyond = np.abs(force / mass + GRAVITY - run.mpc_acceleration).max(axis=1)
    assert pull[-1] < 1.0
    assert (beyond <= 1e-9 + pull / mass).all()
    rate = np.diff(run.mpc_momentum, axis=0)[between - 1] / 1e-3
    np.testing.assert_allclose(rate, run.mpc_momentum_rate[between], atol=0.5)
    tilt = run.mpc_orientation[updates[1:], :2]  # the desired torso is level
    np.testing.assert_allclose(tilt, run.rpy[updates[1:], :2], atol=1e-3)
    assert np.abs(run.mpc_mean_velocity - run.mpc_velocity).max() < 0.5


def test_buffers_grow_and_going_back_drops_what_is_not_past():
    loop = build_closed_loop(SHORT, controller=Limp())
    simulator = loop.make_simulator()
    simulator.Initialize()
    simulator.AdvanceTo(1.5)
    assert loop.recorder.count == 1501
    first = loop.recorder.samples("q")[1000].copy()
    simulator.get_mutable_context().SetTime(0.5)
    simulator.Initialize()
    assert loop.recorder.samples("time")[-1] == pytest.approx(0.5)
    again = loop.make_simulator()
    again.Initialize()
    again.AdvanceTo(1.0)
    assert loop.recorder.count == 1001
    np.testing.assert_array_equal(loop.recorder.samples("q")[1000], first)


def test_nothing_depends_on_where_batches_end(monkeypatch):
    """Batches of 50 samples, asked for in the middle of one, against those of a run."""
    monkeypatch.setattr(recorder_module, "_BATCH", 50)
    loop = build_closed_loop(SHORT)
    simulator = loop.make_simulator()
    for end in (0.0103, 0.13, 0.14, SHORT.duration):
        simulator.AdvanceTo(end)
        assert loop.recorder.samples("time", 1)[0] == pytest.approx(end, abs=1e-3)
    whole = short_run()
    for name, values in loop.recorder.arrays().items():
        if name not in WALL_TIMES:
            np.testing.assert_array_equal(values, getattr(whole, name), err_msg=name)


def test_a_batch_that_goes_back_in_time_keeps_the_later_samples():
    loop = build_closed_loop(SHORT, controller=Limp())
    for _ in range(2):  # each begins anew before a batch is full
        simulator = loop.make_simulator()
        simulator.Initialize()
        simulator.AdvanceTo(0.02)
    np.testing.assert_allclose(loop.recorder.samples("time"), np.arange(21) * 1e-3, atol=1e-12)
    assert np.isfinite(loop.recorder.samples("true_force")).all()


@pytest.mark.parametrize("n", [0, 5, 100])
def test_it_goes_on_after_it_forgot(n):
    loop = build_closed_loop(SHORT, controller=Limp())
    simulator = loop.make_simulator()
    simulator.AdvanceTo(0.03)
    loop.recorder.keep_last(n)
    simulator.AdvanceTo(0.04)
    kept = np.arange(max(31 - n, 0), 41) * 1e-3
    np.testing.assert_allclose(loop.recorder.samples("time"), kept, atol=1e-12)


def test_recorded_quaternions_have_unit_norm_and_the_plant_is_left_alone():
    loop = build_closed_loop(SHORT)
    simulator = loop.make_simulator()
    simulator.AdvanceTo(SHORT.duration)
    raw, q = loop.recorder.samples("q"), loop.recorder.arrays()["q"]
    norms = np.linalg.norm(raw[:, :4], axis=1)
    assert np.abs(norms - 1.0).max() > 1e-9  # it drifts
    np.testing.assert_allclose(np.linalg.norm(q[:, :4], axis=1), 1.0, atol=1e-15)
    np.testing.assert_allclose(q[:, :4] * norms[:, None], raw[:, :4], atol=1e-15)
    np.testing.assert_array_equal(q[:, 4:], raw[:, 4:])


def test_without_optional_ports_their_channels_are_nan():
    loop = build_closed_loop(SHORT, controller=Limp())
    simulator = loop.make_simulator()
    simulator.Initialize()
    arrays = loop.recorder.arrays()
    for name in ("contact_flag", "mode", "mpc_wrench", "wbc_wrench"):
        assert np.isnan(arrays[name]).all(), name
    for name in ("q", "v", "com", "torque", "true_force", "slip_speed"):
        assert np.isfinite(arrays[name]).all(), name


def fixed(humanoid):
    """What the inputs of a recorder must have."""
    scratch = humanoid.plant.CreateDefaultContext()
    return {
        "command": np.arange(4.0),
        "torque": np.full(18, 2.0),
        "applied_torque": np.full(18, 3.0),
        "foot_contacts": np.zeros(24),
        "dynamics": dynamics_vector(humanoid, scratch, humanoid.x_nominal),
    }


def test_alone_with_another_period():
    loop = build_closed_loop(SHORT)
    recorder = Recorder(loop.humanoid, period=0.004)
    simulator = Simulator(recorder)
    for name, value in fixed(loop.humanoid).items():
        recorder.GetInputPort(name).FixValue(simulator.get_mutable_context(), value)
    simulator.AdvanceTo(0.02)
    np.testing.assert_allclose(recorder.samples("time"), np.arange(6) * 0.004, atol=1e-12)
    np.testing.assert_array_equal(recorder.samples("command")[-1], np.arange(4.0))
    assert (recorder.samples("applied_torque") == 3.0).all()
    assert (recorder.samples("true_force") == 0.0).all()


def test_a_state_that_is_not_finite_is_not_recorded():
    loop = build_closed_loop(SHORT, controller=Limp())
    simulator = loop.make_simulator()
    simulator.AdvanceTo(0.005)
    context = loop.plant.system.GetMyMutableContextFromRoot(simulator.get_mutable_context())
    context.SetDiscreteState(np.full(49, np.nan))
    simulator.get_mutable_context().SetTime(1.0)
    simulator.Initialize()
    assert loop.recorder.count == 6


@pytest.mark.parametrize(
    "port", ["dynamics", "contact", "targets", "plan", "report", "estimate", "foot_contacts"]
)
def test_a_signal_of_another_size_is_refused_by_name(port):
    loop = build_closed_loop(SHORT, controller=Limp())
    recorder = Recorder(loop.humanoid)
    context, into = recorder.CreateDefaultContext(), recorder.GetInputPort(port)
    with pytest.raises(RuntimeError, match=f"(?i)expected.* size={into.size()}.*{port}"):
        into.FixValue(context, np.zeros(into.size() + 1))
