"""The command as a LeafSystem: played from a scenario, or set from outside."""

from __future__ import annotations

from bisect import bisect_right

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydrake.systems.framework import BasicVector, Context, OutputPort

from drake_linefoot.scenario import Segment
from drake_linefoot.systems import Block, weak

Array = NDArray[np.float64]


class CommandSchedule(Block):
    """Plays the segments of a scenario one after the other and holds the last.

    .. pydrake_system::

        name: CommandSchedule
        output_ports:
        - command

    | port | type | shape | unit |
    |---|---|---|---|
    | command | vector | 4 | v_x, v_y [m/s], turn rate [rad/s], walk (0 or 1) |
    """

    def __init__(self, segments: list[Segment]) -> None:
        """Declare the port."""
        super().__init__()
        self.set_name("command")
        self._ends: list[float] = np.cumsum([s.duration for s in segments]).tolist()
        rows = ([*s.velocity, s.turn_rate, 1.0 if s.walk else 0.0] for s in segments)
        self._commands = [np.array(row, dtype=float) for row in rows]
        self._command = self.DeclareVectorOutputPort(
            "command",
            4,
            weak(self, self._calc_command),
            prerequisites_of_calc={self.time_ticket()},
        )

    def get_command_output_port(self) -> OutputPort:
        """The command."""
        return self._command

    def at(self, time: float) -> Array:
        """Return the command at `time` [s], shape (4,)."""
        k = bisect_right(self._ends, time + 1e-9)
        return self._commands[min(k, len(self._commands) - 1)]

    def _calc_command(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(self.at(context.get_time()))


class HeldCommand(Block):
    """Holds the command it was told last; standing still until then.

    .. pydrake_system::

        name: HeldCommand
        output_ports:
        - command

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
