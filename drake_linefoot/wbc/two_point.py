"""The whole-body controller with two point contacts at each foot instead of one line.

What the paper compares its line contact with: a foot has a force at the heel and one at the
toe, six variables with eight inequalities (9), where the line has five with six (18). With

    [v_heel, v_toe] = T J v,    T = [[1, -X (w x e_x)], [1, +X (w x e_x)]]

every point quantity follows from those of the line: the Jacobian of the points is ``T J`` and
the wrench of two forces is ``T' f``. T is 6 x 5, and that has two consequences:

* Five of the six velocities are independent: the two points cannot move apart along the line.
  `independent_point_task` leaves out the toe along the line, so that the stack of tasks keeps
  full row rank and one QR factorisation serves. `contact_task` has all six rows, for
  pseudoinverses, as the paper has it.
* Forces at heel and toe that pull against each other along the line make no wrench: this
  internal force does not show in the motion. The cost of (49) is here that of the line, on the
  resulting wrench, and leaves it undetermined; a small weight draws it to the split in
  proportion to the normal forces (`points_from_wrench`), which is inside both pyramids whenever
  the wrench is inside (18).

Hence both controllers have the same torques. Only where the friction of one point along the line
is used up does the small weight bend the wrench, in proportion to that weight.
"""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drake_linefoot.contact.cone_kernels import LEVEL, ground_frame
from drake_linefoot.contact.wrench_cone import point_cone
from drake_linefoot.robot.dynamics import FootMotion, RobotDynamics, SharedDynamics
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.signals import CentroidalPlan, GaitTargets, PlanSample, WholeBodyReport
from drake_linefoot.wbc.control import WholeBodyControl
from drake_linefoot.wbc.parameters import WbcParameters
from drake_linefoot.wbc.priorities import TaskRows, prioritised_acceleration
from drake_linefoot.wbc.wrench_qp import (
    BASE,
    ReducedProgram,
    WrenchQp,
    WrenchSolution,
    falling,
    inside_cones,
    minimise,
    reduce_program,
)

Array = NDArray[np.float64]

INTERNAL_WEIGHT = 1e-6  # [-] of Q_1 on forces: what the internal force costs
_DIAGONAL = (np.arange(6), np.tile(np.arange(3), 2))
_SIGNS = np.array([-1.0, 1.0])  # e_y x e_x = -e_z, e_z x e_x = e_y


@dataclass(frozen=True)
class TwoPointSolution(WrenchSolution):
    """What the program decided, with the forces behind the wrenches.

    Attributes:
        forces: at heel and toe of each standing foot, in W [N], shape (n, 2, 3).
    """

    forces: Array


@dataclass(frozen=True)
class PointFoot(FootMotion):
    """Motion of a foot whose heel and toe are the contacts.

    `J` and `Jdot_v` are of heel and toe in W, shapes (6, nv) and (6,). The acceleration that
    points have from turning, ``w x (w x d)``, is left out, as it is for the line: it is 0 for a
    line that does not turn.

    Attributes:
        T: what makes them of the line's, shape (6, 5).
        J_independent: heel x y z and toe y z in the contact frame, shape (5, nv).
        Jdot_v_independent: likewise, shape (5,).
    """

    T: Array
    J_independent: Array
    Jdot_v_independent: Array


def point_map(R_WC: Array, half_length: float) -> Array:
    """Return T: velocities of heel and toe in W from the line's five, shape (6, 5).

    Args:
        R_WC: contact frame, shape (3, 3).
        half_length: X [m].
    """
    T = np.zeros((6, 5))
    T[_DIAGONAL] = 1.0
    turn = half_length * R_WC[:, [2, 1]] * _SIGNS  # X w x e_x for w_y and w_z
    T[:3, 3:] = -turn
    T[3:, 3:] = turn
    return T


