"""The dynamics of the present state as a LeafSystem: computed once for all who ask."""

from pydrake.systems.framework import BasicVector, Context

from drake_linefoot.leaf_system import Block, read_finite
from drake_linefoot.robot.dynamics import dynamics_layout, dynamics_vector
from drake_linefoot.robot.humanoid import Humanoid


class StateDynamics(Block):
    """Computes what several blocks need of a state.

    .. pydrake_system::

        name: StateDynamics
        input_ports:
        - state
        output_ports:
        - dynamics

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
        layout, of_state = dynamics_layout(humanoid), {self._state.ticket()}
        self.signal_output("dynamics", layout, self._calc_dynamics, of_state)

    def _calc_dynamics(self, context: Context, output: BasicVector) -> None:
        x = read_finite(self, self._state, context)
        output.SetFromVector(dynamics_vector(self._humanoid, self._humanoid.scratch, x))
