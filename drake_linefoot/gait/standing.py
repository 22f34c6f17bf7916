"""Whether a robot that stands can go on standing."""

import math

import numpy as np

from drake_linefoot.gait.footsteps import heading_vector
from drake_linefoot.gait.pendulum import dcm
from drake_linefoot.gait.state import GaitConstants, GaitState
from drake_linefoot.math.compiled import compiled
from drake_linefoot.types import Array


@compiled
def corners_of_feet(s: GaitState, c: GaitConstants) -> Array:
    """Return heel and toe of both contact lines, or the corners of both soles [m], shape (n, 2).

    Those of what the centre of pressure may use of them: less their margin.
    """
    X, Y, sides = c.half_length - c.contact_margin, 0.0, 1
    if c.half_width > 0.0:
        Y, sides = c.half_width - c.contact_margin, 2
    corners = np.empty((4 * sides, 2))
    for k in range(len(corners)):
        end = k // sides
        along, across = X if end % 2 else -X, -Y if k % sides else Y
        foot = s.robot.feet[end // 2]
        corners[k] = foot[:2] + heading_vector(foot[3], along, across)
    return corners


@compiled
def outside_feet(s: GaitState, c: GaitConstants) -> float:
    """Return how far the DCM is outside the hull of both feet [m]; 0 inside.

    There no centre of pressure brings it back.
    """
    xi, corners = (
        dcm(s.robot.pendulum_com[:], s.robot.pendulum_velocity[:], c.omega),
        corners_of_feet(s, c),
    )
    outside, count = 0.0, len(corners)
    for a in range(count):
        for b in range(count):
            edge = corners[b] - corners[a]
            length, is_side = math.hypot(edge[0], edge[1]), a != b
            for other in range(count):
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
