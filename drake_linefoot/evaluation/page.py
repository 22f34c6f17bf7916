"""The report as one page of HTML, pictures inside, and the claims as a table for the terminal."""

from __future__ import annotations

import base64
from dataclasses import dataclass
from html import escape
from importlib.metadata import version as version_of
from platform import machine, python_version, system
from typing import Any

from rich.table import Table

from drake_linefoot.evaluation.figure import Claim

PAPER = (
    "García, Griffin and Pratt, MPC-based Locomotion Control of Bipedal Robots with Line-Feet "
    "Contact using Centroidal Dynamics"
)
LINK = "https://doi.org/10.1109/HUMANOIDS47582.2021.9555775"
STYLE = """
body { font: 15px/1.45 sans-serif; max-width: 62rem; margin: 1rem auto; padding: 0 1rem;
       color: #222; background: #fff; }
img { max-width: 100%; border: 1px solid #ddd; }
table { border-collapse: collapse; margin: 0.6rem 0; font-size: 13px; }
th, td { border: 1px solid #ccc; padding: 0.2rem 0.5rem; text-align: left; vertical-align: top; }
.yes { background: #e3f4e3; } .no { background: #fbe3e0; } .fell { color: #c02020; }
pre { background: #f5f5f5; padding: 0.5rem; font-size: 12px; overflow: auto; }
"""


@dataclass(frozen=True)
class Section:
    """A figure on the page.

    Attributes:
        name: of the figure.
        title: one line.
        picture: PNG.
        table: header first.
        claims: of the figure.
        scenario: YAML text.
        seeds: of the runs.
        fell: why a run fell that should not have; empty when none did.
        seconds: how long the figure took.
    """

    name: str
    title: str
    picture: bytes
    table: list[list[str]]
    claims: list[Claim]
    scenario: str
    seeds: list[int]
    fell: str
    seconds: float


def html(sections: list[Section], summary: dict[str, Any]) -> str:
    """Return the page.

    Args:
        sections: in their order.
        summary: what `claims.json` holds.
    """
    claims = [claim for section in sections for claim in section.claims]
    body = [
        "<h1>The paper's results, reproduced</h1>",
        f'<p>{escape(PAPER)} (<a href="{LINK}">doi</a>), on the MIT Humanoid in simulation. '
        f"{_made_with(summary)}</p>",
        f"<p>{sum(c.holds for c in claims)} of {len(claims)} claims hold here.{_ratios(summary)}"
        "</p>",
        _claims(claims, with_figure=True),
        *(_section(section) for section in sections),
    ]
    head = f'<meta charset="utf-8"><title>drake_linefoot: the paper</title><style>{STYLE}</style>'
    return (
        f'<!DOCTYPE html>\n<html lang="en"><head>{head}</head><body>\n'
        + "\n".join(body)
        + "\n</body></html>\n"
    )


def claims_table(claims: list[Claim]) -> Table:
    """Return the claims as a table for the terminal."""
    table = Table()
    for column in ("figure", "claim", "here", "holds"):
        table.add_column(column)
    for claim in claims:
        texts = (claim.figure, claim.claim, claim.ours, "yes" if claim.holds else "NO")
        table.add_row(*(text.replace("[", r"\[") for text in texts))
    return table


def _made_with(summary: dict[str, Any]) -> str:
    length = "shortened runs (--quick)" if summary["quick"] else "full runs"
    return (
        f"Made by <code>linefoot paper</code>, {length}, with drake_linefoot {summary['version']}, "
        f"Drake {version_of('drake')}, Python {python_version()}, {system()} on {machine()}."
    )


def _ratios(summary: dict[str, Any]) -> str:
    source = summary["ratios_from"]
    if source is None:
        return ""
    values = [
        "no number"
        if summary[f"{name}_rms_ecd_over_srbm"] is None
        else f"{summary[f'{name}_rms_ecd_over_srbm']:.2f}"
        for name in ("roll", "pitch")
    ]
    return (
        f" RMS of the ECD over that of the single rigid body: roll {values[0]}, pitch {values[1]}"
        f" ({escape(source)})."
    )


def _section(section: Section) -> str:
    picture = base64.b64encode(section.picture).decode("ascii")
    fell = f'<p class="fell">A run FELL: {escape(section.fell)}</p>' if section.fell else ""
    seeds = ", ".join(map(str, section.seeds)) or "-"
    return "\n".join(
        [
            f'<h2 id="{section.name}">{section.name}: {escape(section.title)}</h2>',
            fell,
            f'<img alt="{escape(section.title)}" src="data:image/png;base64,{picture}">',
            _rows(section.table),
            _claims(section.claims, with_figure=False),
            f"<details><summary>Scenario (seeds {seeds}; {section.seconds:.0f} s to compute)"
            f"</summary><pre>{escape(section.scenario)}</pre></details>",
        ]
    )


def _rows(rows: list[list[str]]) -> str:
    if not rows:
        return ""
    head, *body = rows
    lines = ["<tr>" + "".join(f"<th>{escape(str(cell))}</th>" for cell in head) + "</tr>"]
    lines += [
        "<tr>" + "".join(f"<td>{escape(str(cell))}</td>" for cell in row) + "</tr>" for row in body
    ]
    return f"<table>{''.join(lines)}</table>"


def _claims(claims: list[Claim], with_figure: bool) -> str:
    names = ["claim", "paper", "here", "holds", "note"]
    lines = [*(["figure"] if with_figure else []), *names]
    rows = ["<tr>" + "".join(f"<th>{name}</th>" for name in lines) + "</tr>"]
    for claim in claims:
        cells = [claim.claim, claim.paper, claim.ours, "yes" if claim.holds else "no", claim.note]
        shown = "".join(f"<td>{escape(cell)}</td>" for cell in cells)
        if with_figure:
            shown = f'<td><a href="#{claim.figure}">{claim.figure}</a></td>{shown}'
        rows.append(f'<tr class="{"yes" if claim.holds else "no"}">{shown}</tr>')
    return f"<table>{''.join(rows)}</table>"
