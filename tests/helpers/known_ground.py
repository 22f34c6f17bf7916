"""A robot on ground that it has a map of."""

import numpy as np

from drake_linefoot.gait.state import new_state
from drake_linefoot.gait.told_ground import take_in_terrain
from drake_linefoot.lab.plants.ground import Ground
from drake_linefoot.lab.plants.patch_ground import outlines
from drake_linefoot.lab.plants.terrain_map import near
from drake_linefoot.lab.scenario.courses import StairsParameters
from drake_linefoot.lab.scenario.scene import Scene
from tests.helpers.steps import SHAPE, constants

RISE = 0.12
STAIRS = Ground(Scene(stairs=StairsParameters(rise=RISE, at=0.5, heading=0.2)))
FEET = constants(SHAPE, half_length=0.075, edge_margin=0.015)


def state_on(ground, place=(0.0, 0.0), error=0.0):
    """A robot with both feet at a place of ground that it knows."""
    s = new_state()
    s.clock.lift_off[:] = 1e9
    for foot, aside in enumerate((0.08, -0.08)):
        x, y = place[0], place[1] + aside
        s.robot.feet[foot] = [x, y, ground.height(x, y), 0.0]
    patches = ground.patches()
    patches = patches._replace(sigma=patches.sigma + error)
    take_in_terrain(s, near(outlines(patches), np.array(place), 3.0), FEET)
    return s
