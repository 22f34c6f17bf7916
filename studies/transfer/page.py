"""Bars and page of the walks in two simulators."""

from collections.abc import Mapping, Sequence
from typing import Any

from drake_linefoot.lab.results.tables import number
from studies.common.paired import HOW
from studies.common.types import Data
from studies.transfer.cases import (
    CASES,
    DRAKE,
    ESTIMATE,
    ITS_OWN_SPEED,
    LATE,
    LATENCY,
    LESS,
    MUJOCO,
    MUJOCO_2,
    OWN,
    PLANTS,
    RATE,
    SPEED,
)
from studies.transfer.robots import WALKED, in_both


def bars_of(
    rows: Sequence[Mapping[str, Any]], pairs: Mapping[str, Data], others: Sequence[Data]
) -> list[Data]:
    """Return what is asked: `what`, `value`, `bar`, and whether it `holds`.

    Args:
        rows: of `walked`.
        pairs: see `shares`.
        others: robots, of `robots.walked`.
    """

    def of(plant: str, name: str, cases: Sequence[str] = tuple(CASES)) -> list[float]:
        mine = [row[name] for row in rows if row["plant"] == plant and row["case"] in cases]
        return [value for value in mine if value is not None]

    fell = sum(not row["upright"] for row in rows)
    ours = [name for name in CASES if name not in (ESTIMATE, LATE) and "push" not in name]
    rates = [of(plant, "rate") for plant in (MUJOCO_2, DRAKE)]
    ratio = [sum(rate) / len(rate) for rate in rates if rate]
    asked = (
        ("runs that are not upright", fell, 0.0),
        ("speed in MuJoCo: largest error [m/s]", max(of(MUJOCO, "speed_error", ours)), SPEED),
        ("likewise with its own contacts", max(of(OWN, "speed_error", ours)), ITS_OWN_SPEED),
        ("likewise on the estimate", max(of(MUJOCO, "speed_error", [ESTIMATE])), ITS_OWN_SPEED),
        ("likewise with 5 ms of delay", max(of(MUJOCO, "speed_error", [LATE])), ITS_OWN_SPEED),
        ("false contacts in MuJoCo, without pushes", sum(of(MUJOCO, "false_contacts", ours)), 0.0),
        ("latency of contacts in MuJoCo [ms]", max(of(MUJOCO, "contact_latency", ours)), LATENCY),
    )
    found: list[Data] = [
        {"what": what, "value": value, "bar": bar, "holds": value <= bar + 1e-9}
        for what, value, bar in asked
    ]
    share = ratio[0] / ratio[1]
    quick = "simulated seconds a CPU second: MuJoCo at 2 ms over Drake at 1 ms"
    found.append({"what": quick, "value": share, "bar": RATE, "holds": share >= RATE})
    fewer = [100.0 * (one["drake"] - one["mujoco"]) / one["runs"] for one in pairs.values()]
    what, most = "group with the most runs fewer upright in MuJoCo [%]", max(fewer, default=0.0)
    found.append({"what": what, "value": most, "bar": LESS, "holds": most <= LESS})
    what, walk = "robots of the zoo that walk in both", len(in_both(others))
    return [*found, {"what": what, "value": walk, "bar": WALKED, "holds": walk >= WALKED}]


def page_of(
    rows: Sequence[Mapping[str, Any]], pairs: Mapping[str, Data], others: Sequence[Data], made: str
) -> str:
    """Return the page, as Markdown for the documentation; `made` says with what it was made."""
    bars = bars_of(rows, pairs, others)
    lines = [
        "# The same walks in two simulators",
        "",
        f"**The speed in MuJoCo is off by {number(bars[1]['value'], '.2g')} m/s at most; "
        f"{sum(bar['holds'] for bar in bars)} of {len(bars)} bars hold.**",
        "",
        "The MIT Humanoid in Drake and in",
        "[MuJoCo](../simulators.md#mujoco), in the contacts that a scenario has by default and in",
        "those that MuJoCo has. Errors of the speed are the largest of a run's segments.",
        "",
        "| what is asked | found | bar | |",
        "|---|---|---|---|",
    ]
    for bar in bars:
        value, holds = number(bar["value"], ".3g"), "holds" if bar["holds"] else "**missed**"
        lines.append(f"| {bar['what']} | {value} | {bar['bar']:g} | {holds} |")
    for title, name, spec in (
        ("Error of the speed [m/s]", "speed_error", ".3f"),
        ("Latency of contacts, median [ms]", "contact_latency", ".0f"),
        ("False contacts", "false_contacts", "d"),
        ("Simulated seconds a CPU second", "rate", ".2f"),
    ):
        lines += ["", f"## {title}", "", "| |" + "".join(f" {plant} |" for plant in PLANTS)]
        lines.append("|---|" + "---|" * len(PLANTS))
        for case in CASES:
            at = {row["plant"]: row for row in rows if row["case"] == case}
            cells = [
                number(at[plant][name], spec) if at[plant]["upright"] else "fell"
                for plant in PLANTS
            ]
            lines.append(f"| {case} | " + " | ".join(cells) + " |")
    lines += ["", "## Robustness", "", "Runs of each group of [the sweep](../sweeps.md) that stay"]
    lines += ["upright, the same draws in Drake, in MuJoCo, and in Drake with each plan of the MPC"]
    lines += ["[an update late](../simulators.md#the-mpc-beside-the-tick); behind it the median of"]
    lines += ["the largest tilt of those [rad].", ""]
    lines += ["| | runs | Drake | MuJoCo | late plans |", "|---|---|---|---|---|"]
    for group, one in pairs.items():
        cells = [f"{one[how]}, {number(one[f'{how}_tilt'], '.3f')}" for how in HOW]
        lines.append(f"| {group} | {one['runs']} | {' | '.join(cells)} |")
    lines += ["", "## Robots of the zoo", "", "Each described from its model alone, walked as fast"]
    lines += [
        "as its first walk is. The H1 is that of robosuite-models, an MJCF; that it walks as it is",
        "there, with its own joints, contacts and options, counts as a simulator of its own.",
        "",
        "| | simulator | speed [m/s] | error | |",
        "|---|---|---|---|---|",
    ]
    for one in others:
        end = "walks" if one["upright"] else one["reason"]
        cells = [number(one["speed"], ".2f"), number(one["error"], ".3f"), end]
        lines.append(
            f"| {one['name']}, {one['contact']} | {one['simulator']} | {' | '.join(cells)} |"
        )
    lines += ["", "---", "", f"Made by `make transfer`, by which it is changed. {made}."]
    return "\n".join(lines) + "\n"