def point_foot(foot: FootMotion, half_length: float) -> PointFoot:
    """Return the motion of heel and toe; `half_length` is X [m]."""
    T = point_map(foot.R_WC, half_length)
    to_five = np.zeros((5, 6))
    to_five[:3, :3] = foot.R_WC.T
    to_five[3:, 3:] = foot.R_WC[:, 1:].T
    J, bias = T @ foot.J, T @ foot.Jdot_v
    return PointFoot(
        p_WC=foot.p_WC,
        R_WC=foot.R_WC,
        v_WC=foot.v_WC,
        w_WF=foot.w_WF,
        J=J,
        Jdot_v=bias,
        T=T,
        J_independent=to_five @ J,
        Jdot_v_independent=to_five @ bias,
    )


def point_contacts(
    dynamics: RobotDynamics, sides: Sequence[int], half_length: float
) -> RobotDynamics:
    """Return the quantities with heel and toe as the contacts of standing feet.

    Args:
        dynamics: with a line as the contact of each foot.
        sides: standing feet; their `feet` become `PointFoot`.
        half_length: X [m].
    """
    left, right = (
        point_foot(foot, half_length) if i in sides else foot
        for i, foot in enumerate(dynamics.feet)
    )
    points = copy(dynamics)
    vars(points)["feet"] = left, right  # which are else made of the lines when asked for
    return points


def independent_point_task(
    dynamics: RobotDynamics, sides: Sequence[int], damping: float
) -> TaskRows:
    """Keep heel and toe of standing feet where they are, by five independent rows for each foot.

    Args:
        dynamics: of `point_contacts`.
        sides: standing feet.
        damping: of what a standing foot still moves [1/s].
    """
    nv = len(dynamics.v)
    if not sides:
        return TaskRows(np.zeros((0, nv)), np.zeros(0))
    feet = _standing(dynamics, sides)
    J = np.vstack([foot.J_independent for foot in feet])
    bias = np.concatenate([foot.Jdot_v_independent for foot in feet])
    return TaskRows(J, -bias - damping * (J @ dynamics.v))


def _standing(dynamics: RobotDynamics, sides: Sequence[int]) -> list[PointFoot]:
    """Return the standing feet; they must be of `point_contacts`."""
    feet = [dynamics.feet[i] for i in sides]
    points = [foot for foot in feet if isinstance(foot, PointFoot)]
    if len(points) != len(feet):
        raise TypeError("the quantities of standing feet must be those of point_contacts")
    return points


