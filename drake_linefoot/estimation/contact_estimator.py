"""The contact estimator as a LeafSystem."""

import math
from typing import Any, NamedTuple

import numpy as np
from pydrake.systems.framework import BasicVector, Context, DiscreteValues

from drake_linefoot.estimation.contact_parameters import CONSTRAINED, EstimatorParameters
from drake_linefoot.estimation.external_wrench import (
    ExternalConstants,
    external_constants,
    update_external_estimate,
    without_external,
)
from drake_linefoot.estimation.momentum_observer import (
    follow_late,
    momentum_terms,
    update_residual,
)
from drake_linefoot.estimation.wrench_estimate import (
    ConstrainedEstimate,
    contact_flags,
    estimate_wrenches,
    half_the_weight,
)
from drake_linefoot.layout import Layout
from drake_linefoot.leaf_system import check_finite, read_finite, read_vector, weak
from drake_linefoot.math.compiled import compiled
from drake_linefoot.robot.dynamics import dynamics_layout
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.robot.scaling import scaled
from drake_linefoot.signals import ContactEstimate, open_contact, open_dynamics
from drake_linefoot.tunable_block import TunableBlock
from drake_linefoot.types import Array, Indices


class Constants(NamedTuple):
    """What does not change from tick to tick.

    Attributes:
        period: length of a tick [s].
        gamma: filter constant of (21), 0 <= gamma < 1.
        touch_force: normal force above which a foot in the air counts as standing [N].
        release_force: normal force below which a standing foot counts as in the air [N].
        actuated_v: index in v of each actuator, shape (na,).
        external: of what else acts on the robot.
        nw: how many numbers the wrench of a foot has.
        theta: see `follow_late`, of the joint rates in the state.
        friction: in the cones of the constrained form [-].
    """

    period: float
    gamma: float
    touch_force: float
    release_force: float
    actuated_v: Indices
    external: ExternalConstants
    nw: int
    theta: float
    friction: float


@compiled
def next_estimate(vector: Array, dynamics: Array, torque: Array, c: tuple[Any, ...]) -> Array:
    """Return the state of the estimator a tick later, with the pseudoinverse for (22).

    Args:
        vector: the state, see `ContactEstimator`, shape (2 nv + 2 na + 2 nw + 20,).
        dynamics: `RobotDynamics` at the end of the tick, as they travel.
        torque: of the actuators over the tick [N m], shape (na,).
        c: `Constants`, as a plain tuple.
    """
    nw, late = c[6], 6 + len(torque)
    nv = len(vector) // 2 - late - nw - 4
    now, before = open_dynamics(dynamics, nv, nw), open_contact(vector[nv + 2 * late :], nv, nw)
    constants = Constants(c[0], c[1], c[2], c[3], c[4], ExternalConstants(*c[5]), nw, c[7], c[8])
    stages, v = vector[nv : nv + 2 * late].copy().reshape(2, late), now.v.copy()
    followed = follow_late(stages, np.concatenate((v[:6], torque)), constants.theta)
    v[:6], actuation = followed[:6], np.zeros(nv)
    for k in range(len(torque)):
        actuation[constants.actuated_v[k]] = followed[6 + k]
    momentum, known = momentum_terms(now, v)
    rate = (momentum - vector[:nv]) / constants.period
    residual = update_residual(before.residual, rate, known, actuation, constants.gamma)
    unfiltered, lever = rate - known - actuation, now.p_WG - now.q[4:7]
    external = update_external_estimate(
        before.external, unfiltered, now.J, lever, constants.external
    )
    of_ground = without_external(residual, external, lever)
    wrench = estimate_wrenches(of_ground, now.J)
    flags = contact_flags(
        wrench[:, 2], before.contact, constants.touch_force, constants.release_force
    )
    parts = stages.reshape(2 * late), wrench.reshape(2 * nw), flags, residual, external
    return np.concatenate((momentum, *parts))


