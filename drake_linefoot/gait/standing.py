"""Whether a robot that stands can go on standing."""

import math

import numpy as np

from drake_linefoot.gait.footsteps import heading_vector
from drake_linefoot.gait.pendulum import dcm
from drake_linefoot.gait.state import GaitConstants, GaitState
from drake_linefoot.math.compiled import compiled


@compiled
def outside_feet(s: GaitState, c: GaitConstants) -> float:
    """Return how far the DCM is outside the hull of both contact lines [m]; 0 inside.

    There no centre of pressure brings it back.
    """
    xi, corners = (
        dcm(s.robot.pendulum_com[:], s.robot.pendulum_velocity[:], c.omega),
        np.empty((4, 2)),
    )
    for end in range(4):
        foot = s.robot.feet[end // 2]
        along = heading_vector(foot[3], c.half_length if end % 2 else -c.half_length, 0.0)
        corners[end] = foot[:2] + along
    outside = 0.0
    for a in range(4):
        for b in range(4):
            edge = corners[b] - corners[a]
            length, is_side = math.hypot(edge[0], edge[1]), a != b
            for other in range(4):
                d = corners[other] - corners[a]
                is_side = is_side and d[0] * edge[1] - d[1] * edge[0] <= 1e-9 * length
            if is_side and length > 0.0:
                d = xi - corners[a]
                outside = max(outside, (d[0] * edge[1] - d[1] * edge[0]) / length)
    return outside


@compiled
def foot_towards(s: GaitState, c: GaitConstants) -> int:
    """Return on which side of the middle between the feet the DCM is, 0 left, 1 right."""
    xi = dcm(s.robot.pendulum_com[:], s.robot.pendulum_velocity[:], c.omega)
    away = xi - 0.5 * (s.robot.feet[0, :2] + s.robot.feet[1, :2])
    return 0 if heading_vector(-s.command.yaw, away[0], away[1])[1] > 0.0 else 1
