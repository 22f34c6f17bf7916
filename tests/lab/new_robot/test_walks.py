"""Robots described from their models walk, with nothing typed."""

import numpy as np
import pytest

from drake_linefoot.lab import cli
from drake_linefoot.lab.new_robot.folder import scenario_beside
from drake_linefoot.lab.results.metrics import compute_metrics
from drake_linefoot.lab.scenario.edit import with_duration
from drake_linefoot.lab.scenario.load import load_scenario
from drake_linefoot.lab.simulation.run import simulate
from drake_linefoot.lab.wiring.closed_loop import build_closed_loop
from drake_linefoot.robot.description import robot_file
from tests.helpers import made_up_robots as made_up


def walked(folder, name, duration, *changes):
    """Describe a robot by the command and walk its scenario; return the run."""
    tree = made_up.mit()
    for change in changes:
        change(tree)
    model = made_up.write(tree, folder, name)
    out = folder / f"{name}_described"
    assert cli.main(["new-robot", str(model), "--out", str(out)]) == 0
    scenario = load_scenario(scenario_beside(robot_file(out)))
    return simulate(build_closed_loop(with_duration(scenario, duration)))


def turn_frames(tree):
    made_up.turn_frame(tree, "torso", made_up.TURNED)
    made_up.turn_feet(tree)


@pytest.mark.slow
def test_a_robot_with_other_frames_walks_the_same(tmp_path):
    """Until rounding has grown."""
    plain, other = (
        walked(tmp_path, name, 1.9, *changes)
        for name, changes in (("plain", ()), ("turned", (turn_frames,)))
    )
    assert plain.gait_steps[-1] >= 1  # it has lifted a foot
    np.testing.assert_allclose(other.com, plain.com, atol=1e-6)
    np.testing.assert_allclose(other.rpy, plain.rpy, atol=1e-5)
    np.testing.assert_allclose(other.contact_points, plain.contact_points, atol=1e-5)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "lower", "upper"),
    [("ankle", -0.5, 0.7), ("ankle", -0.38, 0.38), ("knee", 0.0, 0.8), ("hip_pitch", -0.45, 0.3)],
)
def test_legs_that_turn_little_walk_as_told(tmp_path, kind, lower, upper):
    """Clear of the stops, while the foot stands."""
    run = walked(tmp_path, "biped", 4.5, lambda tree: made_up.bound(tree, kind, lower, upper))
    metrics = compute_metrics(run)
    assert not run.fell and metrics["joints_at_stops"] == {}
    assert metrics["segments"][1]["error"][0] == pytest.approx(0.0, abs=0.03)
    assert metrics["slip_m"] < 0.01


@pytest.mark.slow
def test_box_feet_ankle_rolls_and_a_waist_walk(tmp_path):
    changes = made_up.box_feet, made_up.add_roll, made_up.add_waist, made_up.drop_transmissions
    run = walked(tmp_path, "biped", 5.0, *changes)
    assert not run.fell
    speed = (run.com[-1, 0] - run.com[3000, 0]) / 2.0
    assert speed == pytest.approx(run.scenario.segments[1].velocity[0], abs=0.05)
    assert np.abs(run.rpy[:, :2]).max() < np.radians(4.0)
