"""Where a tick of the closed loop goes: the own time of each callback of a block, in the loop."""

import sys
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from time import perf_counter
from typing import Any
from unittest.mock import patch

from drake_linefoot import leaf_system
from drake_linefoot.lab.scenario import Scenario
from studies.bench.loops import CHUNK, LoopChunks

REST = "plant and Drake's framework"
TICKS = 1e3 * CHUNK  # in a chunk of the loop
UNTIMED = leaf_system.weak


class _Clock:
    """Adds up what callbacks take by themselves, without what they call."""

    def __init__(self) -> None:
        self.own, self.calls = Counter[str](), Counter[str]()
        self._inside: list[float] = []  # of each callback that goes on, what it calls took

    def weak(self, system: Any, method: Callable[..., Any]) -> Callable[..., Any]:
        """Return what `leaf_system.weak` does, timed."""
        call = UNTIMED(system, method)
        name = method.__qualname__

        def timed(*args: Any) -> Any:
            start = perf_counter()
            self._inside.append(0.0)
            result = call(*args)
            took = perf_counter() - start
            self.own[name] += took - self._inside.pop()  # type: ignore[assignment]
            self.calls[name] += 1
            if self._inside:
                self._inside[-1] += took
            return result

        return timed


@contextmanager
def _timed(clock: _Clock) -> Iterator[None]:
    """Let blocks that are built in the `with` block run by the clock."""
    with ExitStack() as stack:
        for module in list(sys.modules.values()):
            if getattr(module, "weak", None) is UNTIMED:
                stack.enter_context(patch.object(module, "weak", clock.weak))
        yield


def tick_parts(scenario: Scenario, chunks: int) -> list[dict[str, float | str]]:
    """Walk some chunks of the closed loop; return where the time of a tick goes, most first.

    Returns:
        Of each callback its `name`, `us`, own microseconds a tick, and `calls` a tick; with
        `REST`, what is left of the loop's time.
    """
    clock = _Clock()
    with _timed(clock):
        loop = LoopChunks(scenario)
    clock.own.clear()
    clock.calls.clear()
    ticks = chunks * TICKS
    whole = TICKS * sum(loop.batch(chunks))
    own: dict[str, float] = {**clock.own, REST: whole - sum(clock.own.values())}
    return [
        {"name": name, "us": 1e6 * time / ticks, "calls": clock.calls[name] / ticks}
        for name, time in sorted(own.items(), key=lambda item: -item[1])
    ]
