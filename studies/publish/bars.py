"""The bars of all studies in one form, each with the lower end of its rate where it is one."""

from collections.abc import Callable, Mapping
from typing import NamedTuple

from drake_linefoot.lab.sweep.statistics import interval
from studies.common.types import Data


class Bar(NamedTuple):
    """What is asked of a number."""

    what: str
    value: float | None
    least: float | None  # lower end of Wilson's interval at 95 % of a rate; None of another number
    asked: str  # of it, in words
    met: bool | None  # None: undecided, or nothing is known


def bars_of(target: str, data: Data) -> list[Bar]:
    """Return the bars of a result.

    Args:
        target: name of the result.
        data: its JSON.
    """
    found = _READ.get(target, _plain)(data)
    return [bar for bar in found if bar.asked]


def _plain(data: Data) -> list[Bar]:
    bars = data.get("bars", {})
    if isinstance(bars, Mapping):
        bars = [{"what": name, **bar} for name, bar in bars.items()]
    return [
        Bar(bar["what"], bar["value"], None, _number(bar["bar"]), bar["holds"])
        for bar in bars
        if bar.get("bar") is not None
    ]


def _of_robustness(data: Data) -> list[Bar]:
    found = []
    for name, bar in data["bars"].items():
        group = data["groups"].get(name) or {}
        asked = "at least " if bar["least"] is not None else "at most "
        limit = bar["least"] if bar["least"] is not None else bar["most"]
        low = group.get("low") if bar["least"] is not None else None
        found.append(Bar(name, data[name], low, asked + _number(limit), bar["met"]))
    return found


def _of_running(data: Data) -> list[Bar]:
    found = []
    for name, bar in data["bars"].items():
        group = data["groups"].get(name) or {"runs": 0}
        low = interval(group["succeeded"], group["runs"])[0] if group["runs"] else None
        unit = "" if bar["unit"] == "-" else f" {bar['unit']}"
        found.append(Bar(name, bar["value"], low, _number(bar["bar"]) + unit, bar["holds"]))
    return found


def _of_ground(data: Data) -> list[Bar]:
    return [
        Bar(
            name,
            one["share"],
            interval(one["done"], one["runs"])[0],
            "at least " + _number(one["bar"]),
            one["holds"],
        )
        for name, one in data["cases"].items()
    ]


def _of_estimation(data: Data) -> list[Bar]:
    found = []
    for name, one in data.get("bars", {}).items():
        asked = f"at {'most' if one['less'] else 'least'} {_number(one['bar'])} {one['unit']}"
        found.append(Bar(name, one["value"], None, asked, one["holds"]))
    return found


def _of_envelope(data: Data) -> list[Bar]:
    return [
        Bar(one["title"], one["size"], None, _number(one["aim"]), one["size"] >= one["aim"])
        for one in data["axes"].values()
    ]


def _of_paper(data: Data) -> list[Bar]:
    """Return its claims: what is asked of them is what the paper says."""
    return [
        Bar(f"{one['figure']}: {one['claim']}", None, None, one["paper"], one["holds"])
        for one in data["claims"]
    ]


def _number(value: float) -> str:
    return f"{value:.4g}"


_READ: Mapping[str, Callable[[Data], list[Bar]]] = {
    "robustness": _of_robustness,
    "running": _of_running,
    "ground": _of_ground,
    "estimation": _of_estimation,
    "envelope": _of_envelope,
    "paper": _of_paper,
}
