"""Replays of the worst runs: simulated again, which gives the same run to the last bit."""

import tempfile
from collections.abc import Callable, Iterable
from functools import partial
from pathlib import Path

from drake_linefoot.errors import LinefootError, OutputError
from drake_linefoot.files import writing
from drake_linefoot.lab.results.judge import state_hash
from drake_linefoot.lab.simulation.drake_logging import silence_drake
from drake_linefoot.lab.simulation.recording import LOG
from drake_linefoot.lab.sweep.file import Sweep
from drake_linefoot.lab.sweep.jobs import Key, job
from drake_linefoot.lab.sweep.rows import Row, key_of
from drake_linefoot.lab.sweep.worker import simulated
from drake_linefoot.lab.visualization.replay import draw_replay

FOLDER = "replays"
DIFFERS = "the replay of {} differs from the run: its worker computes otherwise"


def file_of(row: Row) -> str:
    """Return the file of a run's replay, relative to the folder of the sweep.

    The state's hash is in its name: a replay of another run is never taken for it.
    """
    return f"{FOLDER}/{row['group']}-{row['index']}-{row['state_hash']}.html"


def write_replays(
    sweep: Sweep, rows: Iterable[Row], out: Path, report: Callable[[str], None]
) -> dict[Key, str]:
    """Write the replays that are not there yet, and remove those of other runs of the sweep.

    `report` is called when a run comes out differently, or has no picture.

    Returns:
        The file of each replay by its run, relative to `out`.

    Raises:
        OutputError: one cannot be written.
    """
    groups = {group.name: group for group in sweep.groups}
    written = {}
    for row in rows:
        path, name = out / file_of(row), f"run {row['index']} of {row['group']}"
        if not path.exists():
            scenario = job(sweep, groups[row["group"]], row["index"]).scenario
            try:
                _write_replay(scenario, row, path, partial(report, DIFFERS.format(name)))
            except OutputError:
                raise
            except LinefootError as error:
                report(f"the replay of {name} is missing: {error}")
                continue
        written[key_of(row)] = file_of(row)
    for path in (out / FOLDER).glob("*.html"):
        group, *rest = path.stem.rsplit("-", 2)
        ours = group in groups and len(rest) == 2 and all(map(str.isalnum, rest))
        if ours and f"{FOLDER}/{path.name}" not in written.values():
            path.unlink()
    return written


def _write_replay(scenario: str, row: Row, path: Path, differs: Callable[[], None]) -> None:
    """Simulate a run, and have its replay drawn by a process of its own.

    `differs` is called when the run comes out differently.
    """
    silence_drake()
    run = simulated(scenario)
    if state_hash(run) != row["state_hash"]:
        differs()
    with writing(path.parent):
        path.parent.mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory(prefix="linefoot-") as scratch:
        log = Path(scratch) / LOG
        run.save(log)
        draw_replay(log, path, f"{row['group']} {row['index']}, drake_linefoot {run.version}")
