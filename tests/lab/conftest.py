"""What the tests of the commands share."""

import pytest

from drake_linefoot.errors import LinefootError
from drake_linefoot.lab.simulation import run as simulation


@pytest.fixture
def simulated(monkeypatch):
    """Loops that would have been simulated; the command breaks off instead."""
    loops = []

    def simulate(loop, *_, **__):
        loops.append(loop)
        raise LinefootError("not simulated")

    monkeypatch.setattr(simulation, "simulate", simulate)
    return loops
