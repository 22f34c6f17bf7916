"""One tick of the whole-body controller as a plain function call."""

from __future__ import annotations

import time
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from drake_linefoot.math.active_set import STEPS
from drake_linefoot.robot.dynamics import GRAVITY, RobotDynamics, SharedDynamics
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.signals import CentroidalPlan, GaitTargets, PlanSample, WholeBodyReport
from drake_linefoot.wbc import tasks as rows
from drake_linefoot.wbc.kernels import joint_torque
from drake_linefoot.wbc.parameters import WbcParameters
from drake_linefoot.wbc.priorities import RANK_TOLERANCE, TaskRows
from drake_linefoot.wbc.stop_kernels import Stops
from drake_linefoot.wbc.tick_kernels import LineConstants, line_acceleration, line_tick
from drake_linefoot.wbc.wrench_qp import WrenchQp, active_rows

Array = NDArray[np.float64]

_NO_SWING = np.zeros((0, 3))
# Rows of standing feet, by whether left and right stand: a slice is faster than a list.
_SIDES = {
    (True, True): slice(0, 2), (True, False): slice(0, 1),
    (False, True): slice(1, 2), (False, False): slice(0, 0),
}  # fmt: skip


class WholeBodyControl:
    """State and plans in, joint torques out: (49)-(53).

    Attributes:
        wrench_qp: the program (49).
        dynamics: gives the quantities of a state.
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
        self.dynamics = dynamics or SharedDynamics(humanoid)
        self.wrench_qp = WrenchQp(parameters, humanoid.mass, humanoid.half_length)
        p, h = parameters, humanoid
        arm_goal = h.q_nominal[h.arm_q]
        kp, kd = p.arm_position_gain, p.arm_velocity_gain
        self._arms = rows.JointTask(h.arm_v, h.arm_q, arm_goal, kp, kd, h.nv)
        gains = (
            p.com_position_gain, p.com_velocity_gain, p.angular_momentum_gain,
            p.swing_position_gain, p.swing_velocity_gain, kp, kd, p.contact_velocity_gain,
        )  # fmt: skip
        self._constants = LineConstants(
            gains, (h.arm_q, h.arm_v, arm_goal), leg_stops(h, p), RANK_TOLERANCE,
            self.wrench_qp.program_terms, (h.actuated_v, h.effort_limits), GRAVITY,
        )  # fmt: skip

    def compute(self, x: Array, targets: GaitTargets, plan: CentroidalPlan) -> WholeBodyReport:
        """Return torques and how they came about.

        Args:
            x: state [q, v], shape (nq + nv,).
            targets: which feet stand, and where the swing foot should be.
            plan: the MPC's plan.
        """
        started = time.perf_counter()
        d = self.dynamics(x)
        report = self.at_once(d, targets, plan, started)
        return report or self.step_by_step(d, targets, plan, started)

    def at_once(
        self, dynamics: RobotDynamics, targets: GaitTargets, plan: CentroidalPlan, started: float
    ) -> WholeBodyReport | None:
        """Return what `step_by_step` does, from one call of compiled code; None where it cannot.

        It leaves programs to it that need a solver.

        Args:
            dynamics: present quantities.
            targets: which feet stand, and where the swing foot should be.
            plan: the MPC's plan.
            started: when the tick began, by `time.perf_counter` [s].
        """
        d, swing = dynamics, targets.swing
        if not any(targets.contact):
            return None
        torque, wrench, error, delta_f, vdot, (dropped, active, clipped), found = line_tick(
            (d.M, d.q, d.v, d.Cv, d.tau_g), (d.A, d.base, d.p_WG), (d.J, d.lines, d.R_WC),
            targets.contact, targets.time, plan.for_ticks,
            _NO_SWING if swing is None else swing.motion, targets.slope, self._constants, STEPS,
        )  # fmt: skip
        if not found:
            return None
        return WholeBodyReport(
            torque=torque,
            wrench=wrench,
            wrench_error=error,
            acceleration_error=delta_f,
            vdot=vdot,
            success=True,
            status=active_rows(active),
            dropped_rows=dropped,
            clipped=clipped,
            milliseconds=1e3 * (time.perf_counter() - started),
        )

    def step_by_step(
        self, dynamics: RobotDynamics, targets: GaitTargets, plan: CentroidalPlan, started: float
    ) -> WholeBodyReport:
        """Return torques and how they came about, one part of the tick after the other.

        Args:
            dynamics: present quantities.
            targets: which feet stand, and where the swing foot should be.
            plan: the MPC's plan.
            started: when the tick began, by `time.perf_counter` [s].

        Raises:
            numpy.linalg.LinAlgError: the mass matrix is not positive definite.
        """
        h, d = self._humanoid, dynamics
        sample = plan.sample(targets.time, GRAVITY)
        sides = [i for i in (0, 1) if targets.contact[i]]
        contacts = self.contacts(d, sides)
        vdot, dropped = self.acceleration(contacts, targets, sample)
        standing = _SIDES[targets.contact]
        solution = self.wrench_qp.solve(
            contacts, vdot, sides, sample.wrench[standing], targets.slope
        )
        wrench, error = solution.wrench, solution.delta_fr
        if len(sides) < 2:
            wrench, error = _of_both(wrench, standing), _of_both(error, standing)
        torque, clipped = joint_torque(
            d.M, vdot, solution.delta_f, d.Cv, d.tau_g, d.J, wrench, h.actuated_v, h.effort_limits
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

    def acceleration(
        self, dynamics: RobotDynamics, targets: GaitTargets, sample: PlanSample
    ) -> tuple[Array, int]:
        """Return the acceleration that meets `tasks`, shape (nv,), and how many rows it drops.

        The rows are put together in compiled code; what they are, `tasks` says. Joints of
        the legs are kept off their stops, see `kept_off_stops`.

        Raises:
            numpy.linalg.LinAlgError: the mass matrix is not positive definite.
        """
        c, d, swing = self._constants, dynamics, targets.swing
        vdot, dropped, positive = line_acceleration(
            d.M, d.q, d.v, (d.A, d.base, d.p_WG), (d.J, d.lines, d.R_WC), targets.contact,
            sample.motion, _NO_SWING if swing is None else swing.motion,
            self._humanoid.mass, c.gains, c.arms, c.stops, c.tolerance,
        )  # fmt: skip
        if not positive:
            raise np.linalg.LinAlgError("the mass matrix is not positive definite")
        return vdot, dropped

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


def leg_stops(humanoid: Humanoid, parameters: WbcParameters) -> Stops:
    """Return the stops of both legs, with the margin and the rate of the parameters."""
    lower, upper = np.full(humanoid.nq, -np.inf), np.full(humanoid.nq, np.inf)
    lower[humanoid.actuated_q] = humanoid.position_lower + parameters.stop_margin
    upper[humanoid.actuated_q] = humanoid.position_upper - parameters.stop_margin
    legs, rate = humanoid.leg_q, float(parameters.stop_rate)
    return Stops(legs, humanoid.leg_v, lower[legs], upper[legs], rate)


def _of_both(values: Array, rows: slice) -> Array:
    """Return values of standing feet, shape (n, 5), as those of both, zero in the air, (2, 5)."""
    out = np.zeros((2, 5))
    out[rows] = values
    return out
