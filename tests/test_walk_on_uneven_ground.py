"""The closed loop on ground its controller knows nothing of: 10 degrees, and random tiles."""

import numpy as np
import pytest

from drake_linefoot.results.metrics import compute_metrics
from drake_linefoot.scenario import Scenario, Segment
from drake_linefoot.scenario.disturbances import GroundParameters
from drake_linefoot.simulation.run import simulate
from drake_linefoot.simulation.scene import ground_of
from drake_linefoot.wiring.closed_loop import build_closed_loop

SPEED, DURATION = 0.4, 5.0
TILT = 0.1  # [rad]
SPEED_ERROR = 0.06  # [m/s, rad/s]
SLIP = 0.03  # [m] a step


def walked(**entries):
    """A walk straight ahead, and what is to say of it."""
    segments = [Segment("forward", DURATION, True, [SPEED, 0.0])]
    loop = build_closed_loop(Scenario(segments=segments, **entries))
    run = simulate(loop)
    metrics = compute_metrics(run)
    assert not metrics["fell"], metrics["fall_reason"]
    assert metrics["duration_s"] == pytest.approx(DURATION)
    assert metrics["solver_failures"] == {"mpc": 0, "wbc": 0}
    assert metrics["roll_max_rad"] <= TILT
    assert metrics["pitch_max_rad"] <= TILT
    assert metrics["slip_m"] <= SLIP
    assert np.abs(metrics["segments"][0]["error"]).max() <= SPEED_ERROR
    return run


@pytest.mark.slow
@pytest.mark.parametrize("heading", [0.0, 0.5 * np.pi, np.pi, 1.5 * np.pi])
def test_it_walks_up_down_and_along_a_slope(heading):
    """And ends on the slope, as high above it as it stood above the pad."""
    run = walked(scene="slope_10", ground=GroundParameters(slope_heading=heading))
    ground = ground_of(run.scenario)
    start, end = run.q[0, 4:7], run.q[-1, 4:7]
    assert end[0] > 1.2  # the slope begins at 0.5 m
    above = end[2] - ground.plane(end[0], end[1])
    assert above == pytest.approx(start[2], abs=0.06)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2])
def test_it_walks_over_random_tiles(seed):
    run = walked(scene="rough", ground=GroundParameters(step_height=0.03), seed=seed)
    assert run.q[-1, 4] > 1.2
