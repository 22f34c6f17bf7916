"""The gait over a horizon: phases, footholds and the DCM that goes with them."""

from typing import Any

import numpy as np

from drake_linefoot.gait.footsteps import (
    foot_heading,
    nearest_turn,
    next_foothold,
    nominal_strides,
    settle_time,
    step_command,
    swing_duration,
    weight_shift,
)
from drake_linefoot.gait.ground import line_on_ground, line_pitch
from drake_linefoot.gait.pendulum import balancing_cop, dcm, dcm_offset, propagate_dcm
from drake_linefoot.gait.state import PITCH, PLACE, SIZE, YAW, fields_of
from drake_linefoot.gait.swing import Swing
from drake_linefoot.parts import FOREVER
from drake_linefoot.signals import GaitHorizon
from drake_linefoot.statuses import Mode
from drake_linefoot.types import Array

_PHASE = "ends", "contact", "feet", "swing", "reference", "target"


class _Builder:
    """Appends phases and DCM pieces one after the other."""

    def __init__(self, s: np.record, c: np.record, length: float) -> None:
        self.constants, self.command = c, step_command(s, c)
        self.single_support = swing_duration(s.velocity[0], c)
        self.s, self.c = fields_of(s), fields_of(c)
        self.double_support, self.switch = weight_shift(s, c)
        self.settle = settle_time(s, c)
        self.end: float = self.s.time + length
        self.phases: list[tuple[Any, ...]] = []  # rows of parts of `GaitHorizon`, see `_PHASE`
        self.pieces: list[tuple[float, ...]] = []
        self.feet: Array = self.s.feet.copy()
        self.footholds: list[Array] = []
        self.xi = dcm(self.s.pendulum_com, self.s.com_velocity, self.c.omega)
        self.at: float = self.s.time  # end of the last DCM piece

    def piece(self, cop: Array, end: float) -> None:
        """Let the DCM move freely around `cop` until `end`."""
        if end <= self.at:
            return
        self.pieces.append((self.at, end, *cop, *(self.xi - cop), self.c.omega))
        self.xi = propagate_dcm(self.xi, cop, self.c.omega, end - self.at)
        self.at = end

    def both(self, start: float, end: float) -> None:
        """Append a phase in which both feet stand."""
        swing = np.zeros(5), np.zeros((3, SIZE)), np.zeros(SIZE)
        self.phases.append(((start, end), (1.0, 1.0), self.feet.copy(), *swing))

    def stand(self, start: float) -> None:
        """Stand on both feet for ever, the DCM going to the middle between them."""
        self.both(start, FOREVER)
        middle = 0.5 * (self.feet[0, :2] + self.feet[1, :2])
        rate = -self.c.capture_rate
        self.pieces.append((self.at, FOREVER, *middle, *(self.xi - middle), rate))

    def walk_on(self, start: float, side: int) -> None:
        """Append double and single supports until the horizon is covered.

        `start` is the beginning of a double support in which the weight goes to `side`.
        """
        while start < self.end:
            self.both(start, start + self.double_support)
            start, side = self.step(start, start + self.double_support, side), 1 - side

    def step(self, start: float, lift: float, side: int) -> float:
        """Append the rest of a step onto `side`, whose double support goes from `start` to `lift`.

        Returns:
            When its swing foot lands [s].
        """
        s = self.s
        self.piece(self.feet[1 - side, :2], start + self.switch)
        land = lift + self.single_support
        stance = self.feet[side, :2]
        self.piece(stance, land + self.switch)
        heading = foot_heading(s.yaw, s.turn_rate, land - s.time, self.command.duration)
        place, _ = next_foothold(self.xi, stance, heading, 1 - side, self.command, self.constants)
        foot, known = self.feet[1 - side], s.feet[int(s.side)]
        reference = np.zeros((3, SIZE))
        reference[0, :3], reference[0, YAW] = foot[:3], foot[3]
        reference[0, PITCH] = line_pitch(s.slope, foot[3])
        target = line_on_ground(s.slope, known, place, nearest_turn(heading, foot[3]))
        swing = Swing(lift, land, lift, reference, target, s.swing_height, self.settle)
        self.swing(lift, land, side, np.array([*target[:3], heading]), swing)
        return land

    def swing(self, lift: float, land: float, side: int, place: Array, swing: Swing) -> None:
        """Append a single support on `side` and put the swing foot down at its end."""
        self.feet[1 - side] = place
        self.footholds.append(place)
        contact = float(side == 0), float(side == 1)
        about = (swing.start, swing.end, swing.now, swing.height, swing.settle)
        motion = about, swing.reference, swing.target
        self.phases.append(((lift, land), contact, self.feet.copy(), *motion))


