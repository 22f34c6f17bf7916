"""Where the feet go: from the state of the gait to footholds."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from drake_linefoot.gait.footstep_kernels import (
    SIDE_SIGN,
    StepCommand,
    StepShape,
    foot_heading,
    heading_vector,
    learned_command,
    next_foothold,
    nominal_strides,
)
from drake_linefoot.gait.ground_kernels import height_on, line_pitch
from drake_linefoot.gait.parameters import GaitParameters
from drake_linefoot.gait.pendulum import balancing_cop, natural_frequency, switch_time
from drake_linefoot.gait.pendulum_kernels import dcm, dcm_offset
from drake_linefoot.gait.state import GaitState
from drake_linefoot.gait.tick_kernels import TickConstants, aim, swing_duration
from drake_linefoot.robot.description import StepLimits

Array = NDArray[np.float64]

_NUMBERS = (
    "early_contact_phase", "single_support", "single_support_min", "double_support", "step_length",
    "step_width", "swing_height", "settle_time", "step_time_decrement", "remaining_time_min",
    "swing_time_min", "swing_acceleration_max",
)  # fmt: skip
_SHORTEST_SHIFT = 0.08  # [s] below it the balancing CoP is not updated any more


class FootPlacement:
    """Footholds of one robot's gait; stateless.

    Attributes:
        omega: natural frequency of the pendulum [1/s].
        switch: when the CoP switches, after the start of a double support [s].
        constants: what a tick needs of the parameters.
        reach: what a step at the slowest pace is like.
    """

    def __init__(self, parameters: GaitParameters, limits: StepLimits) -> None:
        """Derive the constants of a step."""
        self.parameters = parameters
        self.omega = natural_frequency(parameters.com_height)
        self.switch = switch_time(parameters.double_support, self.omega)
        p = parameters
        self.constants = TickConstants(
            limits=(float(p.forward_max), float(p.lateral_max), float(p.turn_max)),
            rates=2 * (float(p.linear_acceleration),) + (float(p.angular_acceleration),),
            contact_feedback=bool(p.contact_feedback),
            last_aim=p.settle_time + p.freeze_time,
            switch=float(self.switch),
            **{name: float(getattr(p, name)) for name in _NUMBERS},
        )
        self.reach = StepShape(
            duration=parameters.single_support + parameters.double_support,
            width=float(parameters.step_width),
            omega=self.omega,
            length_max=float(limits.step_length),
            width_min=float(limits.step_width_min),
            width_max=float(limits.step_width_max),
            reach_forward=float(parameters.reach_forward),
            reach_outward=float(parameters.reach_outward),
        )

    def single_support(self, state: GaitState) -> float:
        """Return how long a single support lasts at the present speed [s]; see `swing_duration`."""
        return swing_duration(float(state.velocity[0]), self.constants)

    def late_contact_time(self, state: GaitState) -> float:
        """Return how long a late foot is waited for [s].

        Not so long that the step gets longer than `step_length` at the present speed.
        """
        p, speed = self.parameters, abs(float(state.velocity[0]))
        step = state.due - state.phase_start + p.double_support
        if speed * (step + p.late_contact_max) <= p.step_length:
            return p.late_contact_max
        return max(p.step_length / speed - step, 0.0)

    def shape(self, state: GaitState) -> StepShape:
        """Return what a step is like at the present speed."""
        duration = self.single_support(state) + self.parameters.double_support
        if duration == self.reach.duration:
            return self.reach
        return self.reach._replace(duration=duration)

    def dcm(self, state: GaitState) -> Array:
        """Return the DCM [m], shape (2,)."""
        return dcm(state.com, state.com_velocity, self.omega)

    def command(self, state: GaitState) -> StepCommand:
        """Return the command that footholds are made for, with the learned scale."""
        return learned_command(*_asked(state))

    def beside(self, state: GaitState) -> Array:
        """Return the place beside the stance foot where a walk ends [m], shape (2,)."""
        aside = SIDE_SIGN[state.swing_side] * self.parameters.step_width
        return state.feet[state.side, :2] + heading_vector(state.yaw, 0.0, aside)

    def aim(self, state: GaitState) -> GaitState:
        """Choose where the swing foot will land, and when, if that is out of reach.

        Returns:
            The state with `target`, `phase_end`, `due` and the count of moved footholds.
        """
        vector = state.to_vector()
        aim(vector, self.constants, self.reach)
        return GaitState.from_vector(vector)

    def foothold(
        self, state: GaitState, xi: Array, stance: Array, side: int, touchdown: float
    ) -> Array:
        """Return a later foothold [x, y, z, yaw], shape (4,).

        Args:
            state: present state (heading, command, ground height).
            xi: DCM at the switch onto the new foot [m], shape (2,).
            stance: the foot that stands before [m], shape (2,).
            side: side of the new foot.
            touchdown: when it lands [s].
        """
        shape = self.shape(state)
        yaw = foot_heading(state.yaw, state.turn_rate, touchdown - state.time, shape.duration)
        place, _ = next_foothold(xi, stance, yaw, side, self.command(state), shape)
        height = height_on(state.slope, state.feet[state.side], place)
        return np.array([*place, height, yaw])

    def line(self, state: GaitState, place: Array, yaw: float) -> Array:
        """Return a contact line on the ground, [x, y, z, pitch, yaw], shape (5,).

        Args:
            state: present state, which knows the ground.
            place: its middle, x, y first [m].
            yaw: its heading [rad].
        """
        height = height_on(state.slope, state.feet[state.side], place)
        return np.array([place[0], place[1], height, line_pitch(state.slope, yaw), yaw])

    def first_step_dcm(self, state: GaitState) -> Array:
        """Return the DCM at the switch onto the first stance foot of a walk, shape (2,)."""
        shape = self.shape(state)
        strides = nominal_strides(self.command(state), shape, state.yaw, state.side)
        offset = dcm_offset(strides, self.omega, shape.duration)
        return state.feet[state.side, :2] + offset

    def shift_cop(self, state: GaitState) -> Array:
        """Return the CoP of the weight shift before the first step [m], shape (2,).

        It stays on the segment between the feet.
        """
        remaining = max(state.phase_end - state.time, _SHORTEST_SHIFT) + self.switch
        cop = balancing_cop(self.dcm(state), self.first_step_dcm(state), self.omega, remaining)
        return _onto_segment(cop, state.feet[0, :2], state.feet[1, :2])


def _asked(state: GaitState) -> tuple[Array, Array, Array, float]:
    """Return the arguments of `learned_command`."""
    return state.velocity, state.speed_scale, state.speed_offset, state.turn_rate


def _onto_segment(p: Array, a: Array, b: Array) -> Array:
    """Return the point of the segment from `a` to `b` that is nearest to `p`."""
    d = b - a
    length_2 = max(float(d @ d), 1e-12)
    s = float(np.clip((p - a) @ d / length_2, 0.0, 1.0))
    return a + s * d
