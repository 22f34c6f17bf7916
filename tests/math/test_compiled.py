"""Compiled functions beside other threads of Python, and what they say of shapes that differ."""

import threading
from time import perf_counter

import numpy as np
import pytest

from drake_linefoot.math.compiled import compiled


@compiled
def work(count):
    """Return a sum that no compiler foresees, after a while."""
    total = 1.0
    for k in range(count):
        total = 1.0 + total / (1.0 + k % 7 + total)
    return total


def test_other_threads_go_on_while_a_compiled_function_runs():
    work(1)
    times, done = [], threading.Event()

    def tick():
        while not done.wait(1e-3):
            times.append(perf_counter())

    thread = threading.Thread(target=tick)
    thread.start()
    begin = perf_counter()
    work(50_000_000)
    end = perf_counter()
    done.set()
    thread.join()
    assert any(begin + 0.25 * (end - begin) < t < begin + 0.75 * (end - begin) for t in times)


@compiled
def put(into, values):
    """Put values into all but the first row."""
    into[1:] = values


@pytest.mark.parametrize("shape", [(3,), (2, 2)])
def test_shapes_that_differ_are_an_error_and_nothing_is_written(shape):
    into = np.zeros((3, 2))
    with pytest.raises(ValueError, match=r"shape|size"):
        put(into[:, 0] if len(shape) == 1 else into[:2], np.ones(shape))
    assert not into.any()
    put(into, np.ones(2))
    assert into.tolist() == [[0.0, 0.0], [1.0, 1.0], [1.0, 1.0]]
