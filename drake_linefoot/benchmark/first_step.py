"""`linefoot walk` up to the end of its first simulated step, whose time it prints.

As in the command there are imports, the scenario, the model, Meshcat for the replay, the diagram
and its initialisation; nothing is written.
"""

from __future__ import annotations

import os
import sys
import time

from pydrake.systems.framework import Context, EventStatus

from drake_linefoot.cli import main
from drake_linefoot.simulation import run


class _Stop(run.FallWatch):
    """Ends the process after the first step."""

    def __call__(self, root: Context) -> EventStatus:
        if root.get_time() > 0.0:
            print(repr(time.time()), flush=True)
            os._exit(0)
        return super().__call__(root)


if __name__ == "__main__":
    run.FallWatch = _Stop  # type: ignore[misc]
    sys.exit(main(["walk", "--out", sys.argv[1]]))
