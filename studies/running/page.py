"""The page of the study, as Markdown for the documentation."""

from collections.abc import Mapping
from pathlib import Path

from drake_linefoot.lab.results.page import render
from drake_linefoot.lab.results.tables import number
from studies.common.bars import HEAD as BAR_HEAD
from studies.common.bars import bar_rows
from studies.common.types import Data
from studies.running.cases import VARIANTS
from studies.running.summary import BARS

HEAD = ("commanded", "upright", "measured", "flight [ms]", "duty factor", "Froude", "tilt [rad]",
        "turns [rad]", "torque at limit", "cost of transport", "holds")  # fmt: skip


def page_of(summary: Data, pictures: Mapping[str, str]) -> str:
    """Return the page; `pictures` are files by their titles."""
    return render(
        "index.md.j2",
        Path(__file__).parent,
        summary=summary,
        bars=bar_rows(summary["bars"]),
        bar_head=BAR_HEAD,
        head=HEAD,
        ladders={name: [rung_row(r) for r in rungs] for name, rungs in summary["ladders"].items()},
        titles={name: BARS[name].what for name in summary["ladders"]},
        variants={
            VARIANTS[name].what: [rung_row(r) for r in rungs]
            for name, rungs in summary["variants"].items()
            if rungs
        },
        number=number,
        pictures=pictures,
    )


def rung_row(rung: Data) -> list[str]:
    """Return the cells of a size of a ladder, see `HEAD`."""
    flight = None if rung["flight"] is None else 1e3 * rung["flight"]
    return [
        f"{rung['size']:g}",
        f"{rung['upright']} of {rung['runs']}",
        number(rung["measured"], ".2f"),
        number(flight, ".0f"),
        number(rung["duty"], ".2f"),
        number(rung["froude"], ".2f"),
        number(rung["tilt"], ".2f"),
        number(rung["turns"], ".2f"),
        number(rung["limited"], ".0%"),
        number(rung["cost"], ".2f"),
        "yes" if rung["holds"] else "no",
    ]
