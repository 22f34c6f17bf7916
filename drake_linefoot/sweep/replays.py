"""Replays of the worst runs: simulated again, which gives the same run to the last bit."""

from collections.abc import Callable, Iterable
from pathlib import Path

from drake_linefoot.files import write_file
from drake_linefoot.simulation.quiet import quieten_drake
from drake_linefoot.sweep.file import Sweep
from drake_linefoot.sweep.jobs import Key, job
from drake_linefoot.sweep.rows import Row, key_of, state_hash
from drake_linefoot.sweep.worker import simulated
from drake_linefoot.visualization.replay import recording, replay_html
from drake_linefoot.visualization.view import open_meshcat

FOLDER = "replays"


def file_of(row: Row) -> str:
    """Return the file of a run's replay, relative to the folder of the sweep.

    The state's hash is in its name: a replay of another run is never taken for it.
    """
    return f"{FOLDER}/{row['group']}-{row['index']}-{row['state_hash']}.html"


def write_replays(
    sweep: Sweep,
    rows: Iterable[Row],
    out: Path,
    report: Callable[[str], None],
) -> dict[Key, str]:
    """Write the replays that are not there yet, and remove those of other runs of the sweep.

    Args:
        sweep: the runs are of.
        rows: the runs.
        out: folder of the sweep.
        report: called when a run comes out differently, in words.

    Returns:
        The file of each replay by its run, relative to `out`.

    Raises:
        OutputError: one cannot be written.
    """
    quieten_drake()
    groups = {group.name: group for group in sweep.groups}
    written = {}
    for row in rows:
        path = out / file_of(row)
        if not path.exists():
            scenario = job(sweep, groups[row["group"]], row["index"]).scenario
            with recording(meshcat := open_meshcat()):
                run = simulated(scenario, meshcat)
            if state_hash(run) != row["state_hash"]:
                name = f"run {row['index']} of {row['group']}"
                report(f"the replay of {name} differs from the run: its worker computes otherwise")
            title = f"{row['group']} {row['index']}, drake_linefoot {run.version}"
            write_file(path, replay_html(meshcat, title).encode())
        written[key_of(row)] = file_of(row)
    for path in (out / FOLDER).glob("*.html"):
        group, *rest = path.stem.rsplit("-", 2)
        ours = group in groups and len(rest) == 2 and all(map(str.isalnum, rest))
        if ours and f"{FOLDER}/{path.name}" not in written.values():
            path.unlink()
    return written
