"""Samples of many channels in blocks that stay where they are, so that nothing is freed."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

ROWS = 4096  # samples of a block


class SampleStore:
    """Rows of named arrays that grow; one channel is "time" and increases.

    Attributes:
        count: number of rows that are complete.
    """

    def __init__(self, shapes: Mapping[str, tuple[int, ...]]) -> None:
        """Keep the shapes of one sample of each channel, "time" among them."""
        self._shapes = dict(shapes)
        self._blocks: list[dict[str, Array]] = []
        self.count = 0

    def next_rows(self, n: int) -> dict[str, Array]:
        """Return the next rows to write of each channel, at most `n`; they hold NaN.

        They count when `count` says so.
        """
        if self.count == ROWS * len(self._blocks):
            shapes = self._shapes.items()
            block = {name: np.full((ROWS, *shape), np.nan) for name, shape in shapes}
            self._blocks.append(block)
        first = self.count - ROWS * (len(self._blocks) - 1)
        return {name: values[first : first + n] for name, values in self._blocks[-1].items()}

    def drop_from(self, time: float) -> bool:
        """Forget the rows at or after `time` [s]; return whether there were any."""
        if not self.count or self.recent("time", 1)[0] < time:
            return False
        self.count = int(np.searchsorted(self.recent("time", self.count), time))
        self._blocks = self._blocks[: -(-self.count // ROWS)]
        if self._blocks:
            for values in self._blocks[-1].values():
                values[self.count - ROWS * (len(self._blocks) - 1) :] = np.nan
        return True

    def recent(self, name: str, n: int) -> Array:
        """Return the last `n` rows of a channel, or all when there are fewer."""
        first = max(self.count - n, 0)
        begin = first // ROWS
        parts = [block[name] for block in self._blocks[begin:]]
        rows = slice(first - begin * ROWS, self.count - begin * ROWS)
        if len(parts) == 1:
            return parts[0][rows]
        return np.concatenate([np.empty((0, *self._shapes[name])), *parts])[rows]

    def keep_last(self, n: int) -> None:
        """Forget all but the last `n` rows."""
        kept = {name: self.recent(name, n).copy() for name in self._shapes}
        self._blocks, self.count = [], 0
        total = len(kept["time"])
        while self.count < total:
            rows = self.next_rows(total - self.count)
            end = self.count + len(rows["time"])
            for name, values in kept.items():
                rows[name][:] = values[self.count : end]
            self.count = end
