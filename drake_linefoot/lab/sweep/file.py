"""The file of a sweep: which scenario, what is changed, what is sampled and how, how often.

The entries of the scenario are known by their dotted paths only, and what a path may hold is
left to the scenario's own checks: a new entry of the scenario can be swept without a change here.
"""

import copy
import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Annotated, Any, Self

import numpy as np
from annotated_types import Ge, Le
from pydantic import AfterValidator, Field, Strict

from drake_linefoot.checks import check, plain, shown
from drake_linefoot.errors import ScenarioError
from drake_linefoot.fields import NameOrPath, Whole, misfit, together
from drake_linefoot.lab.scenario import paths
from drake_linefoot.lab.scenario.load import load_scenario, make_scenario, validate
from drake_linefoot.yaml_file import read_yaml

SEED = "seed"
MOST_RUNS = 1_000_000
MOST_CHECKED = 1000  # scenarios of a sweep, each of which takes some milliseconds
LONGEST_NAME = 100  # characters
_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]*")
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


def _plain_name(text: str) -> str:
    if not _NAME.fullmatch(text) or len(text) > LONGEST_NAME:
        raise ValueError("must be a name of letters, digits, '_', '-' and '.'")
    return text


FileName = Annotated[str, Strict(), AfterValidator(_plain_name), Field(validate_default=True)]
Changes = dict[Any, Any]  # by dotted path, which is looked up later


@dataclass
class GroupEntry:
    """A case of a sweep: what it has beside what all cases share."""

    name: FileName = ""
    """Of the case, in every table."""
    set: Changes = field(default_factory=dict)
    """Dotted path -> value."""
    sample: Changes = field(default_factory=dict)
    """Dotted path -> distribution."""


@dataclass
class CaseEntry(GroupEntry):
    """A case among others, which may have runs of its own number."""

    runs: Annotated[Whole, Ge(1), Le(MOST_RUNS)] | None = None
    """Of this case; None: as many as of each."""


@dataclass
class SweepFile(GroupEntry):
    """The fields of a sweep file; its name is that of the folder of the results."""

    scenario: NameOrPath = "walk"
    """A shipped one, or the path of one."""
    runs: Annotated[Whole, Ge(1), Le(MOST_RUNS)] = 100
    """Of each group, but those with a number of their own."""
    seed: Annotated[Whole, Ge(0)] = 0
    """Of everything that is sampled."""
    groups: Annotated[list[CaseEntry], Strict()] = field(default_factory=list)

    @together
    def _names_groups_apart(self) -> None:
        names: set[str] = set()
        for i, group in enumerate(self.groups):
            if group.name in names:
                raise misfit(f"groups[{i}].name", group.name, "is the name of another group")
            names.add(group.name)


@dataclass(frozen=True)
class Distribution:
    """How a value is sampled.

    Attributes:
        kind: one of `KINDS`.
        values: its two numbers, or the values to choose from.
        clip: lowest and highest value of a normal distribution; None for no bounds.
    """

    kind: str
    values: tuple[Any, ...]
    clip: tuple[float, float] | None = None

    def sample(self, rng: np.random.Generator) -> Any:
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


ANY_SEED = Distribution("integer", (0, 2**31 - 1))  # where a sweep does not set it


@dataclass(frozen=True)
class Group:
    """A case of a sweep.

    Attributes:
        name: of the case.
        base: its scenario in plain data, every field there, before anything is sampled.
        sample: distributions by dotted path.
        runs: of it.
    """

    name: str
    base: Mapping[str, Any]
    sample: Mapping[str, Distribution]
    runs: int


@dataclass(frozen=True)
class Sweep:
    """A sweep that has been checked.

    Attributes:
        name: of the sweep.
        scenario: that was changed.
        seed: of everything that is sampled.
        groups: at least one, in the order of the file.
    """

    name: str
    scenario: str
    seed: int
    groups: tuple[Group, ...]

    @property
    def runs(self) -> dict[str, int]:
        """How many runs each group has, by its name."""
        return {group.name: group.runs for group in self.groups}

    def at_most(self, runs: int) -> Self:
        """Return a sweep with at most so many runs of each group."""
        some = (replace(group, runs=min(group.runs, runs)) for group in self.groups)
        return replace(self, groups=tuple(some))