class TwoPointQp(WrenchQp):
    """The program (49) in the forces at heel and toe; takes quantities of `point_contacts`."""

    def __init__(self, parameters: WbcParameters, mass: float, half_length: float) -> None:
        """Keep the constants; `mass` [kg], `half_length` X [m].

        Raises:
            InputError: the parameters name an unknown solver.
        """
        super().__init__(parameters, mass, half_length)
        self.units = np.full(6, self.units[0])
        self._internal = 0.5 * INTERNAL_WEIGHT * parameters.force_error_weight
        self._pyramid = point_cone(self._mu)
        self._norms = 2.0 * np.array([1.0, 1.0, 1.0, half_length**2, half_length**2])  # of T'T

    def solve(
        self,
        dynamics: RobotDynamics,
        vdot_cmd: Array,
        sides: Sequence[int],
        wrench_mpc: Array,
        slope: Array = LEVEL,
    ) -> WrenchSolution:
        """Return the wrenches closest to the MPC's; as `WrenchQp.solve`."""
        if not sides:
            return falling(dynamics, vdot_cmd)
        feet = _standing(dynamics, sides)
        program = self.program(dynamics, vdot_cmd, sides, wrench_mpc, slope)
        delta, success, status = minimise(program, self._solver, self.units)
        forces = program.u + delta.reshape(program.u.shape)
        if not success:
            moved = inside_cones(wrench_mpc, dynamics, sides, self._mu, self._X, slope)
            forces = self._split(feet, moved)
            delta = (forces - program.u).ravel()
        wrench = np.array([f @ foot.T for f, foot in zip(forces, feet, strict=True)])
        return TwoPointSolution(
            wrench=wrench,
            delta_fr=wrench - wrench_mpc,
            delta_f=program.c + program.G @ delta,
            success=success,
            status=status,
            forces=forces.reshape(-1, 2, 3),
        )

    def program(
        self,
        dynamics: RobotDynamics,
        vdot_cmd: Array,
        sides: Sequence[int],
        wrench_mpc: Array,
        slope: Array = LEVEL,
    ) -> ReducedProgram:
        """Return what `solve` solves, for at least one standing foot; arguments as there."""
        feet = _standing(dynamics, sides)
        J_b = np.concatenate([foot.J[:, :BASE] for foot in feet])  # (6 n, 6)
        W = np.zeros((len(feet), 8, 6))
        Q1 = np.zeros((6 * len(feet), 6 * len(feet)))
        for k, foot in enumerate(feet):
            W[k, :4, :3] = W[k, 4:, 3:] = self._pyramid @ ground_frame(foot.R_WC, slope).T
            Q1[6 * k : 6 * k + 6, 6 * k : 6 * k + 6] = self._cost(foot)
        u = self._split(feet, wrench_mpc)
        return reduce_program(dynamics, vdot_cmd, J_b, u, Q1, self.program_terms.Q2, W)

    def _cost(self, foot: PointFoot) -> Array:
        """Return Q_1 of the resulting wrench, and the weight of the internal force."""
        pull = _pull(foot.R_WC)
        cost: Array = (foot.T * self._weights) @ foot.T.T + self._internal * (pull[:, None] * pull)
        return cost

    def _split(self, feet: Sequence[PointFoot], wrench: Array) -> Array:
        """Return forces in W that make the wrenches (`points_from_wrench`), shape (n, 6)."""
        forces = np.empty((len(feet), 6))
        for row, foot, w in zip(forces, feet, wrench, strict=True):
            f_x, f_z = w[:3] @ foot.R_WC[:, 0], w[:3] @ foot.R_WC[:, 2]
            internal = -0.5 * f_x * w[3] / (self._X * f_z) if f_z != 0.0 else 0.0
            row[:] = foot.T @ (w / self._norms) + internal * _pull(foot.R_WC)
        return forces


def _pull(R_WC: Array) -> Array:
    """Return forces at heel and toe that pull the line apart, one unit each, shape (6,)."""
    return np.concatenate([-R_WC[:, 0], R_WC[:, 0]])


class TwoPointControl(WholeBodyControl):
    """The whole-body controller, with heel and toe as the contacts."""

    def __init__(
        self,
        humanoid: Humanoid,
        parameters: WbcParameters,
        dynamics: SharedDynamics | None = None,
    ) -> None:
        """Keep the robot; as `WholeBodyControl`.

        Raises:
            InputError: the parameters name an unknown solver.
        """
        super().__init__(humanoid, parameters, dynamics)
        self.wrench_qp = TwoPointQp(parameters, humanoid.mass, humanoid.half_length)

    def at_once(
        self, dynamics: RobotDynamics, targets: GaitTargets, plan: CentroidalPlan, started: float
    ) -> WholeBodyReport | None:
        """Return None: what is compiled has lines for contacts."""
        return None

    def contacts(self, dynamics: RobotDynamics, sides: Sequence[int]) -> RobotDynamics:
        """Return the quantities with the contacts of this controller."""
        return point_contacts(dynamics, sides, self._humanoid.half_length)

    def acceleration(
        self, dynamics: RobotDynamics, targets: GaitTargets, sample: PlanSample
    ) -> tuple[Array, int]:
        """Return the acceleration that meets `tasks`, shape (nv,), and how many rows it drops.

        Joints may come to their stops.
        """
        return prioritised_acceleration(dynamics.M, self.tasks(dynamics, targets, sample))

    def contact_task(self, dynamics: RobotDynamics, sides: Sequence[int]) -> TaskRows:
        """Return the task of standing feet; `dynamics` of `contacts`."""
        return independent_point_task(dynamics, sides, self._parameters.contact_velocity_gain)
