"""The contact estimator as a LeafSystem."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from pydrake.common.value import AbstractValue
from pydrake.systems.framework import (
    Context,
    DiscreteValues,
    InputPort,
    OutputPort,
)

from drake_linefoot.contact.kernels import next_estimate
from drake_linefoot.contact.momentum_observer import momentum_terms
from drake_linefoot.contact.parameters import CONSTRAINED, EstimatorParameters
from drake_linefoot.contact.wrench_estimate import (
    RANK_TOLERANCE,
    ConstrainedEstimate,
    contact_flags,
    estimate_wrenches,
    initial_state,
)
from drake_linefoot.robot.dynamics import RobotDynamics, SharedDynamics
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.signals import ContactEstimate
from drake_linefoot.systems import Block, read_finite, weak

Array = NDArray[np.float64]


class ContactEstimator(Block):
    """Estimates the wrench of each line foot from momentum, (19)-(22).

    .. pydrake_system::

        name: ContactEstimator
        input_ports:
        - state
        - applied_torque
        output_ports:
        - contact

    | port | type | shape | unit |
    |---|---|---|---|
    | state | vector | nq + nv | q in m and rad, v in m/s and rad/s, Drake's order |
    | applied_torque | vector | na | N m, what the actuators really applied |
    | contact | ContactEstimate | - | N, N m |

    Updates every `period`: discrete state = momentum, residual, wrenches, flags. With a
    plant whose output ports are sampled, the update sees the state after a plant step and
    the torque of that same step, which is just what (21) needs. Raises SignalError for a
    non-finite input, SolverError when the constrained form is not solved.
    """

    def __init__(
        self,
        humanoid: Humanoid,
        parameters: EstimatorParameters,
        period: float = 0.001,
        dynamics: SharedDynamics | None = None,
    ) -> None:
        """Declare ports, state and events.

        Args:
            humanoid: the robot.
            parameters: filter, thresholds.
            period: between two updates, and of the plant's steps [s].
            dynamics: shared with other blocks; its own without.
        """
        super().__init__()
        self.set_name("contact_estimator")
        self._humanoid, self._parameters = humanoid, parameters
        self._period = period
        self._dynamics = dynamics or SharedDynamics(humanoid)
        self._constrained = (
            ConstrainedEstimate(parameters.friction, humanoid.mass, humanoid.half_length)
            if parameters.method == CONSTRAINED
            else None
        )
        nv = humanoid.nv
        self._state = self.DeclareVectorInputPort("state", humanoid.nq + nv)
        self._torque = self.DeclareVectorInputPort("applied_torque", humanoid.na)
        self.DeclareDiscreteState(2 * nv + 12)  # momentum, residual, wrenches, flags
        self._contact = self.DeclareAbstractOutputPort(
            "contact",
            lambda: AbstractValue.Make(_nothing(nv)),
            weak(self, self._calc_contact),
            prerequisites_of_calc={self.xd_ticket()},
        )
        self.DeclareInitializationDiscreteUpdateEvent(weak(self, self._initialize))
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, weak(self, self._update))

    def get_state_input_port(self) -> InputPort:
        """State of the robot."""
        return self._state

    def get_applied_torque_input_port(self) -> InputPort:
        """Torque the actuators applied over the last step."""
        return self._torque

    def get_contact_output_port(self) -> OutputPort:
        """The estimate."""
        return self._contact

    def _initialize(self, context: Context, discrete: DiscreteValues) -> None:
        """Start from the present momentum, with both feet standing under half the weight."""
        x = read_finite(self, self._state, context)
        d = self._dynamics(x)
        discrete.set_value(initial_state(d.M @ d.v, d.J, self._humanoid.mass))

    def _update(self, context: Context, discrete: DiscreteValues) -> None:
        p = self._parameters
        x = read_finite(self, self._state, context)
        torque = read_finite(self, self._torque, context)
        dynamics = self._dynamics(x)
        terms = momentum_terms(self._humanoid, self._dynamics.scratch, dynamics)
        before = context.get_discrete_state_vector().value()
        state, independent = next_estimate(
            before, terms.momentum, terms.known, torque, self._humanoid.actuated_v, self._period,
            p.filter_constant, dynamics.J, RANK_TOLERANCE, p.touch_force, p.release_force,
        )  # fmt: skip
        if self._constrained is not None or not independent:
            self._explain_otherwise(state, before, dynamics)
        discrete.set_value(state)

    def _explain_otherwise(self, state: Array, before: Array, dynamics: RobotDynamics) -> None:
        """Set wrenches and flags of a state whose residual is not explained by plain inversion."""
        p, nv = self._parameters, self._humanoid.nv
        residual = state[nv : 2 * nv]
        if self._constrained is None:
            wrench = estimate_wrenches(residual, dynamics.J)
        else:
            wrench = self._constrained.solve(residual, dynamics.J, dynamics.R_WC)
        left, right = (before[-2:] > 0.5).tolist()
        state[2 * nv : -2] = wrench.ravel()
        state[-2:] = contact_flags(wrench[:, 2], (left, right), p.touch_force, p.release_force)

    def _calc_contact(self, context: Context, output: AbstractValue) -> None:
        state = context.get_discrete_state_vector().value().copy()
        nv = self._humanoid.nv
        left, right = state[-2:].tolist()
        wrench = state[2 * nv : -2].reshape(2, 5)
        contact = ContactEstimate(wrench, (left > 0.5, right > 0.5), state[nv : 2 * nv])
        output.set_value(contact)


def _nothing(nv: int) -> ContactEstimate:
    """Return an estimate without contact, to size the port with."""
    return ContactEstimate(np.zeros((2, 5)), (False, False), np.zeros(nv))
