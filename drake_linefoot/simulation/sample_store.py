"""Samples in blocks that stay where they are, so that nothing is freed."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from drake_linefoot.types import Array

ROWS = 1024  # samples of a block: larger ones than 4 MB take numpy much longer to get


class SampleStore:
    """Rows of named numbers that grow; one name is "time" and increases.

    Attributes:
        count: number of rows that are complete.
    """

    def __init__(self, dtype: np.dtype[np.void]) -> None:
        """Keep the type of a row: doubles, with a place named "time" among them."""
        self._dtype = dtype
        self._blocks: list[NDArray[np.void]] = []
        self.count = 0

    def next_rows(self, n: int) -> NDArray[np.void]:
        """Return the next rows to write, at most `n`; they hold NaN.

        They count when `count` says so.
        """
        if self.count == ROWS * len(self._blocks):
            nothing = np.full((ROWS, self._dtype.itemsize // 8), np.nan)
            self._blocks.append(nothing.view(self._dtype)[:, 0])
        first = self.count - ROWS * (len(self._blocks) - 1)
        return self._blocks[-1][first : first + n]

    def drop_from(self, time: float) -> bool:
        """Forget the rows at or after `time` [s]; return whether there were any."""
        if not self.count or self.recent("time", 1)[0] < time:
            return False
        self.count = int(np.searchsorted(self.recent("time", self.count), time))
        self._blocks = self._blocks[: -(-self.count // ROWS)]
        if self._blocks:
            self._blocks[-1][self.count - ROWS * (len(self._blocks) - 1) :] = np.nan
        return True

    def recent(self, name: str, n: int) -> Array:
        """Return the last `n` numbers of a name, or all when there are fewer."""
        first = max(self.count - n, 0)
        begin = first // ROWS
        rows = slice(first - begin * ROWS, self.count - begin * ROWS)
        parts = self._blocks[begin:] or [np.empty(0, self._dtype)]
        values: Array = (
            parts[0][name] if len(parts) == 1 else np.concatenate([part[name] for part in parts])
        )
        return values[rows]

    def keep_last(self, n: int) -> None:
        """Forget all but the last `n` rows."""
        blocks = self._blocks or [np.empty(0, self._dtype)]
        kept = np.concatenate(blocks)[max(self.count - n, 0) : self.count]
        self._blocks, self.count = [], 0
        while self.count < len(kept):
            rows = self.next_rows(len(kept) - self.count)
            rows[:] = kept[self.count : self.count + len(rows)]
            self.count += len(rows)
