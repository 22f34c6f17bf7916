"""Compiled functions beside other threads of Python."""

import threading
from time import perf_counter

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
