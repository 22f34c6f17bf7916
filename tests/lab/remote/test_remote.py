"""The controller's end and the robot's: the same bits in lockstep, and what goes wrong between."""

import os
import signal
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

from drake_linefoot.errors import RemoteError
from drake_linefoot.lab.remote.bus import Bus
from drake_linefoot.lab.remote.control import RemoteControl
from drake_linefoot.lab.remote.messages import (
    DAMP,
    HOLD,
    KINDS,
    ControllerStatus,
    RobotInput,
    RobotOutput,
    WalkCommand,
    decode,
    encode,
)
from drake_linefoot.lab.remote.robot import SILENCE, RemoteController
from drake_linefoot.lab.scenario import PlantParameters, Scenario, Segment
from drake_linefoot.lab.simulation.recording import Run
from drake_linefoot.lab.simulation.run import simulate
from drake_linefoot.lab.wiring.closed_loop import build_closed_loop
from drake_linefoot.mpc import solve
from drake_linefoot.wiring.without_simulator import Controller
from tests.lab.simulation.test_faults import spoilt

SCENARIO = Scenario(segments=[Segment("stand", 0.1), Segment("walk", 0.7, True, [0.4, 0.05], 0.2)])


class Wire:
    """Carries messages, as bytes, between a block and a control in this process.

    Attributes:
        spoil: what becomes of a state on its way; None loses it.
        time: of the clock, one tick later with each state [s].
    """

    def __init__(self, control, spoil=lambda state: state):
        self.control, self.spoil, self.newest, self.time = control, spoil, None, 0.0

    def publish(self, message):
        message = decode(type(message), encode(message))
        if isinstance(message, WalkCommand):
            self.control.command(message)
            return
        self.time += 0.001
        message = self.spoil(message)
        answer = None if message is None else self.control.answer(message)
        if answer is not None:
            self.newest = decode(RobotInput, encode(answer))

    def wait(self, timeout):
        pass

    def take(self, kind):
        answer, self.newest = self.newest, None
        return answer


def walked(humanoid, spoil=lambda state: state, lockstep=True, scenario=SCENARIO):
    """A run whose controller is at the end of a wire; the control and the block."""
    control = RemoteControl(Controller(humanoid, scenario))
    wire = Wire(control, spoil)
    block = RemoteController(humanoid, wire, lockstep=lockstep, clock=lambda: wire.time)
    return simulate(build_closed_loop(scenario, controller=block)), control, block


@pytest.fixture(scope="module")
def usual():
    return simulate(build_closed_loop(SCENARIO))


def test_in_lockstep_it_walks_with_the_same_bits(humanoid, usual):
    run, control, block = walked(humanoid)
    assert not run.fell
    np.testing.assert_array_equal(run.q, usual.q)
    np.testing.assert_array_equal(run.v, usual.v)
    np.testing.assert_array_equal(run.torque, usual.torque)
    status = control.status()
    assert (status.seq, status.begun, status.missed, status.refused) == (800, 1, 0, 0)
    assert status.fault == "" and status.worst_tick > 0.0
    assert status.contact.sum() >= 1.0
    assert block.braked == 0


@pytest.mark.parametrize("simulator", ["drake", "mujoco"])
def test_the_imu_feels_the_weight_of_a_robot_that_stands(humanoid, simulator):
    pytest.importorskip(simulator if simulator == "mujoco" else "pydrake")
    said = []
    stand = replace(SCENARIO, segments=[Segment("stand", 0.5)])
    stand.plant = PlantParameters(simulator=simulator)
    walked(humanoid, lambda state: said.append(state.imu) or state, scenario=stand)
    np.testing.assert_array_equal(said[0], np.zeros(6))
    np.testing.assert_allclose(np.mean(said[300:], axis=0), [0, 0, 0, 0, 0, 9.81], atol=0.3)


def losing(share, seed=0):
    """Lose a share of the states, but the first one."""
    random = np.random.default_rng(seed)
    return lambda state: None if state.seq and random.uniform() < share else state


@pytest.mark.parametrize("share", [0.01, 0.05, 0.2])
def test_states_that_are_lost_are_survived(humanoid, usual, share):
    run, control, block = walked(humanoid, losing(share), lockstep=False)
    assert not run.fell, run.fall_reason
    np.testing.assert_allclose(run.com[-1], usual.com[-1], atol=0.05)
    assert control.status().missed == pytest.approx(800 * share, rel=0.6)
    assert block.late > 0 and block.braked == 0


