"""`python -m studies.paper`: computes the figures, draws them, and writes the report.

Every figure leaves `NAME.json` (its data, and what they were made with) and `NAME.png`; all of
them together `claims.json` and `index.html`. A figure whose JSON is there and was made with the
same version, scenario and length is not computed again.
"""

import json
import sys
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from importlib.metadata import version as version_of
from pathlib import Path
from platform import machine, python_version, system
from typing import Annotated

import typer
from rich.markup import escape
from rich.table import Table

from drake_linefoot.lab.results.page import render
from drake_linefoot.lab.results.provenance import made_with
from drake_linefoot.lab.results.tables import wide_console
from drake_linefoot.lab.scenario.load import dump_scenario
from studies.common.command import FELL, Fresh, Out, Quick, run
from studies.common.files import prepare, write_json, write_picture, write_text
from studies.common.runs import paper_scenario
from studies.common.stamp import Probe, stamped
from studies.common.types import Data
from studies.envelope import envelope
from studies.paper import compute
from studies.paper.figure import FALLS_EXPECTED, FIGURES, Claim, load_figure
from studies.paper.parts import probe
from studies.paper.statistic import KEYS

RATIOS = tuple(
    f"{angle}_rms_{pair}{kind}"
    for pair in ("ecd_over_srbm", "cc_over_ecd")
    for angle in ("roll", "pitch")
    for kind in KEYS
)
STATISTIC = "statistic"  # that ratios are, in words
FORECAST = "forecast_contact_consistent"
ANSWERS = {  # what a figure of the paper shows here; {0} is what was found for its first claim
    "fig2": "With one line, not two points, the program is solved {0}; with the kinematics {1}.",
    "fig3": "Velocities follow the command: the result is {1}, the plan of the MPC {0}.",
    "fig4": "The torso stays as commanded: {0}. Roll, against the single body: {2}; pitch: {4}.",
    "fig5": "The whole-body controller does what the MPC plans: {1}.",
    "fig6": "The ground presses as the MPC plans it: {2} once the foot stands, {1} in all.",
    "fig7": "The centroidal trajectories are tracked with a median error of {0}.",
}
RATIO_SOURCES = ("grid", "fig4")  # the first that is there
CLAIMS, PAGE = "claims.json", "index.html"


@dataclass(frozen=True)
class Section:
    """A figure on the page."""

    name: str  # of the figure
    title: str  # one line
    picture: bytes  # PNG
    table: list[list[str]]  # header first
    claims: list[Claim]  # of the figure
    data: Data  # of the figure
    seconds: float  # how long the figure took


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
    names = list(FIGURES)
    if figure is not None:
        load_figure(figure)  # there is one of that name
        names = [figure]
    prepare(out)
    made = stamp(quick)
    missing = [name for name in names if fresh or read(out, name, made) is None]
    for name in missing if fresh else ():
        if done := getattr(load_figure(name), "DONE", None):  # of a figure that goes on
            done.unlink(missing_ok=True)
    if missing:
        compute.run(missing, quick, out, made, screen)
    results = {name: found for name in FIGURES if (found := read(out, name, made))}
    whole = figure is None and not quick
    sections = report(results, names, out, made, probe if whole else None)
    screen.print(claims_table([s for s in sections if s.name in names]), soft_wrap=False)
    typer.echo(str(out / PAGE))
    walks = [name for name in names if name not in FALLS_EXPECTED]  # with the paper's controller
    if any(found["data"].get("fell") for name, found in results.items() if name in walks):
        raise typer.Exit(FELL)


def stamp(quick: bool) -> Data:
    """Return what a figure's data must have been made with to be used again."""
    scenario = dump_scenario(paper_scenario(quick))
    return {"made_with": made_with(), "quick": quick, "scenario": scenario}


def read(out: Path, name: str, made: Data) -> Data | None:
    """Return what an earlier run stored of a figure; None when it cannot be used."""
    try:
        stored: Data = json.loads((out / f"{name}.json").read_text(encoding="utf-8"))
        usable = stored["made_with"] == made and stored["figure"] == name
        return {**stored, "data": {**stored["data"]}} if usable else None
    except (OSError, ValueError, KeyError, TypeError):
        return None


def ratios(results: Mapping[str, Data]) -> tuple[Data, str | None]:
    """Return the ratios between models and their statistic, and the figure they are from."""
    names = (*RATIOS, STATISTIC)
    for source in RATIO_SOURCES:
        data = results.get(source, {}).get("data", {})
        found = {**data, **data.get("ratios", {})}
        if all(key in found for key in names):
            return {key: found[key] for key in names}, source
    return dict.fromkeys(names), None


def _envelope(out: Path) -> list[Section]:
    """Return the section on the walking envelope, when `studies.envelope` wrote it here."""
    try:
        data = json.loads((out / envelope.JSON).read_text(encoding="utf-8"))
        picture = (out / envelope.PICTURE).read_bytes()
        table, seconds = envelope.table(data), float(data["seconds"])
    except (OSError, ValueError, KeyError):
        return []
    return [Section("envelope", envelope.TITLE, picture, table, [], data, seconds)]


def report(
    results: Mapping[str, Data],
    names: Sequence[str],
    out: Path,
    made: Data,
    quick_form: Probe | None = None,
) -> list[Section]:
    """Draw the named figures and write claims and page over all; return what is on the page."""
    sections = []
    for name, stored in results.items():
        module, data = load_figure(name), stored["data"]
        picture = out / f"{name}.png"
        if name in names or not picture.exists():
            write_picture(picture, module.draw(data))
        about = name, module.TITLE, picture.read_bytes(), module.table(data)
        sections.append(Section(*about, module.claims(data), data, float(stored["seconds"])))
    sections += _envelope(out)
    values, source = ratios(results)
    summary = {
        **stamped("paper", sum(section.seconds for section in sections), quick_form),
        "quick": made["quick"],
        **values,
        FORECAST: results["fig4"]["data"].get(FORECAST) if "fig4" in results else None,
        "ratios_from": source,
        "claims": [
            {
                "figure": section.name,
                **asdict(claim),
                "holds": None if claim.holds is None else bool(claim.holds),
            }
            for section in sections
            for claim in section.claims
        ],
    }
    write_json(out / CLAIMS, summary)
    write_text(out / PAGE, html(sections, summary))
    return sections


def html(sections: list[Section], summary: Data) -> str:
    """Return the page of figures in their order; `summary` is what `claims.json` holds."""
    ratios = [summary[f"{name}_rms_ecd_over_srbm"] for name in ("roll", "pitch")]
    return render(
        "paper.html.j2",
        Path(__file__).parent,
        title="drake_linefoot: the paper",
        sections=sections,
        summary=summary,
        answers={s.name: answer(s) for s in sections if s.name in ANSWERS},
        ratios=["no number" if ratio is None else f"{ratio:.2f}" for ratio in ratios],
        system=f"Drake {version_of('drake')}, Python {python_version()}, {system()} on {machine()}",
    )


def answer(section: Section) -> str:
    """Return what a figure of the paper shows here, in a sentence."""
    found = [claim.ours for claim in section.claims]
    return ANSWERS[section.name].format(*found, *["no number"] * 10)


def claims_table(sections: list[Section]) -> Table:
    """Return the claims as a table for the terminal."""
    table = Table("figure", "claim", "here", "holds")
    for section in sections:
        for claim in section.claims:
            texts = (section.name, claim.claim, claim.ours, claim.verdict)
            table.add_row(*map(escape, texts))
    return table


if __name__ == "__main__":
    sys.exit(run(paper, "paper"))
