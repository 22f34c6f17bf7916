import hashlib
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from pydrake.systems.framework import EventStatus

from drake_linefoot.errors import SignalError
from drake_linefoot.lab.scenario import Perturbation, Scenario, Segment
from drake_linefoot.lab.simulation import run as run_module
from drake_linefoot.lab.simulation.recording import CHANNELS, WALL_TIMES
from drake_linefoot.lab.simulation.run import fall_reason, simulate
from drake_linefoot.lab.wiring.closed_loop import build_closed_loop
from drake_linefoot.math.rotation import roll_pitch_yaw
from drake_linefoot.robot.humanoid import load_humanoid
from tests.helpers.recorded_runs import SHORT, Limp, short_run

ROOT = Path(__file__).resolve().parents[3]
RANDOM = Scenario(
    seed=5,
    segments=[Segment("stand", 0.05), Segment("step", 0.15, True)],
    perturbation=Perturbation(0.005, 0.02, 0.02),
)


def digest(run):
    """One number for everything that was logged, but for wall times."""
    sums = hashlib.sha256()
    for name in CHANNELS:
        if name not in WALL_TIMES:
            sums.update(np.ascontiguousarray(getattr(run, name)).tobytes())
    return sums.hexdigest()


def test_a_run_says_what_it_was():
    run = short_run()
    assert run.scenario == SHORT
    assert not run.fell
    assert run.fall_time is None
    assert run.fall_reason == ""
    assert run.time[-1] == pytest.approx(0.4)
    assert run.joint_names[0] == "left_hip_yaw"
    assert run.effort_limits.shape == (18,)
    assert 0.0 < run.realtime_rate < 100.0


def test_the_same_loop_and_a_new_one_give_the_same_bits():
    loop = build_closed_loop(RANDOM)
    first = digest(simulate(loop))
    assert digest(simulate(loop)) == first
    assert digest(simulate(build_closed_loop(RANDOM))) == first


def test_another_process_gives_the_same_bits():
    """So does one that compiles all kernels anew: see tests/test_packaging.py."""
    code = f"import sys; sys.path.insert(0, {str(ROOT)!r})\n" + (
        "from tests.lab.simulation.test_run import RANDOM, build_closed_loop, digest, simulate\n"
        "print(digest(simulate(build_closed_loop(RANDOM))))"
    )
    said = subprocess.check_output([sys.executable, "-c", code], text=True, timeout=600)
    assert said.split()[-1] == digest(simulate(build_closed_loop(RANDOM)))


def test_progress_tells_time_rate_and_velocity():
    reports = []
    simulate(build_closed_loop(SHORT), progress=reports.append)
    assert [r.time for r in reports] == pytest.approx([0.125, 0.25, 0.375, 0.4])
    assert all(r.duration == pytest.approx(0.4) for r in reports)
    assert all(r.realtime_rate > 0.0 for r in reports)
    np.testing.assert_array_equal(reports[-1].commanded, [0.1, 0.0, 0.0])
    assert np.abs(reports[-1].measured).max() < 0.2


def test_a_robot_without_torque_falls_and_the_run_ends_there():
    scenario = Scenario(segments=[Segment("stand", 5.0)])
    reports = []
    run = simulate(build_closed_loop(scenario, controller=Limp()), progress=reports.append)
    assert run.fell
    assert 0.1 < run.fall_time < 2.0
    assert run.time[-1] == pytest.approx(run.fall_time)
    assert "torso" in run.fall_reason
    assert reports[-1].time == pytest.approx(run.fall_time)


@pytest.mark.parametrize(("angle", "fallen"), [(0.95, False), (1.05, True), (3.0, True)])
@pytest.mark.parametrize("axis", [0, 1])
def test_tilt(angle, fallen, axis):
    humanoid = load_humanoid("mit_humanoid")
    q = humanoid.q_nominal.copy()
    q[0], q[1 + axis] = np.cos(0.5 * angle), np.sin(0.5 * angle)
    assert roll_pitch_yaw(q[:4])[axis] != 0.0
    assert ("tilted" in fall_reason(humanoid, q)) == fallen


def test_turning_is_no_tilt_and_crouching_no_fall():
    humanoid = load_humanoid("mit_humanoid")
    q = humanoid.q_nominal.copy()
    q[0], q[3] = np.cos(1.5), np.sin(1.5)
    q[6] *= 0.65
    assert fall_reason(humanoid, q) == ""
    q[6] *= 0.9
    assert "high, below" in fall_reason(humanoid, q)


def test_a_state_that_is_not_finite_is_a_fall():
    humanoid = load_humanoid("mit_humanoid")
    q = humanoid.q_nominal.copy()
    q[10] = np.nan
    assert "not finite" in fall_reason(humanoid, q)


def failing(error):
    """Return a watch that lets the simulation fail with `error` after 20 ms."""

    class Watch(run_module.FallWatch):
        def __call__(self, root):
            if root.get_time() > 0.02:
                raise error
            return EventStatus.DidNothing()

    return Watch


@pytest.mark.parametrize(
    ("error", "reason"),
    [
        (RuntimeError("discrete update solver failed to converge at t = 0.02"), "no solution"),
        (RuntimeError("NewtonWithBisectionFallback did not converge."), "no solution"),
        (SignalError("gait_planner.state", "element 3 is nan"), r"not finite: port gait_planner"),
    ],
)
def test_a_simulation_that_breaks_down_is_a_fall(monkeypatch, error, reason):
    monkeypatch.setattr(run_module, "FallWatch", failing(error))
    run = simulate(build_closed_loop(SHORT))
    assert run.fell
    assert run.fall_time == pytest.approx(0.021, abs=2e-3)
    assert reason in run.fall_reason


def test_other_errors_are_not_taken_for_a_fall(monkeypatch):
    monkeypatch.setattr(run_module, "FallWatch", failing(RuntimeError("out of paper")))
    with pytest.raises(RuntimeError, match="out of paper"):
        simulate(build_closed_loop(SHORT))


def test_a_quaternion_that_drifts_is_brought_back_and_nothing_else_changes(monkeypatch):
    loop = build_closed_loop(SHORT)
    monkeypatch.setattr(run_module, "LARGEST_DRIFT", 1e-10)
    run, whole = simulate(loop), short_run()
    norms = np.linalg.norm(loop.recorder.samples("q")[:, :4], axis=1)
    before = np.arange(124, len(norms) - 1, 125)
    assert np.abs(norms[before] - 1.0).max() > 1e-9  # it drifts
    np.testing.assert_allclose(norms[before + 2], 1.0, atol=1e-9)
    np.testing.assert_allclose(run.q, whole.q, atol=1e-7)
    np.testing.assert_allclose(run.contact_wrench, whole.contact_wrench, atol=1e-3)
