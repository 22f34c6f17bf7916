"""The centre of pressure in a sole, as recorded, and how often it is at the edge."""

import numpy as np
import pytest

from drake_linefoot.axes import TAU_Y
from drake_linefoot.lab.results.pressure import (
    AT_EDGE,
    cop_at_edge,
    pressure_plot,
    true_pressure,
    wanted_pressure,
)
from drake_linefoot.lab.simulation.run_view import humanoid_named
from tests.helpers.recorded_runs import make_run

TIME = np.arange(100) * 1e-3
X = humanoid_named("mit_humanoid").half_length


def pressed(places, load=120.0):
    """Normal forces at heel and toe of both feet that act at places, shape (n, 2), in halves."""
    toe = 0.5 * load * (1.0 + places)
    return np.stack([load - toe, toe], axis=-1)


def test_it_is_where_the_forces_are():
    places = np.linspace(-0.9, 0.9, 200).reshape(100, 2)
    wrench = np.zeros((100, 2, 5))
    wrench[..., 2], wrench[..., TAU_Y] = 120.0, -120.0 * X * places
    run = make_run(TIME, true_normal=pressed(places), wbc_wrench=wrench)
    np.testing.assert_allclose(true_pressure(run)[..., 0], X * places, atol=1e-12)
    np.testing.assert_allclose(wanted_pressure(run)[..., 0], X * places, atol=1e-12)
    names = [panel.label for panel in pressure_plot(run).panels]
    assert names == ["left foot, ahead", "right foot, ahead"]


def test_the_share_at_the_edge_counts_ticks_with_load():
    """The right foot is in the air for half of the time, then at the edge in a third of it."""
    places, load = np.zeros((100, 2)), np.full((100, 2), 120.0)
    load[:40, 1] = 0.0
    places[40:60, 1] = -1.0 + 0.99 * AT_EDGE
    places[60:80, 1] = -1.0 + 1.01 * AT_EDGE
    run = make_run(TIME, true_normal=pressed(places, load))
    assert cop_at_edge(run) == {"left": 0.0, "right": pytest.approx(1.0 / 3.0)}


def test_without_load_nothing_is_known():
    run = make_run(TIME, true_normal=np.zeros((100, 2, 2)))
    assert cop_at_edge(run) == {"left": None, "right": None}
    assert np.isnan(true_pressure(run)).all()
