"""How two models are compared over many walks: the geometric mean of the ratios of their RMS.

An RMS over all points of a grid is that of the few at which the torso moves most: of 23 points two
held 68 to 99 % of the sum of squares. In a geometric mean each point counts alike, and the ratio
the other way round is its inverse. Points of one command are alike, so the bootstrap draws the
commands, with all their points; of few commands it sees little, and is rather too narrow.
"""

from collections.abc import Hashable, Iterable

import numpy as np

from studies.common import runs
from studies.common.types import Array, Data
from studies.paper.figure import LEVEL, shown

FEW = 10  # clusters; the interval of fewer is called narrow
ENDS = (50.0 * (1.0 - LEVEL), 50.0 * (1.0 + LEVEL))  # [%] of an interval
KEYS = {"": "ratio", "_interval": "interval", "_pooled": "pooled"}  # how a summary names what

Clustered = tuple[Hashable, Data, Data]  # what makes a cluster; the one model there, the other


def compared_by_cluster(points: Iterable[Clustered], key: str) -> Data:
    """Compare a quantity of two models at the points where neither fell.

    Args:
        points: cluster, and what each model did: `fell`, and the quantity or None. Where there is
            none, or nothing but zero, the point is left out.
        key: of the quantity, positive.

    Returns:
        `ratio`: geometric mean over the points of one over the other; `interval`: of 95 %, by a
        bootstrap that draws clusters; `pooled`: the ratio of root mean squares over the points;
        `lower`: at how many of the `pairs` the one is below the other; `clusters`: how many have
        pairs. None without a number, and the interval also of a single cluster.
    """
    known = [
        (cluster, one[key], other[key])
        for cluster, one, other in points
        if not (one["fell"] or other["fell"]) and one[key] and other[key]
    ]
    names = list(dict.fromkeys(cluster for cluster, *_ in known))
    found: Data = {"ratio": None, "interval": None, "pooled": None, "lower": 0}
    found |= {"pairs": len(known), "clusters": len(names)}
    if not known:
        return found
    ours, theirs = np.array([values for _, *values in known], dtype=float).T
    logs = np.log(ours / theirs)
    found["ratio"] = float(np.exp(logs.mean()))
    found["pooled"] = runs.rms(ours) / runs.rms(theirs)
    found["lower"] = int(np.sum(ours < theirs))
    if len(names) > 1:
        of = np.array([names.index(cluster) for cluster, *_ in known])
        found["interval"] = np.exp(_interval(logs, of)).tolist()
    return found


def _interval(values: Array, cluster: Array) -> Array:
    """Return the ends of the interval of a mean, clusters drawn with replacement, shape (2,).

    Args:
        values: shape (n,).
        cluster: number of each one's, from 0 on without a gap, shape (n,).
    """
    count, total = np.bincount(cluster), np.bincount(cluster, weights=values)
    drawn = np.random.default_rng(0).integers(len(count), size=(runs.RESAMPLES, len(count)))
    means = total[drawn].sum(axis=1) / count[drawn].sum(axis=1)
    ends: Array = np.percentile(means, ENDS)
    return ends


def mean(found: Data) -> str:
    """Return a geometric mean for a table, with its interval."""
    if found["interval"] is None:
        return shown(found["ratio"], ".2f")
    return "{:.2f} ({:.2f} to {:.2f})".format(found["ratio"], *found["interval"])


def over(points: str, clusters: str, count: int) -> str:
    """Return the statistic in words.

    Args:
        points: what the ratios are of.
        clusters: what the bootstrap draws, in the plural.
        count: how many of these there are.
    """
    words = f"Geometric mean over {points} of the ratio of the models' RMS; interval of "
    words += f"{100 * LEVEL:g} % by a bootstrap that draws the {clusters} with replacement"
    few = f", {count} only, so that it is rather too narrow" if count < FEW else f", {count}"
    return words + few + "; pooled is the ratio of RMS over all of them"