def test_states_out_of_order_are_dropped(humanoid):
    before = []

    def disorder(state):
        before.append(state)
        return before[-3] if state.seq and state.seq % 7 == 0 else state

    run, control, _ = walked(humanoid, disorder, lockstep=False)
    assert not run.fell, run.fall_reason
    assert control.status().old == pytest.approx(800 / 7, abs=2)


def spoiled(ticks):
    """Make NaN of a velocity in some ticks."""

    def spoil(state):
        if state.seq not in ticks:
            return state
        velocity = state.velocity.copy()
        velocity[3] = np.nan
        return state._replace(velocity=velocity)

    return spoil


def test_two_states_that_are_not_finite_are_bridged_by_the_last_torque(humanoid):
    run, control, block = walked(humanoid, spoiled({300, 301, 500}))
    assert not run.fell
    np.testing.assert_array_equal(run.torque[300], run.torque[299])
    np.testing.assert_array_equal(run.torque[301], run.torque[299])
    assert (run.torque[302] != run.torque[299]).any()
    assert (control.status().refused, block.braked) == (3, 0)


def test_at_the_third_in_a_row_joints_are_braked(humanoid):
    run, _, block = walked(humanoid, spoiled({300, 301, 302, 303}))
    assert block.braked == 2
    v = run.v[302][humanoid.actuated_v]
    damping = humanoid.effort_limits / humanoid.velocity_limits
    np.testing.assert_allclose(run.torque[302], -damping * v)
    assert (run.torque[304] != 0.0).all()


def test_silence_is_braked_and_a_standing_robot_survives_it(humanoid):
    """Of 15 ms the torque holds; of 40 ms joints are braked from the 20th on."""
    stand = replace(SCENARIO, segments=[Segment("stand", 1.0)])

    def silent(begin, end):
        return lambda state: None if begin <= state.seq < end else state

    run, _, block = walked(humanoid, silent(300, 315), lockstep=False, scenario=stand)
    assert not run.fell and block.braked == 0 and block.late >= 15
    run, control, block = walked(humanoid, silent(300, 340), lockstep=False, scenario=stand)
    assert not run.fell and 15 <= block.braked <= 25
    assert round(1e3 * SILENCE) == 20
    assert control.status().begun == 2  # 40 ticks are too many to be repeated


def test_a_controller_that_is_new_takes_over(humanoid):
    """As one that was killed and started again beside a robot that stands."""
    stand = replace(SCENARIO, segments=[Segment("stand", 0.8)])
    wires = []

    def exchange(state):
        if state.seq == 400:
            wires[0].control = RemoteControl(Controller(humanoid, stand))
        return state

    control = RemoteControl(Controller(humanoid, stand))
    wires.append(Wire(control, exchange))
    block = RemoteController(humanoid, wires[0], clock=lambda: wires[0].time)
    run = simulate(build_closed_loop(stand, controller=block))
    assert not run.fell and wires[0].control is not control
    np.testing.assert_allclose(run.q[-1], run.q[399], atol=0.01)


@pytest.fixture
def control(humanoid):
    return RemoteControl(Controller(humanoid))


def state(humanoid, seq, **changes):
    q, v = np.split(humanoid.x_nominal, [humanoid.nq])
    message = RobotOutput(1000 * seq, seq, q, v, np.zeros(humanoid.na), np.zeros(6))
    return message._replace(**changes)


def test_a_state_of_another_robot_is_not_answered(humanoid, control):
    short = np.zeros(humanoid.nq - 1)
    assert control.answer(state(humanoid, 0, position=short)) is None
    status = control.status()
    assert status.refused == 1 and "has shape (48,): must be (49,)" in status.fault
    assert status.begun == 0
    assert control.answer(state(humanoid, 0)).mode == HOLD
    assert control.status().fault == ""


def test_a_first_state_that_is_not_finite_is_braked(humanoid, control):
    answer = control.answer(state(humanoid, 0, velocity=np.full(humanoid.nv, np.nan)))
    assert answer.mode == DAMP and (answer.effort == 0.0).all() and (answer.damping > 0.0).all()
    assert control.answer(state(humanoid, 1)).mode == HOLD


