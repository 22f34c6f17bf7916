"""How a parameter of a sweep is drawn: as a sweep file says it, checked, and with a generator."""

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from drake_linefoot.checks import shown
from drake_linefoot.errors import ScenarioError

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
    """Return a distribution from what an entry of a sweep file says.

    It is a mapping of one of `KINDS` to a list; a normal one may have `clip` as well.

    Raises:
        ScenarioError: it is none.
    """
    kinds = [key for key in data if key != CLIP] if isinstance(data, dict) else []
    if not isinstance(data, dict) or len(kinds) != 1 or kinds[0] not in KINDS:
        raise ScenarioError(file, entry, shown(data), _ALLOWED)
    (kind,) = kinds
    found = {}
    for key, values in data.items():
        problem = _problem("uniform" if key == CLIP else kind, values)
        if key == CLIP and kind != "normal":
            problem = "belongs to a normal distribution alone"
        if problem:
            raise ScenarioError(file, f"{entry}.{key}", shown(values), problem)
        found[key] = tuple(values if kind in ("choice", "integer") else map(float, values))
    return Distribution(kind, found[kind], found.get(CLIP))


def _problem(kind: str, values: object) -> str:
    """Return why a distribution cannot have these values; empty when it can."""
    if not isinstance(values, list) or not values or (kind != "choice" and len(values) != 2):
        return f"must be {KINDS[kind]}"
    if kind == "choice":
        return ""
    types = (int,) if kind == "integer" else (int, float)
    for value in values:
        fits = isinstance(value, types) and not isinstance(value, bool)
        if not fits or abs(value) > _LARGEST or not math.isfinite(value):
            return f"must be {KINDS[kind]}, finite numbers"
    first, second = values
    if kind == "normal":
        return "must have no negative deviation" if second < 0.0 else ""
    if first > second:
        return "must have the lower number first"
    return f"must be {KINDS[kind]}" if kind == "log_uniform" and first <= 0.0 else ""
