"""What came of the trials, held against what is asked."""

from collections.abc import Mapping, Sequence

import numpy as np

from studies.common.bars import Asked, judged, loss, rate
from studies.common.paired import KNOWN
from studies.common.types import Data
from studies.ground.cases import CASES

FAST = Asked("mean speed of `stairs_fast`", 0.45, "m/s")
CUT = Asked("joints and ticks with a torque cut, up stairs of 12 cm", 20.0, most=True)
EDGES = Asked("landings over an edge, up and down stairs of 12 cm", 0.0, most=True)
FEWER = "fewer upright with a map than without, of the same draws of `{}`"
LARGEST_LOSS = 5.0  # [points]


def bars(found: Mapping[str, Data], pairs: Mapping[str, Data]) -> dict[str, Data]:
    """Return what is asked of each case that was tried, of speed, torques and feet, and of a map.

    Args:
        found: see `summed`.
        pairs: groups of the sweep of robustness, see `shares`.
    """
    nothing = {"speed": None, "cut": None, "over_edge": None}
    up, down, fast = (
        found.get(name, nothing) for name in ("stairs_up_12", "stairs_down_12", "stairs_fast")
    )
    edges = [one["over_edge"] for one in (up, down)]
    return {
        **{
            name: rate(
                Asked(CASES[name].what, 100.0 * CASES[name].bar, "%"), of["done"], of["runs"]
            )
            for name, of in found.items()
        },
        "speed_on_stairs": judged(FAST, fast["speed"]),
        "torques_cut": judged(CUT, up["cut"]),
        "over_edge": judged(EDGES, None if None in edges else sum(edges)),
        **{
            f"{KNOWN}_{group}": loss(
                Asked(FEWER.format(group), LARGEST_LOSS, "points", True),
                of[f"{KNOWN}_lost"],
                of[f"{KNOWN}_won"],
                of["runs"],
            )
            for group, of in pairs.items()
        },
    }


def summed(rows: Sequence[Data]) -> dict[str, Data]:
    """Return for each case how many runs were done, how fast, torques cut, feet over edges."""
    found = {}
    for name in CASES:
        of = [row for row in rows if row["case"] == name]
        if of:
            speeds = [row["speed"] for row in of if row["speed"] is not None]
            found[name] = {
                "runs": len(of),
                "done": sum(row["done"] for row in of),
                "speed": float(np.mean(speeds)) if speeds else None,
                "cut": float(np.median([row["cut"] for row in of])),
                "over_edge": sum(row["over_edge"] for row in of),
                "landings": sum(row["landings"] for row in of),
            }
    return found
