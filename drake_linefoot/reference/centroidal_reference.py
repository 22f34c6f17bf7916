"""The reference of the MPC as a LeafSystem."""

from pydrake.systems.framework import BasicVector, Context

from drake_linefoot.layout import Layout
from drake_linefoot.leaf_system import Block, read_signal
from drake_linefoot.reference.parameters import ReferenceParameters
from drake_linefoot.reference.reference import ReferenceGenerator
from drake_linefoot.robot.dynamics import dynamics_layout
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.robot.size import sized
from drake_linefoot.signals import GaitHorizon, Reference


class CentroidalReference(Block):
    """Turns the gait's horizon into the desired trajectory x_H* of (40).

    .. pydrake_system::

        name: CentroidalReference
        input_ports:
        - dynamics
        - horizon
        output_ports:
        - reference

    Stateless; computed when the MPC asks for it. Raises SignalError for an input that is not
    finite.
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
        self._of_dynamics = dynamics_layout(humanoid.nv)
        self._dynamics = self.signal_input("dynamics", self._of_dynamics)
        sizes = {"knots": parameters.knots}
        self._of_horizon, self._of_reference = Layout(GaitHorizon, sizes), Layout(Reference, sizes)
        self._horizon = self.signal_input("horizon", self._of_horizon)
        inputs = {self._dynamics.ticket(), self._horizon.ticket()}
        self.signal_output("reference", self._of_reference, self._calc_reference, inputs)

    def _calc_reference(self, context: Context, output: BasicVector) -> None:
        d = read_signal(self, self._dynamics, context, self._of_dynamics)
        horizon = read_signal(self, self._horizon, context, self._of_horizon)
        reference = self._generator.generate(horizon, d)
        output.SetFromVector(self._of_reference.vector(reference))
