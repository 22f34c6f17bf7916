"""The whole-body controller with two point contacts at each foot instead of one line.

What the paper compares its line contact with: a foot has a force at the heel and one at the
toe, six variables with eight inequalities (9), where the line has five with six (18). With

    v_point = T J v,    T = [[1, -X (w x e_x)], [1, +X (w x e_x)]]

every point quantity follows from those of the line: ``J_points = T J`` and the wrench of two
forces is ``T' f``. T is 6 x 5, and that has two consequences:

* Five of the six velocities are independent: the two points cannot move apart along the line.
  `independent_point_task` leaves out the toe along the line, so that the stack of tasks keeps
  full row rank and one QR factorisation serves; `point_task` has all six rows, for a
  pseudoinverse, as the paper has it.
* Forces at heel and toe that pull against each other along the line make no wrench: the
  internal force does not show in the motion. The cost of (49) is here that of the line, on the
  resulting wrench, and leaves it undetermined; a small weight draws it to the split in
  proportion to the normal forces (`points_from_wrench`), which is inside both pyramids whenever
  the wrench is inside (18).

Hence both controllers have the same torques. Only where the friction of one point along the line
is used up does the small weight bend the wrench, in proportion to that weight.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag

from drake_linefoot.contact.wrench_cone import point_cone, points_from_wrench
from drake_linefoot.robot.dynamics import FootMotion, RobotDynamics
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.wbc.control import WholeBodyControl
from drake_linefoot.wbc.parameters import WbcParameters
from drake_linefoot.wbc.priorities import TaskRows
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
_INDEPENDENT = [0, 1, 2, 4, 5]  # heel x y z, toe y z in the contact frame


@dataclass(frozen=True)
class TwoPointSolution(WrenchSolution):
    """What the program decided, with the forces behind the wrenches.

    Attributes:
        forces: at heel and toe of each standing foot, in W [N], shape (n, 2, 3).
    """

    forces: Array


def point_map(R_WC: Array, half_length: float) -> Array:
    """Return T: velocities of heel and toe in W from the line's five, shape (6, 5).

    Args:
        R_WC: contact frame, shape (3, 3).
        half_length: X [m].
    """
    turn = half_length * np.column_stack([-R_WC[:, 2], R_WC[:, 1]])  # X w x e_x for w_y, w_z
    return np.block([[np.eye(3), -turn], [np.eye(3), turn]])


def point_task(
    dynamics: RobotDynamics, sides: Sequence[int], damping: float, half_length: float
) -> TaskRows:
    """Keep heel and toe of standing feet where they are, six rows for each foot.

    The acceleration that the points have from turning, ``w x (w x d)``, is left out, as it is
    for the line: it is 0 for a line that does not turn.

    Args:
        dynamics: present quantities.
        sides: standing feet.
        damping: of what a standing foot still moves [1/s].
        half_length: X [m].

    Returns:
        Rows of rank five for each foot, in the contact frame.
    """
    nv = len(dynamics.v)
    if not sides:
        return TaskRows(np.zeros((0, nv)), np.zeros(0))
    parts = [_foot_rows(dynamics.feet[i], half_length) for i in sides]
    J = np.vstack([part[0] for part in parts])
    bias = np.concatenate([part[1] for part in parts])
    return TaskRows(J, -bias - damping * (J @ dynamics.v))


def independent_point_task(
    dynamics: RobotDynamics, sides: Sequence[int], damping: float, half_length: float
) -> TaskRows:
    """Return `point_task` without the row that depends on the others, five for each foot."""
    task = point_task(dynamics, sides, damping, half_length)
    keep = [6 * k + row for k in range(len(sides)) for row in _INDEPENDENT]
    return TaskRows(task.J[keep], task.b[keep])


def _foot_rows(foot: FootMotion, half_length: float) -> tuple[Array, Array]:
    """Return Jacobian and bias of heel and toe, in the contact frame."""
    T = point_map(foot.R_WC, half_length)
    R_CW = block_diag(foot.R_WC.T, foot.R_WC.T)
    rows = R_CW @ T
    return rows @ foot.J, rows @ foot.Jdot_v


class TwoPointQp(WrenchQp):
    """The program (49) in the forces at heel and toe."""

    def __init__(self, parameters: WbcParameters, mass: float, half_length: float) -> None:
        """Keep the constants; `mass` [kg], `half_length` X [m].

        Raises:
            InputError: the parameters name an unknown solver.
        """
        super().__init__(parameters, mass, half_length)
        self.units = np.full(6, self.units[0])
        self._internal = INTERNAL_WEIGHT * parameters.force_error_weight
        self._pyramids = block_diag(point_cone(self._mu), point_cone(self._mu))

    def solve(
        self, dynamics: RobotDynamics, vdot_cmd: Array, sides: Sequence[int], wrench_mpc: Array
    ) -> WrenchSolution:
        """Return the wrenches closest to the MPC's; as `WrenchQp.solve`."""
        if not sides:
            return falling(dynamics, vdot_cmd)
        program = self.program(dynamics, vdot_cmd, sides, wrench_mpc)
        delta, success, status = minimise(program, self._solver, self.units)
        forces = program.u + delta.reshape(program.u.shape)
        if not success:
            moved = inside_cones(wrench_mpc, dynamics, sides, self._mu, self._X)
            forces = self._split(moved, dynamics, sides)
            delta = (forces - program.u).ravel()
        maps = self._maps(dynamics, sides)
        wrench = np.einsum("nij,ni->nj", maps, forces)
        return TwoPointSolution(
            wrench=wrench,
            delta_fr=wrench - wrench_mpc,
            delta_f=program.c + program.G @ delta,
            success=success,
            status=status,
            forces=forces.reshape(-1, 2, 3),
        )

    def program(
        self, dynamics: RobotDynamics, vdot_cmd: Array, sides: Sequence[int], wrench_mpc: Array
    ) -> ReducedProgram:
        """Return what `solve` solves, for at least one standing foot; arguments as there."""
        feet = [dynamics.feet[i] for i in sides]
        T = self._maps(dynamics, sides)
        J_b = np.hstack([foot.J[:, :BASE].T @ Ti.T for foot, Ti in zip(feet, T, strict=True)])
        Q1 = block_diag(*(self._cost(foot, Ti) for foot, Ti in zip(feet, T, strict=True)))
        W = np.stack([self._pyramids @ block_diag(f.R_WC.T, f.R_WC.T) for f in feet])
        u = self._split(wrench_mpc, dynamics, sides)
        return reduce_program(dynamics, vdot_cmd, J_b, u, Q1, self._Q2, W)

    def _cost(self, foot: FootMotion, T: Array) -> Array:
        """Return Q_1 of the resulting wrench, and the weight of the internal force."""
        e = foot.R_WC[:, 0]
        pull = np.concatenate([-e, e]) * np.sqrt(0.5)
        cost: Array = (T * self._Q1) @ T.T + self._internal * np.outer(pull, pull)
        return cost

    def _maps(self, dynamics: RobotDynamics, sides: Sequence[int]) -> Array:
        """Return T of each standing foot, shape (n, 6, 5)."""
        return np.stack([point_map(dynamics.feet[i].R_WC, self._X) for i in sides])

    def _split(self, wrench: Array, dynamics: RobotDynamics, sides: Sequence[int]) -> Array:
        """Return the forces at heel and toe that make the wrenches, in W, shape (n, 6)."""
        rows = []
        for side, w in zip(sides, wrench, strict=True):
            R = dynamics.feet[side].R_WC
            local = np.concatenate([R.T @ w[:3], w[3:]])
            heel, toe = points_from_wrench(local, self._X, self._mu)
            rows.append(np.concatenate([R @ heel, R @ toe]))
        return np.array(rows)


class TwoPointControl(WholeBodyControl):
    """The whole-body controller, with heel and toe as the contacts."""

    def __init__(self, humanoid: Humanoid, parameters: WbcParameters) -> None:
        """Keep the robot and allocate the scratch context.

        Raises:
            InputError: the parameters name an unknown solver.
        """
        super().__init__(humanoid, parameters)
        self.wrench_qp = TwoPointQp(parameters, humanoid.mass, humanoid.half_length)

    def _contact_task(self, dynamics: RobotDynamics, sides: Sequence[int]) -> TaskRows:
        """Return the task of standing feet, in the velocities of heel and toe."""
        damping = self._parameters.contact_velocity_gain
        return independent_point_task(dynamics, sides, damping, self._humanoid.half_length)
