"""The reference of the MPC as a LeafSystem."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from pydrake.common.value import AbstractValue
from pydrake.systems.framework import Context, InputPort, OutputPort

from drake_linefoot.gait.horizon import GaitHorizon, plan_horizon
from drake_linefoot.gait.measure import measure_gait
from drake_linefoot.gait.parameters import GaitParameters
from drake_linefoot.gait.planner import Gait
from drake_linefoot.gait.reference import Measured, ReferenceGenerator
from drake_linefoot.mpc.parameters import MpcParameters
from drake_linefoot.robot.dynamics import SharedDynamics
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.signals import Reference
from drake_linefoot.systems import Block, read_finite, weak

Array = NDArray[np.float64]


class CentroidalReference(Block):
    """Turns the gait's horizon into the desired trajectory x_H* of (40).

    .. pydrake_system::

        name: CentroidalReference
        input_ports:
        - state
        - horizon
        output_ports:
        - reference

    | port | type | shape | unit |
    |---|---|---|---|
    | state | vector | nq + nv | Drake's order |
    | horizon | GaitHorizon | - | of the gait planner |
    | reference | Reference | - | r_d, v_d, R_d, Omega_d, L_d, I_Bd, contacts |

    Stateless; computed when the MPC asks for it. Raises SignalError for a non-finite state.
    """

    def __init__(
        self,
        humanoid: Humanoid,
        parameters: MpcParameters,
        gait: GaitParameters,
        dynamics: SharedDynamics | None = None,
        generator: ReferenceGenerator | None = None,
    ) -> None:
        """Declare ports.

        Args:
            humanoid: the robot.
            parameters: of the MPC: model and knots.
            gait: only sizes the ports.
            dynamics: shared with other blocks; its own without.
            generator: used instead of `ReferenceGenerator`.
        """
        super().__init__()
        self.set_name("centroidal_reference")
        self._generator = generator or ReferenceGenerator(humanoid, parameters)
        self._dynamics = dynamics or SharedDynamics(humanoid)
        nominal = self._dynamics(humanoid.x_nominal)
        measured = measure_gait(nominal, (True, True), humanoid.half_length)
        stand = Gait(gait, humanoid.description.limits).initial_state(0.0, measured)
        model = plan_horizon(Gait(gait, humanoid.description.limits), stand, parameters.horizon)
        reference = self._generate(humanoid.x_nominal, model)
        self._state = self.DeclareVectorInputPort("state", humanoid.nq + humanoid.nv)
        self._horizon = self.DeclareAbstractInputPort("horizon", AbstractValue.Make(model))
        self._reference = self.DeclareAbstractOutputPort(
            "reference",
            lambda: AbstractValue.Make(reference),
            weak(self, self._calc_reference),
            prerequisites_of_calc={self._state.ticket(), self._horizon.ticket()},
        )

    def get_state_input_port(self) -> InputPort:
        """State of the robot."""
        return self._state

    def get_horizon_input_port(self) -> InputPort:
        """Horizon of the gait."""
        return self._horizon

    def get_reference_output_port(self) -> OutputPort:
        """The reference."""
        return self._reference

    def _generate(self, x: Array, horizon: GaitHorizon) -> Reference:
        d = self._dynamics(x)
        return self._generator.generate(horizon, Measured(q=d.q, r=d.p_WG, R_WB=d.R_WB))

    def _calc_reference(self, context: Context, output: AbstractValue) -> None:
        x = read_finite(self, self._state, context)
        output.set_value(self._generate(x, self._horizon.Eval(context)))
