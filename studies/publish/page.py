"""The page of what is claimed: where it is shown, of which code, and how to make it again."""

import json
from collections.abc import Iterable
from pathlib import Path

from drake_linefoot.lab.results.page import render
from drake_linefoot.lab.results.provenance import CONTROLLER
from drake_linefoot.lab.results.tables import NOTHING, VERDICTS
from studies.common.bars import HEAD, bar_rows
from studies.common.command import DOCS
from studies.common.types import Data
from studies.publish.results import Result

PAGE = "results.md"
UNTOLD = "not said"


def page_of(results: Iterable[Result]) -> str:
    """Return the page of results as they are published, as Markdown.

    Raises:
        OSError: the data of one cannot be read.
        ValueError: likewise.
    """
    shown, bars = [], {}
    for one in results:
        data = json.loads((DOCS / one.data).read_text(encoding="utf-8"))
        seconds, made = data.get("seconds"), data.get("made_with") or {}
        hours = NOTHING if seconds is None else f"{seconds / 3600.0:.2g}"
        link = f"[{one.target}]({one.page})"
        shown.append([one.claim, link, f"`make {one.target}`", hours, made.get(CONTROLLER, UNTOLD)])
        if rows := bar_rows(asked_of(data)) or claim_rows(data.get("claims", ())):
            bars[one.target] = rows
    every = [row[-1] for rows in bars.values() for row in rows]
    counts = {word: every.count(word) for word in (*VERDICTS.values(), NOTHING)}
    return render(
        "results.md.j2", Path(__file__).parent, shown=shown, head=HEAD, bars=bars, counts=counts
    )


def asked_of(data: Data) -> dict[str, Data]:
    """Return the bars of a result, without numbers that nothing is asked of."""
    return {key: bar for key, bar in data.get("bars", {}).items() if bar["bar"] is not None}


def claim_rows(claims: Iterable[Data]) -> list[list[str]]:
    """Return the rows of claims of the paper: what is asked of them is what it says."""
    return [
        [
            one["figure"],
            *(one[name].replace("|", "/") for name in ("claim", "ours")),
            NOTHING,
            one["paper"].replace("|", "/"),
            VERDICTS[one["holds"]],
        ]
        for one in claims
    ]
