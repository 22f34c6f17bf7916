"""The command: played from a scenario, or set from outside."""

import numpy as np
from numpy.typing import ArrayLike
from pydrake.systems.framework import Context, Diagram, DiagramBuilder, System
from pydrake.systems.primitives import ConstantVectorSource, TrajectorySource
from pydrake.trajectories import PiecewisePolynomial

from drake_linefoot.lab.scenario import Segment

_EARLY = 1e-9  # [s] that a segment begins before its time, which is a sum of periods


class CommandSchedule(Diagram):
    """Plays the segments of a scenario one after the other and holds the last.

    .. pydrake_system::

        name: CommandSchedule
        output_ports:
        - command

    A Diagram around Drake's TrajectorySource, which gives its port this name.
    """

    def __init__(self, segments: list[Segment]) -> None:
        super().__init__()
        rows = [[*s.velocity, s.turn_rate, 1.0 if s.walk else 0.0] for s in segments]
        breaks = np.cumsum([0.0, *(s.duration for s in segments)]) - _EARLY
        held = PiecewisePolynomial.ZeroOrderHold(breaks, np.array([*rows, rows[-1]]).T)
        _wrap(self, TrajectorySource(held))


class HeldCommand(Diagram):
    """Holds the last command it was given; standing still until then.

    .. pydrake_system::

        name: HeldCommand
        output_ports:
        - command

    A Diagram around Drake's ConstantVectorSource; the command is a parameter of the Context.
    """

    def __init__(self) -> None:
        super().__init__()
        _wrap(self, ConstantVectorSource(np.zeros(4)))

    def hold(self, context: Context, command: ArrayLike) -> None:
        """Hold `command`, shape (4,), from now on in this system's `context`."""
        context.get_mutable_numeric_parameter(0).SetFromVector(np.asarray(command, dtype=float))


def _wrap(diagram: Diagram, source: System) -> None:
    """Make a diagram of a source, whose port is then named `command`."""
    builder = DiagramBuilder()
    builder.AddNamedSystem("schedule", source)
    builder.ExportOutput(source.get_output_port(), "command")
    builder.BuildInto(diagram)
    diagram.set_name("command")
