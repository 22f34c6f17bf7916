"""The tasks of the whole-body controller, in the order of their priority."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from drake_linefoot.robot.dynamics import RobotDynamics
from drake_linefoot.signals import PlanSample, SwingTarget
from drake_linefoot.wbc.kernels import momentum_wish, swing_wish
from drake_linefoot.wbc.parameters import WbcParameters
from drake_linefoot.wbc.priorities import TaskRows

Array = NDArray[np.float64]
Indices = NDArray[np.int64]


def contact_task(dynamics: RobotDynamics, sides: Sequence[int], damping: float) -> TaskRows:
    """Keep the lines of standing feet where they are: ``J_c vdot = -Jdot_c v - k J_c v``.

    Args:
        dynamics: present quantities.
        sides: standing feet.
        damping: k [1/s].

    Returns:
        Five rows for each standing foot.
    """
    if not sides:
        return TaskRows(np.zeros((0, len(dynamics.v))), np.zeros(0))
    feet = [dynamics.feet[i] for i in sides]
    J = np.concatenate([foot.J for foot in feet])
    b = -np.concatenate([foot.Jdot_v for foot in feet])
    if damping:
        b -= damping * (J @ dynamics.v)
    return TaskRows(J, b)


def momentum_task(
    dynamics: RobotDynamics, plan: PlanSample, mass: float, parameters: WbcParameters
) -> TaskRows:
    """Follow the plan's angular and linear momentum, (52), (53).

    Args:
        dynamics: present quantities.
        plan: the centroidal plan now.
        mass: [kg].
        parameters: gains.

    Returns:
        Six rows, angular over linear.
    """
    d, p = dynamics, parameters
    gains = (p.com_position_gain, p.com_velocity_gain, p.angular_momentum_gain)
    b = momentum_wish(mass, gains, plan.motion, d.p_WG, d.v_WG, d.A, d.v, d.Adot_v)
    return TaskRows(d.A, b)


def swing_task(
    dynamics: RobotDynamics, side: int, target: SwingTarget, parameters: WbcParameters
) -> TaskRows:
    """Follow position and direction of the swing foot's contact line.

    Args:
        dynamics: present quantities.
        side: the swing foot.
        target: where it should be.
        parameters: gains.

    Returns:
        Five rows: position, and the turn across the line.
    """
    d, p = dynamics, parameters
    kp, kd = p.swing_position_gain, p.swing_velocity_gain
    b = swing_wish(kp, kd, target.motion, d.lines[side], d.R_WC[side])
    return TaskRows(d.J[side], b)


class JointTask:
    """Hold joints at given angles."""

    def __init__(
        self, index_v: Indices, index_q: Indices, q_d: Array, kp: float, kd: float, nv: int
    ) -> None:
        """Keep what does not change.

        Args:
            index_v: where the joints stand in v, shape (m,).
            index_q: where they stand in q, shape (m,).
            q_d: desired angles [rad], shape (m,).
            kp: [1/s^2].
            kd: [1/s].
            nv: number of velocities.
        """
        self._index_v, self._index_q, self._q_d = index_v, index_q, q_d
        self._kp, self._kd = kp, kd
        self._J = np.zeros((len(index_v), nv))
        self._J[np.arange(len(index_v)), index_v] = 1.0

    def rows(self, dynamics: RobotDynamics) -> TaskRows:
        """Return one row for each joint."""
        q, v = dynamics.q[self._index_q], dynamics.v[self._index_v]
        return TaskRows(self._J, self._kp * (self._q_d - q) - self._kd * v)
