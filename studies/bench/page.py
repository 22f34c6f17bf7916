"""Writes the page on speed from `bench.json`, so that it says what was measured.

python -m studies.bench.page docs/bench.json docs/benchmarks.md
"""

import json
import sys
from pathlib import Path
from typing import Any

from drake_linefoot.errors import InputError
from drake_linefoot.lab.results.page import render
from studies.bench import tables
from studies.bench.measures import THRESHOLDS
from studies.common.bars import HEAD, bar_rows
from studies.common.command import run
from studies.common.files import write_text


def page(data: dict[str, Any], source: str) -> str:
    """Return the page as Markdown: `data` of `bench.json`, which it links to as `source`."""
    return render(
        "benchmarks.md.j2",
        Path(__file__).parent,
        data=data,
        source=source,
        versions=", ".join(f"{name} {found}" for name, found in data["versions"].items() if found),
        head=HEAD,
        bars=bar_rows(data["bars"]),
        times=tables.time_rows(data),
        solvers=tables.solver_rows(data),
        growth={
            size: tables.growth_rows(data["scaling"][name], size)
            for size, name in (
                ("knots", "mpc_over_knots"),
                ("wrenches", "mpc_over_contacts"),
                ("horizon_s", "mpc_over_knot_step"),
                ("degrees_of_freedom", "wbc_over_joints"),
            )
        },
        number=tables.number,
        notes=tables.notes(data),
    )


def write(source: Path, target: Path) -> None:
    """Write the page TARGET from SOURCE, a bench.json."""
    try:
        data = json.loads(source.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise InputError(source, "", "benchmark", f"cannot be read: {error}") from error
    if missing := [name for name in THRESHOLDS if name not in data]:
        raise InputError(source, "", "benchmark", f"lacks {', '.join(missing)}")
    write_text(target, page(data, source.name))


if __name__ == "__main__":
    sys.exit(run(write, "bench.page"))
