"""`linefoot robustness`: carries out the sweeps, and writes what they come to.

A sweep that is complete in its folder, and was made with the present code, is not done again.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rich.console import Console
from rich.table import Table

from drake_linefoot.errors import InputError, OutputError
from drake_linefoot.evaluation.drawing import DOTS_PER_INCH
from drake_linefoot.evaluation.files import prepare, write_text
from drake_linefoot.robustness.page import bar_rows, page_of
from drake_linefoot.robustness.pictures import draw_map, draw_rates
from drake_linefoot.robustness.summary import robustness_summary
from drake_linefoot.sweep.file import load_sweep
from drake_linefoot.sweep.main import OUT as SWEEPS
from drake_linefoot.sweep.main import Options, main_sweep
from drake_linefoot.sweep.rows import Row
from drake_linefoot.sweep.table import PARQUET, read_table

if TYPE_CHECKING:
    from pydrake.geometry import Meshcat

FILES = (Path("examples/sweeps/nominal.yaml"), Path("examples/sweeps/robustness.yaml"))
SUMMARY, PAGE, RATES = "summary.json", "index.md", "rates.png"


def main_robustness(
    files: Sequence[Path],
    out: Path,
    options: Options,
    command: str,
    console: Console,
    open_meshcat: Callable[[], Meshcat],
) -> tuple[Path, bool]:
    """Carry out the sweeps, or go on with them; write summary, page and pictures.

    Args:
        files: of the sweeps; no two may have a group of the same name.
        out: folder of the page.
        options: how; its `out` is the folder that holds the folders of the sweeps.
        command: that was given, for the page.
        console: where progress and tables go.
        open_meshcat: gives a Meshcat for a replay.

    Returns:
        The page, and whether every run has an outcome.

    Raises:
        InputError: a sweep is not usable, or its folder has results of other code.
        OutputError: results cannot be written.
        LinefootError: the cluster is lost; what was done is kept.
    """
    names = [load_sweep(file).name for file in files]
    prepare(out)
    tables, complete = [], True
    for file, name in zip(files, names, strict=True):
        folder = (options.out or SWEEPS) / name
        chosen = replace(options, out=folder)
        _, whole = main_sweep(file, chosen, console, open_meshcat)
        tables.append(folder / PARQUET)
        complete = complete and whole
    summary = write_robustness(tables, out, command)
    console.print(bars_table(summary))
    return out / PAGE, complete


def write_robustness(tables: Sequence[Path], out: Path, command: str) -> dict[str, Any]:
    """Write summary, page and pictures of the tables of sweeps; return the summary.

    Args:
        tables: Parquet files.
        out: an existing folder.
        command: that was given.

    Raises:
        InputError: a table cannot be read, or two have the same group.
        OutputError: results cannot be written.
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
    summary = robustness_summary(groups, abouts, command)
    try:
        maps = _pictures(summary, groups, units, out)
        write_text(out / SUMMARY, json.dumps(summary, indent=2, allow_nan=False) + "\n")
        write_text(out / PAGE, page_of(summary, groups, maps))
    except OSError as error:
        raise OutputError(out, error.strerror or str(error)) from error
    return summary


def bars_table(summary: Mapping[str, Any]) -> Table:
    """Return the bars for the terminal."""
    shown = Table()
    for name in ("", "found", "95 % interval", "bar", "met"):
        shown.add_column(name)
    for key, _, *values in bar_rows(summary):
        shown.add_row(*(text.strip("`*").replace("`", "") for text in (key, *values)))
    return shown


def _pictures(
    summary: Mapping[str, Any],
    groups: Mapping[str, Sequence[Row]],
    units: Mapping[str, str],
    out: Path,
) -> dict[str, str]:
    """Draw everything; return the files of the maps by group."""
    draw_rates(summary).savefig(out / RATES, dpi=DOTS_PER_INCH)
    maps = {}
    for name, rows in groups.items():
        figure = draw_map(name, rows, units)
        if figure is not None:
            maps[name] = f"map-{name}.png"
            figure.savefig(out / maps[name], dpi=DOTS_PER_INCH)
    return maps
