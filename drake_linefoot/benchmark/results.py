"""What `bench.json` holds: ratios with their bars, times, peers, scaling, notes."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from drake_linefoot.benchmark.statistics import Summary


@dataclass(frozen=True)
class Key:
    """A number of `bench.json`.

    Attributes:
        meaning: in words.
        bar: what it must not exceed; None when it is only reported.
    """

    meaning: str
    bar: float | None = None


KEYS = {
    "wbc_tick_over_placo": Key("WBC tick through its output port / PlaCo's tick", 4.0),
    "estimator_over_plant_step": Key("contact estimator's update / bare plant step", 0.8),
    "mpc_update_over_daqp": Key("MPC update, all parts / DAQP's solve of the same problems", 10.0),
    "closed_loop_over_plant_step": Key("closed loop per ms at 1 kHz / bare plant step", 5.0),
    "realtime_rate_1khz": Key("realtime rate, plant and WBC at 1 kHz, MPC at 50 Hz"),
    "realtime_rate_500hz": Key("realtime rate, plant and WBC at 500 Hz, MPC at 50 Hz"),
    "memory_growth_mb": Key("memory at 600 s - at 60 s of walking, log apart [MB]", 20.0),
    "import_over_pydrake": Key("import drake_linefoot / import pydrake.multibody.plant", 1.5),
    "help_over_pydrake": Key("linefoot --help / import pydrake.multibody.plant", 2.0),
    "mpc_40_over_10_knots": Key("MPC update at 40 knots / at 10 knots"),
}


@dataclass
class Results:
    """What has been measured so far.

    Attributes:
        values: by name, see `KEYS`; what is missing was not measured.
        notes: by name, why there is no value, and remarks.
        times: of each part.
        peers: of each peer what it is and what it does.
        scaling: how times grow.
        rest: machine, versions, command, date and the like.
    """

    values: dict[str, float | None] = field(default_factory=dict)
    notes: dict[str, str] = field(default_factory=dict)
    times: dict[str, Summary | None] = field(default_factory=dict)
    peers: dict[str, dict[str, Any]] = field(default_factory=dict)
    scaling: dict[str, Any] = field(default_factory=dict)
    rest: dict[str, Any] = field(default_factory=dict)

    def as_dict(self) -> dict[str, Any]:
        """Return what `bench.json` holds; a value that is missing is null and has a note."""
        values = {name: finite(self.values.get(name)) for name in KEYS}
        notes = dict(self.notes)
        for name, value in values.items():
            if value is None:
                notes.setdefault(name, "not measured")
        return {
            **self.rest,
            **values,
            "bars": bars(values),
            "times": {name: s.as_dict() if s else None for name, s in self.times.items()},
            "peers": self.peers,
            "scaling": self.scaling,
            "notes": notes,
        }


def finite(value: float | None) -> float | None:
    """Return a number as JSON takes it: None when it is not finite."""
    return value if value is not None and math.isfinite(value) else None


def bars(values: Mapping[str, float | None]) -> dict[str, dict[str, float | bool | None]]:
    """Return value, bar and whether it holds, of every number with a bar; None is unknown."""
    table: dict[str, dict[str, float | bool | None]] = {}
    for name, key in KEYS.items():
        if key.bar is not None:
            value = values.get(name)
            holds = None if value is None else value <= key.bar
            table[name] = {"value": value, "bar": key.bar, "holds": holds}
    return table
