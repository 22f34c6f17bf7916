"""Robots of other size, sole and mass, at four fifths of the speed that the zoo has of them."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from drake_linefoot.lab.new_robot.analysis import analyse
from drake_linefoot.lab.new_robot.folder import write_folder
from drake_linefoot.lab.results.metrics import segment_velocity
from drake_linefoot.lab.scenario import Segment
from drake_linefoot.lab.scenario.load import load_scenario
from drake_linefoot.lab.simulation.run import simulate
from drake_linefoot.lab.wiring.closed_loop import build_closed_loop
from drake_linefoot.robot.description import SCENARIO
from drake_linefoot.robot.scaling import MASS
from studies.zoo import made_up
from studies.zoo.robots import make

ZOO = Path(__file__).resolve().parents[1] / "docs" / "zoo" / "summary.json"
SHARE, SECONDS = 0.8, 5.0  # [-], [s]
BEARS = 0.1  # [-] of the load of a foot
SOON = 20  # ticks: of the filters that tell what an end bears


def long_soles(folder):
    """33 kg on soles of 17 cm, of which 12 are ahead of the ankle; 1.05 m/s when it was made."""
    tree = made_up.mit()
    made_up.scale_all(tree, (33.0 / MASS) ** (1.0 / 3.0), 33.0 / MASS)
    made_up.put_soles(tree, -0.05, 0.12)
    return made_up.write(tree, folder, "long_soles"), 1.05


def robot_of_zoo(name):
    def found(folder):
        found = json.loads(ZOO.read_text(encoding="utf-8"))["robots"][name]["line"]
        return make(name, folder), found["fastest"]["speed"]

    return found


def bears_long(run):
    """Which ends have borne for so long that it must be known, shape (n, 2, 2)."""
    load = run.true_normal.sum(axis=2, keepdims=True)
    bears = run.true_normal > BEARS * np.maximum(load, 1e-9)
    bears &= run.planned_contact[:, :, None] > 0.5
    since = np.cumsum(bears, axis=0)
    bears[:SOON] = False
    bears[SOON:] &= since[SOON:] - since[:-SOON] == SOON
    return bears


@pytest.mark.slow
@pytest.mark.parametrize(
    "made",
    [long_soles, *map(robot_of_zoo, ("no_arms", "half_mass", "small", "heavy_weak_ankles"))],
    ids=["long_soles", "no_arms", "half_mass", "small", "heavy_weak_ankles"],
)
def test_it_walks_as_fast_as_told_on_every_end_that_bears(made, tmp_path):
    model, fastest = made(tmp_path)
    found = analyse(model)
    write_folder(tmp_path / "robot", found)
    speed, scenario = SHARE * fastest, load_scenario(tmp_path / "robot" / SCENARIO)
    segments = [Segment("stand", 0.5), Segment("forward", SECONDS, True, [speed, 0.0])]
    run = simulate(build_closed_loop(replace(scenario, segments=segments)))
    assert not run.fell
    measured = segment_velocity(run, 0.5, 0.5 + SECONDS)
    assert measured[0] == pytest.approx(speed, rel=0.1)
    assert abs(measured[1]) < 0.1 * speed
    np.testing.assert_array_equal(run.reference_limited, 0.0)
    hangs = (run.reference_friction_share < 1.0) & bears_long(run)
    assert not hangs.any()
