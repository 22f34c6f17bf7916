"""A robot that is a point on a linear inverted pendulum, to drive the gait with.

Its swing foot is where the gait plans it, its centre of pressure where the phase says: under
the stance foot, moving evenly from foot to foot in double support. The pendulum knows no height:
on a slope, too, its CoM moves at one, and only the feet are on the ground.
"""

from dataclasses import dataclass

import numpy as np

from drake_linefoot.gait.parameters import GaitParameters
from drake_linefoot.gait.planner import Gait, GaitMeasurement
from drake_linefoot.gait.state import GaitState, Mode
from drake_linefoot.gait.swing import LineMotion
from drake_linefoot.math.so3 import wrap_angle
from tests.helpers.walking import robot

DT = 0.001
STAND_STILL = np.zeros(4)


@dataclass(frozen=True)
class Tick:
    """The gait after one tick."""

    gait: Gait
    state: GaitState

    @property
    def foot(self) -> LineMotion | None:
        """The desired motion of the swing foot, if any."""
        if self.state.mode != Mode.SWING:
            return None
        return self.gait.swing(self.state).motion(np.array([self.state.time]))


def landed(state):
    """Flags of an estimator that finds the swing foot on the ground when it is due."""
    if state.mode != Mode.SWING:
        return True, True
    there = state.time + DT >= state.due - 1e-9
    return (True, there) if state.side == 0 else (there, True)


class PendulumRobot:
    """Pendulum and gait in a loop of 1 ms.

    Its ground rises by `slope` per metre along x and y; the feet feel it where they land.
    A foot that is said to be in contact has stopped, one in the air moves as the gait plans it.
    """

    def __init__(self, parameters=None, yaw=0.0, slope=(0.0, 0.0)):
        self.slope = np.array(slope)
        self.gait = Gait(parameters or GaitParameters(), robot().description.limits)
        half = 0.5 * self.gait.parameters.step_width
        c, s = np.cos(yaw), np.sin(yaw)
        self.feet = np.array([[-s * half, c * half, 0.0, yaw], [s * half, -c * half, 0.0, yaw]])
        self.feet[:, 2] = self.feet[:, :2] @ self.slope
        self.com = np.array([0.0, 0.0, self.gait.parameters.com_height])
        self.com_velocity = np.zeros(3)
        self.climb = np.zeros(2)
        self.state = self.gait.initial_state(0.0, self.measure((True, True)))

    def measure(self, contact):
        """What the gait sees; a measured heading has no whole turns."""
        feet = self.feet.copy()
        feet[:, 3] = wrap_angle(feet[:, 3])
        rise = np.cos(feet[:, 3]) * self.slope[0] + np.sin(feet[:, 3]) * self.slope[1]
        com, velocity = self.com.copy(), self.com_velocity.copy()
        return GaitMeasurement(com, velocity, feet, contact, rise, self.climb)

    def cop(self):
        """The centre of pressure over the coming tick, shape (2,)."""
        s, p = self.state, self.gait.placement
        if s.mode == Mode.STAND:
            xi, middle = p.dcm(s), s.feet[:, :2].mean(axis=0)
            return xi + (xi - middle) * self.gait.parameters.capture_rate / p.omega
        if s.mode == Mode.SHIFT:
            return p.shift_cop(s)
        if s.mode == Mode.SWING:
            return s.feet[s.side, :2]
        share = (s.time + 0.5 * DT - s.phase_start) / self.gait.parameters.double_support
        return (1.0 - share) * s.feet[1 - s.side, :2] + share * s.feet[s.side, :2]

    def tick(self, command, contact=(True, True), stopped=None):
        """Move on by 1 ms; a foot in the air touches only when `contact` says so.

        `stopped`: feet that the ground has stopped; default: those in contact.
        """
        w, p = self.gait.placement.omega, self.cop()
        c, v = self.com[:2] - p, self.com_velocity[:2].copy()
        self.com[:2] = p + c * np.cosh(w * DT) + v / w * np.sinh(w * DT)
        self.com_velocity[:2] = c * w * np.sinh(w * DT) + v * np.cosh(w * DT)
        time = self.state.time + DT
        self.climb = np.zeros(2)
        if self.state.mode == Mode.SWING:
            motion = self.gait.swing(self.state).motion(np.array([time]))
            side = self.state.swing_side
            self.feet[side] = motion.position[0, [0, 1, 2, 4]]
            if not (contact if stopped is None else stopped)[side]:
                late = self.state.time >= self.state.due - 1e-9
                way = self.state.reference[1] if late else motion.velocity[0]
                self.climb[side] = way[2]
            if contact[side] and self.slope.any():
                self.feet[side, 2] = self.feet[side, :2] @ self.slope
        self.state = self.gait.update(
            self.state, np.asarray(command, dtype=float), self.measure(tuple(contact)), time
        )
        return Tick(self.gait, self.state)

    def run(self, command, duration, contact=None):
        """Tick for `duration` [s]; `contact` gives the flags of a state, default: as planned."""
        flags = contact or landed
        return [self.tick(command, flags(self.state)) for _ in range(round(duration / DT))]
