"""The whole-body controller as a LeafSystem."""

import numpy as np
from pydrake.common.value import AbstractValue
from pydrake.systems.framework import (
    BasicVector,
    Context,
    InputPort,
    OutputPort,
)

from drake_linefoot.leaf_system import Block, read_signal, weak
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.robot.state_dynamics import read_dynamics
from drake_linefoot.signals import CentroidalPlan, GaitTargets, WholeBodyReport
from drake_linefoot.wbc.control import WholeBodyControl
from drake_linefoot.wbc.parameters import WbcParameters


class WholeBodyController(Block):
    """Turns the plan into joint torques, (49)-(53).

    | port | type | shape | unit |
    |---|---|---|---|
    | dynamics | RobotDynamics | - | of the state |
    | targets | GaitTargets | - | of the gait planner |
    | plan | CentroidalPlan | - | of the MPC |
    | torque | vector | na | N m, within the effort limits |
    | report | WholeBodyReport | - | wrenches, errors, solver |

    Stateless: the report is computed once per tick, inside the plant's step, and the torque is
    taken from it. When the wrench program is not solved, the MPC's wrench is moved into
    the cone and the report says so. Raises SignalError for a non-finite state and for an object
    of another type.
    """

    def __init__(self, humanoid: Humanoid, parameters: WbcParameters) -> None:
        """Declare the ports.

        Args:
            humanoid: the robot.
            parameters: gains and weights.

        Raises:
            InputError: the parameters name an unknown solver.
        """
        super().__init__()
        self.set_name("whole_body_controller")
        self._control = WholeBodyControl(humanoid, parameters)
        self._dynamics = self.DeclareAbstractInputPort("dynamics", AbstractValue.Make(object()))
        self._targets = self.DeclareAbstractInputPort("targets", AbstractValue.Make(object()))
        self._plan = self.DeclareAbstractInputPort("plan", AbstractValue.Make(object()))
        inputs = {self._dynamics.ticket(), self._targets.ticket(), self._plan.ticket()}
        empty = _empty_report(humanoid)
        self._torque = self.DeclareVectorOutputPort(
            "torque", humanoid.na, weak(self, self._calc_torque), prerequisites_of_calc=inputs
        )
        self._report = self.DeclareAbstractOutputPort(
            "report",
            lambda: AbstractValue.Make(empty),
            weak(self, self._calc_report),
            prerequisites_of_calc=inputs,
        )

    def get_dynamics_input_port(self) -> InputPort:
        """Quantities of the robot's state."""
        return self._dynamics

    def get_targets_input_port(self) -> InputPort:
        """Targets of the gait."""
        return self._targets

    def get_plan_input_port(self) -> InputPort:
        """Plan of the MPC."""
        return self._plan

    def get_torque_output_port(self) -> OutputPort:
        """Joint torques."""
        return self._torque

    def get_report_output_port(self) -> OutputPort:
        """What was done."""
        return self._report

    def _calc_report(self, context: Context, output: AbstractValue) -> None:
        d = read_dynamics(self, self._dynamics, context)
        targets = read_signal(self, self._targets, context, GaitTargets)
        plan = read_signal(self, self._plan, context, CentroidalPlan)
        output.set_value(self._control.compute(d, targets, plan))

    def _calc_torque(self, context: Context, output: BasicVector) -> None:
        report: WholeBodyReport = self._report.Eval(context)
        output.SetFromVector(report.torque)


def _empty_report(humanoid: Humanoid) -> WholeBodyReport:
    """Return a report of nothing, to size the port with."""
    return WholeBodyReport(
        torque=np.zeros(humanoid.na),
        wrench=np.zeros((2, 5)),
        wrench_error=np.zeros((2, 5)),
        acceleration_error=np.zeros(6),
        vdot=np.zeros(humanoid.nv),
        success=False,
        status="not yet solved",
        dropped_rows=0,
        clipped=0,
        milliseconds=0.0,
    )
