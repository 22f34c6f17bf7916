"""The gait as a LeafSystem."""

import numpy as np
from pydrake.common.value import AbstractValue
from pydrake.systems.framework import Context, DiscreteValues, InputPort, OutputPort

from drake_linefoot.gait.constants import constants_of
from drake_linefoot.gait.horizon import plan_horizon
from drake_linefoot.gait.measurement import measure_gait
from drake_linefoot.gait.parameters import GaitParameters
from drake_linefoot.gait.planner import begin, update
from drake_linefoot.gait.state import GAIT, YAW, Mode, Records, contact_of, gait_record
from drake_linefoot.gait.swing import present_line
from drake_linefoot.leaf_system import Block, read_finite, read_signal, weak
from drake_linefoot.math.compiled import compiled
from drake_linefoot.robot.dynamics import RobotDynamics, robot_dynamics
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.robot.state_dynamics import read_dynamics
from drake_linefoot.signals import ContactEstimate, GaitTargets, SwingTarget
from drake_linefoot.types import Array

COMMAND_SIZE = 4
_MODES = tuple(mode.name.lower() for mode in Mode)


class GaitPlanner(Block):
    """Decides when which foot stands, where it lands and how it gets there.

    | port | type | shape | unit |
    |---|---|---|---|
    | dynamics | RobotDynamics | - | of the present state |
    | command | vector | 4 | v_x, v_y in the heading frame [m/s], turn rate [rad/s], walk (0 or 1) |
    | contact | ContactEstimate | - | of the contact estimator |
    | targets | GaitTargets | - | what holds now; cheap, for every tick |
    | horizon | GaitHorizon | - | phases and footholds ahead; evaluated at the MPC's rate |

    Updates every 1 ms; the discrete state is that of `state.GAIT`, stamped with the
    time of the state it was computed from. A simulation begins with the feet where they are
    measured; a state that was saved goes on. A command outside its limits is clipped and
    counted. Raises SignalError for a non-finite input, or one of another type.
    """

    def __init__(
        self,
        humanoid: Humanoid,
        parameters: GaitParameters,
        horizon_length: float,
        period: float = 0.001,
    ) -> None:
        """Declare ports, state and events.

        Args:
            humanoid: the robot.
            parameters: of the gait.
            horizon_length: what `horizon` covers [s].
            period: between two updates [s].
        """
        super().__init__()
        self.set_name("gait_planner")
        self._constants = constants_of(parameters, humanoid)
        self._length = horizon_length
        self._period = period
        self._dynamics = self.DeclareAbstractInputPort("dynamics", AbstractValue.Make(object()))
        self._command = self.DeclareVectorInputPort("command", COMMAND_SIZE)
        self._contact = self.DeclareAbstractInputPort("contact", AbstractValue.Make(object()))
        nominal = robot_dynamics(humanoid, humanoid.scratch, humanoid.x_nominal)
        standing = self._begin(nominal, 0.0)
        standing.begun = 0
        self.DeclareDiscreteState(np.frombuffer(standing))
        targets = gait_targets(np.frombuffer(standing).copy())
        horizon = plan_horizon(standing, self._constants[0], horizon_length)
        self._targets = self.DeclareAbstractOutputPort(
            "targets",
            lambda: AbstractValue.Make(targets),
            weak(self, self._calc_targets),
            prerequisites_of_calc={self.xd_ticket()},
        )
        self._horizon = self.DeclareAbstractOutputPort(
            "horizon",
            lambda: AbstractValue.Make(horizon),
            weak(self, self._calc_horizon),
            prerequisites_of_calc={self.xd_ticket()},
        )
        self.DeclareInitializationDiscreteUpdateEvent(weak(self, self._initialize))
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, weak(self, self._update))

    def get_dynamics_input_port(self) -> InputPort:
        """Dynamics of the robot's state."""
        return self._dynamics

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

    def gait_state(self, context: Context) -> np.record:
        """Return a copy of the state of the gait in this system's context, see `state.GAIT`."""
        return gait_record(context.get_discrete_state_vector().value().copy())

    def _begin(self, d: RobotDynamics, time: float) -> np.record:
        c = self._constants[0]
        return begin(measure_gait(d, (True, True), c), time, c)

    def _initialize(self, context: Context, discrete: DiscreteValues) -> None:
        if not self.gait_state(context).begun:
            d = read_dynamics(self, self._dynamics, context)
            discrete.set_value(np.frombuffer(self._begin(d, context.get_time())))

    def _update(self, context: Context, discrete: DiscreteValues) -> None:
        d = read_dynamics(self, self._dynamics, context)
        command = read_finite(self, self._command, context)
        estimate = read_signal(self, self._contact, context, ContactEstimate)
        # The plant has stepped already, so the state belongs to the end of this tick.
        time = context.get_time() + self._period
        after = context.get_discrete_state_vector().value().copy()
        says = estimate.contact, (estimate.wrench, estimate.external)
        update(np.frombuffer(after, GAIT), command, d, *says, time, self._constants)
        discrete.set_value(after)

    def _calc_targets(self, context: Context, output: AbstractValue) -> None:
        vector = context.get_discrete_state_vector().value().copy()
        output.set_value(gait_targets(vector))

    def _calc_horizon(self, context: Context, output: AbstractValue) -> None:
        horizon = plan_horizon(self.gait_state(context), self._constants[0], self._length)
        output.set_value(horizon)


def gait_targets(vector: Array) -> GaitTargets:
    """Return what the whole-body controller needs of the gait.

    Args:
        vector: state of the gait, see `state.GAIT`.
    """
    (mode, left, right, *counts), (time, yaw, friction), line, places, (grip, external) = (
        present_targets(np.frombuffer(vector, GAIT))
    )
    return GaitTargets(
        time=time,
        mode=_MODES[mode],
        contact=(left, right),
        swing=None if left and right else SwingTarget(*line),
        foothold=places[:4],
        command=places[4:7],
        yaw=yaw,
        slope=places[7:],
        friction=friction,
        grip=grip,
        external=external,
        limited=counts[0],
        steps=counts[1],
        moved_footholds=counts[2],
        clipped_commands=counts[3],
    )


@compiled
def present_targets(
    gait: Records,
) -> tuple[
    tuple[int, bool, bool, int, int, int, int],
    tuple[float, float, float],
    Array,
    Array,
    tuple[Array, Array],
]:
    """Return a state of the gait as its targets take it.

    Args:
        gait: an array of one record, shape (1,).

    Returns:
        ((mode, left, right, limited, steps, moved, clipped), (time, yaw, friction), line, places,
        (grip, external)): which feet stand, and the counts; `present_line` of a swing; foothold,
        command and slope, shape (9,); as of `GaitTargets`. Line and foothold are NaN where both
        feet stand.
    """
    s = gait[0]
    line, places = np.full((6, 3), np.nan), np.full(9, np.nan)
    left, right = contact_of(s)
    if not (left and right):
        duration, elapsed = s.due - s.phase_start, s.time - s.phase_start
        line = present_line(s.reference[:], s.swing_height, duration, elapsed)
        places[:3], places[3] = s.target[:3], s.target[YAW]
    places[4:6], places[6], places[7:] = s.velocity, s.turn_rate, s.slope
    counts = int(s.limited), int(s.steps), int(s.moved_footholds), int(s.clipped_commands)
    return (
        (int(s.mode), left, right, *counts),
        (s.time, s.yaw, s.friction),
        line,
        places,
        (s.grip.copy(), s.external.copy()),
    )
