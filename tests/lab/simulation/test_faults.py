"""Numbers that are none, and algebra that fails, once in a walk: nothing is lost."""

import re
from dataclasses import replace

import numpy as np
import pytest

from drake_linefoot.lab.results.output import write_outputs
from drake_linefoot.lab.scenario import Scenario, Segment
from drake_linefoot.lab.simulation.recording import Run
from drake_linefoot.lab.simulation.run import run_so_far, simulate
from drake_linefoot.lab.wiring.closed_loop import build_closed_loop
from drake_linefoot.mpc import solve
from drake_linefoot.robot.humanoid import load_humanoid
from drake_linefoot.signals import layouts
from drake_linefoot.wbc.control import WholeBodyControl

STEPPING = Scenario(segments=[Segment("stand", 0.05), Segment("step", 0.15, True)])
TICK, UPDATE = 100, 5  # of the whole-body controller, of the MPC


PLAN = r".* not finite: port whole_body_controller\.plan: {} is nan: must be finite"


def at_call(monkeypatch, owner, name, number, fault):
    """Let the result of one call of a function go through `fault`."""
    function, calls = getattr(owner, name), []

    def call(*args, **options):
        calls.append(1)
        result = function(*args, **options)
        return fault(result) if len(calls) == number else result

    monkeypatch.setattr(owner, name, call)


def spoilt(name):
    """Return what makes NaN of a part of a signal, or of a program."""

    def spoil(value):
        numbers = {name: np.full_like(getattr(value, name), np.nan)}
        return value._replace(**numbers) if isinstance(value, tuple) else replace(value, **numbers)

    return spoil


def spoilt_report(name):
    """Return what makes NaN of a part of the whole-body controller's report, as it travels."""
    layout = layouts(load_humanoid("mit_humanoid").sizes)["report"]
    return lambda report: layout.vector(spoilt(name)(layout.open(report)))


def failing(error):
    def fail(_):
        raise error

    return fail


@pytest.mark.parametrize(
    ("owner", "name", "number", "fault", "reason"),
    [
        (WholeBodyControl, "compute", TICK, spoilt_report("torque"), "torque not finite"),
        (solve.MpcSolver, "solve", UPDATE, spoilt("wrench"), PLAN.format(r"wrench\[0, 0, 0\]")),
        (solve.MpcSolver, "solve", UPDATE, spoilt("states"), PLAN.format(r"states\[0, 0\]")),
        (
            WholeBodyControl,
            "compute",
            TICK,
            failing(np.linalg.LinAlgError("singular")),
            r"the controller found no solution \(singular\)",
        ),
        (
            WholeBodyControl,
            "compute",
            TICK,
            failing(RuntimeError("The mass matrix is not positive-definite.")),
            "the simulator found no solution .*not positive-definite.*",
        ),
    ],
)
def test_a_fault_is_a_fall_with_its_reason_and_the_run_is_kept(
    monkeypatch, tmp_path, owner, name, number, fault, reason
):
    at_call(monkeypatch, owner, name, number, fault)
    run = simulate(build_closed_loop(STEPPING))
    assert run.fell
    assert re.fullmatch(reason, run.fall_reason)
    assert 0.07 < run.fall_time < 0.101
    assert run.time[-1] == pytest.approx(run.fall_time, abs=0.002)
    metrics = write_outputs(run, tmp_path / "out")
    assert metrics["fall_reason"] == run.fall_reason
    np.testing.assert_array_equal(Run.load(tmp_path / "out").q, run.q)


def test_a_program_of_no_numbers_is_a_counted_failure(monkeypatch, capfd):
    at_call(monkeypatch, solve, "build_qp", UPDATE, spoilt("H"))
    run = simulate(build_closed_loop(STEPPING))
    assert not run.fell
    assert run.mpc_failures[-1] == 1
    assert run.time[-1] == pytest.approx(STEPPING.duration)
    assert capfd.readouterr().out == ""


def test_a_controller_that_fails_at_once_leaves_a_run_without_a_sample(monkeypatch, tmp_path):
    at_call(monkeypatch, WholeBodyControl, "compute", 1, failing(np.linalg.LinAlgError("singular")))
    loop = build_closed_loop(STEPPING)
    run = simulate(loop)
    assert run_so_far(loop) is None
    assert (run.fell, len(run.time), run.realtime_rate) == (True, 0, 0.0)
    write_outputs(run, tmp_path / "out")
    assert Run.load(tmp_path / "out").fall_reason == run.fall_reason


def test_a_simulation_stops_when_it_is_asked_to():
    times = iter([False, True])
    run = simulate(build_closed_loop(STEPPING), stop=lambda: next(times))
    assert not run.fell
    assert run.time[-1] == pytest.approx(0.125)
