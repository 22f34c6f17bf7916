"""One update of the MPC, from its signals to its plan: what a block does, here or far away."""

from typing import Any, NamedTuple

from drake_linefoot.contact.contacts import Contact
from drake_linefoot.layout import Layout, Sizes
from drake_linefoot.mpc.condensed_qp import Constants, constants_of
from drake_linefoot.mpc.models.registry import model_named
from drake_linefoot.mpc.parameters import MpcParameters
from drake_linefoot.mpc.prediction import predict
from drake_linefoot.mpc.solve import MpcSolver
from drake_linefoot.signals import CentroidalPlan, Reference, RobotDynamics, layouts

_SIGNALS = ("dynamics", "reference", "plan")


class Setting(NamedTuple):
    """What an MPC is made of, plain data.

    Attributes:
        parameters: in the size of the robot.
        mass: [kg].
        contact: of the feet.
        sizes: of the robot, see `drake_linefoot.signals.layouts`.
    """

    parameters: MpcParameters
    mass: float
    contact: Contact
    sizes: Sizes


class Planner:
    """The MPC of one robot.

    Attributes:
        layouts: of the signals that it takes and of its plan, by name.
    """

    def __init__(self, setting: Setting) -> None:
        """Keep what it is made of.

        Raises:
            InputError: the parameters name an unknown solver or model.
        """
        self._setting, p = setting, setting.parameters
        self._lead, self._measure = p.lead, model_named(p.model).measure
        self._solver = MpcSolver(p, setting.mass, setting.contact)
        of = layouts(setting.sizes, p.knots)
        self.layouts: dict[str, Layout[Any]] = {name: of[name] for name in _SIGNALS}

    def constants(self, parameters: MpcParameters) -> Constants:
        """Return the constants of other weights and friction."""
        return constants_of(parameters, self._setting.mass, self._setting.contact)

    def plan(
        self, d: RobotDynamics, reference: Reference, previous: CentroidalPlan, constants: Constants
    ) -> CentroidalPlan:
        """Return the plan, see `MpcSolver.solve`.

        It starts from the state that was measured, or where it is used later, from the one to
        which the previous plan leads by then.
        """
        measured, begin = self._measure(d), float(reference.times[0])
        if self._lead:
            measured = predict(measured, d.v[:3], previous, begin - self._lead, begin)
        return self._solver.solve(reference, measured, previous, constants)
