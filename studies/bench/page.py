"""Writes the page on speed from `bench.json`, so that it says what was measured.

python -m studies.bench.page docs/bench.json docs/benchmarks.md
"""

import json
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from drake_linefoot.errors import OutputError
from drake_linefoot.results.page import render
from studies.bench import tables
from studies.bench.measures import THRESHOLDS
from studies.common.files import write_text

USAGE = "usage: python -m studies.bench.page BENCH_JSON PAGE_MD"


def page(data: dict[str, Any], source: str) -> str:
    """Return the page as Markdown.

    Args:
        data: what `bench.json` holds.
        source: the name under which the page links to it.
    """
    growth, peer, plant = data["scaling"], *map(data["peers"].get, ("placo", "mujoco"))
    return render(
        "benchmarks.md.j2",
        Path(__file__).parent,
        data=data,
        source=source,
        versions=", ".join(f"{name} {found}" for name, found in data["versions"].items() if found),
        summary=tables.summary_rows(data),
        times=tables.time_rows(data),
        memory=_memory(data),
        solvers=tables.solver_rows(data),
        force=peer and tables.number(peer["vertical_force_difference_n"]),
        masses=plant and f"{plant['mass_matrix_difference']:.1g}",
        growth={
            size: tables.growth_rows(growth[name], size)
            for size, name in (
                ("knots", "mpc_over_knots"),
                ("wrenches", "mpc_over_contacts"),
                ("horizon_s", "mpc_over_knot_step"),
                ("degrees_of_freedom", "wbc_over_joints"),
            )
        },
        models=_models(growth.get("mpc_over_models")),
        profile=[
            [part, f"`{f['function']}`", f"{100.0 * f['share']:.0f} %"]
            for part, functions in growth["where_time_goes"].items()
            for f in functions
        ],
        handed_out=_handed_out(growth.get("dispatch_over_workers")),
        tick=[
            [f"`{part['name']}`", f"{part['us']:.1f}", f"{part['calls']:.2f}"]
            for part in growth.get("where_a_tick_goes", [])
        ],
        notes=tables.notes(data),
    )


def main(arguments: Sequence[str]) -> int:
    """Read `bench.json` and write the page; return the exit status."""
    if len(arguments) != 2:
        print(USAGE, file=sys.stderr)
        return 2
    source, target = map(Path, arguments)
    try:
        data = json.loads(source.read_text(encoding="utf-8"))
        missing = [name for name in THRESHOLDS if name not in data]
        if missing:
            print(f"{source}: lacks {', '.join(missing)}", file=sys.stderr)
            return 2
        write_text(target, page(data, source.name))
    except (OSError, ValueError, OutputError) as error:
        print(error, file=sys.stderr)
        return 2
    return 0


def _models(found: dict[str, Any] | None) -> list[list[str]]:
    """Return a row for each model of the MPC: the parts of an update, the whole over the ECD's."""
    if found is None:
        return []
    columns = {**found["median_ms"], "whole over the ECD's": found["over_ecd"]}
    rows = zip(found["models"], *columns.values(), strict=True)
    head = ["median [ms]", *columns]
    return [head, *([f"`{name}`", *map(tables.number, row)] for name, *row in rows)]


def _handed_out(found: dict[str, Any] | None) -> list[list[str]]:
    """Return a row for each number of workers of a sweep."""
    if found is None:
        return []
    columns = ("workers", "handed_out_per_s", "finished_per_s", "hours_for_many")
    rows = zip(*(found[name] for name in columns), strict=True)
    head = ["workers", "handed out [1/s]", "finished [1/s]", f"hours for {found['many']} runs"]
    return [head, *(list(map(tables.number, row)) for row in rows)]


def _memory(data: dict[str, Any]) -> str:
    """Return how memory was measured, when it was."""
    memory = data.get("memory")
    if not memory or "last" not in memory:
        return ""
    return ", ".join(
        f"{memory[name]['resident_mb']:.0f} MB with {memory[name]['log_mb']:.0f} MB of log on "
        f"the disk after {time:g} s"
        for name, time in zip(("first", "last"), memory["times_s"], strict=True)
    )


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
