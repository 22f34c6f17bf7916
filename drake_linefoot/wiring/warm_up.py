"""Compile every kernel before a run that somebody watches or measures."""

import gc
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from drake_linefoot.math.compiled import (
    keep_machine_code,
    machine_code_can_be_kept,
    machine_code_is_kept,
    watched,
)
from drake_linefoot.scenario import Scenario, Segment
from drake_linefoot.wiring.closed_loop import build_closed_loop

MESSAGE = "Compiling, once after an installation or a change: about a minute ..."
NOWHERE = (
    "Compiling, about a minute, and anew each time: neither the package nor the cache folder of "
    "this user can be written; NUMBA_CACHE_DIR names another one ..."
)


def warm_up(
    say: Callable[[str], None], progress: Callable[[float], None] = lambda share: None
) -> None:
    """Walk a few steps when there is no machine code yet; otherwise do nothing.

    `say` is told that it takes a while, `progress` the share of functions that are compiled.
    """
    if machine_code_is_kept():
        return
    say(MESSAGE if machine_code_can_be_kept() else NOWHERE)
    segments = [Segment("stand", 0.02), Segment("walk", 2.0, walk=True, velocity=[0.3, 0.0])]
    simulator = build_closed_loop(Scenario(segments=segments)).make_simulator()
    with watched(progress), _seldom_collected():
        simulator.AdvanceTo(0.9)  # the shift, and a step with each foot
    keep_machine_code()


@contextmanager
def _seldom_collected() -> Iterator[None]:
    """Collect garbage seldom in the `with` block: compiling leaves little, and takes 10 % less."""
    usual = gc.get_threshold()
    gc.set_threshold(100_000, 50, 100)
    try:
        yield
    finally:
        gc.set_threshold(*usual)
