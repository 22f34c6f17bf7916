"""The reference of the MPC as a LeafSystem."""

from pydrake.common.value import AbstractValue
from pydrake.systems.framework import Context, InputPort, OutputPort

from drake_linefoot.gait.horizon import GaitHorizon
from drake_linefoot.leaf_system import Block, read_signal, weak
from drake_linefoot.reference.parameters import ReferenceParameters
from drake_linefoot.reference.reference import ReferenceGenerator
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.robot.size import sized
from drake_linefoot.robot.state_dynamics import read_dynamics


class CentroidalReference(Block):
    """Turns the gait's horizon into the desired trajectory x_H* of (40).

    | port | type | shape | unit |
    |---|---|---|---|
    | dynamics | RobotDynamics | - | of the present state |
    | horizon | GaitHorizon | - | of the gait planner |
    | reference | Reference | - | r_d, v_d, R_d, Omega_d, L_d, I_Bd, contacts |

    Stateless; computed when the MPC asks for it. Raises SignalError for a state that is not
    finite, or an input of another type.
    """

    def __init__(
        self,
        humanoid: Humanoid,
        parameters: ReferenceParameters,
        generator: ReferenceGenerator | None = None,
    ) -> None:
        """Declare ports.

        Args:
            humanoid: the robot.
            parameters: model and knots, of the MPC.
            generator: used instead of `ReferenceGenerator`.
        """
        super().__init__()
        self.set_name("centroidal_reference")
        self._generator = generator or ReferenceGenerator(humanoid, sized(parameters, humanoid))
        self._dynamics = self.DeclareAbstractInputPort("dynamics", AbstractValue.Make(object()))
        self._horizon = self.DeclareAbstractInputPort("horizon", AbstractValue.Make(object()))
        self._reference = self.DeclareAbstractOutputPort(
            "reference",
            lambda: AbstractValue.Make(object()),
            weak(self, self._calc_reference),
            prerequisites_of_calc={self._dynamics.ticket(), self._horizon.ticket()},
        )

    def get_dynamics_input_port(self) -> InputPort:
        """Dynamics of the robot's state."""
        return self._dynamics

    def get_horizon_input_port(self) -> InputPort:
        """Horizon of the gait."""
        return self._horizon

    def get_reference_output_port(self) -> OutputPort:
        """The reference."""
        return self._reference

    def _calc_reference(self, context: Context, output: AbstractValue) -> None:
        d = read_dynamics(self, self._dynamics, context)
        horizon = read_signal(self, self._horizon, context, GaitHorizon)
        output.set_value(self._generator.generate(horizon, d))
