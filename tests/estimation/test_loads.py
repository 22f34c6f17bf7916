"""What the filter makes of loads that change: how deep points sink in, and when they may slip."""

import numpy as np
import pytest

from drake_linefoot.constants import GRAVITY
from drake_linefoot.estimation.filter_state import CONTACT, POINTS, filter_of, new_filter
from drake_linefoot.estimation.invariant_filter import propagate, rates_of, sunk
from tests.estimation.test_invariant_filter import POSTURE, QUIET, H, standing_filter


def test_how_fast_a_load_changes_follows_a_steady_change():
    """To 3 % after four times the time over which it is seen; and not a load that stays."""
    s = filter_of(new_filter())
    for k in range(40):
        rates = rates_of(s, np.array([2e3 * k * H, 0.0, 0.0, 0.0]), H, QUIET)
    assert rates[0] == pytest.approx(2e3, rel=0.03)
    np.testing.assert_array_equal(rates[1:], 0.0)


def test_a_point_sinks_in_as_a_spring_with_hunts_and_crossleys_damping():
    """Of a spring that sinks in by 5 mm/s, f = k x (1 + c v), with a load that is 4 ms late."""
    k, c, v, late = 2.5e5, 12.0, 5e-3, 4e-3
    noise = QUIET._replace(stiffness=k, dissipation=c, delay=late)
    x = 4e-4
    load, rate = k * x * (1.0 + c * v), k * v * (1.0 + c * v)
    assert sunk(load - late * rate, rate, noise) == pytest.approx(x, rel=0.01)
    assert sunk(100.0, 0.0, noise) == pytest.approx(100.0 / k)


def test_a_point_whose_load_falls_may_slip():
    """What it bears is twice `full`; falling so that it bears nothing in `change` it is free."""
    wander = {}
    for rate in (0.0, -6e3):
        s = standing_filter(POSTURE)
        s.active[:] = 1.0
        before = s.P[CONTACT, CONTACT]
        rest, load = np.concatenate([np.zeros(3), -GRAVITY]), np.full(POINTS, 60.0)
        c = QUIET._replace(slip=1e-4)
        propagate(s, rest, (load, np.array([rate, 0.0, 0.0, 0.0])), H, c)
        wander[rate] = s.P[CONTACT, CONTACT] - before
    assert wander[0.0] == pytest.approx(H * (1.5e-4) ** 2, rel=1e-6)
    assert wander[-6e3] > 1e4 * wander[0.0]
