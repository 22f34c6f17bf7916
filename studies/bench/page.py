"""Writes the page on speed from `bench.json`, so that it says what was measured.

python -m studies.bench.page docs/bench.json docs/benchmarks.md
"""

import json
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from drake_linefoot.errors import OutputError
from drake_linefoot.lab.results.page import render
from studies.bench import tables
from studies.bench.measures import THRESHOLDS
from studies.common.files import write_text

USAGE = "usage: python -m studies.bench.page BENCH_JSON PAGE_MD"


def page(data: dict[str, Any], source: str) -> str:
    """Return the page as Markdown: `data` of `bench.json`, which it links to as `source`."""
    return render(
        "benchmarks.md.j2",
        Path(__file__).parent,
        data=data,
        source=source,
        versions=", ".join(f"{name} {found}" for name, found in data["versions"].items() if found),
        summary=tables.summary_rows(data),
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


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
