from dataclasses import replace

import numpy as np
import pytest

from drake_linefoot.errors import InputError, ScenarioError
from drake_linefoot.lab.drive import session as module
from drake_linefoot.lab.drive.session import KEPT, KEPT_AT_MOST, Session, segments
from drake_linefoot.lab.drive.teleop import Tuning
from drake_linefoot.lab.scenario import Scenario
from drake_linefoot.lab.scenario.load import validate
from drake_linefoot.lab.simulation.recording import CHANNELS


@pytest.fixture
def session():
    return Session(Scenario(), None, record=True)


def test_it_begins_standing_and_obeys_a_command(session):
    session.advance(0.1)
    assert session.time == pytest.approx(0.1)
    np.testing.assert_array_equal(session.loop.recorder.last("command"), np.zeros(4))
    session.command([0.3, 0.0, 0.0, 1.0])
    session.advance(0.1)
    np.testing.assert_array_equal(session.loop.recorder.last("command"), [0.3, 0.0, 0.0, 1.0])


def test_a_push_moves_the_robot_and_ends(session):
    session.advance(0.05)
    session.push([40.0, 0.0])
    session.advance(0.1)
    pushed = session.loop.recorder.last("v")[3]
    assert 0.05 < pushed < 40.0 * 0.1 / session.loop.humanoid.mass * 1.5
    push = session.loop.push
    port = push.GetOutputPort("push")
    context = push.GetMyContextFromRoot(session._simulator.get_context())
    np.testing.assert_array_equal(port.Eval(context), np.zeros(3))
    session.advance(0.6)
    assert abs(session.loop.recorder.last("v")[3]) < 0.5 * pushed
    assert session.fall == ""


def test_a_fall_says_why_stops_time_and_is_over_after_a_reset(session):
    session.push([600.0, 0.0])
    session.advance(2.0)
    assert session.fall.startswith("torso ")
    time = session.time
    assert time < 2.0
    session.advance(0.1)
    assert session.time == time
    run = session.run()
    assert (run.fell, run.fall_time, run.fall_reason) == (True, time, session.fall)
    session.reset()
    assert (session.time, session.fall) == (0.0, "")
    session.advance(0.05)
    assert not session.run().fell
    assert session.run().time[-1] == pytest.approx(0.05)


def test_gait_and_model_change_without_a_break_in_the_motion(session):
    session.command([0.3, 0.0, 0.0, 1.0])
    session.advance(1.003)
    before = session.loop.recorder.last("q").copy(), session.loop.recorder.last("gait_steps")
    session.retune(Tuning(0.22, 0.07, 0.63, "srbm"))
    assert session.tuning == Tuning(0.22, 0.07, 0.63, "srbm")
    session.advance(0.5)
    run = session.run()
    np.testing.assert_allclose(np.diff(run.time), 1e-3, atol=1e-9)
    assert np.abs(np.diff(run.q, axis=0)).max() < 0.02
    before[0][:4] /= np.linalg.norm(before[0][:4])  # as a run has them
    np.testing.assert_array_equal(run.q[1002], before[0])
    assert run.gait_steps[1003] == before[1] > 0
    assert run.gait_steps[-1] > before[1]
    assert session.fall == ""
    np.testing.assert_array_equal(run.command[-1], [0.3, 0.0, 0.0, 1.0])
    assert run.scenario.mpc.model == "srbm"


def test_a_model_that_is_chosen_again_goes_on_in_its_loop_with_all_samples(session):
    first, begun = session.loop, session.tuning
    held = 0
    for model in ("srbm", begun.model, "srbm", begun.model):
        session.advance(0.01)
        session.retune(replace(begun, model=model))
        assert (session.loop is first) == (model == begun.model)
        assert session.loop.recorder.count > held
        held = session.loop.recorder.count
    assert first.recorder.count == held
    np.testing.assert_allclose(np.diff(first.recorder.samples("time")), 1e-3, atol=1e-9)


