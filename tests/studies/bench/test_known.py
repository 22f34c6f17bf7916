"""The map that is measured with."""

import numpy as np
import pytest

from drake_linefoot.lab.plants.patch_ground import outlines
from drake_linefoot.lab.plants.scene import ground_of
from drake_linefoot.lab.plants.terrain_map import near, told
from drake_linefoot.lab.scenario import Scenario
from drake_linefoot.lab.scenario.load import validate
from drake_linefoot.terrain import PATCHES, TERRAIN
from studies.bench.known import with_map


@pytest.mark.parametrize("here", [(0.0, 0.0), (12.0, -6.0)])
def test_it_has_as_many_patches_as_a_controller_is_told(tmp_path, here):
    made = validate(with_map(Scenario(), tmp_path))
    assert ground_of(made).is_flat
    known = told(ground_of(made), made)
    terrain = TERRAIN.open(near(outlines(known), np.array(here), made.terrain.range))
    assert terrain.number == PATCHES
    assert np.all(terrain.plane == 0.0)
    middles = terrain.corners[:, :4].mean(axis=1)
    assert np.abs(middles - here).max() < made.terrain.range
