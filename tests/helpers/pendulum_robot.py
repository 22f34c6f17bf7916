"""A robot that is a point on a linear inverted pendulum, to drive the gait with.

Its swing foot is where the gait plans it, its centre of pressure where the phase says: under
the stance foot, moving evenly from foot to foot in double support. The pendulum knows no height:
on a slope, too, its CoM moves at one, and only the feet are on the ground.
"""

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from drake_linefoot.gait.constants import Ankles, gait_constants
from drake_linefoot.gait.horizon import shift_cop
from drake_linefoot.gait.measurement import measure_gait
from drake_linefoot.gait.parameters import GaitParameters
from drake_linefoot.gait.pendulum import dcm
from drake_linefoot.gait.planner import begin, update
from drake_linefoot.gait.swing import LineMotion, swing_motion
from drake_linefoot.gait.swing_foot import present_swing
from drake_linefoot.layout import flat
from drake_linefoot.robot.humanoid import load_humanoid
from drake_linefoot.signals import ContactEstimate, RobotDynamics
from drake_linefoot.statuses import Mode
from drake_linefoot.terrain import felt_ground
from tests.helpers.phases import (
    mode_of,
    phase_end,
    phase_start,
    planned_touchdown,
    repeats_swing,
    swing_of,
)

DT = 0.001
STAND_STILL, HALF_LENGTH = np.zeros(4), 0.1
ACCELERATION = np.array([175.0, 114.0, 190.0])  # [m/s^2] of a swing foot
LIMITS = load_humanoid("mit_humanoid").description.limits
# The first of q, at rest.
ANKLES = Ankles(np.zeros(2, dtype=int), np.tile([-1.0, 1.0], (2, 1)), np.array([0.1, 0.04]))


@dataclass(frozen=True)
class Tick:
    """The gait after one tick."""

    constants: np.record
    state: np.record

    @property
    def foot(self) -> LineMotion | None:
        """The desired motion of the swing foot, if any."""
        if mode_of(self.state) != Mode.SWING:
            return None
        return foot_motion(self.state, self.constants, self.state.clock.time)


def foot_motion(state, constants, time):
    """The motion of the swing foot at one time [s], each part of shape (1, 5)."""
    return LineMotion(
        *swing_motion(present_swing(state, 1 - int(state.clock.side), constants), np.array([time]))
    )


def dcm_on(piece, t):
    """The DCM on a piece of its trajectory at `t` [s], shape (2,)."""
    return piece.centre + piece.amplitude * np.exp(piece.rate * (t - piece.start))


def landed(state):
    """Flags of an estimator that finds the swing foot on the ground when it is due."""
    if mode_of(state) != Mode.SWING:
        return True, True
    there = state.clock.time + DT >= planned_touchdown(state) - 1e-9
    return (True, there) if state.clock.side == 0 else (there, True)