def constants_of(p: EstimatorParameters, humanoid: Humanoid, period: float) -> tuple[Any, ...]:
    """Return the `Constants` of a robot as plain tuples, with parameters in its size."""
    constants = Constants(
        period=float(period),
        gamma=float(p.filter_constant),
        touch_force=float(p.touch_force),
        release_force=float(p.release_force),
        actuated_v=humanoid.actuated_v,
        external=external_constants(p, humanoid, period),
        nw=humanoid.contact.size,
        theta=math.exp(-period * (p.rate_bandwidth or math.inf)),
        friction=float(p.friction),
    )
    return tuple(tuple(c) if isinstance(c, tuple) else c for c in constants)


class ContactEstimator(TunableBlock[EstimatorParameters, tuple[Any, ...]]):
    """Estimates the wrench of each foot from momentum, (19)-(22).

    .. pydrake_system::

        name: ContactEstimator
        input_ports:
        - dynamics
        - applied_torque
        output_ports:
        - contact

    Its parameters are numeric parameters, but for method and `rate_bandwidth`. Updates every
    `period`: the discrete state is the momentum p = M v, NaN before it has begun,
    velocity of the base and torque behind it as `follow_late` filters them, and the
    `ContactEstimate`.
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
        self._humanoid, p = humanoid, scaled(parameters, humanoid)
        self.declare_parameters(p, lambda p: constants_of(p, humanoid, period))
        self._constrained = (
            ConstrainedEstimate(humanoid.mass, humanoid.contact)
            if p.method == CONSTRAINED
            else None
        )
        nv = humanoid.nv
        self._of_dynamics = dynamics_layout(humanoid)
        self._dynamics = self.signal_input("dynamics", self._of_dynamics)
        self._torque = self.DeclareVectorInputPort("applied_torque", humanoid.na)
        self._of_contact = Layout(ContactEstimate, humanoid.sizes)
        nothing = np.full(nv, np.nan), np.zeros(12 + 2 * humanoid.na + self._of_contact.size)
        self.DeclareDiscreteState(np.concatenate(nothing))
        after = {self.xd_ticket()}
        self._contact = self.signal_output("contact", self._of_contact, self._calc_contact, after)
        self.DeclareInitializationDiscreteUpdateEvent(weak(self, self._initialize))
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, weak(self, self._update))

    def _initialize(self, context: Context, discrete: DiscreteValues) -> None:
        """Begin at the present momentum, with both feet standing under half the weight."""
        if np.isfinite(context.get_discrete_state_vector().value()[0]):
            return  # it goes on from a context that was saved
        d = self._of_dynamics.open(self._read_dynamics(context))
        h = self._humanoid
        wrench = half_the_weight(h.mass, h.contact.size)
        residual = np.einsum("fij,fi->j", d.J, wrench)
        momentum, known = momentum_terms(d, d.v)
        torque = -(known + residual)[h.actuated_v]  # so that it stays what it is
        begun = ContactEstimate(wrench, np.ones(2), residual, np.zeros(6))
        behind = np.tile(np.concatenate((d.v[:6], torque)), 2), self._of_contact.vector(begun)
        discrete.set_value(np.concatenate((momentum, *behind)))

    def _update(self, context: Context, discrete: DiscreteValues) -> None:
        packed = self.constants_in(context)
        dynamics = self._read_dynamics(context)
        torque = read_finite(self, self._torque, context)
        before = context.get_discrete_state_vector().value().copy()
        after = next_estimate(before, dynamics, torque, packed)
        if self._constrained is not None:
            c, d = Constants(*packed), self._of_dynamics.open(dynamics)
            size = self._of_contact.size
            state, last = (self._of_contact.open(x[-size:]) for x in (after, before))
            of_ground = without_external(state.residual, state.external, d.p_WG - d.p_WB)
            wrench = self._constrained.solve(of_ground, d.J, d.R_WC, c.friction)
            state.wrench[:] = wrench
            state.contact[:] = contact_flags(
                wrench[:, 2], last.contact, c.touch_force, c.release_force
            )
        check_finite(self, self._contact, after, "state")
        discrete.set_value(after)

    def _read_dynamics(self, context: Context) -> Array:
        return read_vector(self, self._dynamics, context, self._of_dynamics)

    def _calc_contact(self, context: Context, output: BasicVector) -> None:
        vector = context.get_discrete_state_vector().value()
        output.SetFromVector(vector[-self._of_contact.size :])
