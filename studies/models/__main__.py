"""`python -m studies.models`: models, horizons and errors under the same pushes; docs/models/.

Every trial that is done is kept at once, one a line; a study that was broken off goes on with
what this code found, or finds the same.
"""

import sys
from pathlib import Path
from typing import Annotated

import typer

from drake_linefoot.lab.results.page import render
from drake_linefoot.lab.results.tables import NOTHING, number, number_table, wide_console
from studies.common.command import First, Fresh, PageOut, Processes, Quick, folder_of, run, words_of
from studies.common.files import write_json, write_picture, write_text
from studies.common.stamp import stamped
from studies.common.trials import FRESH, TRIALS, Trials, seconds_of
from studies.common.types import Data
from studies.models.cases import GENTLE, HARD, QUICK_RUNS, RUNS, trials
from studies.models.summary import draw, summed
from studies.models.trial import limit, lost, probe, tried

HEAD = (
    *("", "what", "upright", "95 %", "won, lost", "p"),
    *("pitch [mrad]", "over the first", "off [m/s]"),
)
PICTURE = "curves.png"


def models(
    out: PageOut = None,
    runs: Annotated[int, typer.Option(min=1, help="Of each variant.")] = RUNS,
    first: First = FRESH,
    quick: Quick = False,
    fresh: Fresh = False,
    workers: Processes = None,
) -> None:
    """Walk every variant through the same commands and pushes; write page, picture and numbers."""
    screen = wide_console()
    out = folder_of(out, "models", quick)
    jobs = list(trials(QUICK_RUNS if quick else runs, first))
    kept = Trials(out / TRIALS, tried, lost, limit, workers)
    rows = kept.begun(jobs, fresh)
    for count, row in kept.carried_out(jobs, rows):
        screen.print(f"{count} of {len(jobs)}: {row['key']} {row['reason']}", markup=False)
    some = [rows[job.key] for job in jobs]
    found = summed(some)
    command = words_of("models", quick, runs=(runs, RUNS), first=(first, FRESH))
    made = stamped("models", seconds_of(some), None if quick else probe)
    pushed = {"impulses": {"models": HARD, "errors": GENTLE}}  # [N s]
    summary = {"command": command, **made, "quick": quick, **pushed, "variants": found}
    write_json(out / "summary.json", summary)
    write_picture(out / PICTURE, draw(found))
    cells = [cells_of(name, one) for name, one in found.items()]
    told = {"summary": summary, "head": HEAD, "rows": cells, "picture": PICTURE}
    write_text(out / "index.md", render("index.md.j2", Path(__file__).parent, **told))
    screen.print(number_table(HEAD, cells, words=2, wrapped="what"))
    typer.echo(str(out / "index.md"))


def cells_of(name: str, one: Data) -> list[str]:
    """Return the cells of a variant, see `HEAD`."""
    against, ratio = one.get("against"), one.get("pitch_ratio")
    return [
        f"`{name}`",
        one["what"],
        f"{one['upright']} of {one['runs']}",
        f"{100.0 * one['low']:.0f} to {100.0 * one['high']:.0f}",
        f"{against['won']}, {against['lost']}" if against else NOTHING,
        number(against["p"], ".2g") if against else NOTHING,
        NOTHING if one["pitch"] is None else number(1e3 * one["pitch"], ".1f"),
        NOTHING if ratio is None else number(ratio, ".2f"),
        NOTHING if one["speed_error"] is None else number(one["speed_error"], ".3f"),
    ]


if __name__ == "__main__":
    sys.exit(run(models, "models"))
