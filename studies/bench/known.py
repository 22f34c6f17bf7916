"""Flat ground of which the controller has a map: what patches cost."""

from dataclasses import replace
from pathlib import Path

import yaml

from drake_linefoot.lab.scenario import Scenario
from drake_linefoot.lab.scenario.courses import TerrainParameters

MAP = "map.yaml"
DEEP, WIDE = 0.3, 1.0  # [m] of a patch, a tread of stairs that do not rise
ALONG, ACROSS = (-15.0, 15.0), (-9.0, 9.0)  # [m] where patches are


def with_map(scenario: Scenario, folder: Path) -> Scenario:
    """Return a scenario on flat ground with a map of treads, more near the robot than it is told.

    The plant is as without the map, so that what is slower is what reads it: `TerrainMap`, which
    the simulation needs, and the gait.
    """
    rows, columns = (
        round((end - begin) / size) for (begin, end), size in ((ALONG, DEEP), (ACROSS, WIDE))
    )
    patches = []
    for i in range(rows):
        for k in range(columns):
            x, y = ALONG[0] + i * DEEP, ACROSS[0] + k * WIDE
            corners = [[x, y], [x + DEEP, y], [x + DEEP, y + WIDE], [x, y + WIDE]]
            patches.append({"corners": corners})
    file = folder / MAP
    file.write_text(yaml.safe_dump({"patches": patches}))
    return replace(scenario, terrain=TerrainParameters("file", file=str(file)))
