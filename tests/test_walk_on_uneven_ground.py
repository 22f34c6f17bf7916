"""The closed loop on ground its controller knows nothing of: 10 degrees, random tiles, friction."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from drake_linefoot.gait.parameters import GaitParameters
from drake_linefoot.lab.plants.scene import ground_of
from drake_linefoot.lab.results.clearance import leg_clearance
from drake_linefoot.lab.results.contact_events import largest_slip
from drake_linefoot.lab.results.metrics import compute_metrics, segment_velocity
from drake_linefoot.lab.results.thresholds import thresholds_of
from drake_linefoot.lab.scenario import Scenario, Segment
from drake_linefoot.lab.scenario.disturbances import GroundParameters
from drake_linefoot.lab.scenario.schema import PlantParameters
from drake_linefoot.lab.simulation.run import simulate
from drake_linefoot.lab.simulation.run_view import robot_of
from drake_linefoot.lab.sweep.file import load_sweep
from drake_linefoot.lab.sweep.jobs import job
from drake_linefoot.lab.sweep.worker import simulated
from drake_linefoot.lab.wiring.closed_loop import build_closed_loop

SPEED, DURATION = 0.4, 5.0
TILT = 0.1  # [rad]
SPEED_ERROR = 0.06  # [m/s, rad/s]
SLIP = 0.03  # [m] a step
ON_TILES = 0.08, 10  # likewise; ticks on an edge whose wrench is moved into its cone instead


def walked(bars=(SPEED_ERROR, 0), **entries):
    """A walk straight ahead; bars are of the error of its speed and of ticks without a solution."""
    segments = [Segment("forward", DURATION, True, [SPEED, 0.0])]
    loop = build_closed_loop(Scenario(segments=segments, **entries))
    run = simulate(loop)
    metrics = compute_metrics(run)
    assert not metrics["fell"], metrics["fall_reason"]
    assert metrics["duration_s"] == pytest.approx(DURATION)
    assert metrics["solver_failures"]["mpc"] == 0
    assert metrics["solver_failures"]["wbc"] <= bars[1]
    assert metrics["roll_max_rad"] <= TILT
    assert metrics["pitch_max_rad"] <= TILT
    assert metrics["slip_m"] <= SLIP
    assert np.abs(metrics["segments"][0]["error"]).max() <= bars[0]
    gap = run.contact_points[..., 2] - loop.ground.height(*run.contact_points[..., :2].T).T
    assert -0.02 < gap.min() < 0.002 and gap.max() > 0.03
    return run


@pytest.mark.slow
@pytest.mark.parametrize("heading", [0.0, 0.5 * np.pi, np.pi])
def test_it_walks_up_down_and_along_a_slope(heading):
    """And ends on the slope, as high above it as it stood above the pad.

    Along it with the slope at its left; at its right would be the mirror image.
    """
    run = walked(scene="slope_10", ground=GroundParameters(slope_heading=heading))
    ground = ground_of(run.scenario)
    start, end = run.q[0, 4:7], run.q[-1, 4:7]
    assert end[0] > 1.2  # the slope begins at 0.5 m
    above = end[2] - ground.plane(end[0], end[1])
    assert above == pytest.approx(start[2], abs=0.06)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2])
def test_it_walks_over_random_tiles(seed):
    run = walked(ON_TILES, scene="rough", ground=GroundParameters(step_height=0.03), seed=seed)
    assert run.q[-1, 4] > 1.2


def run_of(case, index):
    """A run of a case of the robustness study, with a seed for tuning."""
    sweep = load_sweep(Path(__file__).parents[1] / "examples" / "sweeps" / "robustness.yaml")
    (group,) = (group for group in sweep.groups if group.name == case)
    return simulated(job(replace(sweep, seed=1), group, index).scenario)


@pytest.mark.slow
@pytest.mark.parametrize("index", [3, 16])
def test_where_a_steep_slope_begins_feet_stand_on_their_toes_and_tell_of_it(index):
    run = run_of("wide_slope_15", index)
    assert not run.fell
    assert (run.reference_friction_share[run.time < 4.0] < 1.0).any()
    places, ground = run.foothold[run.time > 5.0][::100].reshape(-1, 4), ground_of(run.scenario)
    misses = [place[2] - ground.plane(*place[:2]) for place in places]
    assert np.nanmedian(np.abs(misses)) < 0.01


@pytest.mark.slow
def test_a_foot_on_its_toe_does_not_spin_into_the_other_leg():
    """Its heel hangs beyond the edge of a tile; the whole-body controller counts on the toe."""
    run = run_of("wide_rough", 13)
    assert not run.fell
    assert (run.reference_friction_share < 1.0).any()
    along = run.contact_points[:, :, 1] - run.contact_points[:, :, 0]
    yaw = np.unwrap(np.arctan2(along[..., 1], along[..., 0]), axis=0)
    for side in (0, 1):
        alone = run.planned_contact[:, side] * (1.0 - run.planned_contact[:, 1 - side])
        begun, ended = (np.flatnonzero(np.diff(alone) == change) + 1 for change in (1.0, -1.0))
        turned = [np.ptp(yaw[a:b, side]) for a, b in zip(begun, ended, strict=False)]
        assert len(turned) > 10
        assert max(turned) < 0.35
    assert leg_clearance(robot_of(run), run.q[::10]).min() > 0.0


def walk_at(friction, **gait):
    """A fast walk in a curve, on ground with a friction."""
    segments = [Segment("curve", 4.0, True, [0.8, 0.0], turn_rate=0.4)]
    ground, parameters = GroundParameters(friction=friction), GaitParameters(**gait)
    return simulate(build_closed_loop(Scenario(segments=segments, ground=ground, gait=parameters)))


@pytest.mark.slow
def test_it_learns_the_friction_of_slippery_ground_and_slides_less():
    learned, unaware = walk_at(0.4), walk_at(0.4, slip_min=1.0)
    assert not learned.fell
    known = learned.reference_friction[learned.time > 2.0]
    assert 0.3 < known.min() < 0.45
    assert known.mean() == pytest.approx(0.4, abs=0.1)
    np.testing.assert_array_equal(unaware.reference_friction, 1.0)

    def slid(run):  # distance of the stance feet
        standing = run.planned_contact.sum(axis=1) == 1.0
        return (run.slip_speed * run.planned_contact)[standing].sum() * 0.001

    assert slid(learned) < 0.7 * slid(unaware)


@pytest.mark.slow
@pytest.mark.parametrize("creep", [0.02, 0.1])
def test_feet_that_creep_do_not_slow_it(creep):
    """By some millimetres a step, for friction is regularised: the ground holds all the same."""
    segments = [Segment("forward", 4.0, True, [0.8, 0.0])]
    plant = PlantParameters(stiction_tolerance=creep)
    run = simulate(build_closed_loop(Scenario(segments=segments, plant=plant)))
    assert not run.fell
    assert largest_slip(run.contact_points, run.true_normal, thresholds_of(run)) > 0.002
    np.testing.assert_array_equal(run.reference_limited, 0.0)
    assert segment_velocity(run, 0.0, 4.0)[0] == pytest.approx(0.8, abs=0.08)


@pytest.mark.slow
def test_feet_that_move_in_the_estimate_alone_do_not_slow_it():
    segments = [Segment("forward", 4.0, True, [1.2, 0.0])]
    run = simulate(build_closed_loop(Scenario(segments=segments, estimation=True)))
    assert not run.fell
    np.testing.assert_array_equal(run.reference_limited, 0.0)
    assert segment_velocity(run, 0.0, 4.0)[0] == pytest.approx(1.2, abs=0.1)


@pytest.mark.slow
def test_it_believes_nothing_of_ground_that_holds():
    run = walk_at(0.8)
    assert not run.fell
    np.testing.assert_array_equal(run.reference_friction, 1.0)
