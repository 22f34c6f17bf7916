"""Legs that reach the planned contacts, by inverse kinematics, and what they weigh there."""

import numpy as np

from drake_linefoot.math.compiled import inlined
from drake_linefoot.math.linear import cholesky
from drake_linefoot.mpc.models.motion import BodyMotion, LinePlan, Robot, places_in_torso
from drake_linefoot.robot.leg_inertia import (
    MomentumMaps,
    momentum_maps,
    weigh_torso,
    whole_in_torso,
)
from drake_linefoot.robot.leg_kinematics import inverse, leg_jacobian
from drake_linefoot.robot.legs import Legs
from drake_linefoot.signals import RobotDynamics
from drake_linefoot.types import Array, Indices


def determinant(legs: Legs, q: Array) -> float:
    """Return the least of the legs' Jacobian determinants at joint angles q [rad], (n, j)."""
    least = np.inf
    for leg in range(len(q)):
        E = leg_jacobian(legs, leg, q[leg])
        root, _ = cholesky(E @ E.T)
        least = min(least, float(np.prod(np.diag(root))))
    return least


@inlined
def joints_of_legs(q: Array, leg_q: Indices) -> Array:
    """Return the joint angles of both legs [rad], shape (2, j), of positions; `Robot.leg_q`."""
    angles = np.empty(leg_q.shape)
    for side in range(len(leg_q)):
        for i in range(leg_q.shape[1]):
            angles[side, i] = q[leg_q[side, i]]
    return angles


@inlined
def joints(
    legs: Legs, body: BodyMotion, lines: LinePlan, com: Array, now: Array
) -> tuple[Array, float]:
    """Return joint angles of the legs that go with a planned motion.

    The torso is put where the CoM, fixed in the torso as it is now, is on its
    reference; each leg reaches its planned contact.

    Args:
        legs: both legs.
        body: CoM and torso at K times.
        lines: planned there.
        com: present CoM from the torso's origin, in B [m], shape (3,).
        now: present joint angles [rad], shape (2, j).

    Returns:
        (angles, reach_error): [rad], shape (2, K, j), and the largest residual of the inverse
        kinematics [m, rad].
    """
    (p, R), K, reach = places_in_torso(body, lines), len(body.R), 0.0
    guess = np.empty((2, K, len(legs.zeros)))
    for side in range(2):
        for k in range(K):
            for i in range(3):
                p[side, k, i] += com[i]
            for i in range(len(legs.zeros)):
                guess[side, k, i] = now[side, i]
    angles, residual = inverse(legs, p, R, guess, 8, 1e-6)
    for side in range(2):
        for k in range(K):
            reach = max(reach, residual[side, k])
    return angles, reach


@inlined
def reaching_legs(
    body: BodyMotion, lines: LinePlan, now: RobotDynamics, robot: Robot
) -> tuple[Array, MomentumMaps, float]:
    """Return joint angles of legs that reach planned lines, and the momenta that they give there.

    Args:
        body: CoM and torso at K times.
        lines: planned there.
        now: of the present state: arms stay as they are.
        robot: what is to know of it.

    Returns:
        (angles, maps, reach_error): angles and error as of `joints`.
    """
    com, inertia = whole_in_torso(now.q, now.p_WG, now.R_WB, now.A)
    angles_now = joints_of_legs(now.q, robot.leg_q)
    weigh_torso(robot.legs, robot.masses, angles_now, com, inertia)
    angles, reach = joints(robot.legs, body, lines, com, angles_now)
    return angles, momentum_maps(robot.legs, robot.masses, angles), reach