def load_sweep(file: str | Path, simulator: str | None = None) -> Sweep:
    """Read and check a sweep file; in a simulator that is named it is a sweep of its own.

    Raises:
        ScenarioError: it cannot be read, or is no sweep; the message names file, entry and value.
    """
    path = Path(file)
    one = check(read_yaml(path, "sweep"), SweepFile, path)
    name = one.name if simulator is None else f"{one.name}-{simulator}"
    cases = {f"groups[{i}].": case for i, case in enumerate(one.groups)}
    cases = cases or {"": CaseEntry(name)}
    if (count := sum(map(len, (one.set, *(case.set for case in one.groups))))) > MOST_CHECKED:
        raise ScenarioError(path, "set", f"{count} entries", f"must be at most {MOST_CHECKED}")
    base = _changed(plain(load_scenario(one.scenario)), one.set, path, "set")
    groups: list[Group] = []
    for at, case in cases.items():
        changed = _changed(base, case.set, path, f"{at}set")
        if simulator is not None:
            changed = _changed(changed, {"plant.simulator": simulator}, path, "--simulator")
        shared = {entry: what for entry, what in one.sample.items() if entry not in case.set}
        sample = shared | case.sample
        sampled = {} if SEED in {*one.set, *case.set, *sample} else {SEED: ANY_SEED}
        for entry, what in sample.items():
            label = f"{at}sample.{entry}"
            _lookup(changed, entry, what, path, label)
            sampled[entry] = parse_distribution(what, path, label)
        groups.append(Group(case.name, changed, sampled, case.runs or one.runs))
    _check_groups(groups, cases, path)
    return Sweep(name, one.scenario, one.seed, tuple(groups))


def _check_groups(groups: Sequence[Group], cases: Mapping[str, GroupEntry], path: Path) -> None:
    """Check the scenarios of all groups; of those that differ in name alone the first."""
    apart, plain_ones = [], 0
    for group, (at, case) in zip(groups, cases.items(), strict=True):
        plain_ones += not (case.set or case.sample)
        if case.set or case.sample or plain_ones == 1:
            apart.append((group, at))
    ends = [len(d.extremes()) for group, _ in apart for d in group.sample.values()]
    if (count := len(apart) + sum(ends)) > MOST_CHECKED:
        allowed = f"must be at most {MOST_CHECKED}: groups, ends of distributions, choices"
        raise ScenarioError(path, "groups", f"{count} scenarios to check", allowed)
    for group, at in apart:
        _check_extremes(group, f"{path}: {at}sample")


def _check_extremes(group: Group, where: str) -> None:
    """Check the scenario at both ends of every distribution, the others at one of theirs."""
    start = copy.deepcopy(dict(group.base))
    for path, distribution in group.sample.items():
        for value in distribution.extremes()[:1]:
            paths.put(start, path, value)
    ends = [(path, value) for path, d in group.sample.items() for value in d.extremes()]
    for change in [(), *ends]:
        data = copy.deepcopy(start)
        if change:
            paths.put(data, *change)
        validate(make_scenario(data, where), where)


def _changed(base: dict[str, Any], changes: Mapping[str, Any], file: Path, at: str) -> Any:
    """Return a scenario in plain data with entries replaced, one after the other.

    After each one the rest of what it brings has its defaults: `pushes: [{time: 1}]` and then
    `pushes[0].duration: 0.2` work, whatever else a push has.
    """
    for path, value in changes.items():
        data = copy.deepcopy(base)
        _lookup(data, path, value, file, f"{at}.{path}")
        paths.put(data, path, value)
        base = plain(make_scenario(data, f"{file}: {at}"))
    return base


def _lookup(data: dict[str, Any], path: object, value: object, file: Path, label: str) -> None:
    """Refuse a path that leads nowhere."""
    try:
        paths.get(data, str(path))
    except KeyError as error:
        allowed = "no such entry in the scenario; must be like gait.step_width or segments[0].name"
        raise ScenarioError(file, label, shown(value), allowed) from error


def parse_distribution(data: object, file: str | Path, entry: str) -> Distribution:
    """Return a distribution from an entry of a sweep file.

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