def plan_horizon(s: np.record, c: np.record, length: float) -> GaitHorizon:
    """Return phases, footholds and DCM over a horizon.

    Args:
        s: state of the gait, see `state.GAIT`; the plan keeps parts of it.
        c: its constants, see `gait_constants`.
        length: length of the horizon [s].

    Returns:
        The plan, with as many rows as it has; its last phase and piece end beyond the horizon.
    """
    b = _Builder(s, c, length)
    now, constants = b.s, b.c
    time, end, side = now.time, now.phase_end, int(now.side)
    if now.mode == Mode.STAND:
        b.stand(time)
    elif now.mode == Mode.SHIFT:
        b.both(time, end)
        b.piece(shift_cop(s, c), end + constants.switch)
        b.walk_on(end, side)
    elif now.mode == Mode.DOUBLE:
        b.both(time, end)
        begun = -np.inf if now.again else now.phase_start  # the weight is there already
        b.walk_on(b.step(begun, end, side), 1 - side)
    else:
        b.swing(time, end, side, now.target[PLACE], present_swing(s, c))
        b.piece(now.feet[side, :2], end)
        if now.closing:
            b.stand(end)
        else:
            b.walk_on(end, 1 - side)
    parts = {
        name: np.array(rows) for name, rows in zip(_PHASE, zip(*b.phases, strict=True), strict=True)
    }
    return GaitHorizon(
        time=time,
        phases=float(len(b.phases)),
        **parts,
        pieces=float(len(b.pieces)),
        dcm=np.array(b.pieces),
        coming=float(len(b.footholds)),
        footholds=np.array(b.footholds).reshape(-1, 4),
        yaw=now.yaw,
        turn_rate=now.turn_rate,
        omega=constants.omega,
        com_height=constants.com_height,
        ground=now.feet[side, :3],
        slope=now.slope,
        friction=now.friction,
        external=now.external,
        lean=now.lean,
    )


def present_swing(s: np.record, c: np.record) -> Swing:
    """Return the swing in progress, given state and constants of the gait."""
    now = s.phase_start, s.phase_end, s.time, s.reference, s.target
    return Swing(*now, s.swing_height, settle_time(s, c))


def shift_cop(s: np.record, c: np.record) -> Array:
    """Return the CoP of the weight shift before the first step [m], shape (2,).

    It takes the DCM to where it has to be when the weight comes onto the first stance foot, and
    stays on the segment between the feet.
    """
    side, command = int(s.side), step_command(s, c)
    strides = nominal_strides(command, c, s.yaw, side)
    goal = s.feet[side, :2] + dcm_offset(strides, c.omega, command.duration)
    remaining = max(s.phase_end - s.time, c.shift_duration_min) + c.switch
    cop = balancing_cop(dcm(s.pendulum_com, s.com_velocity, c.omega), goal, c.omega, remaining)
    return _onto_segment(cop, s.feet[0, :2], s.feet[1, :2])


def _onto_segment(p: Array, a: Array, b: Array) -> Array:
    """Return the point of the segment from `a` to `b` that is nearest to `p`."""
    d = b - a
    length_2 = max(float(d @ d), 1e-12)
    share = float(np.clip((p - a) @ d / length_2, 0.0, 1.0))
    return a + share * d
