"""The report as one page of HTML, pictures inside, and the claims as a table for the terminal."""

from dataclasses import dataclass
from importlib.metadata import version as version_of
from pathlib import Path
from platform import machine, python_version, system

from rich.markup import escape
from rich.table import Table

from drake_linefoot.results.page import render
from studies.common.types import Data
from studies.paper.figure import Claim


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


def html(sections: list[Section], summary: Data) -> str:
    """Return the page of figures in their order; `summary` is what `claims.json` holds."""
    ratios = [summary[f"{name}_rms_ecd_over_srbm"] for name in ("roll", "pitch")]
    return render(
        "paper.html.j2",
        Path(__file__).parent,
        title="drake_linefoot: the paper",
        sections=sections,
        summary=summary,
        ratios=["no number" if ratio is None else f"{ratio:.2f}" for ratio in ratios],
        system=f"Drake {version_of('drake')}, Python {python_version()}, {system()} on {machine()}",
    )


def claims_table(sections: list[Section]) -> Table:
    """Return the claims as a table for the terminal."""
    table = Table("figure", "claim", "here", "holds")
    for section in sections:
        for claim in section.claims:
            texts = (section.name, claim.claim, claim.ours, claim.verdict)
            table.add_row(*map(escape, texts))
    return table
