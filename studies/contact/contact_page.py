"""The page on the contact estimator, as Markdown for the documentation, and its picture."""

from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from drake_linefoot.lab.results.page import render
from drake_linefoot.lab.results.tables import NOTHING
from studies.common.drawing import BLUE, GREEN, GREY, ORANGE, RED, blank
from studies.contact.constrained import COMPONENTS, EVERY, FORMS, SETTLED
from studies.contact.ledges import HEIGHT, SPEEDS
from studies.contact.thresholds import BETTER, WRONG_MOST, slowest, wrong

FITNESS = {True: "fit", None: "undecided", False: "unfit"}
MANY = 100.0  # from which on a number has no decimals
COLOURS = (BLUE, ORANGE, GREEN, RED, GREY)
WRONG_TICKS = (0.0, 1.0, 10.0, 100.0, 1000.0, 10000.0)  # [%]


def contact_page(data: Mapping[str, Any], picture: str) -> str:
    """Return the page of what `contact.json` holds; `picture` is a file, relative to the page."""
    forms, best = data["forms"].values(), data["choice"]["best"]
    default = next(i for i, cell in enumerate(data["grid"]) if cell["default"])
    return render(
        "contact.md.j2",
        Path(__file__).parent,
        data=data,
        kinds=Counter(walk["kind"] for walk in data["walks"]),
        picture=picture,
        most_wrong=WRONG_MOST,
        wrong=wrong,
        slowest=slowest,
        better=BETTER,
        default=data["grid"][default],
        fitness=FITNESS[data["choice"]["fit"][default]],
        fit=Counter(FITNESS[one] for one in data["choice"]["fit"]),
        best=None if best is None else data["grid"][best],
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


def _number(value: float | None) -> str:
    if value is None:
        return NOTHING
    return f"{value:.0f}" if abs(value) >= MANY else f"{value:.3g}"
