"""The page of what is claimed: where it is shown, of which code, and how to make it again."""

import json
from collections.abc import Iterable
from pathlib import Path

from drake_linefoot.lab.results.page import render
from drake_linefoot.lab.results.provenance import CONTROLLER
from drake_linefoot.lab.results.tables import NOTHING, VERDICTS, number
from studies.common.command import DOCS
from studies.publish.bars import Bar, bars_of
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
        if rows := [_row_of(bar) for bar in bars_of(one.target, data)]:
            bars[one.target] = rows
    every = [row[-1] for rows in bars.values() for row in rows]
    counts = {word: every.count(word) for word in (*VERDICTS.values(), NOTHING)}
    return render("results.md.j2", Path(__file__).parent, shown=shown, bars=bars, counts=counts)


def _row_of(bar: Bar) -> list[str]:
    known = bar.value is not None or bar.met is not None or bar.least is not None
    what = bar.what.replace("|", "/")
    least, asked = number(bar.least, ".3g"), bar.asked.replace("|", "/")
    return [what, number(bar.value, ".3g"), least, asked, VERDICTS[bar.met] if known else NOTHING]
