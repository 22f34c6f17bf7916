"""The gait as plain functions: one tick of the state machine, and the plan that follows."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_linefoot.gait.ground_kernels import line_pitch
from drake_linefoot.gait.learning import learn_ground, learn_speed, no_marks
from drake_linefoot.gait.parameters import GaitParameters
from drake_linefoot.gait.placement import FootPlacement
from drake_linefoot.gait.state import GaitState, Mode
from drake_linefoot.gait.swing import Swing
from drake_linefoot.gait.swing_kernels import PITCH, SIZE, YAW, Z
from drake_linefoot.gait.tick_kernels import TIME_EPSILON, carry_on
from drake_linefoot.math.so3 import wrap_angle
from drake_linefoot.robot.description import StepLimits

Array = NDArray[np.float64]

_NEAR = 0.02  # [m] a foot so far above where it should be has not come to the ground
_REACH_AHEAD = 0.005  # [s] a foot that reaches down is planned to stand so soon


class GaitMeasurement(NamedTuple):
    """What the gait sees of the robot.

    Attributes:
        com, com_velocity: [m, m/s], shape (3,).
        feet: contact lines [x, y, z, yaw], shape (2, 4).
        contact: what the contact estimator says of each foot.
        rise: of each line per metre of its heading [-], shape (2,).
        climb: vertical velocity of the end of each line, heel or toe, that climbs faster [m/s],
            shape (2,).
    """

    com: Array
    com_velocity: Array
    feet: Array
    contact: tuple[bool, bool]
    rise: Array
    climb: Array


class Gait:
    """The gait of one robot: constants and the functions that use them.

    Stateless: every method maps a `GaitState` to something.
    """

    def __init__(self, parameters: GaitParameters, limits: StepLimits) -> None:
        """Derive the constants of a step."""
        self.parameters = parameters
        self.placement = FootPlacement(parameters, limits)

    def initial_state(self, time: float, measured: GaitMeasurement) -> GaitState:
        """Return the state of a robot that stands where it is measured."""
        return GaitState(
            time=time,
            mode=Mode.STAND,
            side=0 if self.parameters.first_swing == "right" else 1,
            closing=0,
            phase_start=time,
            phase_end=np.inf,
            due=np.inf,
            yaw=_mean_yaw(measured.feet),
            velocity=np.zeros(2),
            turn_rate=0.0,
            speed_scale=np.array(self.parameters.speed_scale),
            speed_offset=np.zeros(2),
            marks=no_marks(),
            com=measured.com,
            com_velocity=measured.com_velocity,
            feet=measured.feet,
            target=np.zeros(SIZE),
            reference=np.zeros((3, SIZE)),
            slope=np.zeros(2),
        )

    def update(
        self, state: GaitState, command: Array, measured: GaitMeasurement, time: float
    ) -> GaitState:
        """Advance the state to `time`.

        Args:
            state: state at an earlier time.
            command: [v_x, v_y, turn rate, walk], heading frame [m/s, m/s, rad/s, 0 or 1].
            measured: the robot at `time`.
            time: [s], later than `state.time`.

        Returns:
            The state at `time`.
        """
        step, m = self.placement, measured
        after, ended = carry_on(
            state.to_vector(), command, m.com, m.com_velocity, m.feet, m.contact, time,
            step.constants, step.reach,
        )  # fmt: skip
        if ended:
            after = self.decide(after, command, measured, time - state.time)
        return GaitState.from_vector(after)

    def decide(self, state: Array, command: Array, measured: GaitMeasurement, dt: float) -> Array:
        """Start the next phase of a state, where the present one is over.

        Args:
            state: that `carry_on` advanced, shape (GaitState.size(),).
            command: as in `update`.
            measured: the robot now.
            dt: since the state before [s].

        Returns:
            Shape (GaitState.size(),).
        """
        decided = self._change_phase(GaitState.from_vector(state), command, measured, dt)
        left = decided.phase_end - decided.time
        if decided.mode == Mode.SWING and left > self.placement.constants.last_aim:
            decided = self.placement.aim(decided)
        return decided.to_vector()

    def _change_phase(
        self, state: GaitState, command: Array, measured: GaitMeasurement, dt: float
    ) -> GaitState:
        """Start the next phase when the present one is over."""
        walk = bool(command[3] > 0.5)
        over = state.time >= state.phase_end - TIME_EPSILON
        if state.mode == Mode.STAND:
            return self._start_shift(state) if walk else state
        if state.mode == Mode.SHIFT:
            if not walk:
                return self._stand(state)
            return self._start_double(state, state.side) if over else state
        if state.mode == Mode.DOUBLE:
            return self._start_swing(state, walk) if over else state
        if self._swing_is_over(state, measured, over):
            return self._touch_down(state, command, measured)
        late = self.parameters.contact_feedback and state.time >= state.due - TIME_EPSILON
        return self._reach_down(state, dt) if late else state

    def _swing_is_over(self, state: GaitState, measured: GaitMeasurement, over: bool) -> bool:
        """Tell whether the swing foot has found the ground, or is to stand without it."""
        p = self.parameters
        if not p.contact_feedback:
            return over
        share = (state.time - state.phase_start) / (state.due - state.phase_start)
        foot = state.swing_side
        if share >= p.early_contact_phase and measured.contact[foot]:
            # A push on the torso looks like a force on the foot, but stops neither end of it.
            if measured.climb[foot] > -p.contact_speed:
                return True
        if self._stands_still(state, measured):
            return True
        return state.time >= state.due + self.placement.late_contact_time(state) - TIME_EPSILON

    def _stands_still(self, state: GaitState, measured: GaitMeasurement) -> bool:
        """Tell whether a late foot that is moved down does not go down.

        It has found the ground then, whatever the forces look like: to the estimator a push on the
        torso may hide the force on a foot.
        """
        p, foot = self.parameters, state.swing_side
        if state.time < state.due + p.late_contact_wait - TIME_EPSILON:
            return False
        above = measured.feet[foot, Z] - state.reference[0, Z]
        return bool(measured.climb[foot] > -0.25 * p.reach_speed and above < _NEAR)

    def _reach_down(self, state: GaitState, dt: float) -> GaitState:
        """Move a late foot straight down, and plan to stand on it soon."""
        speed = self.parameters.reach_speed
        reference = np.zeros((3, SIZE))
        reference[0] = state.reference[0]
        reference[0, Z] -= speed * dt
        reference[1, Z] = -speed
        return state.changed(
            phase_end=state.time + _REACH_AHEAD, reference=reference, target=reference[0]
        )

    def _stand(self, state: GaitState) -> GaitState:
        return state.changed(
            mode=Mode.STAND, phase_start=state.time, phase_end=np.inf, closing=0,
            velocity=np.zeros(2), turn_rate=0.0,
        )  # fmt: skip

    def _start_shift(self, state: GaitState) -> GaitState:
        side = 0 if self.parameters.first_swing == "right" else 1
        end = state.time + self.parameters.shift_duration
        return state.changed(
            mode=Mode.SHIFT, side=side, phase_start=state.time, phase_end=end,
            speed_scale=np.array(self.parameters.speed_scale), speed_offset=np.zeros(2),
            marks=no_marks(),
        )  # fmt: skip

    def _start_double(self, state: GaitState, side: int) -> GaitState:
        end = state.time + self.parameters.double_support
        return state.changed(mode=Mode.DOUBLE, side=side, phase_start=state.time, phase_end=end)

    def _touch_down(self, state: GaitState, command: Array, measured: GaitMeasurement) -> GaitState:
        feet = state.feet.copy()
        feet[state.swing_side] = measured.feet[state.swing_side]  # it stands from now on
        p, rise = self.parameters, float(measured.rise[state.side])
        state = learn_ground(p, state.changed(steps=state.steps + 1, feet=feet), rise)
        most = self.placement.constants.limits[:2]
        allowed = np.clip(command[:2], np.negative(most), most)
        state = learn_speed(p, state, steady=np.array_equal(state.velocity, allowed))
        if state.closing:
            return self._stand(state)
        return self._start_double(state, state.swing_side)

    def _start_swing(self, state: GaitState, walk: bool) -> GaitState:
        """Lift the foot the weight has left, from where it stands."""
        foot, duration = state.feet[state.swing_side], self.placement.single_support(state)
        reference = np.zeros((3, SIZE))
        reference[0, :3], reference[0, YAW] = foot[:3], foot[3]
        reference[0, PITCH] = line_pitch(state.slope, foot[3])
        state = state.changed(
            mode=Mode.SWING,
            phase_start=state.time,
            phase_end=state.time + duration,
            due=state.time + duration,
            reference=reference,
            closing=0,
        )
        state = self.placement.aim(state)
        still = not np.any(state.velocity) and state.turn_rate == 0.0
        if not walk and still:
            beside = self.placement.beside(state)
            miss = np.linalg.norm(state.target[:2] - beside)
            if miss < self.parameters.closing_tolerance:
                state = self.placement.aim(state.changed(closing=1))
        return state

    def swing(self, state: GaitState) -> Swing:
        """Return the swing in progress; meaningful in single support only."""
        return Swing(
            start=state.phase_start,
            end=state.phase_end,
            now=state.time,
            reference=state.reference,
            target=state.target,
            height=self.parameters.swing_height,
            settle=self.parameters.settle_time,
        )


def _mean_yaw(feet: Array) -> float:
    """Return the heading in the middle between the two feet [rad]."""
    return float(feet[0, 3] + 0.5 * wrap_angle(feet[1, 3] - feet[0, 3]))
