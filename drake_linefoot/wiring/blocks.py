"""Compile what controller and state estimator call, one block after the other, without a walk.

Each is asked for its output ports and carries out its events, with nothing but ones on its input
ports. What it computes is nonsense, or fails; but by then it is compiled. So two processes can
begin at the two ends, and what one of them is compiling the other one comes back to.
"""

import gc
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import PortDataType, System

from drake_linefoot.estimation.parameters import OnboardParameters, StateEstimatorParameters
from drake_linefoot.estimation.state_estimator import StateEstimator
from drake_linefoot.math.claims import TakenError, claims, shared
from drake_linefoot.math.compiled import machine_code_folder, watched
from drake_linefoot.robot.humanoid import load_humanoid
from drake_linefoot.wiring.controller import makers
from drake_linefoot.wiring.parameters import ControllerParameters

_PATIENCE = 0.2  # [s] until a process looks again, when all that is left is being compiled


def compile_from_the_end() -> None:
    """Be the second process: print the name of each function that is compiled."""
    gc.disable()
    with watched(lambda name: print(name, flush=True)):
        compile_blocks(-1)


def compile_blocks(way: int) -> None:
    """Compile what the blocks call, what another process is compiling when it has done that.

    Args:
        way: 1 to begin with the first block, -1 with the last one.
    """
    # The parameters as they are: in the size of the robot they would need the dynamics.
    humanoid, parameters = load_humanoid("mit_humanoid"), ControllerParameters()
    sensors = OnboardParameters(), StateEstimatorParameters(), parameters.period
    make = makers(humanoid, parameters)
    make["state_estimator"] = lambda: StateEstimator(humanoid, *sensors)
    with shared(machine_code_folder(), waits=False):
        left = [*make][::way]
        while left:
            taken = [name for name in left if not _is_compiled(make[name])]
            if taken == left:
                time.sleep(_PATIENCE)
            left = taken


def _is_compiled(make: Callable[[], System]) -> bool:
    """Compile what a block calls; return whether no other process is compiling some of it."""
    taken: list[TakenError] = []
    with _attempt(taken):
        _exercise(make(), taken)
    return not taken


def _exercise(block: System, taken: list[TakenError]) -> None:
    """Evaluate each output port of a block and carry out its events, with ones as input."""
    context = block.CreateDefaultContext()
    for i in range(block.num_input_ports()):
        port = block.get_input_port(i)
        if port.get_data_type() == PortDataType.kVectorValued:
            port.FixValue(context, np.ones(port.size()))
    for i in range(block.num_output_ports()):
        with _attempt(taken):
            block.get_output_port(i).Eval(context)
    with _attempt(taken):
        Simulator(block, context).AdvanceTo(1e-6)


@contextmanager
def _attempt(taken: list[TakenError]) -> Iterator[None]:
    """Suppress every error in the `with` block, and leave what it has not compiled to others.

    What another process compiles goes into `taken`: it is there when that is done.
    """
    try:
        yield
    except TakenError as error:
        taken.append(error)
    except (Exception, SystemExit):  # Drake's assertions are a SystemExit
        pass
    finally:
        if (claimed := claims()) is not None:
            claimed.free_all()
