"""`python -m studies.paper`: computes the figures, draws them, and writes the report.

Every figure leaves `NAME.json` (its data, and what they were made with) and `NAME.png`; all of
them together `claims.json` and `index.html`. A figure whose JSON is there and was made with the
same version, scenario and length is not computed again.
"""

import json
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import typer

from drake_linefoot import __version__
from drake_linefoot.results.tables import wide_console
from drake_linefoot.scenario.load import dump_scenario
from studies.common.command import FELL, Fresh, Out, Quick
from studies.common.files import prepare, write_json, write_picture, write_text
from studies.common.runs import paper_scenario
from studies.common.types import Data
from studies.envelope import envelope
from studies.paper import compute, page
from studies.paper.figure import FALLS_EXPECTED, Claim, check_name, figure_names, load_figure

RATIOS = tuple(
    f"{angle}_rms_{pair}{kind}"
    for pair in ("ecd_over_srbm", "cc_over_ecd")
    for angle in ("roll", "pitch")
    for kind in ("", "_interval")
)
FORECAST = "forecast_contact_consistent"
RATIO_SOURCES = ("grid", "fig4")  # the first that is there
CLAIMS, PAGE = "claims.json", "index.html"


@dataclass(frozen=True)
class Result:
    """A figure that was computed."""

    name: str  # of the figure
    data: Data  # of its `compute`
    seconds: float  # how long it took


def paper(
    figure: Annotated[
        str | None, typer.Argument(metavar="FIGURE", help="Only this one; else all.")
    ] = None,
    out: Out = Path("out/paper"),
    quick: Quick = False,
    fresh: Fresh = False,
) -> None:
    """Reproduce the paper's figures; write pictures, data, claims.json and index.html."""
    screen = wide_console()
    names = figure_names() if figure is None else [check_name(figure)]
    prepare(out)
    made_with = stamp(quick)
    missing = [name for name in names if fresh or read(out, name, made_with) is None]
    if missing:
        compute.run(missing, quick, out, made_with, screen)
    results = [found for name in figure_names() if (found := read(out, name, made_with))]
    chosen = [result for result in results if result.name in names]
    claims = report(results, chosen, out, made_with)
    shown = [claim for claim in claims if claim.figure in names]
    screen.print(page.claims_table(shown), soft_wrap=False)
    typer.echo(str(out / PAGE))
    if any(r.data.get("fell") for r in chosen if r.name not in FALLS_EXPECTED):
        raise typer.Exit(FELL)  # where the paper's controller walks


def stamp(quick: bool) -> dict[str, Any]:
    """Return what a figure's data must have been made with to be used again."""
    scenario = dump_scenario(paper_scenario(quick))
    return {"version": __version__, "quick": quick, "scenario": scenario}


def read(out: Path, name: str, made_with: dict[str, Any]) -> Result | None:
    """Return what an earlier run left of a figure; None when it cannot be used."""
    try:
        stored = json.loads((out / f"{name}.json").read_text(encoding="utf-8"))
        if stored["made_with"] != made_with or stored["figure"] != name:
            return None
        return Result(name, dict(stored["data"]), float(stored["seconds"]))
    except (OSError, ValueError, KeyError, TypeError):
        return None


def ratios(results: Iterable[Result]) -> tuple[dict[str, float | None], str | None]:
    """Return the ratios of RMS between models, and the figure they are from."""
    by_name = {result.name: result.data for result in results}
    for source in RATIO_SOURCES:
        data = by_name.get(source, {})
        found = {**data, **data.get("ratios", {})}
        if all(key in found for key in RATIOS):
            return {key: found[key] for key in RATIOS}, source
    return dict.fromkeys(RATIOS), None


def _envelope(out: Path) -> list[page.Section]:
    """Return the section on the walking envelope, when `studies.envelope` wrote it here."""
    try:
        data = json.loads((out / envelope.JSON).read_text(encoding="utf-8"))
        picture = (out / envelope.PICTURE).read_bytes()
        table, seconds = envelope.table(data), float(data["seconds"])
    except (OSError, ValueError, KeyError):
        return []
    return [page.Section("envelope", envelope.TITLE, picture, table, [], data, seconds)]


def claims_json(
    results: list[Result], claims: list[Claim], made_with: dict[str, Any]
) -> dict[str, Any]:
    """Return what `claims.json` holds."""
    values, source = ratios(results)
    torso = next((result.data for result in results if result.name == "fig4"), {})
    return {
        "version": made_with["version"],
        "quick": made_with["quick"],
        **values,
        FORECAST: torso.get(FORECAST),
        "ratios_from": source,
        "claims": [claim.as_dict() for claim in claims],
    }


def report(
    results: list[Result], chosen: list[Result], out: Path, made_with: dict[str, Any]
) -> list[Claim]:
    """Draw the chosen figures and write claims and page over all; return all claims."""
    sections, claims = [], []
    for result in results:
        module = load_figure(result.name)
        picture = out / f"{result.name}.png"
        if result in chosen or not picture.exists():
            write_picture(picture, module.draw(result.data))
        own = module.claims(result.data)
        claims += own
        about = result.name, module.TITLE, picture.read_bytes(), module.table(result.data)
        sections.append(page.Section(*about, own, result.data, result.seconds))
    sections += _envelope(out)
    summary = claims_json(results, claims, made_with)
    write_json(out / CLAIMS, summary)
    write_text(out / PAGE, page.html(sections, summary))
    return claims
