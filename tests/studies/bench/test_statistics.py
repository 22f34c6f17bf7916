"""Medians, turns, ratios and exponents."""

import numpy as np
import pytest

from studies.bench.measures import Summary, exponent, ratio, summarise, take_turns


def test_summary_is_median_and_95th_percentile():
    summary = summarise([float(k) for k in range(101)])
    assert summary == Summary(median=50.0, p95=95.0, n=101)
    assert summary.as_dict() == {"median_ms": 50e3, "p95_ms": 95e3, "n": 101}


def test_nothing_has_no_summary_and_no_ratio():
    assert summarise([]) is None
    assert ratio(None, Summary(1.0, 1.0, 1)) is None
    assert ratio(Summary(1.0, 1.0, 1), None) is None
    assert ratio(Summary(1.0, 1.0, 1), Summary(0.0, 1.0, 1)) is None


def test_ratio_is_that_of_the_medians():
    assert ratio(Summary(3.0, 100.0, 5), Summary(2.0, 7.0, 9)) == 1.5


def test_contestants_take_turns_and_turns_rotate():
    calls = []

    def batch(name):
        def run():
            calls.append(name)
            return [1.0, 2.0]

        return run

    heard = []
    times = take_turns({name: batch(name) for name in "abc"}, 3, heard.append)
    assert "".join(calls) == "abcbcacab"
    assert times == {name: [1.0, 2.0] * 3 for name in "abc"}
    assert heard == [f"round {k} of 3" for k in (1, 2, 3)]


def test_nobody_takes_no_turns():
    assert take_turns({}, 2) == {}


@pytest.mark.parametrize("power", [0.0, 1.0, 2.5])
def test_exponent_of_a_power_law(power):
    sizes = np.array([8.0, 10.0, 20.0, 40.0])
    assert exponent(sizes, 3e-3 * sizes**power) == pytest.approx(power, abs=1e-9)


def test_exponent_needs_two_sizes():
    assert exponent([3.0], [1.0]) is None
    assert exponent([3.0, 3.0], [1.0, 2.0]) is None
    assert exponent([3.0, 4.0], [1.0, 0.0]) is None
