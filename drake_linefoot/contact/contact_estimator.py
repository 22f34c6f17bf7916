"""The contact estimator as a LeafSystem."""

from typing import Any, NamedTuple

import numpy as np
from pydrake.common.value import AbstractValue
from pydrake.systems.framework import Context, DiscreteValues, InputPort, OutputPort

from drake_linefoot.contact.external_wrench import (
    ExternalConstants,
    external_constants,
    learn_external,
    without_external,
)
from drake_linefoot.contact.momentum_observer import momentum_terms, update_residual
from drake_linefoot.contact.parameters import CONSTRAINED, EstimatorParameters
from drake_linefoot.contact.wrench_estimate import (
    ConstrainedEstimate,
    contact_flags,
    estimate_wrenches,
    half_the_weight,
)
from drake_linefoot.leaf_system import Block, check_finite, read_finite, weak
from drake_linefoot.math.compiled import as_python, compiled, inlined
from drake_linefoot.robot.dynamics import RobotDynamics
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.robot.size import sized
from drake_linefoot.robot.state_dynamics import read_dynamics
from drake_linefoot.signals import ContactEstimate
from drake_linefoot.types import Array, Indices


class EstimatorState(NamedTuple):
    """What the estimator remembers from one tick to the next.

    Attributes:
        momentum: p = M v, shape (nv,); NaN before the estimator has begun.
        residual: tau_d of (21), shape (nv,).
        external: what else acts on the robot, moment about the CoM over force [N m, N], shape (6,).
        wrench: of each foot [N, N m], left before right, shape (10,).
        contact: whether each foot stands, 0 or 1, shape (2,).
    """

    momentum: Array
    residual: Array
    external: Array
    wrench: Array
    contact: Array


class Constants(NamedTuple):
    """What does not change from tick to tick.

    Attributes:
        period: length of a tick [s].
        gamma: filter constant of (21), 0 <= gamma < 1.
        touch_force: normal force above which a foot in the air counts as standing [N].
        release_force: normal force below which a standing foot counts as in the air [N].
        actuated_v: index in v of each actuator, shape (na,).
        external: of what else acts on the robot.
    """

    period: float
    gamma: float
    touch_force: float
    release_force: float
    actuated_v: Indices
    external: ExternalConstants


@inlined
def estimator_state(vector: Array) -> EstimatorState:
    """Return the parts of the state in Drake's vector, shape (2 nv + 18,), as views."""
    nv = (len(vector) - 18) // 2
    rest = vector[nv:-18], vector[-18:-12], vector[-12:-2], vector[-2:]
    return EstimatorState(vector[:nv], rest[0], rest[1], rest[2], rest[3])


@compiled
def next_estimate(vector: Array, d: tuple[Array, ...], torque: Array, c: tuple[Any, ...]) -> Array:
    """Return the state of the estimator a tick later, with the pseudoinverse for (22).

    Args:
        vector: the state, see `estimator_state`.
        d: `RobotDynamics` at the end of the tick, as a plain tuple, which Numba takes over faster.
        torque: of the actuators over the tick [N m], shape (na,).
        c: `Constants`, as a plain tuple.
    """
    now, before = RobotDynamics(*d), estimator_state(vector)
    constants = Constants(c[0], c[1], c[2], c[3], c[4], ExternalConstants(*c[5]))
    actuation = np.zeros(len(now.v))
    for k in range(len(torque)):
        actuation[constants.actuated_v[k]] = torque[k]
    momentum, known = momentum_terms(now)
    rate = (momentum - before.momentum) / constants.period
    residual = update_residual(before.residual, rate, known, actuation, constants.gamma)
    unfiltered, lever = rate - known - actuation, now.p_WG - now.q[4:7]
    external = learn_external(before.external, unfiltered, now.J, lever, constants.external)
    of_ground = without_external(residual, external, lever)
    wrench = estimate_wrenches(of_ground, now.J)
    flags = contact_flags(
        wrench[:, 2], before.contact, constants.touch_force, constants.release_force
    )
    return np.concatenate((momentum, residual, external, wrench.reshape(10), flags))


class ContactEstimator(Block):
    """Estimates the wrench of each line foot from momentum, (19)-(22).

    | port | type | shape | unit |
    |---|---|---|---|
    | dynamics | RobotDynamics | - | of the state |
    | applied_torque | vector | na | N m, what the actuators really applied |
    | contact | ContactEstimate | - | N, N m |

    Updates every `period`: the discrete state is an `EstimatorState`, see `estimator_state`.
    With a plant whose output ports are sampled, the update sees the state after a plant step
    and the torque of that same step, which is just what (21) needs. Raises SignalError for an
    input or an estimate that is not finite, SolverError when the constrained form is not solved.
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
        self._humanoid, p = humanoid, sized(parameters, humanoid)
        self._constants = Constants(
            period=float(period),
            gamma=float(p.filter_constant),
            touch_force=float(p.touch_force),
            release_force=float(p.release_force),
            actuated_v=humanoid.actuated_v,
            external=external_constants(p, humanoid, period),
        )
        self._packed = (*self._constants[:-1], tuple(self._constants.external))
        self._constrained = (
            ConstrainedEstimate(p.friction, humanoid.mass, humanoid.half_length)
            if p.method == CONSTRAINED
            else None
        )
        nv = humanoid.nv
        self._dynamics = self.DeclareAbstractInputPort("dynamics", AbstractValue.Make(object()))
        self._torque = self.DeclareVectorInputPort("applied_torque", humanoid.na)
        nothing = np.zeros(nv), np.zeros(6), np.zeros(10), np.zeros(2)
        default = EstimatorState(np.full(nv, np.nan), *nothing)
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

    def _initialize(self, context: Context, discrete: DiscreteValues) -> None:
        """Begin at the present momentum, with both feet standing under half the weight."""
        if np.isfinite(context.get_discrete_state_vector().value()[0]):
            return  # it goes on from a context that was saved
        d = read_dynamics(self, self._dynamics, context)
        wrench = half_the_weight(self._humanoid.mass)
        residual = np.einsum("fij,fi->j", d.J, wrench)
        state = EstimatorState(d.M @ d.v, residual, np.zeros(6), wrench.ravel(), np.ones(2))
        discrete.set_value(np.concatenate(state))

    def _update(self, context: Context, discrete: DiscreteValues) -> None:
        c = self._constants
        d = read_dynamics(self, self._dynamics, context)
        torque = read_finite(self, self._torque, context)
        before = context.get_discrete_state_vector().value().copy()
        after = next_estimate(before, tuple(d), torque, self._packed)
        if self._constrained is not None:
            state, flags = estimator_state(after), estimator_state(before).contact
            of_ground = without_external(state.residual, state.external, d.p_WG - d.p_WB)
            wrench = self._constrained.solve(of_ground, d.J, d.R_WC)
            state.wrench[:] = wrench.ravel()
            state.contact[:] = contact_flags(wrench[:, 2], flags, c.touch_force, c.release_force)
        check_finite(self, self._contact, after, "state")
        discrete.set_value(after)

    def _calc_contact(self, context: Context, output: AbstractValue) -> None:
        vector = context.get_discrete_state_vector().value().copy()
        output.set_value(
            _signal(as_python(estimator_state)(vector))
        )  # slices are faster than a call


def _signal(state: EstimatorState) -> ContactEstimate:
    """Return what a state says on the port."""
    left, right = (state.contact > 0.5).tolist()
    wrench = state.wrench.reshape(2, 5)
    return ContactEstimate(wrench, (left, right), state.residual, state.external)
