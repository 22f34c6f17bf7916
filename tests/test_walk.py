"""The main job, judged: the shipped walk, from six initial perturbations."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from drake_linefoot.lab.results.metrics import compute_metrics
from drake_linefoot.lab.scenario.load import load_scenario
from drake_linefoot.lab.simulation.run import simulate
from drake_linefoot.lab.wiring.closed_loop import build_closed_loop

TILT = 0.15  # [rad]
SPEED_ERROR = 0.08  # [m/s, rad/s]
SLIP = 0.03  # [m] a step
STILL = 0.05  # [rad/s] joint speed RMS at the end
CHATTER = 0.3  # [N m] torque change in one tick when standing still; MPC updates make 0.1


def judged(scenario):
    """A run and its metrics, which hold the bars of any walk."""
    run = simulate(build_closed_loop(scenario))
    metrics = compute_metrics(run)
    assert not metrics["fell"], metrics["fall_reason"]
    assert metrics["duration_s"] == pytest.approx(run.scenario.duration)
    assert metrics["solver_failures"] == {"mpc": 0, "wbc": 0}
    assert metrics["roll_max_rad"] <= TILT
    assert metrics["pitch_max_rad"] <= TILT
    assert len(metrics["segments"]) == len(run.scenario.segments)
    for segment in metrics["segments"]:
        assert np.abs(segment["error"]).max() <= SPEED_ERROR, segment
    assert metrics["slip_m"] <= SLIP
    assert np.all(np.abs(run.applied_torque) <= run.effort_limits)
    assert np.array_equal(run.torque[:-1], run.applied_torque[1:])  # nothing was clamped
    assert metrics["contact"]["missed"] == 0
    return run, metrics


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(2, 6))
def test_it_starts_from_other_perturbations(seed):
    """They are of the first state alone: after 3 s of standing and stepping they are forgotten."""
    scenario = load_scenario("walk", {"seed": seed})
    _, metrics = judged(replace(scenario, segments=scenario.segments[:3]))
    assert metrics["steps"] > 8


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(2))
def test_shipped_walk_holds_its_bars(seed):
    run, metrics = judged(load_scenario("walk", {"seed": seed}))
    assert metrics["final_joint_speed_rms"] <= STILL
    last_second = run.torque[run.time > run.time[-1] - 1.0]
    assert np.abs(np.diff(last_second, axis=0)).max() <= CHATTER
    assert metrics["steps"] > 40
    if seed == 0:
        check_readme(metrics)


def check_readme(metrics):
    """What the README says of this walk, to the digits it has; when it fails, change them there."""
    readme = (Path(__file__).parents[1] / "README.md").read_text(encoding="utf-8")
    cell = r"\| *([-\d., ]+?) *"
    rows = re.findall(rf"^\| [a-z ]+{cell}{cell}\|$", readme, re.MULTILINE)
    rows = [[[float(x) for x in cell.split(",")] for cell in row] for row in rows]
    walked = metrics["segments"][1:]  # the first stands
    assert [row[0] for row in rows] == [segment["commanded"] for segment in walked]
    for (_, measured), segment in zip(rows, walked, strict=True):
        np.testing.assert_allclose(segment["measured"], measured, atol=0.01)
    said = re.search(
        r"roll stays within (\S+) and pitch within (\S+) degrees, .* than (\S+) mm", readme
    )
    tilt = np.degrees([metrics["roll_max_rad"], metrics["pitch_max_rad"]])
    found = [*tilt, 1e3 * metrics["slip_m"]]
    np.testing.assert_allclose(found, [float(x) for x in said.groups()], atol=0.1)


@pytest.mark.slow
def test_single_rigid_body_model_walks_too():
    """The baseline is the same code with frozen inertia; at moderate speed it stays up."""
    overrides = {"mpc.model": "srbm"}
    scenario = load_scenario("walk", overrides)
    scenario.segments = scenario.segments[:3]
    metrics = compute_metrics(simulate(build_closed_loop(scenario)))
    assert not metrics["fell"], metrics["fall_reason"]
    assert metrics["solver_failures"] == {"mpc": 0, "wbc": 0}
