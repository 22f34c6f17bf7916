"""The dynamics of the present state as a LeafSystem: computed once for all who ask."""

import numpy as np
from pydrake.common.value import AbstractValue
from pydrake.systems.framework import Context, InputPort, OutputPort

from drake_linefoot.leaf_system import Block, check_finite, read_finite, read_signal, weak
from drake_linefoot.math.linear import both_finite
from drake_linefoot.robot.dynamics import RobotDynamics, robot_dynamics
from drake_linefoot.robot.humanoid import Humanoid


class StateDynamics(Block):
    """Computes what several blocks need of a state.

    | port | type | shape | unit |
    |---|---|---|---|
    | state | vector | nq + nv | q in m and rad, v in m/s and rad/s, Drake's order |
    | dynamics | RobotDynamics | - | mass matrix, momentum, contact lines, ... |

    Stateless: Drake keeps the output until the state changes, so the estimator and the gait at the
    end of a tick, and controller and recorder at the beginning of the next, share one evaluation.
    Raises SignalError for a state that is not finite.
    """

    def __init__(self, humanoid: Humanoid) -> None:
        """Declare ports."""
        super().__init__()
        self.set_name("state_dynamics")
        self._humanoid = humanoid
        self._state = self.DeclareVectorInputPort("state", humanoid.nq + humanoid.nv)
        nominal = robot_dynamics(humanoid, humanoid.scratch, humanoid.x_nominal)
        self._dynamics = self.DeclareAbstractOutputPort(
            "dynamics",
            lambda: AbstractValue.Make(nominal),
            weak(self, self._calc_dynamics),
            prerequisites_of_calc={self._state.ticket()},
        )

    def get_state_input_port(self) -> InputPort:
        """State of the robot."""
        return self._state

    def get_dynamics_output_port(self) -> OutputPort:
        """Quantities of the state."""
        return self._dynamics

    def _calc_dynamics(self, context: Context, output: AbstractValue) -> None:
        x = read_finite(self, self._state, context)
        output.set_value(robot_dynamics(self._humanoid, self._humanoid.scratch, np.array(x)))


def read_dynamics(system: Block, port: InputPort, context: Context) -> RobotDynamics:
    """Return the value of an input port that takes `RobotDynamics`.

    Raises:
        SignalError: it is another object, or of a state that is not finite; names the port.
    """
    d = read_signal(system, port, context, RobotDynamics)
    if not both_finite(d.q, d.v):
        check_finite(system, port, d.q, "position")
        check_finite(system, port, d.v, "velocity")
    return d
