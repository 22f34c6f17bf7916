"""What the gait sees of the robot."""

import math
from typing import NamedTuple

import numpy as np

from drake_linefoot.gait.contacts import in_contact
from drake_linefoot.gait.known_ground import slope_at
from drake_linefoot.gait.state import GaitConstants, GaitState
from drake_linefoot.math.compiled import compiled
from drake_linefoot.math.linear import dot
from drake_linefoot.signals import RobotDynamics
from drake_linefoot.types import Array


class GaitMeasurement(NamedTuple):
    """What the gait sees of the robot.

    Attributes:
        com, com_velocity: [m, m/s], shape (3,).
        pendulum_velocity: see there [m/s], shape (3,).
        feet: contact lines [x, y, z, yaw], shape (2, 4).
        contact: what the contact estimator says of each foot, 0 or 1, shape (2,).
        line_slope: rise of each line per metre of its heading [-], shape (2,).
        cross_slope: rise of each sole per metre to its left [-], shape (2,); 0 of a line.
        presses: where along each line its force acts, from its middle, negative at the heel [m],
            shape (2,).
        vertical_speed: of the end of each line, heel or toe, or corner of a sole that goes up
            faster [m/s], shape (2,). A line that meets an edge with one end goes on turning about
            it: that end has stopped.
    """

    com: Array
    com_velocity: Array
    pendulum_velocity: Array
    feet: Array
    contact: Array
    line_slope: Array
    cross_slope: Array
    presses: Array
    vertical_speed: Array


@compiled
def pendulum_velocity(d: RobotDynamics, com_height: float) -> Array:
    """Return the velocity of a point mass with the robot's angular momentum about its foot [m/s].

    That momentum is ``m h v + L_G``. Swinging legs take L_G up and give it back within a step, and
    the CoM with them; their sum forecasts the end of the step better than the velocity of the CoM
    (Gong and Grizzle, 2008.10763).

    Args:
        d: quantities of the state.
        com_height: h, of the pendulum [m].

    Returns:
        Shape (3,).
    """
    v, mh = d.v_WG.copy(), d.M[3, 3] * com_height
    v[0] += dot(d.A[1], d.v) / mh
    v[1] -= dot(d.A[0], d.v) / mh
    return v


@compiled
def lean_into(external: Array, mass: float, c: GaitConstants) -> Array:
    """Return how far the CoM is to be upwind of where it would be without a lasting force [m].

    With a force F and a moment M about the CoM it is moved by ``(F_x + M_y / h, F_y - M_x / h)``
    over ``m w^2``, then it obeys the law of a free pendulum over the same feet: such a force at a
    height z asks for F z / (m g).

    Args:
        external: moment about the CoM over force in W [N m, N], shape (6,).
        mass: [kg].
        c: constants; w is `omega`, h `com_height`.

    Returns:
        Along the force, shape (2,); at most `lean_max`.
    """
    h, stiffness = c.com_height, mass * c.omega * c.omega
    lean = np.array((external[3] + external[1] / h, external[4] - external[0] / h)) / stiffness
    size = math.hypot(lean[0], lean[1])
    if size > c.lean_max:
        lean *= c.lean_max / size
    return lean


@compiled
def measure_gait(
    d: RobotDynamics, contact: Array, wrench: Array, c: GaitConstants
) -> GaitMeasurement:
    """Return CoM and contact lines of a state.

    Args:
        d: quantities of the state.
        contact: flags of the contact estimator, shape (2,).
        wrench: its wrenches of the feet [N, N m], shape (2, nw).
        c: constants.
    """
    feet, line_slope, cross_slope = np.empty((2, 4)), np.empty(2), np.empty(2)
    presses, vertical_speed = np.zeros(2), np.empty(2)
    for side in range(2):
        R, w = d.R_WC[side], d.w_WF[side]
        feet[side, :3] = d.p_WC[side]
        feet[side, 3] = math.atan2(R[1, 0], R[0, 0])
        line_slope[side] = R[2, 0] / math.hypot(R[0, 0], R[1, 0])
        cross_slope[side] = R[2, 1] / math.hypot(R[0, 1], R[1, 1])
        if wrench[side, 2] > 0.0:
            centre = -wrench[side, 3] / wrench[side, 2]
            presses[side] = min(max(centre, -c.half_length), c.half_length)
        turning = w[0] * R[1, 0] - w[1] * R[0, 0]
        rolling = w[0] * R[1, 1] - w[1] * R[0, 1]
        vertical_speed[side] = d.v_WC[side, 2] + c.half_length * abs(turning)
        vertical_speed[side] += c.half_width * abs(rolling)
    velocity = pendulum_velocity(d, c.com_height)
    return GaitMeasurement(
        d.p_WG, d.v_WG, velocity, feet, contact, line_slope, cross_slope, presses, vertical_speed
    )


@compiled
def take_in(
    s: GaitState, measured: GaitMeasurement, external: Array, mass: float, c: GaitConstants
) -> None:
    """Keep what is measured; of a foot in the air the line on which it will stand is kept.

    Args:
        s: state of the gait.
        measured: now.
        external: moment about the CoM over force in W [N m, N], shape (6,).
        mass: [kg].
        c: constants.
    """
    s.robot.com[:], s.robot.com_velocity[:] = measured.com, measured.com_velocity
    s.robot.external[:], s.robot.lean[:] = external, lean_into(external, mass, c)
    s.robot.pendulum_com[:] = measured.com
    s.robot.pendulum_velocity[:] = measured.pendulum_velocity
    s.robot.pendulum_com[:2] += s.robot.lean
    for foot in range(2):
        if in_contact(s, foot):
            take_in_foot(s, measured, foot, c)


@compiled
def take_in_foot(s: GaitState, measured: GaitMeasurement, foot: int, c: GaitConstants) -> None:
    """Keep where a foot stands; in a run, in which it rolls over its toe, by its lower end."""
    s.robot.feet[foot] = measured.feet[foot]
    if s.command.flight > 0.0:
        yaw, slope = measured.feet[foot, 3], slope_at(s, int(s.terrain.under[foot]))
        believed = slope[0] * math.cos(yaw) + slope[1] * math.sin(yaw)
        s.robot.feet[foot, 2] -= c.half_length * abs(measured.line_slope[foot] - believed)
