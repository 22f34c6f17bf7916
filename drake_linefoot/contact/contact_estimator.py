"""The contact estimator as a LeafSystem."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from pydrake.common.value import AbstractValue
from pydrake.systems.framework import Context, DiscreteValues, InputPort, OutputPort

from drake_linefoot.contact.momentum_observer import (
    mass_matrix_after,
    momentum_terms,
    update_residual,
)
from drake_linefoot.contact.parameters import CONSTRAINED, EstimatorParameters
from drake_linefoot.contact.wrench_estimate import (
    ConstrainedEstimate,
    contact_flags,
    estimate_wrenches,
    half_the_weight,
)
from drake_linefoot.leaf_system import Block, read_finite, weak
from drake_linefoot.math.compiled import compiled
from drake_linefoot.robot.dynamics import RobotDynamics
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.robot.state_dynamics import read_dynamics
from drake_linefoot.signals import ContactEstimate
from drake_linefoot.types import Array


class EstimatorState(NamedTuple):
    """What the estimator remembers from one tick to the next.

    Attributes:
        momentum: p = M v, shape (nv,); NaN before the estimator has begun.
        residual: tau_d of (21), shape (nv,).
        wrench: of each foot [N, N m], left before right, shape (10,).
        contact: whether each foot stands, 0 or 1, shape (2,).
    """

    momentum: Array
    residual: Array
    wrench: Array
    contact: Array


@compiled
def next_estimate(
    before: tuple[Array, ...],
    d: tuple[Array, ...],
    M_after: Array,
    actuation: Array,
    period: float,
    gamma: float,
    thresholds: tuple[float, float],
) -> EstimatorState:
    """Return the state of the estimator a tick later, with the pseudoinverse for (22).

    Args:
        before: the state; like `d` as a plain tuple, which Numba takes over faster.
        d: quantities of the robot's state at the end of the tick.
        M_after: see `mass_matrix_after`, shape (nv, nv).
        actuation: generalized force of the actuators over the tick, shape (nv,).
        period: length of the tick [s].
        gamma: filter constant, 0 <= gamma < 1.
        thresholds: normal force above which a foot in the air counts as standing, and below which
            a standing one counts as in the air [N].
    """
    last, now = EstimatorState(*before), RobotDynamics(*d)
    momentum, known = momentum_terms(now, M_after)
    rate = (momentum - last.momentum) / period
    residual = update_residual(last.residual, rate, known, actuation, gamma)
    wrench = estimate_wrenches(residual, now.J)
    flags = contact_flags(wrench[:, 2], last.contact, thresholds[0], thresholds[1])
    return EstimatorState(momentum, residual, wrench.reshape(10), flags)


class ContactEstimator(Block):
    """Estimates the wrench of each line foot from momentum, (19)-(22).

    | port | type | shape | unit |
    |---|---|---|---|
    | dynamics | RobotDynamics | - | of the state |
    | applied_torque | vector | na | N m, what the actuators really applied |
    | contact | ContactEstimate | - | N, N m |

    Updates every `period`: the discrete state is an `EstimatorState`, one part after the
    other. With a
    plant whose output ports are sampled, the update sees the state after a plant step and
    the torque of that same step, which is just what (21) needs. Raises SignalError for a
    non-finite input, SolverError when the constrained form is not solved.
    """

    def __init__(
        self, humanoid: Humanoid, parameters: EstimatorParameters, period: float = 0.001
    ) -> None:
        """Declare ports, state and events.

        Args:
            humanoid: the robot.
            parameters: filter, thresholds.
            period: between two updates, and of the plant's steps [s].
        """
        super().__init__()
        self.set_name("contact_estimator")
        self._humanoid, self._parameters = humanoid, parameters
        self._period = period
        self._scratch = humanoid.plant.CreateDefaultContext()  # overwritten by each update
        self._constrained = (
            ConstrainedEstimate(parameters.friction, humanoid.mass, humanoid.half_length)
            if parameters.method == CONSTRAINED
            else None
        )
        nv = humanoid.nv
        self._dynamics = self.DeclareAbstractInputPort("dynamics", AbstractValue.Make(object()))
        self._torque = self.DeclareVectorInputPort("applied_torque", humanoid.na)
        default = EstimatorState(np.full(nv, np.nan), np.zeros(nv), np.zeros(10), np.zeros(2))
        self._layout = np.dtype(
            [
                (name, "f8", part.shape)
                for name, part in zip(EstimatorState._fields, default, strict=True)
            ]
        )
        self.DeclareDiscreteState(np.concatenate(default))
        self._contact = self.DeclareAbstractOutputPort(
            "contact",
            lambda: AbstractValue.Make(_signal(default)),
            weak(self, self._calc_contact),
            prerequisites_of_calc={self.xd_ticket()},
        )
        self.DeclareInitializationDiscreteUpdateEvent(weak(self, self._initialize))
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, weak(self, self._update))

    def get_dynamics_input_port(self) -> InputPort:
        """Quantities of the robot's state."""
        return self._dynamics

    def get_applied_torque_input_port(self) -> InputPort:
        """Torque the actuators applied over the last step."""
        return self._torque

    def get_contact_output_port(self) -> OutputPort:
        """The estimate."""
        return self._contact

    def estimator_state(self, context: Context) -> EstimatorState:
        """Return the state of the estimator in this system's context."""
        vector = context.get_discrete_state_vector().value().copy()
        return EstimatorState(*vector.view(self._layout)[0])

    def _initialize(self, context: Context, discrete: DiscreteValues) -> None:
        """Begin at the present momentum, with both feet standing under half the weight."""
        if np.isfinite(self.estimator_state(context).momentum[0]):
            return  # it goes on from a context that was saved
        d = read_dynamics(self, self._dynamics, context)
        wrench = half_the_weight(self._humanoid.mass)
        residual = np.einsum("fij,fi->j", d.J, wrench)
        state = EstimatorState(d.M @ d.v, residual, wrench.ravel(), np.ones(2))
        discrete.set_value(np.concatenate(state))

    def _update(self, context: Context, discrete: DiscreteValues) -> None:
        h, p = self._humanoid, self._parameters
        d = read_dynamics(self, self._dynamics, context)
        actuation = np.zeros(h.nv)
        actuation[h.actuated_v] = read_finite(self, self._torque, context)
        before = self.estimator_state(context)
        M_after = mass_matrix_after(h, self._scratch, d.q, d.v)
        thresholds = float(p.touch_force), float(p.release_force)
        gamma = float(p.filter_constant)
        state = next_estimate(
            tuple(before), tuple(d), M_after, actuation, self._period, gamma, thresholds
        )
        if self._constrained is not None:
            wrench = self._constrained.solve(state.residual, d.J, d.R_WC)
            flags = contact_flags(wrench[:, 2], before.contact, *thresholds)
            state = state._replace(wrench=wrench.ravel(), contact=flags)
        discrete.set_value(np.concatenate(state))

    def _calc_contact(self, context: Context, output: AbstractValue) -> None:
        output.set_value(_signal(self.estimator_state(context)))


def _signal(state: EstimatorState) -> ContactEstimate:
    """Return what a state says on the port."""
    left, right = (state.contact > 0.5).tolist()
    return ContactEstimate(state.wrench.reshape(2, 5), (left, right), state.residual)
