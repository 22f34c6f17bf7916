"""The largest size of something that holds, under every seed."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

FIRST = 2  # seeds that a bisection is made with


@dataclass(frozen=True)
class Found:
    """Where a bisection ended: two sizes, and what was seen there."""

    best: tuple[float, Any] | None  # the largest that held; None when none did
    failed: tuple[float, Any] | None  # the smallest that did not, likewise


def bisect(
    attempt: Callable[[float], tuple[bool, Any]], start: float, end: float, tolerance: float
) -> Found:
    """Find the largest size that holds, between 0 and `end`.

    `start` is tried first; then, as long as everything holds, what is half way to `end`. `attempt`
    returns whether a size held, and what was seen; the two sizes it ends with differ by `tolerance`
    at most.
    """
    best: tuple[float, Any] | None = None
    failed: tuple[float, Any] | None = None
    size = start
    while True:
        held, seen = attempt(size)
        if held:
            best = (size, seen)
        else:
            failed = (size, seen)
        low, high = best[0] if best else 0.0, failed[0] if failed else end
        if high - low <= tolerance * (1.0 + 1e-9):
            return Found(best, failed)
        steps = math.ceil(0.5 * (high - low) / tolerance - 1e-6)  # low plus whole tolerances
        size = round(low + steps * tolerance, 6)


def largest(
    attempt: Callable[[float, Sequence[int]], tuple[bool, list[Any]]],
    seeds: Sequence[int],
    start: float,
    end: float,
    tolerance: float,
) -> Found:
    """Bisect with the first seeds; what that leads to must hold with the others, too.

    `attempt` is of a size and some seeds; the rest is as for `bisect`.
    """
    known: dict[float, tuple[bool, list[Any]]] = {}

    def first_seeds(size: float) -> tuple[bool, list[Any]]:
        if size not in known:
            known[size] = attempt(size, seeds[:FIRST])
        return known[size]

    while True:
        found = bisect(first_seeds, start, end, tolerance)
        if found.best is None or len(seeds) <= FIRST:
            return found
        size, rows = found.best
        held, more = attempt(size, seeds[FIRST:])
        if held:
            return Found((size, rows + more), found.failed)
        known[size] = False, rows + more
