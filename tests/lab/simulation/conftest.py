"""What the tests of the simulation share."""

import pytest

from drake_linefoot.wbc.control import WholeBodyControl


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
