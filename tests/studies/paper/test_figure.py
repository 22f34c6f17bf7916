"""The contract of the figures, and their names."""

import subprocess
import sys

import pytest

from drake_linefoot.errors import InputError
from studies.paper import figure
from studies.paper.figure import Claim, figure_names, load_figure


@pytest.mark.parametrize("name", figure_names())
def test_every_figure_fulfils_the_contract(name):
    module = load_figure(name)
    assert name == module.NAME
    assert module.TITLE
    for function in ("compute", "draw", "table", "claims"):
        assert callable(getattr(module, function))


def test_the_paper_s_figures_are_there():
    assert {"fig3", "fig4", "fig5", "fig6", "fig7", "feasibility"} <= set(figure_names())


def test_an_unknown_figure_is_refused():
    with pytest.raises(InputError, match="figure = 'fig1': unknown; must be one of"):
        load_figure("fig1")


def test_a_module_that_is_missing_is_no_figure(monkeypatch):
    monkeypatch.setitem(figure._MODULES, "fig9", "figure9")
    assert "fig9" not in figure_names()


def test_names_are_told_without_drake():
    code = "import sys; from studies.paper.figure import figure_names; figure_names();"
    code += "sys.exit('pydrake' in sys.modules)"
    subprocess.run([sys.executable, "-c", code], check=True, timeout=60)


def test_a_claim_as_json():
    claim = Claim("fig5", "vanishes", "to zero", "0.1 N", True, "a note")
    assert claim.as_dict() == {
        "figure": "fig5",
        "claim": "vanishes",
        "paper": "to zero",
        "ours": "0.1 N",
        "holds": True,
        "note": "a note",
    }
