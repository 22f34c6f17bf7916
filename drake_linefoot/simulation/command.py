"""The command as a LeafSystem: played from a scenario, or set from outside."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from pydrake.systems.framework import BasicVector, Context, Diagram, DiagramBuilder, OutputPort
from pydrake.systems.primitives import TrajectorySource
from pydrake.trajectories import PiecewisePolynomial

from drake_linefoot.leaf_system import Block, weak
from drake_linefoot.scenario import Segment

_EARLY = 1e-9  # [s] that a segment begins before its time, which is a sum of periods


class CommandSchedule(Diagram):
    """Plays the segments of a scenario one after the other and holds the last.

    | port | type | shape | unit |
    |---|---|---|---|
    | command | vector | 4 | v_x, v_y [m/s], turn rate [rad/s], walk (0 or 1) |

    A Diagram around Drake's TrajectorySource, which gives its port this name.
    """

    def __init__(self, segments: list[Segment]) -> None:
        """Lay the segments end to end."""
        super().__init__()
        rows = [[*s.velocity, s.turn_rate, 1.0 if s.walk else 0.0] for s in segments]
        breaks = np.cumsum([0.0, *(s.duration for s in segments)]) - _EARLY
        held = PiecewisePolynomial.ZeroOrderHold(breaks, np.array([*rows, rows[-1]]).T)
        builder = DiagramBuilder()
        source = builder.AddNamedSystem("schedule", TrajectorySource(held))
        builder.ExportOutput(source.get_output_port(), "command")
        builder.BuildInto(self)
        self.set_name("command")

    def get_command_output_port(self) -> OutputPort:
        """The command."""
        return self.GetOutputPort("command")


class HeldCommand(Block):
    """Holds the last command it was given; standing still until then.

    | port | type | shape | unit |
    |---|---|---|---|
    | command | vector | 4 | v_x, v_y [m/s], turn rate [rad/s], walk (0 or 1) |

    The command is a parameter of the Context.
    """

    def __init__(self) -> None:
        """Declare parameter and port."""
        super().__init__()
        self.set_name("command")
        self.DeclareNumericParameter(BasicVector(np.zeros(4)))
        self.DeclareVectorOutputPort(
            "command",
            4,
            weak(self, self._calc_command),
            prerequisites_of_calc={self.all_parameters_ticket()},
        )

    def hold(self, context: Context, command: ArrayLike) -> None:
        """Hold `command`, shape (4,), from now on in this system's `context`."""
        context.get_mutable_numeric_parameter(0).SetFromVector(np.asarray(command, dtype=float))

    def _calc_command(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(context.get_numeric_parameter(0).value())
