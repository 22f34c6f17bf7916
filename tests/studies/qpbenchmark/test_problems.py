"""The MPC's programs as a problem set: what is in the file, and who can read it."""

import json
import runpy
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from pyarrow import parquet
from pydrake.solvers import ClarabelSolver, MathematicalProgram

from drake_linefoot.errors import InputError
from drake_linefoot.lab.scenario import Scenario
from drake_linefoot.mpc.parameters import MpcParameters
from drake_linefoot.robot.humanoid import load_humanoid
from studies.qpbenchmark import __main__ as problems
from tests.helpers.walking import recorded_walk


@dataclass
class Recorded:
    """A recorded walk as far as the study looks at it."""

    humanoid: object
    scenario: object

    def walking_problems(self, count):
        return recorded_walk().mpc[-count:]


@pytest.fixture(scope="module")
def programs():
    scenario = Scenario(mpc=MpcParameters(model="ecd"))  # as in the recorded walk
    return problems.programs(Recorded(load_humanoid("mit_humanoid"), scenario), 3)


def test_the_file_has_the_programs_in_the_columns_of_qpbenchmark(programs, tmp_path):
    files = problems.write_set(programs, tmp_path)
    rows = parquet.read_table(files[0]).to_pylist()
    assert [row["name"] for row in rows] == ["LINEFOOT000", "LINEFOOT001", "LINEFOOT002"]
    for row, qp in zip(rows, programs, strict=True):
        n = len(row["q"])
        assert [row[key] for key in ("A", "b", "lb", "ub")] == [None] * 4
        P, G = np.reshape(row["P"], (n, n)), np.reshape(row["G"], (-1, n))
        np.testing.assert_array_equal(P, P.T)
        assert len(G) == len(row["h"]) == 6 * n // 5 and not any(row["h"])
        program = MathematicalProgram()
        z = program.NewContinuousVariables(n)
        program.AddQuadraticCost(P, np.array(row["q"]), z)
        program.AddLinearConstraint(G, np.full(len(G), -np.inf), np.array(row["h"]), z)
        best = ClarabelSolver().Solve(program)
        assert best.is_success()
        feet = (best.GetSolution(z) * qp.scale).reshape(-1, 5)
        assert feet[:, 2].max() > 50.0  # [N] that carry the robot


def test_qpbenchmark_reads_the_set_and_its_solvers_solve_it(programs, tmp_path):
    pytest.importorskip("qpbenchmark")
    files = problems.write_set(programs, tmp_path)
    test_set = runpy.run_path(str(files[1]))["LinefootMpc"]()
    assert [each.name for each in test_set][-1] == "LINEFOOT002"
    rows = problems.measure(test_set, 1)
    assert rows and rows[0][1] == 1.0
    assert all(0.0 <= share <= 1.0 and 0.0 < m <= tail for _, share, m, tail in rows)
    page = problems.page_of(problems.data_of(rows, programs))
    assert page.count("\n| ") == len(rows) + 1 and "3 condensed programs" in page


def test_the_page_is_that_of_its_data_and_begins_with_what_was_found(tmp_path):
    docs = Path(problems.__file__).parents[2] / "docs"
    data = json.loads((docs / problems.DATA).read_text(encoding="utf-8"))
    page = problems.page_of(data)
    assert page == (docs / problems.PAGE).read_text(encoding="utf-8")
    quickest = min((row for row in data["rows"] if row[1] == 1.0), key=lambda row: row[2])[0]
    beginning = f"**5 of 6 solvers solve all 100 problems; {quickest} is the quickest, with "
    assert page.splitlines()[2].startswith(beginning)
    data["rows"] = [["osqp", 0.5, 0.1, 2.0], ["quick", 1.0, 1.0, 2.0], ["slow", 1.0, 2.0, 3.0]]
    assert "**2 of 3 solvers solve all 100 problems; quick is" in problems.page_of(data)
    data["rows"] = [["osqp", 0.5, 1.0, 2.0]]
    assert "**None of 1 solvers solves all" in problems.page_of(data)
    with pytest.raises(InputError, match=r"qpbenchmark\.json"):
        problems.qpbenchmark(tmp_path, redraw=True)
