from dataclasses import replace

import numpy as np
import pytest

from drake_linefoot.lab.drive.teleop import AIMS, Seen, Teleop, Tuning

TUNING = Tuning(0.2, 0.06, 0.64, "ecd")
LIMITS = ((-1.0, -0.4, -1.0), (2.6, 0.4, 1.0))


@pytest.fixture
def teleop():
    return Teleop(TUNING, LIMITS)


def seen(*pressed, velocity=(0, 0, 0), lengths=(0.2, 0.06, 0.64), stick=None):
    stick = None if stick is None else np.array(stick, dtype=float)
    return Seen(pressed, np.array(velocity, dtype=float), lengths, 50.0, stick)


def test_a_robot_that_is_let_alone_stands(teleop):
    orders = teleop.update(seen(), 0.0)
    np.testing.assert_array_equal(orders.command, np.zeros(4))
    assert (orders.push, orders.tuning, orders.sliders) == (None, None, None)
    assert not (orders.reset or orders.quit or orders.paused)


def test_a_velocity_makes_it_walk_and_none_lets_it_step_in_place(teleop):
    moved = teleop.update(seen(velocity=(0.3, 0.1, -0.2)), 0.0)
    np.testing.assert_array_equal(moved.command, [0.3, 0.1, -0.2, 1.0])
    np.testing.assert_array_equal(teleop.update(seen(), 0.1).command, [0, 0, 0, 1])


@pytest.mark.parametrize("key", ["stop", "reset"])
def test_stop_makes_it_stand_until_a_slider_is_moved_again(teleop, key):
    teleop.update(seen(velocity=(0.3, 0, 0)), 0.0)
    stopped = teleop.update(seen(key, velocity=(0.3, 0, 0)), 0.1)
    np.testing.assert_array_equal(stopped.command, np.zeros(4))
    np.testing.assert_array_equal(stopped.sliders, np.zeros(3))
    assert stopped.reset == (key == "reset")
    np.testing.assert_array_equal(teleop.update(seen(), 0.2).command, np.zeros(4))
    again = teleop.update(seen(velocity=(0.1, 0, 0)), 0.3)
    np.testing.assert_array_equal(again.command, [0.1, 0, 0, 1])


@pytest.mark.parametrize("aim", AIMS)
def test_a_push_goes_where_it_is_aimed(teleop, aim):
    np.testing.assert_array_equal(teleop.update(seen("push"), 0.0).push, [50.0, 0.0])
    assert teleop.update(seen(aim), 0.1).push is None
    orders = teleop.update(seen("push"), 0.2)
    np.testing.assert_array_equal(orders.push, 50.0 * np.array(AIMS[aim]))
    assert orders.aim == aim


def test_pause_toggles_and_reset_ends_it(teleop):
    assert teleop.update(seen("pause"), 0.0).paused
    assert teleop.update(seen(), 0.1).paused
    assert teleop.update(seen("pause", "pause"), 0.2).paused
    assert not teleop.update(seen("pause"), 0.3).paused
    teleop.update(seen("pause"), 0.4)
    assert not teleop.update(seen("reset"), 0.5).paused


def test_quit(teleop):
    assert teleop.update(seen("quit"), 0.0).quit


def test_a_stick_goes_before_the_sliders_and_has_a_dead_zone(teleop):
    drift = teleop.update(seen(stick=(0.1, -0.1, 0.14)), 0.0)
    np.testing.assert_array_equal(drift.command, np.zeros(4))
    full = teleop.update(seen(velocity=(0.2, 0, 0), stick=(-1, 1, 0.575)), 0.1)
    np.testing.assert_allclose(full.command, [-1.0, 0.4, 0.5, 1.0])
    ahead = teleop.update(seen(stick=(1, 0, 0)), 0.15)
    np.testing.assert_allclose(ahead.command, [2.6, 0.0, 0.0, 1.0])
    let_go = teleop.update(seen(velocity=(0.2, 0, 0), stick=(0, 0, 0)), 0.2)
    np.testing.assert_array_equal(let_go.command, [0.2, 0, 0, 1])


def test_lengths_count_when_they_have_rested_and_once(teleop):
    assert teleop.update(seen(lengths=(0.21, 0.06, 0.64)), 0.0).tuning is None
    assert teleop.update(seen(lengths=(0.22, 0.06, 0.64)), 0.3).tuning is None
    assert teleop.update(seen(lengths=(0.22, 0.06, 0.64)), 0.6).tuning is None
    tuning = teleop.update(seen(lengths=(0.22, 0.06, 0.64)), 0.71).tuning
    assert tuning == Tuning(0.22, 0.06, 0.64, "ecd")
    assert teleop.update(seen(lengths=(0.22, 0.06, 0.64)), 2.0).tuning is None


def test_a_model_counts_at_once(teleop):
    assert teleop.update(seen("model srbm"), 0.0).tuning == Tuning(0.2, 0.06, 0.64, "srbm")
    assert teleop.update(seen("model srbm"), 0.1).tuning is None
    assert teleop.update(seen("model ecd"), 0.2).tuning == TUNING


def test_the_estimate_counts_at_once_and_goes_off_at_the_next_press(teleop):
    on = teleop.update(seen("estimate"), 0.0).tuning
    assert on == replace(TUNING, estimation=True)
    assert teleop.update(seen("estimate", "estimate"), 0.1).tuning is None
    assert teleop.update(seen("estimate"), 0.2).tuning == TUNING
