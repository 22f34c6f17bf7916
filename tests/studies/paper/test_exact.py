"""The identities of the paper: what the checks find when they are broken."""

import numpy as np
import pytest

from studies.paper import exact


def data_of(walks, differ=0, error=1e-14):
    return {
        "scenario": "",
        "seeds": [0],
        "fell": False,
        "cone": {"asked": 10, "inside": 4, "differ": differ, "line": [6, 5], "points": [8, 6]},
        "rows": {name: [error] * exact.KNOTS for name in ("r", "v", "L_G")},
        "walks": walks,
    }


def walks(on, off, count=6):
    return [
        {"feedback": feedback, "ledge_at": float(i), "impact_n": size + i, "roll_rad": 0.01}
        for i in range(count)
        for feedback, size in ((True, on), (False, off))
    ]


def test_the_cone_is_that_of_two_points_and_another_is_not(monkeypatch):
    found = exact.cone_errors(np.random.default_rng(1), 400)
    assert found["differ"] == 0
    assert 40 < found["inside"] < found["asked"] - 40
    cone = exact.line_cone
    monkeypatch.setattr(exact, "line_cone", lambda mu, X: cone(mu, X)[:4])  # a row pair short
    assert exact.cone_errors(np.random.default_rng(1), 400)["differ"] > 10


def test_rows_are_exact_and_a_wrong_one_is_seen(monkeypatch):
    found = exact.row_errors(np.random.default_rng(1))
    assert max(values.max() for values in found.values()) < exact.ROUNDING
    B = exact.input_matrices
    monkeypatch.setattr(exact, "input_matrices", lambda p, *rest: B(p + 1e-3, *rest))
    assert exact.row_errors(np.random.default_rng(1))["L_G"].max() > 1e-5


def test_claims_follow_the_numbers():
    assert [claim.holds for claim in exact.claims(data_of(walks(500.0, 900.0)))] == [True] * 3
    wrong = exact.claims(data_of(walks(900.0, 500.0), differ=1, error=1e-3))
    assert [claim.holds for claim in wrong] == [False] * 3
    assert not exact.claims(data_of([]))[2].holds


@pytest.mark.parametrize("rows", [walks(500.0, 900.0), []])
def test_table_and_picture(rows):
    data = data_of(rows)
    assert all(len(row) == 6 for row in exact.table(data))
    assert len(exact.draw(data).axes) == 2
