"""Viability of a pendulum, against every sequence of steps from a grid."""

from itertools import product

import numpy as np
import pytest

from drake_linefoot.gait.viability import (
    StepBounds,
    is_viable,
    viable_impulse,
    viable_offsets,
)

OMEGA, QUICK = 3.9, 0.13
LIMITS = np.array([0.5, 0.1, 0.45])
BOUNDS = StepBounds(OMEGA, QUICK, LIMITS, viable_offsets(QUICK, LIMITS, OMEGA))
STEPS = 12  # after which what is lost is a metre away


def nearby(start, times, feet, outward):
    """Whether one coordinate of a DCM is near a foot after steps at some of `feet`; brute force."""
    states = np.array([start])
    for time in times:
        ends = states[:, None] * np.exp(OMEGA * time) - feet
        ends = np.unique(np.round(-ends if outward else ends, 3))
        states = ends[np.abs(ends) < 1.0]
    return len(states) > 0


def saved(zeta, soonest):
    """Whether any steps of a grid save a pendulum, quick ones and slow ones."""
    length, narrow, wide = BOUNDS.limits
    ahead, aside = np.linspace(-length, length, 21), np.linspace(narrow, wide, 15)
    for slower in product((1.0, 1.5), repeat=3):
        times = QUICK * np.array([*slower, *[1.0] * (STEPS - 3)])
        times[0] = soonest * slower[0]
        if nearby(zeta[0], times, ahead, False) and nearby(zeta[1], times, aside, True):
            return True
    return False


ANGLES = np.arange(8) * 0.25 * np.pi


@pytest.mark.parametrize("angle", ANGLES)
@pytest.mark.parametrize("soonest", [QUICK, 0.07])
def test_the_bound_is_where_brute_force_has_it(angle, soonest):
    """Along a ray from a DCM of rest, within the 4 % that the grid leaves open."""
    rest, way = np.array([0.0, 0.05]), np.array([np.cos(angle), np.sin(angle)])
    most = viable_impulse(rest, way, soonest, BOUNDS) / OMEGA
    assert is_viable(rest + 0.999 * most * way, soonest, BOUNDS)
    assert not is_viable(rest + 1.001 * most * way, soonest, BOUNDS)
    assert saved(rest + 0.96 * most * way, soonest)
    assert not saved(rest + 1.04 * most * way, soonest)


def test_a_lost_pendulum_takes_no_push_and_a_sooner_step_takes_more():
    lost = np.array([0.0, -0.4])
    assert viable_impulse(lost, np.array([1.0, 0.0]), QUICK, BOUNDS) == 0.0
    rest, outward = np.array([0.0, 0.05]), np.array([0.0, 1.0])
    late, soon = (viable_impulse(rest, outward, t, BOUNDS) for t in (QUICK, 0.05))
    # The DCM that is saved is as large at the switch, whenever that is.
    ratio = np.exp(OMEGA * (QUICK - 0.05))
    assert (soon / OMEGA + 0.05) / (late / OMEGA + 0.05) == pytest.approx(ratio, rel=1e-4)


def test_steps_that_cannot_follow_each_other_are_refused():
    with pytest.raises(ValueError, match=r"cannot be 0\.1 to 0\.11 m wide"):
        is_viable(np.zeros(2), QUICK, BOUNDS._replace(limits=np.array([0.5, 0.1, 0.11])))
