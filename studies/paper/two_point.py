"""Two point contacts at each foot instead of one line: tasks and program of the WBC with both.

What the paper compares its line contact with: a foot has a force at the heel and one at the
toe, six variables with eight inequalities (9), where the line has five with six (18). With

    [v_heel, v_toe] = T J v,    T = [[1, -X (w x e_x)], [1, +X (w x e_x)]]

every point quantity follows from those of the line: the Jacobian of the points is ``T J`` and
the wrench of two forces is ``T' f``. T is 6 x 5, and that has two consequences:

* Five of the six velocities are independent: the two points cannot move apart along the line. One
  QR factorisation of the stack of tasks needs full row rank and takes `Foot.five`, which leaves
  out the toe along the line. Pseudoinverses take all six rows, as the paper has it.
* Forces at heel and toe that pull against each other along the line make no wrench: this
  internal force does not show in the motion. The cost of (49) is here that of the line, on the
  resulting wrench, and leaves it undetermined; a small weight draws it to the split in
  proportion to the normal forces (`points_from_wrench`), which is inside both pyramids whenever
  the wrench is inside (18).

Hence both have the same torques. Only where the friction of one point along the line is used up
does the small weight bend the wrench, in proportion to that weight. Neither keeps joints off their
stops.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from drake_linefoot.centroidal import NO_WRENCH, PlanSample
from drake_linefoot.contact.wrench_cone import ground_frame, point_cone, world_cone
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.signals import GaitTargets, RobotDynamics
from drake_linefoot.wbc.control import WholeBodyControl
from drake_linefoot.wbc.parameters import WbcParameters
from drake_linefoot.wbc.priorities import RANK_TOLERANCE
from drake_linefoot.wbc.tasks.momentum import momentum_task
from drake_linefoot.wbc.tasks.posture import joint_task
from drake_linefoot.wbc.tasks.swing import swing_task
from drake_linefoot.wbc.tasks.task import TaskRows
from drake_linefoot.wbc.wrench_qp import WrenchProgram, reduce_base
from studies.common.types import Array

INTERNAL_WEIGHT = 1e-6  # [-] of Q_1 on forces: what the internal force costs


class Foot(NamedTuple):
    """A standing foot with c unknowns, 5 of a line or 6 of two points.

    The acceleration that points have from turning, ``w x (w x d)``, is left out, as it is for the
    line: it is 0 for a line that does not turn.
    """

    R_WC: Array  # contact frame, shape (3, 3)
    rows: TaskRows  # Jacobian of the contact and minus its bias, shapes (c, nv) and (c,)
    five: TaskRows  # independent rows of the same, shapes (5, nv) and (5,)
    T: Array  # what makes them of the line's, shape (c, 5)


class LineContacts:
    """The whole-body controller's tasks and program with a line at each foot."""

    def __init__(self, humanoid: Humanoid, parameters: WbcParameters) -> None:
        """Keep the constants.

        Raises:
            InputError: the parameters name an unknown solver.
        """
        control = WholeBodyControl(humanoid, parameters)
        self.constants, self.solver = control.constants, control.solver
        self.X = humanoid.half_length
        self.units = humanoid.contact.units(humanoid.mass)  # of one foot's unknowns, shape (c,)

    def feet(self, d: RobotDynamics, sides: Sequence[int]) -> list[Foot]:
        """Return the standing feet `sides`."""
        rows = [TaskRows(d.J[side], -d.Jdot_v[side]) for side in sides]
        return [
            Foot(d.R_WC[side], own, own, np.eye(5)) for side, own in zip(sides, rows, strict=True)
        ]

    def tasks(
        self, d: RobotDynamics, contacts: Sequence[TaskRows], targets: GaitTargets, plan: PlanSample
    ) -> list[TaskRows]:
        """Return the tasks of a tick, highest priority first.

        Args:
            d: present quantities.
            contacts: `rows` or `five` of the standing feet.
            targets: which feet stand, and where swing feet should be.
            plan: the centroidal plan now.
        """
        c, damping = self.constants, self.constants.gains.contact_velocity
        tasks = [TaskRows(J, b - damping * (J @ d.v)) for J, b in contacts]
        tasks.append(momentum_task(d, plan, c.mass, c.gains))
        for side in np.flatnonzero(targets.swings):
            tasks.append(
                swing_task(
                    d, int(side), targets.swing_target(int(side)), targets.slope[side], c.gains
                )
            )
        return [*tasks, joint_task(d, c.arms, targets.arms, c.gains)]

    def program(
        self, d: RobotDynamics, vdot: Array, feet: Sequence[Foot], wrench_mpc: Array, slopes: Array
    ) -> WrenchProgram:
        """Return (49) in the unknowns of the feet.

        Args:
            d: present quantities.
            vdot: commanded acceleration, shape (nv,).
            feet: those that stand, at least one.
            wrench_mpc: the MPC's wrench of each of them, shape (n, 5).
            slopes: of the ground below each, rise per metre along x and y of W, shape (n, 2).
        """
        c = len(self.units)
        u = np.array([self.start(foot, w) for foot, w in zip(feet, wrench_mpc, strict=True)])
        W = np.array([self.cone(foot, slope) for foot, slope in zip(feet, slopes, strict=True)])
        J_b, Q1 = np.empty((u.size, 6)), np.zeros((u.size, u.size))
        for k, foot in enumerate(feet):
            own = slice(c * k, c * k + c)
            J_b[own], Q1[own, own] = foot.rows.J[:, :6], self.cost(foot)
        Q2 = self.constants.weights.Q2
        H, g, G, delta_f = reduce_base(d, vdot, J_b, u.ravel(), Q1, Q2, NO_WRENCH)
        return WrenchProgram(H, g, W, u, G, delta_f)

    def start(self, foot: Foot, wrench: Array) -> Array:
        """Return the unknowns that make the MPC's wrench, shape (c,)."""
        return wrench

    def cost(self, foot: Foot) -> Array:
        """Return Q_1 of a foot, shape (c, c)."""
        cost: Array = np.diag(self.constants.weights.Q1)
        return cost

    def cone(self, foot: Foot, slope: Array) -> Array:
        """Return the rows of the cone of a foot, of the unit of a force, shape (r, c)."""
        return world_cone(self.constants.weights.cone, foot.R_WC, slope)


