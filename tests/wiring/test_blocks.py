"""Compiling block by block reaches what a walk calls, or a second core has nothing to do."""

import os
import subprocess
import sys

import pytest
from pydrake.systems.framework import LeafSystem

from drake_linefoot.math.claims import TakenError, claims, shared
from drake_linefoot.math.compiled import config
from drake_linefoot.wiring import blocks

# Functions that Python has called, after the blocks and after a walk, in a process of its own.
REACHED = """
import sys
from numba.core.dispatcher import Dispatcher
from drake_linefoot.wiring.blocks import compile_blocks
from drake_linefoot.lab.wiring.closed_loop import _walk_a_little

def called():
    modules = [module for name, module in sys.modules.items() if name.startswith("drake_linefoot")]
    found = [each for module in modules for each in vars(module).values()]
    functions = [each for each in found if isinstance(each, Dispatcher) and each.signatures]
    return {f"{each.__module__}.{each.__name__}" for each in functions}

compile_blocks(int(sys.argv[1]))
print(*called())
_walk_a_little()
print(*called())
"""


@pytest.mark.slow
@pytest.mark.skipif(config.DISABLE_JIT, reason="nothing is compiled")
@pytest.mark.parametrize("way", ["1", "-1"])
def test_the_blocks_reach_what_a_walk_calls_but_for_some_small_ones(way):
    done = subprocess.run(
        [sys.executable, "-c", REACHED, way],
        env=os.environ,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    reached, all_of_them = (set(line.split()) for line in done.stdout.splitlines())
    assert len(all_of_them) > 20
    assert len(all_of_them - reached) < len(all_of_them) / 3, all_of_them - reached
    largest = "robot.dynamics.dynamics_of_tree", "gait.planner.update", "wbc.control.control_tick"
    assert {f"drake_linefoot.{name}" for name in largest} <= reached


class Failing(LeafSystem):
    """A block whose outputs fail, the first one because another process is compiling."""

    def __init__(self):
        super().__init__()
        self.calls = []
        self.DeclareVectorInputPort("x", 2)
        self.DeclareVectorOutputPort("a", 1, self.taken)
        self.DeclareVectorOutputPort("b", 1, self.sum)
        self.DeclarePeriodicPublishEvent(0.1, 0.0, self.publish)

    def taken(self, context, output):
        self.calls.append("taken")
        claims().take("what it could not compile")
        raise TakenError("a")

    def sum(self, context, output):
        self.calls.append(self.get_input_port(0).Eval(context).sum())
        raise SystemExit

    def publish(self, context):
        self.calls.append("published")


def test_what_fails_in_a_block_ends_no_other_and_claims_nothing(tmp_path):
    block, taken = Failing(), []
    with shared(tmp_path, waits=False):
        blocks._exercise(block, taken)
        assert claims()._held == set()
    assert block.calls == ["taken", 2.0, "published"]
    assert [str(error) for error in taken] == ["a"]


def test_what_another_process_compiles_is_come_back_to(monkeypatch):
    """Until it is there: all blocks call what the first one does, which one of the two compiles."""
    asked = []

    def made(name, fails):
        asked.append(name)
        if asked.count(name) <= fails:
            raise TakenError(name)
        return LeafSystem()

    ways = {"a": lambda: made("a", 0), "b": lambda: made("b", 2), "c": lambda: made("c", 1)}
    monkeypatch.setattr(blocks, "makers", lambda *_: ways)
    monkeypatch.setattr(blocks, "StateEstimator", lambda *_: made("estimator", 1))
    monkeypatch.setattr(blocks, "_PATIENCE", 0.0)
    blocks.compile_blocks(-1)
    assert asked == ["estimator", "c", "b", "a", "estimator", "c", "b", "b"]
