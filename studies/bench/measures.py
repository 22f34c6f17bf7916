"""Times of contestants that take turns, and what `bench.json` holds of them and of the machine."""

import math
import os
import platform
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import numpy as np

from drake_linefoot import __version__
from studies.common.bars import Asked, judged

Batch = Callable[[], Iterable[float] | Mapping[str, Iterable[float]]]

PACKAGES = ("drake", "mujoco", "numpy", "scipy", "daqp", "piqp", "proxsuite", "quadprog")
THRESHOLDS = {  # the numbers of `bench.json`
    "wbc_tick_over_placo": Asked("WBC tick through its output port / PlaCo's tick", 1.2, most=True),
    "estimator_over_plant_step": Asked(
        "contact estimator's update / bare plant step", 0.2, most=True
    ),
    "mpc_update_over_daqp": Asked(
        "MPC update, all parts / DAQP's solve of the same problems", 6.0, most=True
    ),
    "mpc_active_set_over_daqp": Asked(
        "the same update with `mpc.solver: active_set`", 3.0, most=True
    ),
    "closed_loop_over_plant_step": Asked(
        "closed loop per ms at 1 kHz / bare plant step", 3.4, most=True
    ),
    "closed_loop_over_plant_step_busy": Asked(
        "the same of both while another closed loop runs in a process of its own",
        4.5,
        most=True,
    ),
    "map_over_none": Asked("closed loop with a map of 24 patches / without", 1.1, most=True),
    "realtime_rate_1khz": Asked("realtime rate, plant and WBC at 1 kHz, MPC at 50 Hz"),
    "realtime_rate_500hz": Asked("realtime rate, plant and WBC at 500 Hz, MPC at 50 Hz"),
    "closed_loop_over_other": Asked("closed loop / that of the other environment"),
    "plant_step_over_other": Asked("plant step / that of the other environment"),
    "sweep_runs_per_core_minute": Asked(
        "runs of a sweep a minute and core / those of the other environment"
    ),
    "memory_growth_mb": Asked("memory at 600 s - at 60 s of walking", 20.0, "MB", most=True),
    "import_over_pydrake": Asked(
        "import drake_linefoot / import pydrake.multibody.plant", 1.5, most=True
    ),
    "help_over_pydrake": Asked("linefoot --help / import pydrake.multibody.plant", 2.0, most=True),
    "first_walk_cpu_s": Asked(
        "CPU of a first `linefoot walk`, which compiles, to its first step",
        55.0,
        "s",
        most=True,
    ),
    "first_walk_wall_s": Asked("how long that takes", 35.0, "s", most=True),
    "mpc_40_over_10_knots": Asked("MPC update at 40 knots / at 10 knots"),
}


@dataclass(frozen=True)
class Effort:
    """How much is measured."""

    quick: bool  # a shorter walk to record
    states: int  # ticks and problems that are measured on
    rounds: int  # in which contestants take turns
    chunks: int  # of the closed loop in each round
    runs: int  # of a sweep in each of two environments
    scaling_problems: int  # that are measured on for what grows
    scaling_rounds: int  # likewise
    starts: int  # of each process
    memory: tuple[float, float] | None  # times at which it is looked at [s]; None for no long walk


@dataclass(frozen=True)
class Summary:
    """What is said of the times of one contestant."""

    median: float  # [s]
    p95: float  # 95th percentile [s]
    n: int  # number of times

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
    batches: Mapping[str, Batch], rounds: int, report: Callable[[str], None] | None = None
) -> dict[str, list[float]]:
    """Run every contestant's batch once per round; who begins changes from round to round.

    Contestants that run side by side in time see the same machine: when it is busy for a while,
    all of them are slow, and ratios of medians hold.

    Args:
        batches: of each contestant; a call does its work once and returns its times [s], or those
            of its parts by name.
        rounds: number of rounds.
        report: called with every round.

    Returns:
        All times of each contestant or part [s].
    """
    names, times = list(batches), dict[str, list[float]]()
    for number in range(rounds):
        if report is not None:
            report(f"round {number + 1} of {rounds}")
        first = number % len(names) if names else 0
        for name in names[first:] + names[:first]:
            found = batches[name]()
            parts = found if isinstance(found, Mapping) else {name: found}
            for part, values in parts.items():
                times.setdefault(part, []).extend(values)
    return times