class PointContacts(LineContacts):
    """The same with two points at each foot; the unknowns are the forces in W at heel and toe."""

    def __init__(self, humanoid: Humanoid, parameters: WbcParameters) -> None:
        """Keep the constants; as `LineContacts`."""
        super().__init__(humanoid, parameters)
        self.units = np.full(6, self.units[0])
        self._internal = 0.5 * INTERNAL_WEIGHT * parameters.force_error_weight
        self._pyramid = point_cone(parameters.friction)
        self._norms = 2.0 * np.array([1.0, 1.0, 1.0, self.X**2, self.X**2])  # of T'T

    def feet(self, d: RobotDynamics, sides: Sequence[int]) -> list[Foot]:
        """Return the standing feet `sides`."""
        return [self._foot(line) for line in super().feet(d, sides)]

    def _foot(self, line: Foot) -> Foot:
        T = point_map(line.R_WC, self.X)
        to_five = np.zeros((5, 6))  # heel x y z and toe y z in the contact frame
        to_five[:3, :3] = line.R_WC.T
        to_five[3:, 3:] = line.R_WC[:, 1:].T
        rows = TaskRows(T @ line.rows.J, T @ line.rows.b)
        return Foot(line.R_WC, rows, TaskRows(to_five @ rows.J, to_five @ rows.b), T)

    def start(self, foot: Foot, wrench: Array) -> Array:
        """Return the forces of `points_from_wrench`, shape (6,)."""
        f_x, f_z = wrench[:3] @ foot.R_WC[:, 0], wrench[:3] @ foot.R_WC[:, 2]
        internal = -0.5 * f_x * wrench[3] / (self.X * f_z) if f_z != 0.0 else 0.0
        forces: Array = foot.T @ (wrench / self._norms) + internal * _pull(foot.R_WC)
        return forces

    def cost(self, foot: Foot) -> Array:
        """Return Q_1 of the resulting wrench, and the weight of the internal force, (6, 6)."""
        pull = _pull(foot.R_WC)
        wrench: Array = (foot.T * self.constants.weights.Q1) @ foot.T.T
        return wrench + self._internal * (pull[:, None] * pull)

    def cone(self, foot: Foot, slope: Array) -> Array:
        """Return the rows of both pyramids, shape (8, 6)."""
        pyramid, rows = self._pyramid @ ground_frame(foot.R_WC, slope).T, np.zeros((8, 6))
        rows[:4, :3] = rows[4:, 3:] = pyramid
        return rows


def point_map(R_WC: Array, half_length: float) -> Array:
    """Return T: velocities of heel and toe in W from the line's five, shape (6, 5).

    `R_WC` is the contact frame, shape (3, 3), `half_length` is X [m].
    """
    turn = half_length * np.column_stack([-R_WC[:, 2], R_WC[:, 1]])  # X w x e_x for w_y and w_z
    T: Array = np.block([[np.eye(3), -turn], [np.eye(3), turn]])
    return T


def _pull(R_WC: Array) -> Array:
    """Return forces at heel and toe that pull the line apart, one unit each, shape (6,)."""
    return np.concatenate([-R_WC[:, 0], R_WC[:, 0]])


def recursive_acceleration(M: Array, tasks: Sequence[TaskRows]) -> Array:
    """Return the acceleration that meets tasks in order, by the textbook recursion.

    For each task, ``vdot += Jbar (b - J vdot)`` with Jbar the dynamically consistent pseudoinverse
    of the task projected into the null space of all tasks above, ``N -= Jbar J N``.

    Args:
        M: mass matrix, shape (nv, nv).
        tasks: highest priority first.

    Returns:
        Shape (nv,).
    """
    n = len(M)
    M_inv, vdot, N = np.linalg.inv(M), np.zeros(n), np.eye(n)
    for task in tasks:
        JN = task.J @ N
        Lambda = np.linalg.pinv(JN @ M_inv @ JN.T, rcond=RANK_TOLERANCE**2)
        Jbar = M_inv @ JN.T @ Lambda
        vdot = vdot + Jbar @ (task.b - task.J @ vdot)
        N = N @ (np.eye(n) - Jbar @ JN)
    return vdot
