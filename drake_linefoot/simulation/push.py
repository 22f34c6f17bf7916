"""A push on the robot's torso as a LeafSystem."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydrake.common.value import AbstractValue, Value
from pydrake.multibody.math import SpatialForce
from pydrake.multibody.plant import ExternallyAppliedSpatialForce
from pydrake.multibody.tree import RigidBody
from pydrake.systems.framework import BasicVector, Context, LeafSystem

from drake_linefoot.systems import weak

Array = NDArray[np.float64]


class Push(LeafSystem):
    """Pushes one body with a force that lasts for a while.

    .. pydrake_system::

        name: Push
        output_ports:
        - force
        - push

    | port | type | shape | unit |
    |---|---|---|---|
    | force | list of ExternallyAppliedSpatialForce | one | for the plant |
    | push | vector | 3 | N, in W; zero when nothing pushes |

    Force and times are parameters of the Context. The force acts at the body's centre of mass.
    """

    def __init__(self, body: RigidBody) -> None:
        """Declare parameters and ports.

        Args:
            body: of the simulated plant, which is pushed.
        """
        super().__init__()
        self.set_name("push")
        self._body, self._p_BoBcm_B = body.index(), body.default_com()
        self.DeclareNumericParameter(BasicVector(np.zeros(5)))  # force [N], begin, end [s]
        tickets = {self.all_parameters_ticket(), self.time_ticket()}
        self.DeclareAbstractOutputPort(
            "force",
            Value[list[ExternallyAppliedSpatialForce]],
            weak(self, self._calc_force),
            prerequisites_of_calc=tickets,
        )
        self.DeclareVectorOutputPort(
            "push", 3, weak(self, self._calc_push), prerequisites_of_calc=tickets
        )

    def push(self, context: Context, force: ArrayLike, duration: float) -> None:
        """Push from now on; takes the place of a push that is still going on.

        Args:
            context: of this system; its time is now.
            force: in W [N], shape (3,).
            duration: of the push [s].
        """
        now = context.get_time()
        values = np.concatenate([np.asarray(force, dtype=float), [now, now + duration]])
        context.get_mutable_numeric_parameter(0).SetFromVector(values)

    def _present(self, context: Context) -> Array:
        """Return the force now [N], shape (3,)."""
        *force, begin, end = context.get_numeric_parameter(0).value()
        acts = begin - 1e-9 <= context.get_time() < end - 1e-9
        return np.array(force) if acts else np.zeros(3)

    def _calc_force(self, context: Context, output: AbstractValue) -> None:
        applied = ExternallyAppliedSpatialForce()
        applied.body_index = self._body
        applied.p_BoBq_B = self._p_BoBcm_B
        applied.F_Bq_W = SpatialForce(tau=np.zeros(3), f=self._present(context))
        output.set_value([applied])

    def _calc_push(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(self._present(context))