def test_lengths_change_in_the_context_and_stay_after_a_reset(session):
    loop, tuning = session.loop, session.tuning
    low = replace(tuning, com_height=0.62, swing_height=0.09)
    session.retune(low)
    assert session.loop is loop and session.tuning == low
    planner = loop.controller.GetSubsystemByName("gait_planner")
    session.reset()
    session.command([0.2, 0.0, 0.0, 1.0])
    session.advance(1.0)
    context = planner.GetMyContextFromRoot(session._simulator.get_context())
    now = planner.parameters(context)
    assert (now.single_support, now.com_height, now.swing_height) == (0.2, 0.62, 0.09)
    run = session.run()
    as_begun = Session(run.scenario, None, record=True)  # built with them
    as_begun.command([0.2, 0.0, 0.0, 1.0])
    as_begun.advance(1.0)
    assert run.scenario.gait.com_height == 0.62
    np.testing.assert_array_equal(as_begun.run().q, run.q)


def test_it_walks_on_the_estimate_and_on_the_truth_again_without_a_break(session):
    session.command([0.3, 0.0, 0.2, 1.0])
    session.advance(1.203)
    truth = session.tuning
    session.retune(replace(truth, estimation=True))
    estimator = session.loop.estimator
    assert controlled_by(session, estimator.GetOutputPort("state"))
    session.advance(1.5)
    session.retune(truth)
    assert session.loop.estimator is None
    assert controlled_by(session, session.loop.plant.outputs["state"])
    session.advance(0.8)
    assert session.fall == ""
    run = session.run()
    np.testing.assert_allclose(np.diff(run.time), 1e-3, atol=1e-9)
    assert np.abs(np.diff(run.q, axis=0)).max() < 0.02
    known = np.isfinite(run.estimate_pose[:, 0])
    assert 1.2 < run.time[known][0] < 1.21 and 2.69 < run.time[known][-1] < 2.71
    assert known.sum() == pytest.approx(1500, abs=2)
    off = run.estimate_pose[known] - run.q[known, :7]
    assert 1e-6 < np.abs(off).max() < 0.02  # it is not the truth, and stays near it
    assert run.com[-1, 0] > 0.3


def controlled_by(session, port):
    """Return whether the diagram connects the controller's `state` to `port`."""
    wires, state = (
        session.loop.connection_map(),
        session.loop.controller.GetInputPort("state"),
    )
    return wires[state.get_system(), state.get_index()] == (port.get_system(), port.get_index())


@pytest.mark.parametrize("length", [-1.0, float("nan"), float("inf")])
def test_time_only_goes_on(session, length):
    with pytest.raises(InputError, match="must be a time that is not negative"):
        session.advance(length)


def test_a_tuning_that_cannot_be_is_refused_and_nothing_changes(session):
    tuning, loop = session.tuning, session.loop
    with pytest.raises(ScenarioError, match=r"gait\.com_height"):
        session.retune(Tuning(0.2, 0.06, 2.0, "ecd"))
    assert (session.tuning, session.loop) == (tuning, loop)
    session.advance(0.01)


def test_what_was_recorded_is_a_run_with_its_commands_as_segments(session):
    session.advance(0.1)
    session.command([0.2, 0.1, -0.3, 1.0])
    session.advance(0.2)
    run = session.run()
    validate(run.scenario)
    stand, walk = run.scenario.segments
    assert (stand.walk, walk.walk) == (False, True)
    assert (walk.velocity, walk.turn_rate) == ([0.2, 0.1], -0.3)
    assert run.scenario.duration == pytest.approx(0.3)
    assert set(CHANNELS) <= set(vars(run))


def test_segments_of_one_sample():
    (only,) = segments(np.zeros(1), np.zeros((1, 4)))
    assert (only.walk, only.duration) == (False, 1e-3)


def test_without_a_recording_memory_stays_bounded(monkeypatch):
    assert KEPT < KEPT_AT_MOST <= 10_000
    most = KEPT + 100  # is reached sooner
    monkeypatch.setattr(module, "KEPT_AT_MOST", most)
    session = Session(Scenario(), None, record=False)
    session.advance(0.02)
    recorder = session.loop.recorder
    session.advance((most + 10) * 1e-3)
    assert recorder.count == KEPT
    assert recorder.samples("time")[-1] == pytest.approx(session.time, abs=2e-3)
