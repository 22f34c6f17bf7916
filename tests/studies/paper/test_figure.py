"""The contract of the figures, and their names."""

import subprocess
import sys

import numpy as np
import pytest

from drake_linefoot.errors import InputError
from studies.common import runs
from studies.paper.figure import FIGURES, compared, load_figure, survives


@pytest.mark.parametrize("name", FIGURES)
def test_every_figure_fulfils_the_contract(name):
    module = load_figure(name)
    assert module.TITLE
    for function in ("compute", "draw", "table", "claims"):
        assert callable(getattr(module, function))


def test_the_paper_s_figures_are_there():
    assert {"fig3", "fig4", "fig5", "fig6", "fig7", "feasibility"} <= set(FIGURES)


def test_an_unknown_figure_is_refused():
    with pytest.raises(InputError, match="figure = 'fig1': unknown; must be one of"):
        load_figure("fig1")


def test_names_are_told_without_drake():
    code = "import sys; from studies.paper.figure import FIGURES;"
    code += "sys.exit('pydrake' in sys.modules)"
    subprocess.run([sys.executable, "-c", code], check=True, timeout=60)


@pytest.mark.parametrize(
    ("interval", "holds"),
    [([0.3, 0.5], True), ([0.5, 0.8], None), ([0.7, 0.8], False), (None, True)],
)
def test_a_ratio_is_undecided_when_its_interval_has_the_aim(interval, holds):
    ratio = 0.75 if holds is False else 0.45
    found = {"ratio": ratio, "interval": interval, "lower": 3, "pairs": 4}
    claim = compared("c", found, "it", 0.6, "p", "n")
    assert claim.holds is holds
    assert ("lower in 3 of 4" in claim.ours) == (interval is not None)
    assert "pooled" not in claim.ours
    claim = compared("c", {**found, "pooled": 0.9}, "it", 0.6, "p", "n")
    assert ("pooled 0.90" in claim.ours) == (interval is not None)
    assert claim.holds is holds  # the interval decides, whatever the pooled ratio is
    assert claim.verdict == {True: "yes", False: "no", None: "undecided"}[holds]


@pytest.mark.parametrize(
    ("one", "other", "holds"), [(1, 2, None), (0, 8, True), (8, 0, False), (0, 0, None)]
)
def test_falls_decide_only_when_chance_does_not_explain_them(one, other, holds):
    fell = [(True, False)] * one + [(False, True)] * other + [(True, True), (False, False)] * 5
    assert survives("c", "p", fell, "n").holds is holds


def test_the_interval_of_a_ratio():
    rng = np.random.default_rng(2)
    theirs = rng.uniform(1.0, 2.0, 40)
    found = runs.compared(np.column_stack([theirs * rng.uniform(0.4, 0.6, 40), theirs]))
    low, high = found["interval"]
    assert low < found["ratio"] < high
    assert 0.45 < low < high < 0.55
    assert (found["lower"], found["pairs"]) == (40, 40)
    alone = {"ratio": 0.5, "interval": None, "lower": 1, "pairs": 1}
    assert runs.compared([(1.0, 2.0), (None, 1.0)]) == alone


def test_one_large_value_decides_a_ratio_but_not_the_count():
    found = runs.compared([(1.0, 2.0)] * 9 + [(20.0, 10.0)])
    assert found["ratio"] > 1.0
    assert (found["lower"], found["pairs"]) == (9, 10)
