"""Walks over ground that the controller has a map of, in the closed loop."""

import numpy as np
import pytest

from drake_linefoot.lab.plants.scene import ground_of
from drake_linefoot.lab.scenario.load import make_scenario
from drake_linefoot.lab.simulation.run import simulate
from drake_linefoot.lab.wiring.closed_loop import build_closed_loop

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
