"""The page on the contact estimator, as Markdown for the documentation, and its picture."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from drake_linefoot.evaluation.drawing import BLUE, GREEN, GREY, ORANGE, RED, blank
from drake_linefoot.robustness.constrained import COMPONENTS, EVERY, FORMS, SETTLED
from drake_linefoot.robustness.ledges import HEIGHT, SPEEDS
from drake_linefoot.robustness.page import NOTHING, table
from drake_linefoot.robustness.thresholds import BETTER, WRONG_MOST, slowest, wrong

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MANY = 100.0  # from which on a number has no decimals
COLOURS = (BLUE, ORANGE, GREEN, RED, GREY)
WRONG_TICKS = (0.0, 1.0, 10.0, 100.0, 1000.0, 10000.0)  # [%]

_PAGE = """\
# The contact estimator

Made by `{command}`; do not edit. {versions}.
The numbers are in [contact.json](contact.json).

## Filter constant and threshold

{walks} The estimator runs once more over the recorded states, as the sensors
had them, and torques, with other parameters and without effect on the walk. Each cell: median and
95th percentile of the detection latency [ms]; false contacts per swing; missed ones per touchdown.
The release force is 0.4 of the touch force; the default is bold.

{grid}

![Latency and wrong contacts]({picture})

Fit is what has at most {wrong:.2g} % false and missed contacts in every kind of walk but the pushed
ones (any observer of momentum feels a push on the torso as a force on a foot; the gait believes
none while the foot goes down): {fit} of {cells} choices. Among them the smallest 95th percentile
in the worst kind counts, unless the default is within {better:.3g} ms of it. {choice}

## A step of {height:.0f} cm in the ground

Walks at {slow} to {fast} m/s over a single step up or down that nobody told of, {phases} each,
with the edge at another place of the stride, with the gait listening to the estimator and without
(`gait.contact_feedback: false`). Touchdown is the first one beyond the edge; impact is its largest
normal force within 30 ms, roll and pitch the largest within 1 s after it. Medians over the walks,
and the largest.

{ledges}

## The constrained form (22) against the pseudoinverse

Both on the same residuals, every {every} ms: root mean square of the error against the simulator's
wrench, over feet that stand; over those that have stood for {settled:.0f} ms; and over feet in the
air. Times in turns in one run. {unsolved}

{forms}
"""


def contact_page(data: Mapping[str, Any], picture: str) -> str:
    """Return the page.

    Args:
        data: what `contact.json` holds.
        picture: file of the picture, relative to the page.
    """
    cells, chosen = data["grid"], data["choice"]
    made_with = ", ".join(f"{name} {value}" for name, value in data["made_with"].items())
    kinds: dict[str, int] = {}
    for walk in data["walks"]:
        kinds[walk["kind"]] = kinds.get(walk["kind"], 0) + 1
    return _PAGE.format(
        command=data["command"],
        versions=made_with,
        walks="Walks: " + ", ".join(f"{n} {kind}" for kind, n in kinds.items()) + ".",
        grid="\n\n".join(f"{kind}:\n\n{_grid(cells, kind)}" for kind in kinds),
        picture=picture,
        wrong=100.0 * WRONG_MOST,
        fit=len(chosen["fit"]),
        cells=len(cells),
        better=BETTER,
        choice=_choice(cells, chosen),
        height=100.0 * HEIGHT,
        slow=SPEEDS[0],
        fast=SPEEDS[1],
        phases=max(row["n"] for row in data["ledges"]["summary"]),
        ledges=_ledges(data["ledges"]["summary"]),
        every=EVERY,
        settled=1e3 * SETTLED,
        unsolved=_unsolved(data["forms"]),
        forms=_forms(data["forms"]),
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


def _grid(cells: Sequence[Mapping[str, Any]], kind: str) -> str:
    touches = sorted({cell["touch_force"] for cell in cells})
    gammas = sorted({cell["filter_constant"] for cell in cells})
    by_pair = {(cell["filter_constant"], cell["touch_force"]): cell for cell in cells}
    rows = []
    for gamma in gammas:
        row = [f"{gamma:g}"]
        for touch in touches:
            cell = by_pair.get((gamma, touch))
            text = NOTHING if cell is None else _cell(cell["kinds"][kind])
            row.append(f"**{text}**" if cell is not None and cell["default"] else text)
        rows.append(row)
    return table(("filter constant", *(f"{touch:g} N" for touch in touches)), rows)


def _cell(found: Mapping[str, Any]) -> str:
    parts = [_number(found[name]) for name in ("latency_ms", "latency_p95_ms")]
    parts += [_percent(found[name]) for name in ("false_contact_rate", "missed_contact_rate")]
    return "; ".join(parts)


def _choice(cells: Sequence[Mapping[str, Any]], chosen: Mapping[str, Any]) -> str:
    present = next(cell for cell in cells if cell["default"])
    said = f"The default, {_named(present)}"
    if chosen["stays"]:
        return f"{said}, stays."
    if chosen["best"] is None:
        return f"{said}, is not fit, and neither is any other."
    return f"{said}, is beaten by {_named(cells[chosen['best']])}."


def _named(cell: Mapping[str, Any]) -> str:
    return (
        f"filter constant {cell['filter_constant']:g}, touch {cell['touch_force']:g} N "
        f"({slowest(cell):.3g} ms, {100.0 * wrong(cell):.2g} % wrong)"
    )


def _ledges(summary: Sequence[Mapping[str, Any]]) -> str:
    head = ("", "estimator", "upright", "latency [ms]", "missed", "impact [N]", "roll [rad]",
            "pitch [rad]")  # fmt: skip
    rows = []
    for row in summary:
        shown = [f"step {row['case']}", "on" if row["feedback"] else "off"]
        shown += [f"{row['upright']} of {row['n']}", _number(row["latency_ms"])]
        shown += [str(row["missed"])]
        shown += [
            f"{_number(row[name])} (most {_number(row[f'{name}_max'])})"
            for name in ("impact_n", "roll_rad", "pitch_rad")
        ]
        rows.append(shown)
    return table(head, rows, False)


def _unsolved(forms: Mapping[str, Mapping[str, Any]]) -> str:
    lost, total = (sum(found[key] for found in forms.values()) for key in ("unsolved", "samples"))
    return f"{lost} of {total} programs were not solved."


def _forms(forms: Mapping[str, Mapping[str, Any]]) -> str:
    names = ("standing", "settled", "in the air")
    rows = []
    for kind, found in forms.items():
        for form in FORMS:
            some = found[form]
            times = f"{some['median_ms']:.3f} ({some['p95_ms']:.3f})"
            for name, key in zip(names, ("rms", "rms_settled", "rms_swing"), strict=True):
                values = [_number(value) for value in some[key]]
                rows.append([kind, form, name, *values, times])
    head = ("", "form", "feet", *(f"`{name}`" for name in COMPONENTS), "median (p95) [ms]")
    return table(head, rows)


def _number(value: float | None) -> str:
    if value is None:
        return NOTHING
    return f"{value:.0f}" if abs(value) >= MANY else f"{value:.3g}"


def _percent(value: float | None) -> str:
    return NOTHING if value is None else _number(round(100.0 * value, 2)) + " %"
