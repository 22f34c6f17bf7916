"""`python -m studies.zoo.surface_push`: pushes of a G1 on its soles while it walks; docs/zoo/.

The robot is described from its model alone, then a sweep goes on where it was broken off.
"""

import json
import shutil
import sys
from pathlib import Path
from typing import Any

import typer

from drake_linefoot.errors import InputError
from drake_linefoot.lab.new_robot.analysis import analyse
from drake_linefoot.lab.new_robot.folder import write_folder
from drake_linefoot.lab.results.tables import wide_console
from drake_linefoot.lab.sweep.main import OUT as SWEEPS
from drake_linefoot.lab.sweep.main import SUMMARY, Options, main_sweep
from drake_linefoot.lab.sweep.table import PARQUET, read_table
from drake_linefoot.robot.description import SURFACE
from studies.common.command import BROKE_OFF, OUT, Fresh, PageOut, Processes, Runs, folder_of, run
from studies.common.files import write_json
from studies.common.stamp import Probed, stamped
from studies.common.sweeps import first_run, sweep_of
from studies.zoo.robots import G1, PACKAGE, published

SWEEP = Path("studies/zoo/surface_push.yaml")
ROBOT = OUT / "surface_push" / "g1"  # folder, that of the sweep's scenario
JSON = "surface_push.json"


def surface_push(
    out: PageOut = None,
    runs: Runs = None,
    fresh: Fresh = False,
    workers: Processes = None,
) -> None:
    """Push a G1 that walks on its soles, or go on with that; write surface_push.json."""
    out = folder_of(out, "zoo", part=runs is not None)
    described()
    folder = SWEEPS / sweep_of(SWEEP).name
    _, complete = main_sweep(SWEEP, Options(folder, workers, None, fresh, 0, runs), wide_console())
    summary: dict[str, Any] = json.loads((folder / SUMMARY).read_text(encoding="utf-8"))
    rows, _, _ = read_table(folder / PARQUET)
    seconds = sum(row["wall_seconds"] or 0.0 for row in rows)
    whole = complete and runs is None
    write_json(out / JSON, {**summary, **stamped("zoo", seconds, probe if whole else None)})
    if not complete:
        raise typer.Exit(BROKE_OFF)


def described() -> None:
    """Write the robot's folder anew.

    Raises:
        InputError: its model is not installed.
    """
    files, package = published()
    if not package:
        problem = "is not installed: pip install -r requirements/zoo.txt"
        raise InputError("studies.zoo", "package", PACKAGE, problem)
    shutil.rmtree(ROBOT, ignore_errors=True)
    write_folder(ROBOT, analyse(files[G1], contact=SURFACE))


def probe() -> dict[str, Probed]:
    """Return a quick form: what came of the first run."""
    described()
    sweep = sweep_of(SWEEP)
    (group,) = sweep.runs
    return first_run(sweep, group, 0.05)


if __name__ == "__main__":
    sys.exit(run(surface_push, "zoo.surface_push"))
