"""What the tests of the simulation share."""

import numpy as np
import pytest

from drake_linefoot.lab.simulation.recording import LOG
from drake_linefoot.wbc.control import WholeBodyControl
from tests.helpers.recorded_runs import make_run


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """A recording of 11 samples."""
    file = tmp_path_factory.mktemp("whole") / LOG
    make_run(np.arange(11) * 1e-3).save(file)
    return file


@pytest.fixture
def wbc_ticks(monkeypatch):
    """One entry for each tick that the whole-body controller computes."""
    calls = []
    compute = WholeBodyControl.compute

    def counted(self, *args):
        calls.append(1)
        return compute(self, *args)

    monkeypatch.setattr(WholeBodyControl, "compute", counted)
    return calls
