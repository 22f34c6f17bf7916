"""The runs of a sweep: sampled values and scenario of each."""

import copy
import hashlib
import json
from collections.abc import Iterator
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from drake_linefoot.lab.results.provenance import made_with
from drake_linefoot.lab.scenario import Scenario, paths
from drake_linefoot.lab.scenario.load import dump_scenario, make_scenario, parse_scenario
from drake_linefoot.lab.sweep.file import Group, Sweep

LIMIT = 600.0  # [s] of wall time to load and build, and to compile on a machine that is busy
SLOWEST = 60.0  # [s] of wall time a simulated second
Key = tuple[str, int]  # group and index: what makes a run one run


@dataclass(frozen=True)
class Job:
    """A run to carry out.

    Attributes:
        group: it belongs to.
        index: within the group, from 0.
        seed: of its scenario.
        sampled: values by dotted path.
        scenario: YAML text, see `dump_scenario`.
        limit: wall time after which it is given up [s].
    """

    group: str
    index: int
    seed: int
    sampled: dict[str, Any]
    scenario: str
    limit: float = LIMIT

    @property
    def key(self) -> Key:
        """What makes it one run, whoever carries it out and however often."""
        return self.group, self.index


def sampled_values(sweep: Sweep, group: Group, index: int) -> dict[str, Any]:
    """Return the sampled values of run `index` of a group, by dotted path.

    Each value depends on the seed of the sweep, the path and the index alone. So it does not
    change when another parameter is added, whatever the order of the runs; and run i has the same
    values in every group that samples a path alike, which makes groups comparable run by run.
    """
    values = {}
    for path, distribution in group.sample.items():
        digest = hashlib.sha256(path.encode()).digest()
        words = np.frombuffer(digest[:16], dtype="<u4").tolist()
        rng = np.random.default_rng([sweep.seed, index, *words])
        values[path] = distribution.sample(rng)
    return values


def job(sweep: Sweep, group: Group, index: int) -> Job:
    """Return a run of a group."""
    values = sampled_values(sweep, group, index)
    data = copy.deepcopy(dict(group.base))
    for path, value in values.items():
        paths.put(data, path, value)
    scenario = make_scenario(data)
    limit = LIMIT + SLOWEST * scenario.duration
    return Job(group.name, index, int(data["seed"]), values, dump_scenario(scenario), limit)


def scenario_of(sweep: Sweep, group: str, index: int) -> Scenario:
    """Return the scenario of a run of the group of that name."""
    found = next(one for one in sweep.groups if one.name == group)
    return parse_scenario(job(sweep, found, index).scenario)


def jobs(sweep: Sweep) -> Iterator[Job]:
    """Yield every run: the first of each group, the second of each, and so on."""
    for index in range(max(sweep.runs.values())):
        for group in sweep.groups:
            if index < group.runs:
                yield job(sweep, group, index)


def sampled_paths(sweep: Sweep) -> list[str]:
    """Return the dotted paths that any group samples, in the order of the file."""
    return list(dict.fromkeys(path for group in sweep.groups for path in group.sample))


def fingerprint(sweep: Sweep) -> str:
    """Return a short hash of everything that decides what run i of a group is.

    How many runs there are is not part of it: a sweep can be made longer.
    """
    content = asdict(replace(sweep.at_most(0), scenario=""))  # the groups say what they made of it
    text = json.dumps(content, sort_keys=True, default=str)
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def header_of(sweep: Sweep) -> dict[str, Any]:
    """Return what rows are of: only those of the same header belong together."""
    return {"name": sweep.name, "fingerprint": fingerprint(sweep), "made_with": made_with()}
