"""Blocks of samples against one growing array."""

import numpy as np
import pytest

from drake_linefoot.simulation.sample_store import ROWS, SampleStore


def write(store, times):
    for time in times:
        store.drop_from(time)
        rows = store.next_rows(1)
        rows["time"][:] = time
        rows["xy"][:] = [time, -time]
        store.count += 1


@pytest.fixture
def store():
    places = [("time", float), ("xy", float, 2), ("nothing", float, 3)]
    return SampleStore(np.dtype(places))


@pytest.mark.parametrize("count", [0, 1, ROWS - 1, ROWS, ROWS + 1, 2 * ROWS + 7])
def test_rows_come_back_in_order(store, count):
    times = np.arange(float(count))
    write(store, times)
    assert store.count == count
    np.testing.assert_array_equal(store.recent("time", count), times)
    for n in (1, 5, ROWS, ROWS + 3, 10 * ROWS):
        np.testing.assert_array_equal(store.recent("xy", n)[:, 1], -times[max(count - n, 0) :])
    assert store.recent("nothing", count).shape == (count, 3)
    assert np.isnan(store.recent("nothing", count)).all()


@pytest.mark.parametrize("back", [0.0, 3.0, ROWS - 1.0, ROWS + 0.0, ROWS + 2.0])
def test_going_back_drops_what_is_not_past(store, back):
    write(store, np.arange(ROWS + 10.0))
    assert not store.drop_from(ROWS + 10.0)
    assert store.drop_from(back)
    assert store.count == back
    write(store, [back, back + 0.5])
    expected = [*np.arange(back), back, back + 0.5]
    np.testing.assert_array_equal(store.recent("time", store.count), expected)
    assert np.isnan(store.next_rows(1)["time"]).all()


@pytest.mark.parametrize("n", [0, 1, ROWS, ROWS + 5, 5 * ROWS])
def test_keeping_the_last(store, n):
    times = np.arange(2.0 * ROWS + 9.0)
    write(store, times)
    store.keep_last(n)
    kept = times[max(len(times) - n, 0) :]
    np.testing.assert_array_equal(store.recent("time", store.count), kept)
    write(store, [1e6])
    np.testing.assert_array_equal(store.recent("time", store.count), [*kept, 1e6])