def each(time: Callable[[Any], float], inputs: Sequence[Any]) -> Batch:
    """Return a batch of all inputs; an untimed call before them wakes the caches."""

    def batch() -> list[float]:
        time(inputs[0])
        return [time(one) for one in inputs]

    return batch


def by_part(rows: Iterable[Mapping[str, float]], prefix: str = "") -> dict[str, list[float]]:
    """Return the times of parts by name, with a prefix, from those of each run."""
    found: dict[str, list[float]] = {}
    for row in rows:
        for name, time in row.items():
            found.setdefault(prefix + name, []).append(time)
    return found


def ratio(above: Summary | None, below: Summary | None) -> float | None:
    """Return the ratio of two medians; None when one is missing."""
    if above is None or below is None or below.median <= 0.0:
        return None
    return above.median / below.median


def exponent(sizes: Sequence[float], times: Sequence[float]) -> float | None:
    """Return p of the fit ``time = c size^p``, least squares in logarithms, over positive sizes.

    A size whose time is not positive is left out; None with fewer than two different sizes.
    """
    from scipy.stats import linregress

    pairs = [(s, t) for s, t in zip(sizes, times, strict=True) if s > 0.0 and t > 0.0]
    if len({s for s, _ in pairs}) < 2:
        return None
    return float(linregress(*np.log(pairs).T).slope)


@dataclass
class Results:
    """What has been measured so far; `values` are those of `THRESHOLDS`."""

    values: dict[str, float | None] = field(default_factory=dict)  # those that were measured
    notes: dict[str, str] = field(default_factory=dict)  # why there is no value, and remarks
    times: dict[str, Summary | None] = field(default_factory=dict)  # of each part
    peers: dict[str, dict[str, Any]] = field(default_factory=dict)  # what each is and does
    scaling: dict[str, Any] = field(default_factory=dict)  # how times grow
    rest: dict[str, Any] = field(default_factory=dict)  # machine, versions, command, date, ...

    def as_dict(self) -> dict[str, Any]:
        """Return what `bench.json` holds; a value that is missing is null and has a note."""
        values = {name: self.values.get(name) for name in THRESHOLDS}
        values = {n: None if v is None or not math.isfinite(v) else v for n, v in values.items()}
        missing = {name: "not measured" for name, value in values.items() if value is None}
        return {
            **self.rest,
            **values,
            "bars": {name: judged(asked, values[name]) for name, asked in THRESHOLDS.items()},
            "times": {name: s.as_dict() if s else None for name, s in self.times.items()},
            "peers": self.peers,
            "scaling": self.scaling,
            "notes": missing | self.notes,
        }


def version_of(package: str) -> str | None:
    """Return the version of an installed distribution; None without it."""
    try:
        return version(package)
    except PackageNotFoundError:
        return None


def processor() -> str:
    """Return the name of the processor."""
    try:
        for line in Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.split(":", 1)[1].strip()
    except OSError:
        pass
    return platform.processor() or platform.machine()


def machine() -> dict[str, Any]:
    """Return processor, cores, system, and how busy it is (load of the last minute)."""
    return {
        "processor": processor(),
        "cores": os.cpu_count(),
        "system": f"{platform.system()} {platform.release().split('-')[0]} {platform.machine()}",
        "load": round(os.getloadavg()[0], 2),
    }


def versions() -> dict[str, str | None]:
    """Return the versions of Python, this package and everything that is measured."""
    found = {package: version_of(package) for package in PACKAGES}
    return {"python": platform.python_version(), "drake_linefoot": __version__, **found}
