"""Times of contestants that take turns, and what is told of them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

Batch = Callable[[], Iterable[float]]


@dataclass(frozen=True)
class Summary:
    """What is told of the times of one contestant.

    Attributes:
        median: [s].
        p95: 95th percentile [s].
        n: number of times.
    """

    median: float
    p95: float
    n: int

    def as_dict(self) -> dict[str, float | int]:
        """Return it as JSON takes it, in ms."""
        return {"median_ms": 1e3 * self.median, "p95_ms": 1e3 * self.p95, "n": self.n}


def summarise(times: Sequence[float]) -> Summary | None:
    """Return the summary of times [s]; None of nothing."""
    if len(times) == 0:
        return None
    median, p95 = np.percentile(np.asarray(times, dtype=float), [50.0, 95.0])
    return Summary(float(median), float(p95), len(times))


def take_turns(
    batches: Mapping[str, Batch], rounds: int, tell: Callable[[str], None] | None = None
) -> dict[str, list[float]]:
    """Run every contestant's batch once per round; who begins changes from round to round.

    Contestants that run side by side in time see the same machine: when it is busy for a while,
    all of them are slow, and ratios of medians hold.

    Args:
        batches: of each contestant; a call does its work once and returns its times [s].
        rounds: number of rounds.
        tell: hears of every round.

    Returns:
        All times of each contestant [s].
    """
    names = list(batches)
    times: dict[str, list[float]] = {name: [] for name in names}
    for number in range(rounds):
        if tell is not None:
            tell(f"round {number + 1} of {rounds}")
        first = number % len(names) if names else 0
        for name in names[first:] + names[:first]:
            times[name].extend(batches[name]())
    return times


def ratio(above: Summary | None, below: Summary | None) -> float | None:
    """Return the ratio of two medians; None when one is missing."""
    if above is None or below is None or below.median <= 0.0:
        return None
    return above.median / below.median


def exponent(sizes: Sequence[float], times: Sequence[float]) -> float | None:
    """Return p of the fit ``time = c size^p``, least squares in logarithms.

    Args:
        sizes: positive.
        times: [s]; a size whose time is not positive is left out.

    Returns:
        p, or None with fewer than two different sizes.
    """
    pairs = [(s, t) for s, t in zip(sizes, times, strict=True) if s > 0.0 and t > 0.0]
    if len({s for s, _ in pairs}) < 2:
        return None
    logs = np.log(np.array(pairs))
    return float(np.polyfit(logs[:, 0], logs[:, 1], 1)[0])
