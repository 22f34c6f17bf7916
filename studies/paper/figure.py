"""What every figure of the evaluation is: a module that computes, draws and judges.

Nothing here imports Drake: the modules are loaded when they are needed.
"""

import importlib
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol

from matplotlib.figure import Figure

from drake_linefoot.errors import InputError
from studies.common.types import Data

FIGURES = (  # modules, in the order of the report
    *(
        "fig2",
        "fig3",
        "fig4",
        "grid",
        "parts",
        "fig5",
        "fig6",
        "fig7",
        "feasibility",
        "exact",
        "horizon",
    ),
)
ALONE = ("fig2",)  # measures wall time, so nothing may run beside it
TARGET = 0.6  # [-] what the ratios of ECD over single rigid body are to be at most
BETTER = 0.9  # [-] of the ECD's RMS that the contact-consistent model is to have at most
LEVEL = 0.95  # [-] of confidence
FALLS_EXPECTED = ("grid",)  # a map of where what falls


@dataclass(frozen=True)
class Claim:
    """A statement of the paper, and whether it holds here."""

    claim: str  # the statement in words
    paper: str  # the paper's number, or its words
    ours: str  # the number found here, with its unit
    holds: bool | None  # whether the statement holds here; None: undecided
    note: str = ""  # how it was measured, or why it does not hold

    @property
    def verdict(self) -> str:
        """Whether it holds, in a word."""
        return "undecided" if self.holds is None else "yes" if self.holds else "no"


def shown(value: float | None, form: str) -> str:
    """Return a number for a table, a dash without one; `form` is of `format`."""
    return "-" if value is None else format(value, form)


def fell_at(row: Data) -> str:
    """Return what a table says of the fall of a run, `fell` and `fall_time`."""
    return f"at {row['fall_time']:.2f} s" if row["fell"] else "no"


def compared(
    claim: str, found: Data, base: str, most: float, paper: str, note: str, what: str = "RMS"
) -> Claim:
    """Return the claim that an RMS, or `what` it is, is at most `most` times that of `base`.

    The ratio is `found`, of `runs.compared` or `compared_by_cluster`; undecided when its interval
    has `most` in it. `paper` are the paper's words, `note` says how it was measured.
    """
    ratio, interval = found["ratio"], found["interval"]
    ours = "no number" if ratio is None else f"{what} {ratio:.2f} times {base}"
    holds: bool | None = ratio is not None and ratio <= most
    if interval is not None:
        ours += f" ({interval[0]:.2f} to {interval[1]:.2f})"
        ours += f"; lower in {found['lower']} of {found['pairs']}"
        holds = None if interval[0] <= most < interval[1] else holds
        if found.get("pooled") is not None:
            ours += f"; pooled {found['pooled']:.2f}"
    return Claim(claim, paper, ours, holds, note)


def steadier(claim: str, found: Data, base: str, note: str) -> Claim:
    """Return the claim that an RMS of the ECD is well below that of a single rigid body."""
    paper = f"a picture; the aim here is a ratio of at most {TARGET}"
    return compared(claim, found, base, TARGET, paper, note)


def survives(claim: str, paper: str, fell: Sequence[tuple[bool, bool]], note: str) -> Claim:
    """Return the claim that one controller walks where another falls.

    `fell` says of each place whether the one fell there and the other. Where both fall, or none,
    nothing is learned. Of the other places the exact binomial test asks whether the other fell in
    more than half; undecided where it cannot tell, in either direction. `paper` are the paper's
    words, `note` says how it was measured.
    """
    from scipy.stats import binomtest

    one, other = (sum(a and not b for a, b in side) for side in (fell, [(b, a) for a, b in fell]))
    ours = f"only the other falls at {other} of {len(fell)} places, only this one at {one}"
    if not one + other:
        return Claim(claim, paper, ours, None, note)
    test = binomtest(other, one + other)
    low, high = test.proportion_ci(LEVEL)
    ours += f" (p = {test.pvalue:.2g}; the other's share is {low:.2f} to {high:.2f})"
    clear = test.pvalue <= 1.0 - LEVEL
    return Claim(claim, paper, ours, other > one if clear else None, note)


class FigureModule(Protocol):
    """The contract of a figure module.

    Its data have under "scenario" the scenario as YAML text, under "seeds" the seeds, under "fell"
    whether a run of this package's own controller fell that should not have.
    """

    TITLE: str  # one line

    def compute(self, quick: bool) -> Data:
        """Run what is needed; `quick` takes shorter runs. Returns data that JSON can hold."""

    def draw(self, data: Data) -> Figure:
        """Return the picture, from the data alone."""

    def table(self, data: Data) -> list[list[str]]:
        """Return the rows of the table, header first."""

    def claims(self, data: Data) -> list[Claim]:
        """Return what the paper says, and what was found."""


def load_figure(name: str) -> FigureModule:
    """Import a figure module by its name, which is what the command line calls it.

    Raises:
        InputError: there is no such figure.
    """
    if name not in FIGURES:
        raise InputError("figure", "", name, f"unknown; must be one of {list(FIGURES)}")
    module: Any = importlib.import_module(f"{__package__}.{name}")
    figure: FigureModule = module
    return figure
