"""The report as one page of HTML, pictures inside, and the claims as a table for the terminal."""

from dataclasses import dataclass
from importlib.metadata import version as version_of
from pathlib import Path
from platform import machine, python_version, system
from typing import Any

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


def html(sections: list[Section], summary: dict[str, Any]) -> str:
    """Return the page.

    Args:
        sections: in their order.
        summary: what `claims.json` holds.
    """
    ratios = [summary[f"{name}_rms_ecd_over_srbm"] for name in ("roll", "pitch")]
    return render(
        "paper.html.j2",
        Path(__file__).parent,
        title="drake_linefoot: the paper",
        sections=sections,
        summary=summary,
        all_claims=[claim for section in sections for claim in section.claims],
        ratios=["no number" if ratio is None else f"{ratio:.2f}" for ratio in ratios],
        system=f"Drake {version_of('drake')}, Python {python_version()}, {system()} on {machine()}",
    )


def claims_table(claims: list[Claim]) -> Table:
    """Return the claims as a table for the terminal."""
    table = Table()
    for column in ("figure", "claim", "here", "holds"):
        table.add_column(column)
    for claim in claims:
        texts = (claim.figure, claim.claim, claim.ours, claim.verdict)
        table.add_row(*(text.replace("[", r"\[") for text in texts))
    return table
