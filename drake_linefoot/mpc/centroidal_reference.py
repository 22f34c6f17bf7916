"""The reference of the MPC as a LeafSystem."""

from pydrake.systems.framework import BasicVector, Context

from drake_linefoot.leaf_system import Block, read_vector
from drake_linefoot.mpc.parameters import MpcParameters
from drake_linefoot.mpc.reference import ReferenceGenerator
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.robot.scaling import scaled


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
        parameters: MpcParameters,
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
        self._generator = generator or ReferenceGenerator(humanoid, scaled(parameters, humanoid))
        g = self._generator
        self._dynamics = self.signal_input("dynamics", g.dynamics)
        self._horizon = self.signal_input("horizon", g.horizon)
        inputs = {self._dynamics.ticket(), self._horizon.ticket()}
        self.signal_output("reference", g.reference, self._calc_reference, inputs)

    def _calc_reference(self, context: Context, output: BasicVector) -> None:
        g = self._generator
        dynamics = read_vector(self, self._dynamics, context, g.dynamics)
        horizon = read_vector(self, self._horizon, context, g.horizon)
        output.SetFromVector(g.vector(horizon, dynamics))
