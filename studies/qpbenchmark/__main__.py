"""`python -m studies.qpbenchmark`: programs of a walk in the form that qpbenchmark takes.

    minimise 1/2 z'P z + q'z  subject to  G z <= h

P and q are H (47) and g (48), G the wrench cones (18), h zero, all in scaled variables: what the
MPC itself solves. `linefoot_mpc.parquet` holds them, `linefoot_mpc.py` is the test set:

    qpbenchmark out/qpbenchmark/linefoot_mpc.py run
"""

import json
import sys
import warnings
from collections.abc import Sequence
from importlib.metadata import version
from pathlib import Path
from statistics import median
from time import perf_counter
from typing import Annotated, Any

import numpy as np
import pyarrow as pa
import typer
from pyarrow import parquet

from drake_linefoot.errors import InputError, LinefootError
from drake_linefoot.lab.results.page import render
from drake_linefoot.mpc.condensed_qp import CondensedQp
from studies.bench.blocks import MpcUpdate
from studies.common.command import Out, Quick, run
from studies.common.files import prepare, write_json, write_text
from studies.common.recorder import Walk, record
from studies.common.runs import paper_scenario
from studies.common.stamp import cpu_seconds, stamped

NAME, PAGE, DATA = "linefoot_mpc", "qpbenchmark.md", "qpbenchmark.json"
COUNT, ROUNDS = 100, 5
KEYS = ("P", "q", "G", "h", "A", "b", "lb", "ub")
Data = dict[str, Any]
SOLVED = 1e-6  # [-] largest residual or gap of a solution that counts


def programs(walk: Walk, count: int) -> list[CondensedQp]:
    """Return the programs of `count` updates of the MPC, evenly spread over a walk."""
    update = MpcUpdate(walk.humanoid, walk.scenario)
    return [update.program(problem) for problem in walk.walking_problems(count)]


def write_set(found: Sequence[CondensedQp], folder: Path) -> list[Path]:
    """Write the problems and their test set; return the files.

    Matrices are flat, row by row, as qpbenchmark stores them; what there is none of is null.
    """
    columns: dict[str, list[Any]] = {key: [] for key in (*KEYS, "name")}
    for i, qp in enumerate(found):
        G = qp.rows()
        given = {"P": qp.H, "q": qp.g, "G": G, "h": np.zeros(len(G))}
        for key in KEYS:
            columns[key].append(given[key].ravel() if key in given else None)
        columns["name"].append(f"LINEFOOT{i:03d}")
    files = [folder / f"{NAME}.parquet", folder / f"{NAME}.py"]
    parquet.write_table(pa.table(columns), files[0])
    write_text(files[1], render("linefoot_mpc.py.j2", Path(__file__).parent))
    return files


def measure(test_set: Any, rounds: int) -> list[tuple[str, float, float, float]]:
    """Return solver, share of problems solved [-], median and 95th percentile of the time [ms].

    Solvers take turns, problem by problem; of each problem the shortest time of some rounds
    counts. Settings are qpbenchmark's for high accuracy.
    """
    import qpsolvers

    test_set.define_tolerances()
    test_set.define_solver_settings()
    settings = test_set.solver_settings["high_accuracy"]
    rows, problems = [], list(test_set)
    times: dict[str, list[float]] = {solver: [] for solver in sorted(test_set.solvers)}
    solved = dict.fromkeys(times, 0)
    for problem in problems:
        for solver, of_solver in times.items():
            shortest, good = np.inf, False
            dense = solver in qpsolvers.dense_solvers
            given = problem.to_dense() if dense else problem.to_sparse()
            for _ in range(rounds):
                with warnings.catch_warnings():
                    warnings.simplefilter("ignore")  # of solvers that stop early: it is counted
                    begin = perf_counter()
                    found = qpsolvers.solve_problem(given, solver, **settings[solver])
                    shortest = min(shortest, perf_counter() - begin)
                errors = (found.primal_residual(), found.dual_residual(), found.duality_gap())
                good = bool(found.found) and max(errors) < SOLVED
            of_solver.append(1e3 * shortest)
            solved[solver] += good
    for solver, of_solver in times.items():
        tail = float(np.percentile(of_solver, 95))
        rows.append((solver, solved[solver] / len(problems), median(of_solver), tail))
    return sorted(rows, key=lambda row: (-row[1], row[2]))


def data_of(rows: Sequence[tuple[str, float, float, float]], found: Sequence[CondensedQp]) -> Data:
    """Return what the page says, as JSON takes it."""
    sizes = [len(qp.g) for qp in found]
    versions = {name: version(name) for name in ("qpsolvers", "qpbenchmark")}
    of_set = {"name": NAME, "problems": len(sizes), "least": min(sizes), "most": max(sizes)}
    return {"rows": [list(row) for row in rows], "limit": SOLVED, **of_set, **versions}


def page_of(data: Data) -> str:
    """Return the page of what is stored, the solver of all problems that is quickest first."""
    return render("qpbenchmark.md.j2", Path(__file__).parent, **data)


def qpbenchmark(
    out: Out = Path("out/qpbenchmark"),
    quick: Quick = False,
    redraw: Annotated[bool, typer.Option("--page", help="Only write the page anew.")] = False,
) -> None:
    """Write the problem set, solve it with what is installed, and write table and page."""
    prepare(out)
    file = out / DATA
    if not redraw:
        write_json(file, _solved(out, quick) | stamped("qpbenchmark", cpu_seconds()))
    elif not file.exists():
        raise InputError(file, "", "table of a run", "is not there")
    page = page_of(json.loads(file.read_text(encoding="utf-8")))
    write_text(out / PAGE, page)
    print(page)


def _solved(out: Path, quick: bool) -> Data:
    """Write the problem set into a folder and solve it; return the `data_of` it."""
    import runpy

    walk = record(paper_scenario(quick, segments=(0.5, 1.0, 1.0)))
    if walk.fall_reason:
        raise LinefootError(f"the walk was not walked: {walk.fall_reason}")
    found = programs(walk, 10 if quick else COUNT)
    files = write_set(found, out)
    test_set = runpy.run_path(str(files[1]))["LinefootMpc"]()
    return data_of(measure(test_set, 1 if quick else ROUNDS), found)


if __name__ == "__main__":
    sys.exit(run(qpbenchmark, "qpbenchmark"))
