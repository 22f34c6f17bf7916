"""The model-predictive controller as a LeafSystem."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from pydrake.common.value import AbstractValue
from pydrake.systems.framework import (
    Context,
    EventStatus,
    InputPort,
    OutputPort,
    State,
)

from drake_linefoot.gait.measure import measure_gait
from drake_linefoot.mpc.parameters import MpcParameters
from drake_linefoot.mpc.prediction import predict
from drake_linefoot.mpc.solve import CentroidalMeasurement, MpcSolver
from drake_linefoot.robot.dynamics import GRAVITY, SharedDynamics
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.signals import CentroidalPlan, Reference, SolverReport
from drake_linefoot.systems import Block, read_finite, weak

Array = NDArray[np.float64]


class EcdMpc(Block):
    """Plans wrenches and centroidal motion over a horizon, (40)-(48).

    .. pydrake_system::

        name: EcdMpc
        input_ports:
        - state
        - reference
        output_ports:
        - plan

    | port | type | shape | unit |
    |---|---|---|---|
    | state | vector | nq + nv | Drake's order |
    | reference | Reference | - | of the centroidal reference |
    | plan | CentroidalPlan | - | wrenches [N, N m] and predicted states |

    Updates every `period`; the plan is the abstract state and holds in between. It starts as
    the one of a robot that stands still, which holds for the first tick. When the
    program is not solved, the previous plan goes on and the failure is counted in the plan.
    With `MpcParameters.late` it starts from the state that the previous plan leads to, in which
    it will begin to be used. Raises SignalError for a non-finite state.
    """

    def __init__(
        self,
        humanoid: Humanoid,
        parameters: MpcParameters,
        dynamics: SharedDynamics | None = None,
    ) -> None:
        """Declare ports, state and events.

        Args:
            humanoid: the robot.
            parameters: of the MPC.
            dynamics: shared with other blocks; its own without.

        Raises:
            InputError: the parameters name an unknown solver.
        """
        super().__init__()
        self.set_name("ecd_mpc")
        self._humanoid = humanoid
        self._lead = parameters.lead
        self._solver = MpcSolver(parameters, humanoid.mass, humanoid.half_length)
        self._dynamics = dynamics or SharedDynamics(humanoid)
        self._state = self.DeclareVectorInputPort("state", humanoid.nq + humanoid.nv)
        self._reference = self.DeclareAbstractInputPort("reference", AbstractValue.Make(object()))
        self._standing = standing_plan(humanoid, parameters)
        self._plan_state = self.DeclareAbstractState(AbstractValue.Make(self._standing))
        self._plan = self.DeclareStateOutputPort("plan", self._plan_state)
        self.DeclareInitializationUnrestrictedUpdateEvent(weak(self, self._initialize))
        self.DeclarePeriodicUnrestrictedUpdateEvent(
            parameters.period, 0.0, weak(self, self._update)
        )

    def get_state_input_port(self) -> InputPort:
        """State of the robot."""
        return self._state

    def get_reference_input_port(self) -> InputPort:
        """Reference over the horizon."""
        return self._reference

    def get_plan_output_port(self) -> OutputPort:
        """The plan."""
        return self._plan

    def measure(self, x: Array) -> CentroidalMeasurement:
        """Return the centroidal quantities of a state [q, v]."""
        d = self._dynamics(x)
        return CentroidalMeasurement(r=d.p_WG, v=d.v_WG, L=d.L_G, R_WB=d.R_WB)

    def _initialize(self, context: Context, state: State) -> EventStatus:
        state.get_mutable_abstract_state(int(self._plan_state)).set_value(self._standing)
        return EventStatus.Succeeded()

    def _update(self, context: Context, state: State) -> EventStatus:
        previous: CentroidalPlan = context.get_abstract_state(int(self._plan_state)).get_value()
        x = read_finite(self, self._state, context)
        reference: Reference = self._reference.Eval(context)
        measured, begin = self.measure(x), float(reference.times[0])
        if self._lead:
            w_WB = self._dynamics(x).v[:3]
            measured = predict(measured, w_WB, previous, begin - self._lead, begin)
        plan = self._solver.solve(reference, measured, previous)
        state.get_mutable_abstract_state(int(self._plan_state)).set_value(plan)
        return EventStatus.Succeeded()


def standing_plan(humanoid: Humanoid, parameters: MpcParameters) -> CentroidalPlan:
    """Return the plan of a robot that stands still in its nominal posture.

    Half the weight on each foot; it asks for no motion, wherever the robot stands.
    """
    K, mass = parameters.knots, humanoid.mass
    dynamics = SharedDynamics(humanoid)(humanoid.x_nominal)
    measured = measure_gait(dynamics, (True, True), humanoid.half_length)
    wrench = np.zeros((K, 2, 5))
    wrench[:, :, 2] = 0.5 * mass * -GRAVITY[2]
    states = np.zeros((K + 1, 12))
    states[:, :3] = measured.com
    return CentroidalPlan(
        times=parameters.knot_step * np.arange(K + 1.0),
        wrench=wrench,
        states=states,
        r_G=measured.com,
        mass=mass,
        p_WC=np.tile(measured.feet[:, :3], (K, 1, 1)),
        R_WC=np.tile(np.eye(3), (K, 2, 1, 1)),
        footholds=np.zeros((0, 4)),
        report=SolverReport(True, "standing still, not solved", 0, 0.0),
        failures=0,
    )
