"""The gait as a LeafSystem."""

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

from drake_linefoot.gait import tick_kernels as at
from drake_linefoot.gait.horizon import GaitHorizon, plan_horizon
from drake_linefoot.gait.measure import measure_gait
from drake_linefoot.gait.parameters import GaitParameters
from drake_linefoot.gait.planner import Gait
from drake_linefoot.gait.state import GaitState, Mode
from drake_linefoot.gait.tick_kernels import carry_on_lines
from drake_linefoot.robot.dynamics import SharedDynamics
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.signals import ContactEstimate, GaitTargets, SwingTarget
from drake_linefoot.systems import Block, read_finite, weak

Array = NDArray[np.float64]

COMMAND_SIZE = 4
_MODES = tuple(mode.name.lower() for mode in Mode)


class GaitPlanner(Block):
    """Decides when which foot stands, where it lands and how it gets there.

    .. pydrake_system::

        name: GaitPlanner
        input_ports:
        - state
        - command
        - contact
        output_ports:
        - targets
        - horizon

    | port | type | shape | unit |
    |---|---|---|---|
    | state | vector | nq + nv | Drake's order |
    | command | vector | 4 | v_x, v_y in the heading frame [m/s], turn rate [rad/s], walk (0 or 1) |
    | contact | ContactEstimate | - | of the contact estimator |
    | targets | GaitTargets | - | what holds now; cheap, for every tick |
    | horizon | GaitHorizon | - | phases and footholds ahead; evaluated at the MPC's rate |

    Updates every 1 ms; the discrete state is `GaitState` in vector form, stamped with the
    time of the state it was computed from. A command outside its limits is clipped and
    counted. Raises SignalError for a non-finite input.
    """

    def __init__(
        self,
        humanoid: Humanoid,
        parameters: GaitParameters,
        horizon_length: float,
        period: float = 0.001,
        dynamics: SharedDynamics | None = None,
    ) -> None:
        """Declare ports, state and events.

        Args:
            humanoid: the robot.
            parameters: of the gait.
            horizon_length: what `horizon` covers [s].
            period: between two updates [s].
            dynamics: shared with other blocks; its own without.
        """
        super().__init__()
        self.set_name("gait_planner")
        self._humanoid = humanoid
        self._gait = Gait(parameters, humanoid.description.limits)
        self._length = horizon_length
        self._period = period
        self._dynamics = dynamics or SharedDynamics(humanoid)
        self._state = self.DeclareVectorInputPort("state", humanoid.nq + humanoid.nv)
        self._command = self.DeclareVectorInputPort("command", COMMAND_SIZE)
        model = ContactEstimate(np.zeros((2, 5)), (True, True), np.zeros(humanoid.nv))
        self._contact = self.DeclareAbstractInputPort("contact", AbstractValue.Make(model))
        self.DeclareDiscreteState(self._initial(humanoid.x_nominal, 0.0).to_vector())
        self._targets = self.DeclareAbstractOutputPort(
            "targets",
            weak(self, self._allocate_targets),
            weak(self, self._calc_targets),
            prerequisites_of_calc={self.xd_ticket()},
        )
        self._horizon = self.DeclareAbstractOutputPort(
            "horizon",
            weak(self, self._allocate_horizon),
            weak(self, self._calc_horizon),
            prerequisites_of_calc={self.xd_ticket()},
        )
        self.DeclareInitializationDiscreteUpdateEvent(weak(self, self._initialize))
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, weak(self, self._update))

    def get_state_input_port(self) -> InputPort:
        """State of the robot."""
        return self._state

    def get_command_input_port(self) -> InputPort:
        """Velocity command."""
        return self._command

    def get_contact_input_port(self) -> InputPort:
        """Contact estimate."""
        return self._contact

    def get_targets_output_port(self) -> OutputPort:
        """What holds now."""
        return self._targets

    def get_horizon_output_port(self) -> OutputPort:
        """What is planned ahead."""
        return self._horizon

    def gait_state(self, context: Context) -> GaitState:
        """Return the state of the gait in this system's context."""
        return GaitState.from_vector(context.get_discrete_state_vector().value())

    def _initial(self, x: Array, time: float) -> GaitState:
        measured = measure_gait(self._dynamics(x), (True, True), self._humanoid.half_length)
        return self._gait.initial_state(time, measured)

    def _initialize(self, context: Context, discrete: DiscreteValues) -> None:
        x = read_finite(self, self._state, context)
        discrete.set_value(self._initial(x, context.get_time()).to_vector())

    def _update(self, context: Context, discrete: DiscreteValues) -> None:
        x = read_finite(self, self._state, context, self._dynamics.knows)
        command = read_finite(self, self._command, context)
        estimate: ContactEstimate = self._contact.Eval(context)
        d, contact, step = self._dynamics(x), estimate.contact, self._gait.placement
        # The plant has stepped already, so the state belongs to the end of this tick.
        time = context.get_time() + self._period
        before = context.get_discrete_state_vector().value()
        after, ended = carry_on_lines(
            before, command, d.p_WG, d.v_WG, d.lines, d.R_WC, contact, time, step.constants,
            step.reach,
        )  # fmt: skip
        if ended:
            measured = measure_gait(d, contact, self._humanoid.half_length)
            after = self._gait.decide(after, command, measured, time - float(before[at.TIME]))
        discrete.set_value(after)

    def _allocate_targets(self) -> AbstractValue:
        state = self._initial(self._humanoid.x_nominal, 0.0)
        return AbstractValue.Make(gait_targets(self._gait, state.to_vector()))

    def _calc_targets(self, context: Context, output: AbstractValue) -> None:
        state = context.get_discrete_state_vector().value()
        output.set_value(gait_targets(self._gait, state))

    def _allocate_horizon(self) -> AbstractValue:
        state = self._initial(self._humanoid.x_nominal, 0.0)
        return AbstractValue.Make(plan_horizon(self._gait, state, self._length))

    def _calc_horizon(self, context: Context, output: AbstractValue) -> None:
        horizon: GaitHorizon = plan_horizon(self._gait, self.gait_state(context), self._length)
        output.set_value(horizon)


def gait_targets(gait: Gait, state: Array) -> GaitTargets:
    """Return what the whole-body controller needs of a gait state, given as a vector."""
    numbers = state[: at.VELOCITY].tolist()
    motion, place, command = at.present(state, gait.parameters.swing_height)
    mode, contact = int(numbers[at.MODE]), (True, True)
    swings = mode == at.SWING
    if swings:
        contact = (numbers[at.SIDE] == 0.0, numbers[at.SIDE] == 1.0)
    return GaitTargets(
        time=numbers[at.TIME],
        mode=_MODES[mode],
        contact=contact,
        swing=SwingTarget(motion) if swings else None,
        foothold=place,
        command=command,
        yaw=numbers[at.HEADING],
        slope=state[at.SLOPE : at.END].copy(),
        steps=int(numbers[at.STEPS]),
        moved_footholds=int(numbers[at.MOVED]),
        clipped_commands=int(numbers[at.CLIPPED]),
    )
