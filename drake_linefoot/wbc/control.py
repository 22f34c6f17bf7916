"""One tick of the whole-body controller as a plain function call."""

from __future__ import annotations

import time
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from drake_linefoot.robot.dynamics import GRAVITY, RobotDynamics, SharedDynamics
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.signals import CentroidalPlan, GaitTargets, PlanSample, WholeBodyReport
from drake_linefoot.wbc import tasks as rows
from drake_linefoot.wbc.kernels import joint_torque
from drake_linefoot.wbc.parameters import WbcParameters
from drake_linefoot.wbc.priorities import TaskRows, prioritised_acceleration
from drake_linefoot.wbc.wrench_qp import WrenchQp

Array = NDArray[np.float64]


class WholeBodyControl:
    """State and plans in, joint torques out: (49)-(53).

    Attributes:
        wrench_qp: the program (49).
    """

    def __init__(
        self,
        humanoid: Humanoid,
        parameters: WbcParameters,
        dynamics: SharedDynamics | None = None,
    ) -> None:
        """Keep the robot.

        Args:
            humanoid: the robot.
            parameters: gains and weights.
            dynamics: shared with other blocks; its own without.

        Raises:
            InputError: the parameters name an unknown solver.
        """
        self._humanoid, self._parameters = humanoid, parameters
        self._dynamics = dynamics or SharedDynamics(humanoid)
        self.wrench_qp = WrenchQp(parameters, humanoid.mass, humanoid.half_length)
        self._arms = rows.JointTask(
            humanoid.arm_v,
            humanoid.arm_q,
            humanoid.q_nominal[humanoid.arm_q],
            parameters.arm_position_gain,
            parameters.arm_velocity_gain,
            humanoid.nv,
        )

    def compute(self, x: Array, targets: GaitTargets, plan: CentroidalPlan) -> WholeBodyReport:
        """Return torques and how they came about.

        Args:
            x: state [q, v], shape (nq + nv,).
            targets: which feet stand, and where the swing foot should be.
            plan: the MPC's plan.
        """
        started = time.perf_counter()
        h = self._humanoid
        d = self._dynamics(x)
        sample = plan.sample(targets.time, GRAVITY)
        sides = [i for i in (0, 1) if targets.contact[i]]
        contacts = self.contacts(d, sides)
        vdot, dropped = prioritised_acceleration(d.M, self.tasks(contacts, targets, sample))
        solution = self.wrench_qp.solve(contacts, vdot, sides, sample.wrench[sides], targets.slope)
        vdot[:6] += solution.delta_f
        wrench, error = np.zeros((2, 5)), np.zeros((2, 5))
        wrench[sides], error[sides] = solution.wrench, solution.delta_fr
        torque, clipped = joint_torque(
            d.M, vdot, d.Cv, d.tau_g, d.J, wrench, h.actuated_v, h.effort_limits
        )
        return WholeBodyReport(
            torque=torque,
            wrench=wrench,
            wrench_error=error,
            acceleration_error=solution.delta_f,
            vdot=vdot,
            success=solution.success,
            status=solution.status,
            dropped_rows=dropped,
            clipped=clipped,
            milliseconds=1e3 * (time.perf_counter() - started),
        )

    def contacts(self, dynamics: RobotDynamics, sides: Sequence[int]) -> RobotDynamics:
        """Return the quantities with the contacts of this controller: a line at each foot."""
        return dynamics

    def tasks(
        self, dynamics: RobotDynamics, targets: GaitTargets, sample: PlanSample
    ) -> list[TaskRows]:
        """Return the tasks of a tick, highest priority first.

        Args:
            dynamics: of `contacts`.
            targets: which feet stand, and where the swing foot should be.
            sample: the plan now.
        """
        h, p, d = self._humanoid, self._parameters, dynamics
        sides = [i for i in (0, 1) if targets.contact[i]]
        tasks = [self.contact_task(d, sides), rows.momentum_task(d, sample, h.mass, p)]
        if targets.swing is not None:
            tasks.append(rows.swing_task(d, targets.contact.index(False), targets.swing, p))
        tasks.append(self._arms.rows(d))
        return tasks

    def contact_task(self, dynamics: RobotDynamics, sides: Sequence[int]) -> TaskRows:
        """Return the task of standing feet; `dynamics` of `contacts`."""
        return rows.contact_task(dynamics, sides, self._parameters.contact_velocity_gain)
