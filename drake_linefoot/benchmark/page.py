"""Writes the page on speed from `bench.json`, so that it says what was measured.

python -m drake_linefoot.benchmark.page docs/bench.json docs/benchmarks.md
"""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from drake_linefoot.benchmark import tables
from drake_linefoot.benchmark.results import KEYS

USAGE = "usage: python -m drake_linefoot.benchmark.page BENCH_JSON PAGE_MD"

HEAD = """# How fast it is

Made from [{source}]({source}) by `python -m drake_linefoot.benchmark.page`; do not edit.

`{command}` on {date}{quick}: {processor}, {cores} cores, {system}, load {load} when it began;
{versions}.

What is compared took turns in one run, on the states and programs of the recorded walk
`{scenario}` ({ticks} ticks, {mpc} MPC problems). Times differ between machines; the bars are on
ratios of medians within the run.
"""

SOLVERS = """A solver gets the condensed program ready in the form it takes, and starts cold; its
setting is the loosest power of ten that leaves at most 1 N in the first wrench on every problem
(torques count as the force at the end of the line). The errors are to Clarabel at 1e-12: at 1e-10
it may itself be half a newton away from what the exact solvers agree on.
"""

PLACO = """PlaCo {version} (C++, Pinocchio) has line contacts under the standing feet, tasks for the
centre of mass (the plan's acceleration), torso, swing foot and arms, with the same friction; its
tick is state, kinematics, targets and solve. It runs in a process of its own, on the same states
in turn. The vertical force of both feet differs from our controller's by {force} N (median).
"""


def page(data: dict[str, Any], source: str) -> str:
    """Return the page as Markdown.

    Args:
        data: what `bench.json` holds.
        source: the name under which the page links to it.
    """
    growth = data["scaling"]
    parts = [
        _head(data, source),
        "## Ratios and rates",
        _table(tables.summary_rows(data)),
        "## Times",
        _table(tables.time_rows(data)),
        _started(data),
        "## Solvers of the MPC's program",
        SOLVERS,
        _table(tables.solver_rows(data)),
        _placo(data),
        "## How it grows",
        "MPC over the number of knots; a time grows with the power of the knots that the last "
        "column says.",
        _table(tables.growth_rows(growth["mpc_over_knots"], "knots")),
        "MPC over the number of wrenches in its horizon (a standing foot has one per interval).",
        _table(tables.growth_rows(growth["mpc_over_contacts"], "wrenches")),
        "MPC over the length of the horizon [s], knots as they are.",
        _table(tables.growth_rows(growth["mpc_over_knot_step"], "horizon_s")),
        "Whole-body controller over degrees of freedom: "
        f"{', '.join(growth['wbc_over_joints']['robots'])}.",
        _table(tables.growth_rows(growth["wbc_over_joints"], "degrees_of_freedom")),
        "Where the time goes (own time of a function, with the profiler on, which makes Python's "
        "calls dearer):",
        _profile(growth["where_time_goes"]),
        _notes(data),
    ]
    return "\n\n".join(part.strip() for part in parts if part) + "\n"


def main(arguments: Sequence[str]) -> int:
    """Read `bench.json` and write the page; return the exit status."""
    if len(arguments) != 2:
        print(USAGE, file=sys.stderr)
        return 2
    source, target = map(Path, arguments)
    try:
        data = json.loads(source.read_text(encoding="utf-8"))
        missing = [name for name in KEYS if name not in data]
        if missing:
            print(f"{source}: lacks {', '.join(missing)}", file=sys.stderr)
            return 2
        target.write_text(page(data, source.name), encoding="utf-8")
    except (OSError, ValueError) as error:
        print(error, file=sys.stderr)
        return 2
    return 0


def _head(data: dict[str, Any], source: str) -> str:
    versions = [f"{name} {found}" for name, found in data["versions"].items() if found]
    return HEAD.format(
        source=source,
        command=data["command"],
        date=data["date"],
        quick=" (shortened)" if data["quick"] else "",
        versions=", ".join(versions),
        **data["machine"],
        **data["measured_on"],
    )


def _started(data: dict[str, Any]) -> str:
    """Return how memory was measured, when it was."""
    memory = data.get("memory")
    if not memory or "last" not in memory:
        return ""
    looks = ", ".join(
        f"{memory[name]['resident_mb']:.0f} MB with {memory[name]['log_mb']:.0f} MB of log after "
        f"{time:g} s"
        for name, time in zip(("first", "last"), memory["times_s"], strict=True)
    )
    return f"Resident memory of a walk: {looks}."


def _placo(data: dict[str, Any]) -> str:
    peer = data["peers"].get("placo")
    if peer is None:
        return ""
    force = tables.number(peer["vertical_force_difference_n"])
    return PLACO.format(version=peer["version"], force=force)


def _table(rows: tables.Rows) -> str:
    head, *body = rows
    line = "|" + "---|" + "---:|" * (len(head) - 1)
    return "\n".join([_row(head), line, *map(_row, body)])


def _row(cells: Sequence[str]) -> str:
    return "| " + " | ".join(cell.replace("|", r"\|") for cell in cells) + " |"


def _profile(profile: dict[str, list[dict[str, Any]]]) -> str:
    rows = [["part", "function", "share"]]
    for part, functions in profile.items():
        for f in functions:
            rows.append([part, f"`{f['function']}`", f"{100.0 * f['share']:.0f} %"])
    return _table(rows)


def _notes(data: dict[str, Any]) -> str:
    lines = tables.notes(data)
    return "## Notes\n\n" + "\n".join(f"* {line}" for line in lines) if lines else ""


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
