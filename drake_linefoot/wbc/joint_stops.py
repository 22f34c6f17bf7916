"""Keeps the joints of a swinging leg off their stops.

A leg that reaches for a place beyond its stops, or stretches its knee, would be asked for ever
larger accelerations: the task of its foot cannot be met there. Near a stop the joint is held off it
instead, and the foot follows its task in the directions in which the other joints can move it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from drake_linefoot.robot.dynamics import RobotDynamics
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.wbc.parameters import WbcParameters
from drake_linefoot.wbc.priorities import TaskRows
from drake_linefoot.wbc.stop_kernels import off_stops

Array = NDArray[np.float64]

_LENGTH = 0.05  # [m] for which a radian of the foot is given up


class JointStops:
    """The stops of both legs."""

    def __init__(self, humanoid: Humanoid, parameters: WbcParameters) -> None:
        """Keep the limits of the joints, less the margin.

        Args:
            humanoid: the robot.
            parameters: `stop_margin` and `stop_rate`.
        """
        lower, upper = np.full(humanoid.nq, -np.inf), np.full(humanoid.nq, np.inf)
        lower[humanoid.actuated_q] = humanoid.position_lower + parameters.stop_margin
        upper[humanoid.actuated_q] = humanoid.position_upper - parameters.stop_margin
        self._legs = [
            (q, v, lower[q], upper[q]) for q, v in zip(humanoid.leg_q, humanoid.leg_v, strict=True)
        ]
        self._rate = parameters.stop_rate

    def crossed(self, dynamics: RobotDynamics, side: int, vdot: Array) -> dict[int, float]:
        """Return which joints of a leg an acceleration takes too fast towards a stop.

        Args:
            dynamics: present state.
            side: of the leg.
            vdot: shape (nv,).

        Returns:
            Number of the joint in the leg, and the acceleration that it may have [rad/s^2].
        """
        index_q, index_v, lower, upper = self._legs[side]
        allowed, changed = off_stops(
            dynamics.q, dynamics.v, vdot, index_q, index_v, lower, upper, self._rate
        )
        if not changed:
            return {}
        return {int(j): float(allowed[j]) for j in np.flatnonzero(allowed != vdot[index_v])}

    def held(self, task: TaskRows, side: int, joints: dict[int, float]) -> TaskRows:
        """Return the task of a foot with some joints of its leg held.

        Args:
            task: of the swing foot, three rows of position over two of direction.
            side: of the leg.
            joints: as `crossed` returns them.

        Returns:
            A row for each of these joints, then the combinations of the foot's rows that the
            other joints of the leg span; a turn of the foot is given up before its place.
        """
        index = self._legs[side][1]
        units = np.array([1.0, 1.0, 1.0, _LENGTH, _LENGTH])
        J, b = units[:, None] * task.J, units * task.b
        free = [j for j in range(len(index)) if j not in joints]
        Q, _ = np.linalg.qr(J[:, index[free]])
        rows = np.zeros((len(joints), J.shape[1]))
        rows[np.arange(len(joints)), index[list(joints)]] = 1.0
        return TaskRows(
            np.concatenate([rows, Q.T @ J]), np.concatenate([list(joints.values()), Q.T @ b])
        )