class PendulumRobot:
    """Pendulum and gait in a loop of 1 ms.

    Its ground rises by `slope` per metre along x and y; the feet feel it where they land.
    A foot that is said to be in contact has stopped, one in the air moves as the gait plans it.
    """

    def __init__(self, parameters=None, yaw=0.0, slope=(0.0, 0.0)):
        self.slope = np.array(slope)
        self.parameters = parameters or GaitParameters()
        about = LIMITS, (HALF_LENGTH, 0.0, 0.0), ACCELERATION, ANKLES
        self.constants = gait_constants(self.parameters, *about)[0]
        half = 0.5 * self.parameters.step_width
        c, s = np.cos(yaw), np.sin(yaw)
        self.feet = np.array([[-s * half, c * half, 0.0, yaw], [s * half, -c * half, 0.0, yaw]])
        self.feet[:, 2] = self.feet[:, :2] @ self.slope
        self.com = np.array([0.0, 0.0, self.parameters.com_height])
        self.com_velocity = np.zeros(3)
        self.vertical_speed = np.zeros(2)
        self.wrench = np.zeros((2, 5))
        self.force, self.external = np.zeros(2), np.zeros(6)  # that acts, and what is known of it
        self.state = begin(self.measure(), 0.0, self.constants)

    def dynamics(self):
        """What the gait gets of the robot; of the lines' ends one moves at `vertical_speed`."""
        n = np.zeros(6)  # a point mass has no angular momentum
        R_WC = np.empty((2, 3, 3))
        for side, yaw in enumerate(self.feet[:, 3]):
            line_slope = np.array([np.cos(yaw), np.sin(yaw)]) @ self.slope
            R_WC[side] = Rotation.from_euler("ZY", [yaw, -np.arctan(line_slope)]).as_matrix()
        return RobotDynamics(
            q=np.zeros(7), v=n, M=np.eye(6), Cv=n, tau_g=n, CTv=n, R_WB=np.eye(3),
            p_WG=self.com.copy(), v_WG=self.com_velocity.copy(), A=np.zeros((6, 6)),
            Adot_v=np.zeros(6), p_WC=self.feet[:, :3].copy(), R_WC=R_WC,
            v_WC=np.array([[0.0, 0.0, speed] for speed in self.vertical_speed]),
            w_WF=np.zeros((2, 3)), J=np.zeros((2, 5, 6)), Jdot_v=np.zeros((2, 5)),
        )  # fmt: skip

    def measure(self, contact=(True, True)):
        """What the gait sees; a measured heading has no whole turns."""
        flags = np.array(contact, dtype=float)
        return measure_gait(self.dynamics(), flags, self.wrench, self.constants)

    def cop(self):
        """The centre of pressure over the coming tick, shape (2,)."""
        s, c, side = self.state, self.constants, int(self.state.clock.side)
        if mode_of(s) == Mode.STAND:
            xi, middle = (
                dcm(s.robot.pendulum_com, s.robot.com_velocity, c.omega),
                s.robot.feet[:, :2].mean(axis=0),
            )
            return xi + (xi - middle) * c.capture_rate / c.omega
        if mode_of(s) == Mode.SHIFT:
            return shift_cop(s, c)
        if mode_of(s) == Mode.SWING or repeats_swing(s):
            return s.robot.feet[side, :2]
        share = (s.clock.time + 0.5 * DT - phase_start(s)) / (phase_end(s) - phase_start(s))
        return (1.0 - share) * s.robot.feet[1 - side, :2] + share * s.robot.feet[side, :2]

    def tick(self, command, contact=(True, True), stopped=None):
        """Move on by 1 ms; a foot in the air touches only when `contact` says so.

        `stopped`: feet that the ground has stopped; default: those in contact.
        """
        w, p = self.constants.omega, self.cop()
        pull = self.force / w**2  # of a mass of 1 kg, in the height of the CoM
        c, v = self.com[:2] + pull - p, self.com_velocity[:2].copy()
        self.com[:2] = p - pull + c * np.cosh(w * DT) + v / w * np.sinh(w * DT)
        self.com_velocity[:2] = c * w * np.sinh(w * DT) + v * np.cosh(w * DT)
        time = self.state.clock.time + DT
        self.vertical_speed = np.zeros(2)
        if mode_of(self.state) == Mode.SWING:
            motion = foot_motion(self.state, self.constants, time)
            side = 1 - int(self.state.clock.side)
            self.feet[side] = motion.position[0, [0, 1, 2, 4]]
            if not (contact if stopped is None else stopped)[side]:
                late = self.state.clock.time >= planned_touchdown(self.state) - 1e-9
                way = swing_of(self.state).reference[1] if late else motion.velocity[0]
                self.vertical_speed[side] = way[2]
            if contact[side] and self.slope.any():
                self.feet[side, 2] = self.feet[side, :2] @ self.slope
        self.advance(command, self.dynamics(), tuple(contact), time)
        return Tick(self.constants, self.state)

    def advance(self, command, d, contact, time):
        """Update the gait's state, a new record, to `time` [s]."""
        gait, constants = np.array([self.state]), np.array([self.constants])
        flags = np.array(contact, dtype=float)
        estimate = flat(ContactEstimate(self.wrench, flags, np.zeros(6), self.external))
        update(
            gait,
            np.asarray(command, dtype=float),
            flat(d),
            estimate,
            5,
            felt_ground(),
            time,
            constants,
        )
        self.state = gait[0]

    def run(self, command, duration, contact=None):
        """Tick for `duration` [s]; `contact` gives the flags of a state, default: as planned."""
        flags = contact or landed
        return [self.tick(command, flags(self.state)) for _ in range(round(duration / DT))]