def test_the_same_state_gets_the_same_answer_and_changes_nothing(humanoid, control):
    for seq in (0, 1, 2):
        first = control.answer(state(humanoid, seq))
        saved = control.controller.save()
        again = control.answer(state(humanoid, seq))
        np.testing.assert_array_equal(first.effort, again.effort)
        np.testing.assert_array_equal(control.controller.save(), saved)
    assert control.status().old == 0


def test_missed_ticks_are_repeated_and_after_many_it_begins_anew(humanoid, control):
    control.answer(state(humanoid, 0))
    answer = control.answer(state(humanoid, 11))
    status = control.status()
    assert (status.missed, status.begun) == (10, 1)
    other = Controller(humanoid)
    x = humanoid.x_nominal
    other.begin(x)
    for _ in range(11):
        torque = other.tick(x, np.zeros(humanoid.na), np.zeros(4))
    np.testing.assert_array_equal(answer.effort, torque)
    control.answer(state(humanoid, 40))
    assert control.status().begun == 2
    control.answer(state(humanoid, 0))  # the robot was started again
    assert control.status().begun == 3


def test_a_command_that_is_old_is_one_to_stand(humanoid, control):
    control.answer(state(humanoid, 0))
    control.command(WalkCommand(0, np.array([0.3, 0.0]), 0.0, 1))
    control.command(WalkCommand(1000, np.array([np.nan, 0.0]), 0.0, 1))  # it is refused
    told = control._told
    np.testing.assert_array_equal(told(400_000), [0.3, 0.0, 0.0, 1.0])
    np.testing.assert_array_equal(told(600_000), np.zeros(4))


def test_plans_without_a_solution_are_counted(humanoid, control, monkeypatch):
    control.answer(state(humanoid, 0))
    control.answer(state(humanoid, 1))
    assert control.status().unsolved == 0

    build, no_numbers = solve.build_qp, spoilt("H")
    monkeypatch.setattr(solve, "build_qp", lambda *args, **kw: no_numbers(build(*args, **kw)))
    for seq in range(2, 45):
        assert control.answer(state(humanoid, seq)).mode == HOLD
    assert control.status().unsolved == 2


def test_nobody_there_is_said(humanoid, monkeypatch):
    from drake_linefoot.lab.remote import robot

    monkeypatch.setattr(robot, "PATIENCE", 0.05)

    class Deaf(Wire):
        def publish(self, message):
            self.time += 0.01

        def wait(self, timeout):
            self.time += timeout

    wire = Deaf(None)
    block = RemoteController(humanoid, wire, clock=lambda: wire.time)
    loop = build_closed_loop(SCENARIO, controller=block)
    with pytest.raises(RemoteError, match="no controller has answered"):
        loop.make_simulator().Initialize()


def test_a_bus_keeps_the_newest_of_each_kind():
    bus = Bus(*KINDS.values(), url="memq://")
    for seq in range(3):
        bus.publish(RobotInput(1, seq, HOLD, np.zeros(2), np.ones(2)))
    status = ControllerStatus(0, 0, np.ones(2), 0, 0, 0, 0, 0, 0.0, "")
    bus.publish(status)
    bus.wait(0.1)
    assert bus.take(RobotInput).seq == 2
    assert bus.take(RobotInput) is None and bus.take(RobotOutput) is None
    assert bus.take(ControllerStatus).fault == ""
    bus._lcm.Publish("ROBOT_INPUT", b"nothing of ours")
    bus.wait(0.1)
    assert bus.take(RobotInput) is None and bus.damaged == 1


@pytest.mark.slow
def test_two_processes_walk_in_lockstep_with_the_same_bits(tmp_path, usual):
    port = 20000 + os.getpid() % 20000
    url = f"udpm://239.255.76.67:{port}?ttl=0"
    from drake_linefoot.lab.scenario.load import dump_scenario

    file = tmp_path / "short.yaml"
    file.write_text(dump_scenario(usual.scenario), encoding="utf-8")
    program = [sys.executable, "-m", "drake_linefoot"]
    with subprocess.Popen([*program, "control", str(file), "--url", url]) as control:
        words = ["simulate", str(file), "--url", url, "--lockstep", "--no-replay"]
        try:
            subprocess.run(
                [*program, *words, "--out", str(tmp_path / "out")], check=True, timeout=300
            )
        finally:
            control.send_signal(signal.SIGINT)
    assert control.returncode == 130
    run = Run.load(tmp_path / "out")
    np.testing.assert_array_equal(run.q, usual.q)
    np.testing.assert_array_equal(run.torque, usual.torque)
