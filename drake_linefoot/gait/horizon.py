"""The gait over a horizon: phases, footholds and the DCM that goes with them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from drake_linefoot.gait.footstep_kernels import nearest_turn
from drake_linefoot.gait.ground_kernels import line_pitch
from drake_linefoot.gait.pendulum import DcmPiece
from drake_linefoot.gait.pendulum_kernels import propagate_dcm
from drake_linefoot.gait.planner import Gait
from drake_linefoot.gait.schedule import Phase, Schedule
from drake_linefoot.gait.state import GaitState, Mode
from drake_linefoot.gait.swing import Swing
from drake_linefoot.gait.swing_kernels import PITCH, SIZE, YAW

Array = NDArray[np.float64]


@dataclass(frozen=True)
class GaitHorizon:
    """What is planned from now on.

    Attributes:
        time: now [s].
        schedule: phases from now to beyond the horizon.
        dcm: pieces of the DCM reference over the same time.
        footholds: coming footholds [x, y, z, yaw], shape (n, 4), in order.
        yaw: desired heading now [rad].
        turn_rate: desired turn rate [rad/s].
        omega: natural frequency of the pendulum [1/s].
        com_height: desired height of the CoM above the ground [m].
        ground: a point of it, where the stance foot stands [m], shape (3,).
        slope: of the ground, rise per metre along x and y of the world, shape (2,).
    """

    time: float
    schedule: Schedule
    dcm: tuple[DcmPiece, ...]
    footholds: Array
    yaw: float
    turn_rate: float
    omega: float
    com_height: float
    ground: Array
    slope: Array


class _Builder:
    """Appends phases and DCM pieces one after the other."""

    def __init__(self, gait: Gait, state: GaitState, end: float) -> None:
        self.gait, self.state, self.end = gait, state, end
        self.phases: list[Phase] = []
        self.pieces: list[DcmPiece] = []
        self.feet = state.feet.copy()
        self.footholds: list[Array] = []
        self.xi = gait.placement.dcm(state)
        self.at = state.time  # end of the last DCM piece

    def piece(self, cop: Array, end: float) -> None:
        """Let the DCM move freely around `cop` until `end`."""
        if end <= self.at:
            return
        omega = self.gait.placement.omega
        cop = cop.copy()  # `feet` changes as steps are appended
        self.pieces.append(DcmPiece(self.at, end, cop, self.xi - cop, omega))
        self.xi = propagate_dcm(self.xi, cop, omega, end - self.at)
        self.at = end

    def capture(self) -> None:
        """Bring the DCM to the middle between the feet, for ever."""
        middle = 0.5 * (self.feet[0, :2] + self.feet[1, :2])
        rate = -self.gait.parameters.capture_rate
        self.pieces.append(DcmPiece(self.at, np.inf, middle, self.xi - middle, rate))

    def stand(self, start: float) -> None:
        """Stand on both feet for ever."""
        self.phases.append(Phase(start, np.inf, (True, True), self.feet.copy()))
        self.capture()

    def walk_on(self, start: float, side: int) -> None:
        """Append double and single supports until the horizon is covered.

        `start` is the beginning of a double support in which the weight goes to `side`.
        """
        step, p = self.gait.placement, self.gait.parameters
        while start < self.end:
            lift = start + p.double_support
            self.phases.append(Phase(start, lift, (True, True), self.feet.copy()))
            self.piece(self.feet[1 - side, :2], start + step.switch)
            land = lift + step.single_support(self.state)
            stance = self.feet[side, :2].copy()
            self.piece(stance, land + step.switch)
            place = step.foothold(self.state, self.xi, stance, 1 - side, land)
            self.single(lift, land, side, place)
            start, side = land, 1 - side

    def single(self, lift: float, land: float, side: int, place: Array) -> None:
        """Append a single support on `side` whose swing foot starts at rest."""
        reference = np.zeros((3, SIZE))
        reference[0, :3], reference[0, YAW] = self.feet[1 - side, :3], self.feet[1 - side, 3]
        reference[0, PITCH] = line_pitch(self.state.slope, reference[0, YAW])
        yaw = nearest_turn(place[3], reference[0, YAW])
        target = self.gait.placement.line(self.state, place, yaw)
        p = self.gait.parameters
        swing = Swing(lift, land, lift, reference, target, p.swing_height, p.settle_time)
        self.append_swing(lift, land, side, place, swing)

    def append_swing(self, lift: float, land: float, side: int, place: Array, swing: Swing) -> None:
        """Append a single support and put the swing foot down at its end."""
        self.feet[1 - side] = place
        self.footholds.append(place)
        contact = (side == 0, side == 1)
        self.phases.append(Phase(lift, land, contact, self.feet.copy(), swing))


def plan_horizon(gait: Gait, state: GaitState, length: float) -> GaitHorizon:
    """Return phases, footholds and DCM over a horizon.

    Args:
        gait: the gait.
        state: its present state.
        length: length of the horizon [s].

    Returns:
        The plan; its last phase and piece end beyond the horizon.
    """
    b = _Builder(gait, state, state.time + length)
    side = state.side
    if state.mode == Mode.STAND:
        b.stand(state.time)
    elif state.mode == Mode.SHIFT:
        b.phases.append(Phase(state.time, state.phase_end, (True, True), b.feet.copy()))
        b.piece(gait.placement.shift_cop(state), state.phase_end + gait.placement.switch)
        b.walk_on(state.phase_end, side)
    elif state.mode == Mode.DOUBLE:
        _rest_of_double(b, gait, state)
    else:
        place = np.array([*state.target[:3], state.target[YAW]])
        b.append_swing(state.time, state.phase_end, side, place, gait.swing(state))
        if state.closing:
            b.piece(b.feet[side, :2], state.phase_end)
            b.stand(state.phase_end)
        else:
            b.piece(b.feet[side, :2], state.phase_end)
            b.walk_on(state.phase_end, 1 - side)
    return GaitHorizon(
        time=state.time,
        schedule=Schedule(tuple(b.phases), state.slope),
        dcm=tuple(b.pieces),
        footholds=np.array(b.footholds).reshape(-1, 4),
        yaw=state.yaw,
        turn_rate=state.turn_rate,
        omega=gait.placement.omega,
        com_height=gait.parameters.com_height,
        ground=state.feet[side, :3],
        slope=state.slope,
    )


def _rest_of_double(b: _Builder, gait: Gait, state: GaitState) -> None:
    """Finish the present double support, then walk on."""
    side = state.side
    b.phases.append(Phase(state.time, state.phase_end, (True, True), b.feet.copy()))
    b.piece(b.feet[1 - side, :2], state.phase_start + gait.placement.switch)
    land = state.phase_end + gait.placement.single_support(state)
    stance = b.feet[side, :2].copy()
    b.piece(stance, land + gait.placement.switch)
    place = gait.placement.foothold(state, b.xi, stance, 1 - side, land)
    b.single(state.phase_end, land, side, place)
    b.walk_on(land, 1 - side)
