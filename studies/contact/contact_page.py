"""The page on the contact estimator, as Markdown for the documentation, and its picture."""

from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from drake_linefoot.results.page import render
from studies.common.drawing import BLUE, GREEN, GREY, ORANGE, RED, blank
from studies.contact.constrained import COMPONENTS, EVERY, FORMS, SETTLED
from studies.contact.ledges import HEIGHT, SPEEDS
from studies.contact.thresholds import BETTER, WRONG_MOST, slowest, wrong
from studies.robustness.page import NOTHING, listed

MANY = 100.0  # from which on a number has no decimals
COLOURS = (BLUE, ORANGE, GREEN, RED, GREY)
WRONG_TICKS = (0.0, 1.0, 10.0, 100.0, 1000.0, 10000.0)  # [%]


def contact_page(data: Mapping[str, Any], picture: str) -> str:
    """Return the page.

    Args:
        data: what `contact.json` holds.
        picture: file of the picture, relative to the page.
    """
    cells = data["grid"]
    kinds = Counter(walk["kind"] for walk in data["walks"])
    forms, best = data["forms"].values(), data["choice"]["best"]
    return render(
        "contact.md.j2",
        Path(__file__).parent,
        data=data,
        made_with=listed(data["made_with"]),
        walks=", ".join(f"{n} {kind}" for kind, n in kinds.items()),
        grids={kind: _grid(cells, kind) for kind in kinds},
        picture=picture,
        wrong=100.0 * WRONG_MOST,
        better=BETTER,
        default=_named(next(cell for cell in cells if cell["default"])),
        best=None if best is None else _named(cells[best]),
        height=HEIGHT,
        speeds=SPEEDS,
        phases=max(row["n"] for row in data["ledges"]["summary"]),
        every=EVERY,
        settled=1e3 * SETTLED,
        lost=sum(found["unsolved"] for found in forms),
        samples=sum(found["samples"] for found in forms),
        components=COMPONENTS,
        forms=FORMS,
        number=_number,
    )


def draw_grid(data: Mapping[str, Any]) -> Figure:
    """Return latency and wrong contacts over the touch force, a line for each filter constant."""
    cells = data["grid"]
    kinds = list(cells[0]["kinds"])
    gammas = list(dict.fromkeys(cell["filter_constant"] for cell in cells))
    figure, axes = blank("Contact estimator over recorded walks", 2, len(kinds), size=(12.0, 6.5))
    for column, kind in enumerate(kinds):
        above, below = axes[column], axes[len(kinds) + column]
        for gamma, colour in zip(gammas, COLOURS * len(gammas), strict=False):
            some = [cell for cell in cells if cell["filter_constant"] == gamma]
            some.sort(key=lambda cell: float(cell["touch_force"]))
            forces = [cell["touch_force"] for cell in some]
            found = [cell["kinds"][kind] for cell in some]
            style: dict[str, Any] = {"color": colour, "marker": "o", "ms": 3.0}
            late = [f["latency_p95_ms"] for f in found]
            above.plot(forces, late, label=f"{gamma:g}", **style)
            wrongs = [
                100.0 * ((f["false_contact_rate"] or 0.0) + (f["missed_contact_rate"] or 0.0))
                for f in found
            ]
            below.plot(forces, wrongs, **style)
        below.set_yscale("symlog", linthresh=1.0)
        below.set_ylim(-0.1, 1e4)  # one axis for all kinds: most have hardly any
        below.set_yticks(WRONG_TICKS, [f"{tick:g}" for tick in WRONG_TICKS])
        above.set_title(kind)
        below.set_xlabel("touch force [N]")
    axes[0].set_ylabel("latency, 95th percentile [ms]")
    axes[len(kinds)].set_ylabel("false and missed per swing [%]")
    axes[len(kinds)].legend(
        *axes[0].get_legend_handles_labels(), title="filter constant", fontsize=8
    )
    return figure


def _grid(cells: Sequence[Mapping[str, Any]], kind: str) -> list[list[str]]:
    """Return the table of a kind of walk, header first."""
    touches = sorted({cell["touch_force"] for cell in cells})
    gammas = sorted({cell["filter_constant"] for cell in cells})
    by_pair = {(cell["filter_constant"], cell["touch_force"]): cell for cell in cells}
    rows = [["filter constant", *(f"{touch:g} N" for touch in touches)]]
    for gamma in gammas:
        row = [f"{gamma:g}"]
        for touch in touches:
            cell = by_pair.get((gamma, touch))
            text = NOTHING if cell is None else _cell(cell["kinds"][kind])
            row.append(f"**{text}**" if cell is not None and cell["default"] else text)
        rows.append(row)
    return rows


def _cell(found: Mapping[str, Any]) -> str:
    parts = [_number(found[name]) for name in ("latency_ms", "latency_p95_ms")]
    parts += [_percent(found[name]) for name in ("false_contact_rate", "missed_contact_rate")]
    return "; ".join(parts)


def _named(cell: Mapping[str, Any]) -> str:
    return (
        f"filter constant {cell['filter_constant']:g}, touch {cell['touch_force']:g} N "
        f"({slowest(cell):.3g} ms, {100.0 * wrong(cell):.2g} % wrong)"
    )


def _number(value: float | None) -> str:
    if value is None:
        return NOTHING
    return f"{value:.0f}" if abs(value) >= MANY else f"{value:.3g}"


def _percent(value: float | None) -> str:
    return NOTHING if value is None else _number(round(100.0 * value, 2)) + " %"
