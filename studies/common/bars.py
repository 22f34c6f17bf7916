"""What is asked of numbers and whether it is met: one form and the same words for all studies.

A rate, or a loss between pairs of runs, is judged by its interval: it meets its bar when all of the
interval does, misses it when none of it does, and is undecided in between.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass

from rich.table import Table

from drake_linefoot.lab.results.tables import NOTHING, VERDICTS, number_table
from drake_linefoot.lab.sweep.statistics import compare_groups, interval, loss_interval
from studies.common.types import Data

HEAD = ("", "what", "found", "95 % interval", "bar", "met")


@dataclass(frozen=True)
class Asked:
    """What is asked of a number.

    Attributes:
        what: it is, in words.
        bar: that it has to reach; None where nothing is asked of it.
        unit: of both, empty for none.
        most: whether the bar is the largest that will do, not the least.
    """

    what: str
    bar: float | None = None
    unit: str = ""
    most: bool = False


def judged(asked: Asked, value: float | None, ends: Sequence[float] | None = None) -> Data:
    """Return a number held against what is asked of it, as the JSON of a study has it.

    Args:
        asked: of it.
        value: None where it is not known.
        ends: of its interval; None for a number that is judged as it is.

    Returns:
        `value`; `interval`, of which there may be none; the attributes of `Asked`; and `met`, None
        where nothing is known or asked, or the interval is on both sides of the bar.
    """
    met = None
    if value is not None and asked.bar is not None:
        low, high = ends or (value, value)
        if asked.most:
            met = True if high <= asked.bar else False if low > asked.bar else None
        else:
            met = True if low >= asked.bar else False if high < asked.bar else None
    return {"value": value, "interval": ends and list(ends), **asdict(asked), "met": met}


def rate(asked: Asked, good: int, runs: int) -> Data:
    """Return `judged` of a rate [%], by Wilson's interval; unknown without runs."""
    if not runs:
        return judged(asked, None)
    return judged(asked, 100.0 * good / runs, [100.0 * end for end in interval(good, runs)])


def loss(asked: Asked, lost: int, won: int, pairs: int) -> Data:
    """Return `judged` of how much smaller a rate is than another [points], see `loss_interval`."""
    if not pairs:
        return judged(asked, None)
    ends = [100.0 * end for end in loss_interval(lost, won, pairs)]
    return judged(asked, 100.0 * (lost - won) / pairs, ends)


def compared(rows: Iterable[Data], others: Iterable[Data]) -> Data:
    """Return `compare_groups` of trials that say whether they are `upright`, by their `index`."""
    both = (
        [{**row, "fell": not row["upright"], "legs_met": None} for row in r] for r in (rows, others)
    )
    return compare_groups(*both)


def bar_rows(bars: Mapping[str, Data]) -> list[list[str]]:
    """Return the cells of each of some bars, by key, under `HEAD`."""
    rows = []
    for key, one in bars.items():
        ends, bar, unit = one["interval"], one["bar"], one["unit"] and f" {one['unit']}"
        known = one["met"] is not None or (bar is not None and one["value"] is not None)
        cells = [
            NOTHING if one["value"] is None else f"{one['value']:.3g}{unit}",
            f"{ends[0]:.3g} to {ends[1]:.3g}" if ends else NOTHING,
            NOTHING if bar is None else f"at {'most' if one['most'] else 'least'} {bar:g}{unit}",
            VERDICTS[one["met"]] if known else NOTHING,
        ]
        rows.append([f"`{key}`", one["what"].replace("|", "/"), *cells])
    return rows


def bar_table(bars: Mapping[str, Data], title: str | None = None) -> Table:
    """Return some bars for the terminal."""
    rows = [[cell.replace("`", "").strip("*") for cell in row] for row in bar_rows(bars)]
    return number_table(HEAD, rows, title, words=2, wrapped="what")
