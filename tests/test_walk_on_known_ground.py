"""Walks over ground that the controller has a map of, in the closed loop."""

from pathlib import Path

import numpy as np
import pytest
import yaml

from drake_linefoot.gait.state import gait_state
from drake_linefoot.lab.plants.scene import ground_of
from drake_linefoot.lab.scenario.load import load_scenario, make_scenario
from drake_linefoot.lab.simulation.run import simulate
from drake_linefoot.lab.wiring.closed_loop import build_closed_loop
from drake_linefoot.signals import open_targets

EXAMPLES = Path(__file__).parent.parent / "examples"
STAND = {"name": "stand", "duration": 0.3}


def walked(speed, duration, **entries):
    """A run straight ahead."""
    walk = {"name": "walk", "duration": duration, "walk": True, "velocity": [speed, 0.0]}
    given = {"segments": [STAND, walk], "terrain": {"source": "scene"}, **entries}
    return simulate(build_closed_loop(make_scenario(given, "walk")))


def overhang(run):
    """How far heel or toe of a foot that stands is from the ground below it, at most [m]."""
    ground, points = ground_of(run.scenario), run.contact_points
    stands = run["targets.contact"] > 0.5
    gap = points[..., 2] - ground.height(*np.moveaxis(points[..., :2], -1, 0))
    return float(np.abs(gap[stands]).max())


@pytest.mark.slow
@pytest.mark.parametrize("rise", [0.12, -0.12])
def test_it_climbs_and_descends_stairs(rise):
    """Treads of 25 to 30 cm, turned: blind it falls at the first one."""
    stairs = {"rise": rise, "tread": [0.25, 0.3], "steps": 3, "at": 0.5, "heading": 0.15}
    run = walked(0.4, 4.6, ground={"stairs": stairs}, seed=3)
    assert not run.fell
    end = run.q[-1, 4:7]
    assert end[0] > 1.35
    assert end[2] - run.q[0, 6] == pytest.approx(3 * rise, abs=0.05)


@pytest.mark.parametrize("slope", [0.0, 0.17])
def test_where_ground_has_no_step_a_map_changes_nothing_to_the_bit(slope):
    """On the level and where a slope begins, also while a push is survived."""
    given = {
        "pushes": [{"time": 1.2, "impulse": 12.0, "direction": 1.5}],
        "ground": {"slope": slope},
    }
    known, felt = (
        walked(0.6, 1.7, terrain={"source": source}, **given) for source in ("scene", "felt")
    )
    assert not known.fell
    np.testing.assert_array_equal(known.q, felt.q)
    np.testing.assert_array_equal(known.v, felt.v)


def test_each_foot_has_the_slope_of_the_block_it_stands_on():
    """In what the whole-body controller is told, against the ground one centimetre beside it."""
    walk = {"name": "walk", "duration": 2.7, "walk": True, "velocity": [0.4, 0.0]}
    given = {"segments": [STAND, walk], "terrain": {"source": "scene"}, "seed": 2}
    given["ground"] = {"blocks": {"rows": 4, "at": 0.3, "tilt": 0.17}}
    loop = build_closed_loop(make_scenario(given, "walk"))
    gait = loop.GetSubsystemByName("controller").GetSubsystemByName("gait_planner")
    simulator = loop.make_simulator()
    context, told, true = gait.GetMyContextFromRoot(simulator.get_context()), [], []
    for time in np.arange(0.5, 3.0, 0.05):
        simulator.AdvanceTo(time)
        targets = open_targets(gait.GetOutputPort("targets").Eval(context))
        feet = gait_state(context.get_discrete_state(0).value()).robot.feet
        for foot in np.flatnonzero(targets.contact > 0.5):
            x, y = feet[foot, :2]
            rise = [
                (loop.ground.height(x + dx, y + dy) - loop.ground.height(x - dx, y - dy)) / 0.02
                for dx, dy in ((0.01, 0.0), (0.0, 0.01))
            ]
            told.append(targets.slope[foot].copy())
            true.append(rise)
    assert np.mean(np.abs(np.array(told) - np.array(true)).max(axis=1) < 1e-6) > 0.9
    assert np.abs(told).max() > 0.08


def test_a_map_from_a_file_is_the_one_of_the_scene_to_the_bit(tmp_path):
    stairs = {"tread": [0.25, 0.3], "steps": 3, "at": 0.5, "heading": 0.15}
    told = walked(0.4, 2.2, ground={"stairs": stairs}, seed=3)
    patches, file = ground_of(told.scenario).patches(), tmp_path / "map.yaml"
    data = [
        {"corners": corners.tolist(), "plane": plane.tolist()}
        for corners, plane in zip(patches.corners, patches.plane, strict=True)
    ]
    file.write_text(yaml.safe_dump({"patches": data}))
    terrain = {"source": "file", "file": str(file)}
    read = walked(0.4, 2.2, ground={"stairs": stairs}, seed=3, terrain=terrain)
    assert told.q[-1, 6] > told.q[0, 6] + 0.05  # on the stairs
    np.testing.assert_array_equal(told.q, read.q)


@pytest.mark.parametrize("simulator", ["drake", "mujoco"])
def test_it_walks_over_patches_of_ones_own(simulator):
    if simulator == "mujoco":
        pytest.importorskip("mujoco")
    scenario = load_scenario(EXAMPLES / "own_ground.yaml", {"plant.simulator": simulator})
    run = simulate(build_closed_loop(scenario))
    assert not run.fell
    assert run.q[-1, 4] > 2.2
    assert run.q[-1, 6] - run.q[0, 6] == pytest.approx(0.24, abs=0.02)
