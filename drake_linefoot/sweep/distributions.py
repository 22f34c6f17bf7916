"""How a parameter of a sweep is drawn: as a sweep file says it, checked, and with a generator."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from drake_linefoot.errors import ScenarioError
from drake_linefoot.scenario_types import shown

KINDS = {
    "uniform": "[low, high]",
    "log_uniform": "[low, high], both above 0",
    "normal": "[mean, standard deviation]",
    "integer": "[low, high], whole numbers, both ends included",
    "choice": "a list of values, each as likely as the other",
}
CLIP = "clip"
_ALLOWED = "must be one of " + "; ".join(f"{{{kind}: {what}}}" for kind, what in KINDS.items())
_LARGEST = 2**63 - 1  # that a whole number of a scenario can be


@dataclass(frozen=True)
class Distribution:
    """How a value is drawn.

    Attributes:
        kind: one of `KINDS`.
        values: its two numbers, or the values to choose from.
        clip: lowest and highest value of a normal distribution; None for no bounds.
    """

    kind: str
    values: tuple[Any, ...]
    clip: tuple[float, float] | None = None

    def draw(self, rng: np.random.Generator) -> Any:
        """Return a value, in plain Python types."""
        if self.kind == "choice":
            return self.values[int(rng.integers(len(self.values)))]
        a, b = self.values
        if self.kind == "integer":
            return int(rng.integers(a, b, endpoint=True))
        if self.kind == "normal":
            value = float(rng.normal(a, b))
            return value if self.clip is None else min(max(value, self.clip[0]), self.clip[1])
        if self.kind == "log_uniform":
            value = math.exp(rng.uniform(math.log(a), math.log(b)))
            return min(max(value, a), b)  # what rounding has moved out of the bounds
        return float(rng.uniform(a, b))

    def extremes(self) -> tuple[Any, ...]:
        """Return the values between which all others lie; those of a choice are all of them."""
        if self.kind == "normal":
            return () if self.clip is None else self.clip
        return self.values


def parse_distribution(data: object, file: str | Path, entry: str) -> Distribution:
    """Return a distribution from what a sweep file says.

    Args:
        data: a mapping of one of `KINDS` to a list; a normal one may have `clip` as well.
        file: what errors call the source.
        entry: where in it.

    Raises:
        ScenarioError: it is none.
    """
    kinds = [key for key in data if key != CLIP] if isinstance(data, dict) else []
    if not isinstance(data, dict) or len(kinds) != 1 or kinds[0] not in KINDS:
        raise ScenarioError(file, entry, shown(data), _ALLOWED)
    kind = kinds[0]
    at, values = f"{entry}.{kind}", data[kind]
    if not isinstance(values, list) or not values:
        raise ScenarioError(file, at, shown(values), f"must be {KINDS[kind]}")
    if kind == "choice":
        _refuse_clip(data, file, entry)
        return Distribution(kind, tuple(values))
    whole = kind == "integer"
    a, b = _pair(values, whole, file, at, KINDS[kind])
    if kind == "normal":
        if b < 0.0:
            raise ScenarioError(file, at, shown(values), "must have no negative deviation")
        clip = None
        if CLIP in data:
            clip = _pair(data[CLIP], False, file, f"{entry}.{CLIP}", "[low, high]")
            _check_order(clip, file, f"{entry}.{CLIP}")
        return Distribution(kind, (a, b), clip)
    _refuse_clip(data, file, entry)
    _check_order((a, b), file, at)
    if kind == "log_uniform" and a <= 0.0:
        raise ScenarioError(file, at, shown(values), f"must be {KINDS[kind]}")
    return Distribution(kind, (int(a), int(b)) if whole else (a, b))


def _pair(values: object, whole: bool, file: str | Path, at: str, what: str) -> tuple[float, float]:
    """Return two finite numbers."""
    allowed = (int,) if whole else (int, float)
    if not isinstance(values, list) or len(values) != 2:
        raise ScenarioError(file, at, shown(values), f"must be {what}")
    for value in values:
        fits = isinstance(value, allowed) and not isinstance(value, bool)
        if not fits or abs(value) > _LARGEST or not math.isfinite(value):
            raise ScenarioError(file, at, shown(values), f"must be {what}, finite numbers")
    first, second = values
    return (first, second) if whole else (float(first), float(second))


def _check_order(values: Sequence[float], file: str | Path, at: str) -> None:
    low, high = values
    if low > high:
        raise ScenarioError(file, at, list(values), "must have the lower number first")


def _refuse_clip(data: dict[Any, Any], file: str | Path, entry: str) -> None:
    if CLIP in data:
        allowed = "belongs to a normal distribution alone"
        raise ScenarioError(file, f"{entry}.{CLIP}", shown(data[CLIP]), allowed)
