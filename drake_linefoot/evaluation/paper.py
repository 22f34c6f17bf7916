"""`linefoot paper`: computes the figures, draws them, and writes the report.

Every figure leaves `NAME.json` (its data, and what they were made with) and `NAME.png`; all of
them together `claims.json` and `index.html`. A figure whose JSON is there and was made with the
same version, scenario and length is not computed again.
"""

from __future__ import annotations

import json
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rich.console import Console

from drake_linefoot import __version__
from drake_linefoot.errors import OutputError
from drake_linefoot.evaluation import envelope, page, workers
from drake_linefoot.evaluation.drawing import DOTS_PER_INCH
from drake_linefoot.evaluation.figure import (
    FALLS_EXPECTED,
    Claim,
    Data,
    check_name,
    figure_names,
    load_figure,
)
from drake_linefoot.evaluation.files import prepare, write_text
from drake_linefoot.evaluation.runs import paper_scenario
from drake_linefoot.scenario_io import dump_scenario

RATIOS = ("roll_rms_ecd_over_srbm", "pitch_rms_ecd_over_srbm")
RATIO_SOURCES = ("grid", "fig4")  # the first that is there
CLAIMS, PAGE = "claims.json", "index.html"


@dataclass(frozen=True)
class Result:
    """A figure that was computed.

    Attributes:
        name: of the figure.
        data: of its `compute`.
        seconds: how long it took.
    """

    name: str
    data: Data
    seconds: float


def write_paper(
    figure: str | None, out: Path, *, quick: bool, fresh: bool, console: Console
) -> bool:
    """Compute what is missing, write everything, print the claims.

    Args:
        figure: name of the only figure to compute and draw; None takes all.
        out: folder of the results; made when missing.
        quick: shorter runs.
        fresh: compute also what is there.
        console: where progress and claims go.

    Returns:
        Whether the robot stayed up wherever the paper's controller walks.

    Raises:
        InputError: there is no such figure.
        OutputError: `out` cannot be written.
        LinefootError: a figure could not be computed.
    """
    names = figure_names() if figure is None else [check_name(figure)]
    prepare(out)
    made_with = stamp(quick)
    missing = [name for name in names if fresh or read(out, name, made_with) is None]
    if missing:
        workers.run(missing, quick, out, made_with, console)
    results = [
        result for name in figure_names() if (result := read(out, name, made_with)) is not None
    ]
    chosen = [result for result in results if result.name in names]
    try:
        claims = report(results, chosen, out, made_with)
    except OSError as error:
        raise OutputError(out, error.strerror or str(error)) from error
    shown = [claim for claim in claims if claim.figure in names]
    console.print(page.claims_table(shown), soft_wrap=False)
    return not any(r.data.get("fell") for r in chosen if r.name not in FALLS_EXPECTED)


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
    """Return the two ratios of ECD over single body, and the figure they are from."""
    by_name = {result.name: result.data for result in results}
    for source in RATIO_SOURCES:
        data = by_name.get(source, {})
        found = {**data, **data.get("ratios", {})}
        if all(key in found for key in RATIOS):
            return {key: found[key] for key in RATIOS}, source
    return dict.fromkeys(RATIOS), None


def _envelope(out: Path) -> list[page.Section]:
    """Return the section on the walking envelope, when `linefoot envelope` wrote it here."""
    try:
        data = json.loads((out / envelope.JSON).read_text(encoding="utf-8"))
        picture = (out / envelope.PICTURE).read_bytes()
    except (OSError, ValueError):
        return []
    return [
        page.Section(
            name="envelope",
            title=envelope.TITLE,
            picture=picture,
            table=envelope.table(data),
            claims=[],
            scenario=data["scenario"],
            seeds=data["seeds"],
            fell="",
            seconds=data["seconds"],
        )
    ]


def claims_json(
    results: list[Result], claims: list[Claim], made_with: dict[str, Any]
) -> dict[str, Any]:
    """Return what `claims.json` holds."""
    values, source = ratios(results)
    return {
        "version": made_with["version"],
        "quick": made_with["quick"],
        **values,
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
            module.draw(result.data).savefig(picture, dpi=DOTS_PER_INCH)
        own = module.claims(result.data)
        claims += own
        sections.append(
            page.Section(
                name=result.name,
                title=module.TITLE,
                picture=picture.read_bytes(),
                table=module.table(result.data),
                claims=own,
                scenario=str(result.data.get("scenario", "")),
                seeds=list(result.data.get("seeds", [])),
                fell=str(result.data.get("fall_reason") or "") if result.data.get("fell") else "",
                seconds=result.seconds,
            )
        )
    sections += _envelope(out)
    summary = claims_json(results, claims, made_with)
    write_text(out / CLAIMS, json.dumps(summary, indent=2, allow_nan=False) + "\n")
    write_text(out / PAGE, page.html(sections, summary))
    return claims
