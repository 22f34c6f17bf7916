"""`python -m studies.robustness`: carries out the sweeps, and writes a page of their results.

A sweep that is complete in its folder, and was made with the present code, is not done again.
"""

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any

import typer

from drake_linefoot.errors import InputError
from drake_linefoot.files import write_file
from drake_linefoot.lab.results.tables import wide_console
from drake_linefoot.lab.scenario import Scenario
from drake_linefoot.lab.sweep.file import load_sweep
from drake_linefoot.lab.sweep.main import OUT as SWEEPS
from drake_linefoot.lab.sweep.main import Options, main_sweep
from drake_linefoot.lab.sweep.rows import Row
from drake_linefoot.lab.sweep.table import PARQUET, read_table
from studies.common import command
from studies.common.bars import bar_table
from studies.common.files import prepare, write_json, write_picture, write_text
from studies.common.published import go_on_from, hold_over, table_of
from studies.common.stamp import STUDY, Probe, made_by, stamped
from studies.common.trials import SAMPLE
from studies.robustness.page import page_of
from studies.robustness.pictures import draw_map, draw_pushes, draw_rates
from studies.robustness.probe import probe
from studies.robustness.summary import PUSHED, robustness_summary

PAGE, SUMMARY, RATES, PUSHES = "index.md", "summary.json", "rates.png", "pushes.png"


def robustness(
    files: command.Sweeps = None,
    out: Annotated[Path, typer.Option(help="Folder of the page.")] = Path("docs/robustness"),
    sweeps: Annotated[Path, typer.Option(help="Folder of the sweeps' folders.")] = SWEEPS,
    runs: command.Runs = None,
    workers: command.Processes = None,
    scheduler: Annotated[
        str | None,
        typer.Option(metavar="ADDRESS", help="Use the cluster of this dask scheduler, tcp://..."),
    ] = None,
    replays: command.Count = 0,
    fresh: command.Fresh = False,
) -> None:
    """Carry out the sweeps of robustness, or go on with them; write page and summary.json."""
    if scheduler is not None and workers is not None:
        problem = "is for this machine, not for the cluster of --scheduler"
        raise typer.BadParameter(problem, param_hint="'--workers'")
    words = ["python -m studies.robustness", *map(str, files or ())]
    if runs is not None:
        words.append(f"--runs {runs}")
    files, screen = files or list(command.SWEEPS), wide_console()
    wanted = [load_sweep(file) for file in files]
    prepare(out)
    tables, complete = [], True
    for file, sweep in zip(files, wanted, strict=True):
        folder = sweeps / sweep.name
        if not fresh and (held := hold_over(sweep, out, workers)):
            screen.print(f"{held} runs of other code hold: of {SAMPLE} the bits are the same")
        if not fresh and (new := go_on_from(sweep, out, folder)):
            screen.print(f"{new} runs of {sweep.name} are published already", markup=False)
        options = Options(folder, workers, scheduler, fresh, replays, runs)
        _, whole = main_sweep(file, options, screen)
        tables.append(folder / PARQUET)
        complete = complete and whole
    some = probe if complete else None
    screen.print(bar_table(write_robustness(tables, out, " ".join(words), some)["bars"]))
    typer.echo(str(out / PAGE))
    if not complete:
        raise typer.Exit(command.BROKE_OFF)


def write_robustness(
    tables: Sequence[Path], out: Path, words: str, probe: Probe | None = None
) -> dict[str, Any]:
    """Write summary, page and pictures of the tables of sweeps, and these; return the summary.

    Args:
        tables: Parquet files.
        out: an existing folder.
        words: of the command that was given.
        probe: a quick form of the study, where it is to be published.

    Raises:
        InputError: a table cannot be read, or two have the same group.
        OutputError: results cannot be written.
    """
    groups, units, abouts = read_tables(tables)
    summary = robustness_summary(groups, abouts, words)
    seconds = sum(row["wall_seconds"] or 0.0 for rows in groups.values() for row in rows)
    summary = {**stamped("robustness", seconds, probe), **summary}
    summary["made_with"] = {STUDY: made_by("robustness")[STUDY], **summary["made_with"]}
    write_picture(out / RATES, draw_rates(summary))
    maps = {}
    for name, some in groups.items():
        figure = draw_map(name, some, units)
        if figure is not None:
            maps[name] = f"map-{name}.png"
            write_picture(out / maps[name], figure)
    if groups.get(PUSHED):
        write_picture(out / PUSHES, draw_pushes(groups[PUSHED], Scenario()))
    for path, about in zip(tables, abouts, strict=True):
        write_file(table_of(about["name"], out), path.read_bytes())
    write_json(out / SUMMARY, summary)
    viable = PUSHES if groups.get(PUSHED) else None
    write_text(out / PAGE, page_of(summary, groups, maps, viable))
    return summary


def read_tables(
    tables: Sequence[Path],
) -> tuple[dict[str, list[Row]], dict[str, str], list[dict[str, Any]]]:
    """Return the rows of each group, the units of the sampled values, and what is about each table.

    Raises:
        InputError: a table cannot be read, or two have the same group.
    """
    groups: dict[str, list[Row]] = {}
    units: dict[str, str] = {}
    abouts = []
    for path in tables:
        rows, found, about = read_table(path)
        names = list(dict.fromkeys(row["group"] for row in rows))
        for name in names:
            if name in groups:
                raise InputError(path, "group", name, "is a group of another table, too")
            groups[name] = [row for row in rows if row["group"] == name]
        units |= found
        abouts.append(about)
    return groups, units, abouts


if __name__ == "__main__":
    sys.exit(command.run(robustness, "robustness"))
