"""The statistic that compares models: ratios with known answers."""

from itertools import product

import numpy as np
import pytest

from studies.paper import statistic
from studies.paper.statistic import compared_by_cluster


def point(cluster, one, other):
    """A point where the models have these numbers; None is a fall."""
    rows = [{"fell": value is None, "rms": value} for value in (one, other)]
    return cluster, *rows


def compare(*points):
    return compared_by_cluster([point(*values) for values in points], "rms")


def test_geometric_mean_of_constructed_ratios():
    found = compare(("a", 0.02, 0.01), ("b", 0.4, 0.1), ("c", 0.8, 0.8), ("c", 0.9, None))
    assert found["ratio"] == pytest.approx(2.0)  # of 2, 4, 1
    assert (found["pairs"], found["clusters"], found["lower"]) == (3, 3, 0)


def test_an_outlier_moves_the_pooled_ratio_but_not_the_mean():
    """The tenth point moves a hundred times as much; with the same ratio, and the inverse."""
    calm = [(k, 0.01, 0.02) for k in range(9)]
    usual, odd = compare(*calm, (9, 1.0, 2.0)), compare(*calm, (9, 2.0, 1.0))
    assert usual["ratio"] == usual["pooled"] == pytest.approx(0.5)
    assert odd["pooled"] == pytest.approx(2.0, rel=0.01)
    assert odd["ratio"] == pytest.approx(0.5 * 4.0**0.1)
    assert odd["lower"] == 9


def test_the_mirrored_ratio_is_the_inverse():
    rng = np.random.default_rng(3)
    points = [(k % 5, *rng.uniform(0.1, 1.0, 2)) for k in range(20)]
    one, other = compare(*points), compare(*((c, b, a) for c, a, b in points))
    assert other["ratio"] == pytest.approx(1.0 / one["ratio"])
    assert other["pooled"] == pytest.approx(1.0 / one["pooled"])
    assert other["interval"] == pytest.approx([1.0 / end for end in one["interval"][::-1]])


def test_clusters_are_drawn_whole():
    """What scatters within clusters alone leaves no doubt; what scatters between them does."""
    sizes = (0.25, 1.0, 4.0)
    within = compare(*((c, size, 1.0) for c in "abcd" for size in sizes))
    assert within["interval"] == pytest.approx([1.0, 1.0])
    same = compare(*((c, 0.3, 1.0) for c in "abcd" for _ in sizes))
    assert same["interval"] == pytest.approx([0.3, 0.3])
    between = compare(
        *((c, size, 1.0) for c, size in zip("abc", sizes, strict=True) for _ in "123")
    )
    assert between["interval"] == pytest.approx([0.25, 4.0])


def test_the_interval_is_that_of_every_draw():
    """Four clusters of unequal sizes can be drawn in 256 ways, all as likely."""
    logs = [np.array(of) for of in ([0.1], [0.4, 0.2], [-0.3, 0.5, 0.1], [1.0])]
    draws = [
        np.concatenate([logs[i] for i in drawn]).mean() for drawn in product(range(4), repeat=4)
    ]
    found = compare(*((k, np.exp(value), 1.0) for k, of in enumerate(logs) for value in of))
    expected = np.exp(np.percentile(draws, [2.5, 97.5]))
    np.testing.assert_allclose(found["interval"], expected, atol=0.03)  # of 2000 draws


@pytest.mark.parametrize("points", [[], [("a", None, 0.1)], [("a", 0.0, 0.0)], [("a", 0.0, 0.1)]])
def test_without_a_pair_there_is_no_number(points):
    found = compare(*points)
    assert found["ratio"] is found["interval"] is found["pooled"] is None
    assert found["pairs"] == 0
    assert statistic.mean(found) == "-"


def test_one_cluster_has_no_interval():
    found = compare(("a", 0.1, 0.2), ("a", 0.2, 0.2))
    assert found["interval"] is None
    assert statistic.mean(found) == "0.71"
    assert statistic.mean(compare(("a", 0.1, 0.2), ("b", 0.1, 0.2))) == "0.50 (0.50 to 0.50)"


def test_words_say_that_few_is_few():
    assert "6 only" in statistic.over("the points", "commands", 6)
    assert "only" not in statistic.over("the seeds", "seeds", 10)
