"""The model-predictive controller as a LeafSystem."""

import numpy as np
from pydrake.systems.framework import Context, EventStatus, State

from drake_linefoot.centroidal import NO_WRENCH, resultants
from drake_linefoot.constants import STANDARD_GRAVITY
from drake_linefoot.estimation.wrench_estimate import half_the_weight
from drake_linefoot.fields import is_multiple
from drake_linefoot.leaf_system import read_signal, weak
from drake_linefoot.mpc.condensed_qp import Constants
from drake_linefoot.mpc.parameters import MpcParameters
from drake_linefoot.mpc.planner import Planner, Setting
from drake_linefoot.robot.dynamics import robot_dynamics
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.robot.scaling import scaled
from drake_linefoot.signals import CentroidalPlan
from drake_linefoot.statuses import Solved
from drake_linefoot.tunable_block import TunableBlock

_SIGNALS = ("dynamics", "reference")
_NOTHING = 0.01  # [-] of the weight: OSQP leaves a tenth of a newton


class EcdMpc(TunableBlock[MpcParameters, Constants]):
    """Plans wrenches and centroidal motion over a horizon, (40)-(48).

    .. pydrake_system::

        name: EcdMpc
        input_ports:
        - dynamics
        - reference
        output_ports:
        - plan

    Weights and friction are numeric parameters.
    Updates every `period`, and every `run_period` while its plan has a flight. The plan is the
    discrete state and holds in between. It starts as the one of a robot that stands still, which
    holds for the first tick. When the program is not solved, the previous plan goes on and the
    failure is counted in the plan.
    With `MpcParameters.late` it starts from the state that the previous plan leads to, in which
    it will begin to be used. Raises SignalError for an input that is not finite.
    """

    def __init__(self, humanoid: Humanoid, parameters: MpcParameters) -> None:
        """Declare ports, state and events.

        Args:
            humanoid: the robot.
            parameters: of the MPC.

        Raises:
            InputError: the parameters name an unknown solver or model.
        """
        super().__init__()
        self.set_name("ecd_mpc")
        parameters = scaled(parameters, humanoid)
        self.setting = Setting(parameters, humanoid.mass, humanoid.contact, humanoid.sizes)
        self._planner = Planner(self.setting)
        self.declare_parameters(parameters, self._planner.constants)
        of = self._planner.layouts
        self.signals = [(self.signal_input(name, of[name]), of[name]) for name in _SIGNALS]
        self.layouts["plan"] = of["plan"]
        standing = of["plan"].vector(standing_plan(humanoid, parameters))
        self.DeclareStateOutputPort("plan", self.DeclareDiscreteState(standing))
        self._period = parameters.period
        self.DeclarePeriodicUnrestrictedUpdateEvent(
            parameters.shortest_period, 0.0, weak(self, self._update)
        )

    def _update(self, context: Context, state: State) -> EventStatus:
        layout = self.layouts["plan"]
        previous = layout.open(context.get_discrete_state_vector().value().copy())
        if not is_multiple(context.get_time(), self._period) and not has_flight(previous):
            return EventStatus.DidNothing()
        d, reference = (read_signal(self, port, context, layout) for port, layout in self.signals)
        plan = self._planner.plan(d, reference, previous, self.constants_in(context))
        state.get_mutable_discrete_state().set_value(layout.vector(plan))
        return EventStatus.Succeeded()


def has_flight(plan: CentroidalPlan) -> bool:
    """Return whether no foot bears anything in some interval of a plan."""
    return bool(np.any(plan.force[:, 2] < _NOTHING * plan.mass * STANDARD_GRAVITY))


def standing_plan(humanoid: Humanoid, parameters: MpcParameters) -> CentroidalPlan:
    """Return the plan of a robot that stands still in its nominal posture.

    Half the weight on each foot; it asks for no motion, wherever the robot stands.
    """
    K, mass = parameters.knots, humanoid.mass
    d = robot_dynamics(humanoid, humanoid.scratch, humanoid.x_nominal)
    states = np.zeros((K + 1, 12))
    states[:, :3] = d.p_WG
    wrench = np.tile(half_the_weight(mass, humanoid.contact.size), (K, 1, 1))
    p_WC, R_WC = np.tile(d.p_WC, (K, 1, 1)), np.tile(np.eye(3), (K, 2, 1, 1))
    force, moment = resultants(wrench, p_WC, R_WC, d.p_WG)
    return CentroidalPlan(
        times=parameters.knot_step * np.arange(K + 1.0),
        wrench=wrench,
        force=force,
        moment=moment,
        states=states,
        r_G=d.p_WG,
        mass=mass,
        p_WC=p_WC,
        R_WC=R_WC,
        coming=0.0,
        footholds=np.zeros((K + 1, 4)),
        external=NO_WRENCH,
        status=float(Solved.GIVEN),
        active=0.0,
        iterations=0.0,
        milliseconds=0.0,
        failures=0.0,
    )
