"""The whole-body controller as a LeafSystem."""

from collections.abc import Sequence

from pydrake.systems.framework import BasicVector, Context

from drake_linefoot.leaf_system import read_vector, weak
from drake_linefoot.parts import KNOTS
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.robot.scaling import scaled
from drake_linefoot.tunable_block import TunableBlock
from drake_linefoot.wbc.constants import Packed
from drake_linefoot.wbc.control import WholeBodyControl
from drake_linefoot.wbc.parameters import WbcParameters
from drake_linefoot.wbc.tasks.task import Task


class WholeBodyController(TunableBlock[WbcParameters, Packed]):
    """Turns the plan into joint torques, (49)-(53).

    .. pydrake_system::

        name: WholeBodyController
        input_ports:
        - dynamics
        - targets
        - plan
        output_ports:
        - torque
        - report

    Gains and weights are numeric parameters.
    Stateless: the report is computed once per tick, inside the plant's step, and the torque is
    taken from it. When the wrench program is not solved, the MPC's wrench is moved into
    the cone and the report says so. Raises SignalError for an input that is not finite.
    """

    def __init__(
        self,
        humanoid: Humanoid,
        parameters: WbcParameters,
        knots: int = KNOTS,
        tasks: Sequence[Task] = (),
    ) -> None:
        """Declare the ports.

        Args:
            humanoid: the robot.
            parameters: gains and weights.
            knots: intervals of the plans.
            tasks: of one's own, beside those of this package.

        Raises:
            InputError: the parameters name an unknown solver, or a task does not fit the robot.
        """
        super().__init__()
        self.set_name("whole_body_controller")
        parameters = scaled(parameters, humanoid)
        self._control = WholeBodyControl(humanoid, parameters, knots, tasks)
        c = self._control
        self._dynamics = self.signal_input("dynamics", c.dynamics)
        self._targets = self.signal_input("targets", c.targets)
        self._plan = self.signal_input("plan", c.plan)
        inputs = {self._dynamics.ticket(), self._targets.ticket(), self._plan.ticket()}
        inputs.add(self.declare_parameters(parameters, c.packed))
        self.DeclareVectorOutputPort(
            "torque", humanoid.na, weak(self, self._calc_torque), prerequisites_of_calc=inputs
        )
        self._report = self.signal_output("report", c.report, self._calc_report, inputs)

    def _calc_report(self, context: Context, output: BasicVector) -> None:
        c = self._control
        dynamics = read_vector(self, self._dynamics, context, c.dynamics)
        targets = read_vector(self, self._targets, context, c.targets)
        plan = read_vector(self, self._plan, context, c.plan)
        output.SetFromVector(c.compute(dynamics, targets, plan, self.constants_in(context)))

    def _calc_torque(self, context: Context, output: BasicVector) -> None:
        report = self._control.report.open(self._report.Eval(context))
        output.SetFromVector(report.torque)
