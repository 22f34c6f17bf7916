"""Trials that are kept at once, one a line, so that a study that was broken off goes on."""

import json
import time as clock
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, Generic, Protocol, TypeVar

import numpy as np

from drake_linefoot.files import writing
from drake_linefoot.lab.pool import Pool
from drake_linefoot.lab.results.provenance import made_with
from studies.common.files import write_text
from studies.common.types import Data

SECONDS = "seconds"  # of a row: how long it took, of one processor
TRIALS = "trials.jsonl"  # beside the page of a study: where trials are kept
SAMPLE = 40  # trials of other code that are carried out again, to see whether the others hold
FRESH = 500  # the first seed that is published: the tuning has seen smaller ones


class Keyed(Protocol):
    """A job with a name of its own."""

    @property
    def key(self) -> str:
        """What makes it one job."""
        ...


Job_contra = TypeVar("Job_contra", bound=Keyed, contravariant=True)
T = TypeVar("T")
R = TypeVar("R")


def kept(file: Path, made: dict[str, str] | None = None) -> dict[str, Data]:
    """Return the trials of a file by their keys; none without one, or made otherwise than `made`.

    A last line that was not written whole is left out.
    """
    if not file.exists():
        return {}
    lines: list[Any] = []
    for text in file.read_text().splitlines():
        try:
            lines.append(json.loads(text))
        except json.JSONDecodeError:
            break
    if not lines or (made is not None and lines[0] != made):
        return {}
    return {row["key"]: row for row in lines[1:]}


def of_one_kind(_: str) -> str:
    """Return the same for each key, see `Trials`."""
    return ""


def sampled(some: Sequence[T]) -> list[T]:
    """Return a random sample, the same of as many."""
    few = np.random.default_rng(len(some)).permutation(len(some))[:SAMPLE]
    return [some[i] for i in few]


def hold(
    jobs: Sequence[T],
    tried: Callable[[T], R],
    is_same: Callable[[T, R | None], bool],
    limit: Callable[[T], float],
    workers: int | None,
) -> bool:
    """Return whether jobs that other code carried out come to the same again.

    Args:
        jobs: a sample, see `sampled`.
        tried: carries out one.
        is_same: whether what it returns, None of a process that died, is what there is.
        limit: of a job [s].
        workers: processes; None: one per processor.
    """
    with Pool(workers, most=len(jobs)) as pool:
        return all(is_same(one.job, one.value) for one in pool.run(tried, jobs, limit))


@dataclass(frozen=True)
class Trials(Generic[Job_contra]):
    """Trials of a study that are kept in a file, for the methods to carry out what is missing.

    Each raises OutputError when the file cannot be written.

    Attributes:
        file: where rows are kept.
        tried: returns the row of a job.
        lost: returns that of one whose process crashed or took too long, and why.
        limit: of a job [s].
        workers: processes; None: one per processor.
        kind: of a key, see `carried_over`.
    """

    file: Path
    tried: Callable[[Job_contra], Data]
    lost: Callable[[Job_contra, str], Data]
    limit: Callable[[Job_contra], float]
    workers: int | None
    kind: Callable[[str], str] = of_one_kind

    def begun(self, jobs: Sequence[Job_contra], fresh: bool) -> dict[str, Data]:
        """Return the rows of the file that hold, by key; without any the file is begun anew.

        Those that this code made hold; of what other code made, see `carried_over`.

        Args:
            jobs: all that there are.
            fresh: none holds.
        """
        rows = {} if fresh else kept(self.file, made_with())
        if not (rows or fresh):
            rows = self.carried_over(jobs)
        if not rows:
            write_text(self.file, json.dumps(made_with()) + "\n")
        return rows

    def carried_over(self, jobs: Sequence[Job_contra]) -> dict[str, Data]:
        """Return the rows that other code made, by key, of kinds of which this one finds the same.

        A change that keeps the bits leaves rows as they are: a random sample of each kind is
        carried out again, and when each row is the same, but for how long it took, all of the kind
        hold. If any do, the file is left with those, and says that the code of today made them.

        Args:
            jobs: of which the samples are.
        """
        rows, there = kept(self.file), defaultdict(list)
        for job in jobs:
            if job.key in rows:
                there[self.kind(job.key)].append(job)

        def is_same(job: Job_contra, value: Data | None) -> bool:
            row = json.loads(json.dumps(value or {}))
            return {**row, SECONDS: 0.0} == {**rows[job.key], SECONDS: 0.0}

        same = {
            name
            for name, some in there.items()
            if hold(sampled(some), self.tried, is_same, self.limit, self.workers)
        }
        if held := {key: row for key, row in rows.items() if self.kind(key) in same}:
            lines = [made_with(), *held.values()]
            write_text(self.file, "".join(json.dumps(line) + "\n" for line in lines))
        return held

    def carried_out(
        self, jobs: Sequence[Job_contra], rows: dict[str, Data]
    ) -> Iterator[tuple[int, Data]]:
        """Carry out the jobs that have no row yet; yield each row and how many there are then.

        Args:
            jobs: all that there are.
            rows: of those that were done before, by key; the others are added.
        """
        left = [job for job in jobs if job.key not in rows]
        with Pool(self.workers) as pool:
            done = pool.run(partial(_timed, self.tried), left, self.limit)
            for count, one in enumerate(done, len(jobs) - len(left) + 1):
                row: Data = one.value or self.lost(one.job, one.error)
                rows[row["key"]] = row
                with writing(self.file), self.file.open("a") as out:
                    out.write(json.dumps(row) + "\n")
                yield count, row


def seconds_of(rows: Iterable[Data]) -> float:
    """Return how long rows took, of one processor [s]."""
    return float(sum(row.get(SECONDS, 0.0) for row in rows))


def _timed(tried: Callable[[Job_contra], Data], job: Job_contra) -> Data:
    begin = clock.process_time()
    row = tried(job)
    return {**row, SECONDS: round(clock.process_time() - begin, 2)}
