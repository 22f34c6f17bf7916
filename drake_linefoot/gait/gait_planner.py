"""The gait as a LeafSystem."""

import numpy as np
from pydrake.systems.framework import BasicVector, Context, DiscreteValues

from drake_linefoot.gait.arms import arm_motion
from drake_linefoot.gait.constants import constants_of
from drake_linefoot.gait.contacts import in_contact
from drake_linefoot.gait.horizon import horizon_vector
from drake_linefoot.gait.known_ground import slopes_of
from drake_linefoot.gait.measurement import measure_gait
from drake_linefoot.gait.parameters import GaitParameters
from drake_linefoot.gait.planner import begin, update
from drake_linefoot.gait.state import (
    GAIT,
    YAW,
    GaitConstants,
    GaitState,
    Records,
    gait_state,
    vector_of,
)
from drake_linefoot.gait.swing import present_line
from drake_linefoot.layout import Layout
from drake_linefoot.leaf_system import read_finite, read_vector, weak
from drake_linefoot.math.compiled import compiled
from drake_linefoot.parts import KNOTS
from drake_linefoot.robot.dynamics import dynamics_layout, robot_dynamics
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.robot.scaling import scaled
from drake_linefoot.signals import (
    ContactEstimate,
    GaitHorizon,
    GaitTargets,
    RobotDynamics,
    fill_targets,
)
from drake_linefoot.terrain import TERRAIN, felt_ground
from drake_linefoot.tunable_block import TunableBlock
from drake_linefoot.types import Array

COMMAND_SIZE = 4
_FELT = felt_ground()
_TARGETS = Layout(GaitTargets, {}).size


class GaitPlanner(TunableBlock[GaitParameters, Records]):
    """Decides when which foot stands, where it lands and how it gets there.

    .. pydrake_system::

        name: GaitPlanner
        input_ports:
        - dynamics
        - command
        - contact
        - terrain
        output_ports:
        - targets
        - horizon

    Its `GaitParameters` are numeric parameters.
    Updates every 1 ms; the discrete state is a `GaitState`, stamped with the
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
        knots: int = KNOTS,
    ) -> None:
        """Declare ports, state and events.

        Args:
            humanoid: the robot.
            parameters: of the gait.
            horizon_length: what `horizon` covers [s].
            period: between two updates [s].
            knots: of the MPC over it, between which no foot switches.
        """
        super().__init__()
        self.set_name("gait_planner")
        parameters = scaled(parameters, humanoid)
        tuned = self.declare_parameters(parameters, lambda p: constants_of(p, humanoid))
        self._length = horizon_length
        self._period = period
        self._nw = humanoid.contact.size
        self._of_dynamics = dynamics_layout(humanoid)
        self._of_contact = Layout(ContactEstimate, humanoid.sizes)
        self._dynamics = self.signal_input("dynamics", self._of_dynamics)
        self._command = self.DeclareVectorInputPort("command", COMMAND_SIZE)
        self._contact = self.signal_input("contact", self._of_contact)
        self._terrain = self.signal_input("terrain", TERRAIN)
        nominal = robot_dynamics(humanoid, humanoid.scratch, humanoid.x_nominal)
        standing = self._begin(nominal, 0.0, constants_of(parameters, humanoid))
        standing.clock.initialized = 0
        self.DeclareDiscreteState(vector_of(standing))
        self._knots, after = knots, {self.xd_ticket()}
        horizon = Layout(GaitHorizon, {"knots": knots})
        targets = Layout(GaitTargets, {})
        self.signal_output("targets", targets, self._calc_targets, after | {tuned})
        self.signal_output("horizon", horizon, self._calc_horizon, after | {tuned})
        self.DeclareInitializationDiscreteUpdateEvent(weak(self, self._initialize))
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, weak(self, self._update))

    def gait_state(self, context: Context) -> GaitState:
        """Return a copy of the state of the gait in this system's context."""
        return gait_state(context.get_discrete_state_vector().value().copy())

    def _begin(self, d: RobotDynamics, time: float, constants: Records) -> GaitState:
        c = constants[0]
        return begin(measure_gait(d, np.ones(2), np.zeros((2, self._nw)), c), time, c)

    def _initialize(self, context: Context, discrete: DiscreteValues) -> None:
        if not self.gait_state(context).clock.initialized:
            d = read_vector(self, self._dynamics, context, self._of_dynamics)
            now, c = context.get_time(), self.constants_in(context)
            initial = self._begin(self._of_dynamics.open(d), now, c)
            discrete.set_value(vector_of(initial))

    def _update(self, context: Context, discrete: DiscreteValues) -> None:
        d = read_vector(self, self._dynamics, context, self._of_dynamics)
        command = read_finite(self, self._command, context)
        estimate = read_vector(self, self._contact, context, self._of_contact)
        terrain = _FELT
        if self._terrain.HasValue(context):
            terrain = read_vector(self, self._terrain, context, TERRAIN)
        # The plant has stepped already, so the state belongs to the end of this tick.
        time = context.get_time() + self._period
        after = context.get_discrete_state_vector().value().copy()
        gait, nw, c = np.frombuffer(after, GAIT), self._nw, self.constants_in(context)
        update(gait, command, d, estimate, nw, terrain, time, c)
        discrete.set_value(after)

    def _calc_targets(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(present_targets(_record(context), self.constants_in(context)))

    def _calc_horizon(self, context: Context, output: BasicVector) -> None:
        gait, c = _record(context), self.constants_in(context)
        output.SetFromVector(horizon_vector(gait, c, self._length, self._knots))


def _record(context: Context) -> Records:
    return np.frombuffer(context.get_discrete_state_vector().value().copy(), GAIT)


@compiled
def present_targets(gait: Records, constants: Records) -> Array:
    """Return what holds now, `GaitTargets`, in a state of the gait; arrays of one record each."""
    s: GaitState = gait[0]
    c: GaitConstants = constants[0]
    swing, foothold = np.zeros((2, 6, 3)), np.zeros((2, 4))
    contact, swings = np.ones(2), np.zeros(2)
    for foot in range(2):
        if in_contact(s, foot):
            continue
        start, target = s.clock.lift_off[foot], s.swing.target[foot]
        duration, elapsed = s.clock.planned_touchdown[foot] - start, s.clock.time - start
        reference, height, heel = s.swing.reference[foot], s.swing.height[foot], s.swing.heel[foot]
        swing[foot] = present_line(reference, height, heel, duration, elapsed)
        foothold[foot, :3], foothold[foot, 3] = target[:3], target[YAW]
        contact[foot], swings[foot] = 0.0, 1.0
    command = np.array((s.command.velocity[0], s.command.velocity[1], s.command.turn_rate))
    arms = arm_motion(c.arm_swing, contact, s.robot.feet[:], swing, s.command.yaw)
    says = GaitTargets(
        s.clock.time, contact, s.clock.touchdown[:], s.clock.queued, swings, swing, foothold,
        command, s.command.yaw, slopes_of(s), s.footing.friction, s.footing.friction_shares[:],
        s.robot.external[:], arms, s.command.limited, s.clock.steps, s.recovery.moved_footholds,
        s.command.clipped,
    )  # fmt: skip
    targets = np.empty(_TARGETS)
    fill_targets(targets, says)
    return targets
