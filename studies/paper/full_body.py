"""How the torso turns when feet, CoM and momentum move as planned: by the full body's kinematics.

Where the feet, the CoM and the arms are leaves of each orientation of the torso one posture, where
the knees are bent: place of the torso and angles of the legs follow by Newton's method, and so do
its twist w, v_B and the rates of the legs from linear equations, ::

    [L; m r'] = A v,    how the contact lines move = J v,    v = [w; v_B; rates],

with A and J of Drake's plant or what stands for it, and the rates of the arms as planned. No joint
is locked and nothing is linearised. R_WB is integrated from w by Simpson's rule.
"""

from contextlib import suppress
from typing import NamedTuple

import numpy as np
from pydrake.systems.framework import Context
from scipy.spatial.transform import Rotation

from drake_linefoot.robot.dynamics import robot_dynamics
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.signals import RobotDynamics
from studies.common.types import Array

CLOSE = 1e-7  # [m, rad] of the posture that is sought
TRIES = 12  # of Newton's method
MOST = 0.3  # [m, rad] that one of its steps changes at most


class Motion(NamedTuple):
    """What the robot is asked to do at n times: an odd number, every other one in the middle.

    Attributes:
        times: [s], shape (n,).
        r, v: CoM [m, m/s], shape (n, 3).
        L: angular momentum about it in W [kg m^2/s], shape (n, 3).
        p: middles of the contact lines [m], shape (2, n, 3).
        x: unit vectors along them, shape (2, n, 3).
        p_dot, w: velocities of the middles and angular velocities [m/s, rad/s], shape (2, n, 3).
        angles, rates: of `Humanoid.arm_joints` [rad, rad/s], shape (n, m).
    """

    times: Array
    r: Array
    v: Array
    L: Array
    p: Array
    x: Array
    p_dot: Array
    w: Array
    angles: Array
    rates: Array


class FullBody:
    """The kinematics of a robot whose feet are lines."""

    def __init__(self, humanoid: Humanoid) -> None:
        """Keep the robot."""
        self._h, self._context = humanoid, humanoid.plant.CreateDefaultContext()
        self._leg_q, self._leg_v = humanoid.leg_q.ravel(), humanoid.leg_v.ravel()
        self._moved = np.concatenate([np.arange(3, 6), self._leg_v])  # with R_WB given
        self._unknown = np.concatenate([np.arange(6), self._leg_v])

    @property
    def context(self) -> Context:
        """Of the robot's plant; its state may be overwritten."""
        return self._context

    def torso(self, q: Array, motion: Motion) -> Array:
        """Return how the torso is turned at every other time, from the first on.

        Args:
            q: positions to begin with; R_WB is that of the first time, shape (nq,).
            motion: that is asked for.

        Returns:
            R_WB, shape ((n + 1) / 2, 3, 3); NaN from where no posture was found.
        """
        R = Rotation.from_quat(q[:4], scalar_first=True)
        found = np.full(((len(motion.times) + 1) // 2, 3, 3), np.nan)
        x = np.concatenate([q, np.zeros(self._h.nv)])
        found[0] = R.as_matrix()
        with suppress(ValueError):  # no posture, a line that stands upright, a singular matrix
            w = self._turning(x, R, motion, 0)
            for k in range(1, len(found)):
                last, step = 2 * k, float(motion.times[2 * k] - motion.times[2 * k - 2])
                half = self._turning(x, Rotation.from_rotvec(0.5 * step * w) * R, motion, last - 1)
                end = self._turning(x, Rotation.from_rotvec(step * half) * R, motion, last)
                R, w = Rotation.from_rotvec(step / 6.0 * (w + 4.0 * half + end)) * R, end
                found[k] = R.as_matrix()
        return found

    def _turning(self, x: Array, R: Rotation, motion: Motion, i: int) -> Array:
        """Return w at time `i` [rad/s]; `x`, where to begin, becomes the state."""
        h, nq = self._h, self._h.nq
        x[:4], x[nq:] = R.as_quat(scalar_first=True), 0.0
        x[h.arm_q], x[nq + h.arm_v] = motion.angles[i], motion.rates[i]
        d = self._posture(x, motion, i)
        rows = np.concatenate([d.A, *d.J])
        asked = np.concatenate(
            [motion.L[i], h.mass * motion.v[i]]
            + [_rows(d, side, motion.p_dot[side, i], motion.w[side, i]) for side in (0, 1)]
        )
        v = x[nq:]
        v[self._unknown] = np.linalg.solve(rows[:, self._unknown], asked - rows @ v)
        w: Array = v[:3].copy()
        return w

    def _posture(self, x: Array, motion: Motion, i: int) -> RobotDynamics:
        """Find place of the torso and legs and write them into `x`.

        Raises:
            ValueError: the legs do not go there.
        """
        h = self._h
        for _ in range(TRIES):
            d = robot_dynamics(h, self._context, x)
            off = [motion.r[i] - d.p_WG]
            for side in (0, 1):
                turn = np.cross(d.R_WC[side, :, 0], motion.x[side, i])
                off.append(_rows(d, side, motion.p[side, i] - d.p_WC[side], turn))
            missing = np.concatenate(off)
            if np.abs(missing).max() < CLOSE:
                return d
            rows = np.concatenate([d.A[3:] / h.mass, *d.J])[:, self._moved]
            change = np.linalg.solve(rows, missing)
            change *= min(1.0, MOST / float(np.abs(change).max()))
            x[4:7] += change[:3]
            x[self._leg_q] += change[3:]
        raise ValueError("no posture has its feet and its CoM there")


def _rows(d: RobotDynamics, side: int, linear: Array, angular: Array) -> Array:
    """Return what the rows of J of a foot are of a motion of its contact, shape (nw,)."""
    return np.concatenate([linear, d.R_WC[side, :, 1:].T @ angular])
