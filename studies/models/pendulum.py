"""A walk without MPC: the plan of a point mass that tracks the divergent component of motion.

With r the CoM, r_d the gait's, xi = r + r' / omega and p the point that the ground's force goes
through on its way to the CoM,

    p = xi - xi_d' / omega + (k / omega) (xi - xi_d),    r'' = omega^2 (r - p)  in x and y,

on the feet as near as they let it be. The planned angular momentum is zero; the torso is held by
a spring and a damper, whose moment goes with the force.
"""

from typing import NamedTuple

import numpy as np
from pydrake.systems.framework import Context, LeafSystem, State

from drake_linefoot.centroidal import resultants
from drake_linefoot.constants import GRAVITY, STANDARD_GRAVITY
from drake_linefoot.leaf_system import read_signal, weak
from drake_linefoot.math.rotation import rotation_error
from drake_linefoot.mpc.ecd_mpc import standing_plan
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.signals import CentroidalPlan, Reference, RobotDynamics, layouts
from drake_linefoot.wiring.parameters import ParametersOfBlocks
from studies.common.types import Array

FEEDBACK = 5.0  # [1/s] k, at which errors of xi go away
HEIGHT = (100.0, 20.0)  # [1/s^2, 1/s] of the CoM's height
TORSO = (100.0, 20.0)  # [1/s^2, 1/s] of its orientation, by its inertia


class PendulumPlan(LeafSystem):
    """Takes the place of the MPC: same ports, updated as often.

    .. pydrake_system::

        name: PendulumPlan
        input_ports:
        - dynamics
        - reference
        output_ports:
        - plan
    """

    def __init__(self, humanoid: Humanoid, parameters: ParametersOfBlocks) -> None:
        """Declare ports, state and events; parameters in the size of the robot."""
        super().__init__()
        self.set_name("pendulum_plan")
        of, p = layouts(humanoid.sizes, parameters.mpc.knots), parameters.mpc
        self._plan, self._of = of["plan"], (of["dynamics"], of["reference"])
        self._half_length = humanoid.half_length
        self._in = tuple(
            self.DeclareVectorInputPort(name, layout.size)
            for name, layout in zip(("dynamics", "reference"), self._of, strict=True)
        )
        self._standing = standing_plan(humanoid, p)
        state = self.DeclareDiscreteState(self._plan.vector(self._standing))
        self.DeclareStateOutputPort("plan", state)
        self.DeclarePeriodicUnrestrictedUpdateEvent(p.period, 0.0, weak(self, self._update))

    def _update(self, context: Context, state: State) -> None:
        d, reference = (
            read_signal(self, port, context, layout)
            for port, layout in zip(self._in, self._of, strict=True)
        )
        plan = pendulum_plan(d, reference, self._standing, self._half_length)
        state.get_mutable_discrete_state().set_value(self._plan.vector(plan))


def pendulum_plan(
    d: RobotDynamics, ref: Reference, standing: CentroidalPlan, half_length: float
) -> CentroidalPlan:
    """Return the plan of the pendulum from the present state.

    Args:
        d: of the present state.
        ref: what the gait asks for.
        standing: any plan of the robot; what the pendulum does not decide is its.
        half_length: of a foot [m].
    """
    m, K = standing.mass, len(ref.contact)
    omega = np.sqrt(STANDARD_GRAVITY / max(d.p_WG[2] - ref.p_WC[0, :, 2].min(), 1e-3))
    moment = torso_moment(d, ref)
    r, v = d.p_WG.copy(), d.v_WG.copy()
    states, wrench = np.zeros((K + 1, 12)), np.zeros_like(standing.wrench)
    states[0, :6] = *r, *v
    for k, h in enumerate(ref.dt):
        on = nearest(tracking_point(r, v, ref, k, omega), ref, k, half_length)
        a = omega**2 * (r - on.p)
        a[2] = HEIGHT[0] * (ref.r_mid[k, 2] - r[2]) + HEIGHT[1] * (ref.v_mid[k, 2] - v[2])
        wrench[k] = shared(m * (a - GRAVITY), moment, on, ref.R_WC[k], half_length, wrench.shape[2])
        mean = wrench[k, :, :3].sum(axis=0) / m + GRAVITY
        r, v = r + h * v + 0.5 * h**2 * mean, v + h * mean
        states[k + 1, :6] = *r, *v
    total = resultants(wrench, ref.p_WC, ref.R_WC, d.p_WG)
    return standing._replace(
        times=ref.times, wrench=wrench, force=total[0], moment=total[1], states=states, r_G=d.p_WG,
        p_WC=ref.p_WC, R_WC=ref.R_WC, coming=ref.coming, footholds=ref.footholds,
        external=ref.external,
    )  # fmt: skip


