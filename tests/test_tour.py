"""The notebook runs from its first cell to its last, and its outputs are those that it keeps."""

import json
import re

import numpy as np
import pytest

from tests.helpers.notebooks import ROOT, run_notebook

NOTEBOOK = ROOT / "examples" / "tour.ipynb"
NUMBER = re.compile(r"-?\d+(?:\.\d+)?")


def cells(path):
    return [c for c in json.loads(path.read_text(encoding="utf-8"))["cells"] if "outputs" in c]


def outputs(path):
    return [output for cell in cells(path) for output in cell["outputs"]]


def texts(path):
    """What its outputs say: printed, as Markdown, and in drawings."""
    said = []
    for output in outputs(path):
        data = output.get("data", {})
        said.append("".join(output.get("text", "")) + "".join(data.get("text/markdown", "")))
        said += sorted(re.findall(r">([^<]+)</text>", "".join(data.get("image/svg+xml", ""))))
    return "\n".join(said)


def test_its_outputs_are_kept_without_what_differs_from_run_to_run():
    kept = cells(NOTEBOOK)
    assert NOTEBOOK.stat().st_size < 1_000_000
    assert [c["execution_count"] for c in kept] == list(range(1, len(kept) + 1))
    assert {o["output_type"] for o in outputs(NOTEBOOK)} == {
        "display_data",
        "execute_result",
        "stream",
    }
    plain = [str(o.get("text", o.get("data", {}).get("text/plain"))) for o in outputs(NOTEBOOK)]
    assert not re.search(r"0x[0-9a-f]{6}|/tmp|://", "".join(plain))


@pytest.mark.slow
def test_it_runs_and_says_what_it_keeps(tmp_path):
    """When only the comparison fails, run `make notebook`, look at it and commit it."""
    ran = tmp_path / "tour.ipynb"
    run_notebook(ran, timeout=400)
    said = texts(ran)
    assert "solver in 14 intervals" in said and "largest use: " in said
    assert said.count("fell: False") == 2
    kinds = [sorted(o["data"]) for o in outputs(ran) if "data" in o]
    assert kinds == [sorted(o["data"]) for o in outputs(NOTEBOOK) if "data" in o]
    assert sum("image/png" in kind for kind in kinds) == 4
    assert sum("image/svg+xml" in kind for kind in kinds) == 1
    assert NUMBER.sub("#", said) == NUMBER.sub("#", texts(NOTEBOOK))
    numbers = [[float(n) for n in NUMBER.findall(text)] for text in (said, texts(NOTEBOOK))]
    np.testing.assert_allclose(*numbers, rtol=0.05, atol=0.1)
    (frame,) = [
        "".join(o["data"]["text/html"]) for o in outputs(ran) if "text/html" in o.get("data", {})
    ]
    assert 'src="out/tour/replay.html"' in frame
    assert (tmp_path / "out" / "tour" / "replay.html").stat().st_size > 1_000_000
