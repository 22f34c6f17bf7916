"""Real time: holding a simulation back to it, and saying when it cannot keep up."""

from collections import deque

WINDOW = 1.0  # [s] of wall time over which the rate is measured
BACKLOG = 0.1  # [s] it may be late and still catch up; what is more is given up
TOO_SLOW = 0.95  # [-] of real time; below it the machine does not keep up


class Pace:
    """Compares simulated time with a clock.

    Attributes:
        rate: simulated seconds per second over the last second; 1 before anything is known.
    """

    def __init__(self) -> None:
        self.rate = 1.0
        self.restart()

    def restart(self) -> None:
        """Count from now on: after a pause, a reset or a fall."""
        self._anchor: float | None = None
        self._seen: deque[tuple[float, float]] = deque()

    @property
    def keeps_up(self) -> bool:
        """Whether the simulation is as fast as real time."""
        return self.rate >= TOO_SLOW

    def wait(self, time: float, clock: float) -> float:
        """Return how long to wait so that simulated time does not run ahead of the clock [s]."""
        if self._anchor is None:
            self._anchor = clock - time
        ahead = time - (clock - self._anchor)
        if ahead < -BACKLOG:
            self._anchor += -BACKLOG - ahead
        self._measure(time, clock)
        return max(ahead, 0.0)

    def _measure(self, time: float, clock: float) -> None:
        self._seen.append((time, clock))
        while len(self._seen) > 2 and clock - self._seen[1][1] >= WINDOW:
            self._seen.popleft()
        first_time, first_clock = self._seen[0]
        if clock > first_clock:
            self.rate = (time - first_time) / (clock - first_clock)