def torso_moment(d: RobotDynamics, ref: Reference) -> Array:
    """Return the moment about the CoM that holds the torso as the reference has it [N m]."""
    I_W = d.A[:3, :3]
    tilt = rotation_error(d.R_WB, ref.R[0])
    rate = ref.R_mid[0] @ ref.Omega_mid[0]
    moment: Array = I_W @ (-TORSO[0] * (ref.R[0] @ tilt) - TORSO[1] * (d.v[:3] - rate))
    return moment


def tracking_point(r: Array, v: Array, ref: Reference, k: int, omega: float) -> Array:
    """Return p of the module for interval k [m], shape (3,)."""
    ahead = ref.v[k + 1] - ref.v[k]
    wanted = ref.r[k] + ref.v[k] / omega
    rate = ref.v_mid[k] + ahead / (omega * ref.dt[k])
    xi = r + v / omega
    p: Array = xi - rate / omega + (FEEDBACK / omega) * (xi - wanted)
    return p


class Pressed(NamedTuple):
    """Where the feet press on the ground."""

    p: Array  # [m], shape (3,); without a foot that stands: as it was asked for
    shares: Array  # of the force, by foot, shape (2,)
    ahead: float  # of the middles of the feet, along them [m]


def nearest(p: Array, ref: Reference, k: int, half_length: float) -> Pressed:
    """Return the place nearest to p, in the plane, that the feet that stand can press on.

    Of one foot its line; of both the strip between them, ahead and behind as far as each.
    """
    shares = np.array(ref.contact[k], dtype=float)
    if not shares.any():
        return Pressed(p, shares, 0.0)
    if shares.all():
        way = (ref.p_WC[k, 1] - ref.p_WC[k, 0])[:2]
        right = np.clip((p - ref.p_WC[k, 0])[:2] @ way / max(way @ way, 1e-9), 0.0, 1.0)
        shares = np.array([1.0 - right, right])
    base, along = shares @ ref.p_WC[k], shares @ ref.R_WC[k, :, :, 0]
    ahead = float(np.clip((p - base) @ along, -half_length, half_length))
    return Pressed(base + ahead * along, shares, ahead)


def shared(
    force: Array, moment: Array, on: Pressed, R_WC: Array, half_length: float, nw: int
) -> Array:
    """Return the wrenches of both feet: the force through p, and the moment as lines can.

    About y of a foot the moment moves the pressure, to toe or heel at most; about z each foot has
    its share; about x a line has none.

    Args:
        force: [N], shape (3,).
        moment: about the CoM, beside that of the force through p [N m], shape (3,).
        on: where the feet press.
        R_WC: contact frames, shape (2, 3, 3).
        half_length: of a foot [m].
        nw: how many numbers the wrench of a foot has.

    Returns:
        Shape (2, nw).
    """
    wrench = np.zeros((2, nw))
    for foot, share in enumerate(on.shares):
        R = R_WC[foot]
        f, local = share * force, share * (R.T @ moment)
        normal = max(float(f @ R[:, 2]), 0.0)
        wrench[foot, :3] = f
        most = half_length * normal
        wrench[foot, 3] = np.clip(local[1] - on.ahead * normal, -most, most)
        wrench[foot, 4] = local[2]
    return wrench
