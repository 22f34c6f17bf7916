"""What came of the trials, held against what is asked."""

from collections.abc import Sequence

import numpy as np

from drake_linefoot.lab.sweep.statistics import clears
from studies.common.types import Data
from studies.ground.cases import CASES


def summed(rows: Sequence[Data]) -> dict[str, Data]:
    """Return for each case how many runs were done, how fast, torques cut, feet over edges."""
    found = {}
    for name, case in CASES.items():
        of = [row for row in rows if row["case"] == name]
        if of:
            speeds = [row["speed"] for row in of if row["speed"] is not None]
            done = sum(row["done"] for row in of)
            found[name] = {
                "what": case.what,
                "runs": len(of),
                "done": done,
                "share": done / len(of),
                "bar": case.bar,
                "holds": clears(done, len(of), case.bar),
                "speed": float(np.mean(speeds)) if speeds else None,
                "cut": float(np.median([row["cut"] for row in of])),
                "over_edge": sum(row["over_edge"] for row in of),
                "landings": sum(row["landings"] for row in of),
            }
    return found
