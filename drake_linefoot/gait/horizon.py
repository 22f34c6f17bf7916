"""The gait over a horizon: phases, footholds and the DCM that goes with them."""

import math
from typing import NamedTuple

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
from drake_linefoot.gait.state import (
    DOUBLE,
    PITCH,
    PLACE,
    SHIFT,
    SIZE,
    STAND,
    YAW,
    GaitConstants,
    GaitState,
    Records,
)
from drake_linefoot.gait.swing import Swing
from drake_linefoot.gait.swing_foot import present_swing
from drake_linefoot.layout import Layout
from drake_linefoot.math.compiled import compiled, inlined
from drake_linefoot.parts import FOREVER
from drake_linefoot.signals import GaitHorizon, fill_horizon, open_horizon
from drake_linefoot.types import Array


class Outlook(NamedTuple):
    """A horizon that is being written, and where it has got to.

    Attributes:
        horizon: rows of its parts, the first of which are written.
        rows: how many phases, pieces of the DCM and footholds there are, shape (3,).
        feet: where they stand at the end of the last phase, shape (2, 4).
        xi: DCM at the end of the last piece [m], shape (2,).
        at: that end [s], shape (1,).
    """

    horizon: GaitHorizon
    rows: Array
    feet: Array
    xi: Array
    at: Array


PHASE, PIECE, FOOTHOLD = 0, 1, 2  # in `Outlook.rows`
_AT_0 = Layout(GaitHorizon, {"knots": 0}).size  # of the vector, which grows with the knots
_PER_KNOT = Layout(GaitHorizon, {"knots": 1}).size - _AT_0


@compiled
def add_piece(o: Outlook, cop: Array, end: float, omega: float) -> None:
    """Let the DCM move freely around `cop` until `end`."""
    if end > o.at[0]:
        write_piece(o, cop, end, omega)
        o.xi[:] = propagate_dcm(o.xi, cop, omega, end - o.at[0])
        o.at[0] = end


@compiled
def write_piece(o: Outlook, centre: Array, end: float, rate: float) -> None:
    """Append a piece of the DCM; beyond the last row it is left out."""
    row = int(o.rows[PIECE])
    if row < len(o.horizon.dcm):
        piece = o.horizon.dcm[row]
        piece[0], piece[1], piece[6] = o.at[0], end, rate
        piece[2:4], piece[4:6] = centre, o.xi - centre
        o.rows[PIECE] += 1.0


@compiled
def write_phase(o: Outlook, start: float, end: float, left: bool, right: bool) -> int:
    """Append a phase, whose swing is still to be written.

    Returns:
        Its row; -1 where it is left out, beyond the last one.
    """
    row = int(o.rows[PHASE])
    if row == len(o.horizon.ends):
        return -1
    o.horizon.ends[row, 0], o.horizon.ends[row, 1] = start, end
    o.horizon.contact[row, 0], o.horizon.contact[row, 1] = left, right
    o.horizon.feet[row] = o.feet
    o.rows[PHASE] += 1.0
    return row


@compiled
def add_swing(o: Outlook, side: int, lands: Array, swing: Swing) -> None:
    """Append a single support on `side`, at whose end the swing foot is put down.

    Args:
        o: the horizon.
        side: 0 left, 1 right.
        lands: place and heading [x, y, z, yaw].
        swing: of the other foot.
    """
    o.feet[1 - side] = lands
    foothold = int(o.rows[FOOTHOLD])
    if foothold < len(o.horizon.footholds):
        o.horizon.footholds[foothold] = lands
        o.rows[FOOTHOLD] += 1.0
    row = write_phase(o, swing.now, swing.end, side == 0, side == 1)
    if row >= 0:
        about = (swing.start, swing.end, swing.now, swing.height, swing.settle)
        for i in range(len(about)):
            o.horizon.swing[row, 1 - side, i] = about[i]
        o.horizon.reference[row, 1 - side] = swing.reference
        o.horizon.target[row, 1 - side] = swing.target


@compiled
def add_stance(o: Outlook, start: float, c: GaitConstants) -> None:
    """Stand on both feet for ever, the DCM going to the middle between them."""
    write_phase(o, start, FOREVER, True, True)
    middle = 0.5 * (o.feet[0, :2] + o.feet[1, :2])
    write_piece(o, middle, FOREVER, -c.capture_rate)


@compiled
def add_step(
    o: Outlook, start: float, lift: float, side: int, s: GaitState, c: GaitConstants
) -> float:
    """Append the rest of a step onto `side`, whose double support goes from `start` to `lift`.

    Returns:
        When its swing foot lands [s].
    """
    command, switch, known = step_command(s, c), weight_shift(s, c)[1], int(s.clock.side)
    add_piece(o, o.feet[1 - side, :2].copy(), start + switch, c.omega)
    land, stance = lift + swing_duration(s.command.velocity[0], c), o.feet[side, :2].copy()
    add_piece(o, stance, land + switch, c.omega)
    after = land - s.clock.time
    heading = foot_heading(s.command.yaw, s.command.turn_rate, after, command.duration)
    place, _ = next_foothold(o.xi, stance, heading, 1 - side, command, c)
    foot, reference = o.feet[1 - side], np.zeros((3, SIZE))
    reference[0, :3], reference[0, YAW] = foot[:3], foot[3]
    reference[0, PITCH] = line_pitch(s.ground.slope[:], foot[3])
    yaw = nearest_turn(heading, foot[3])
    target = line_on_ground(s.ground.slope[:], s.robot.feet[known], place, yaw)
    lands = target[:4].copy()
    lands[3] = heading
    swing = Swing(lift, land, lift, reference, target, s.swing.height, settle_time(s, c))
    add_swing(o, side, lands, swing)
    return land


@compiled
def walk_on(
    o: Outlook, start: float, side: int, length: float, s: GaitState, c: GaitConstants
) -> None:
    """Append double and single supports until the horizon of a `length` [s] is covered.

    `start` is the beginning of a double support in which the weight goes to `side`.
    """
    end, both = s.clock.time + length, weight_shift(s, c)[0]
    while start < end and o.rows[PHASE] < len(o.horizon.ends):
        write_phase(o, start, start + both, True, True)
        start, side = add_step(o, start, start + both, side, s, c), 1 - side


@inlined
def add_phases(o: Outlook, length: float, s: GaitState, c: GaitConstants) -> None:
    """Append all phases of a horizon of a `length` [s]."""
    time, end, side = s.clock.time, s.clock.phase_end, int(s.clock.side)
    if s.clock.mode == STAND:
        add_stance(o, time, c)
    elif s.clock.mode == SHIFT:
        write_phase(o, time, end, True, True)
        add_piece(o, shift_cop(s, c), end + c.switch, c.omega)
        walk_on(o, end, side, length, s, c)
    elif s.clock.mode == DOUBLE:
        write_phase(o, time, end, True, True)
        begun = -math.inf if s.recovery.again else s.clock.phase_start  # the weight is there
        walk_on(o, add_step(o, begun, end, side, s, c), 1 - side, length, s, c)
    else:
        lands = s.swing.target[PLACE]
        add_swing(o, side, lands, present_swing(s, c))
        add_piece(o, s.robot.feet[side, :2].copy(), end, c.omega)
        if s.clock.closing:
            add_stance(o, end, c)
        else:
            walk_on(o, end, 1 - side, length, s, c)


def plan_horizon(gait: Records, constants: Records, length: float, knots: int) -> GaitHorizon:
    """Return phases, footholds and DCM over a horizon.

    Args:
        gait: a `GaitState`, an array of one.
        constants: `GaitConstants`, likewise.
        length: of the horizon [s].
        knots: intervals of the MPC over it; what comes later than so many can reach, between
            which no phase ends, is left out.
    """
    return Layout(GaitHorizon, {"knots": knots}).open(
        horizon_vector(gait, constants, length, knots)
    )


@compiled
def horizon_vector(gait: Records, constants: Records, length: float, knots: int) -> Array:
    """Return the same as it travels; behind its last phase, piece and foothold it is zero."""
    s: GaitState = gait[0]
    c: GaitConstants = constants[0]
    vector = np.zeros(_AT_0 + knots * _PER_KNOT)
    h = open_horizon(vector, knots)
    xi = dcm(s.robot.pendulum_com[:], s.robot.com_velocity[:], c.omega)
    o = Outlook(h, np.zeros(3), s.robot.feet.copy(), xi, np.array((s.clock.time,)))
    add_phases(o, length, s, c)
    says = GaitHorizon(
        s.clock.time, o.rows[PHASE], h.ends, h.contact, h.feet, h.swing, h.reference, h.target,
        o.rows[PIECE], h.dcm, o.rows[FOOTHOLD], h.footholds, s.command.yaw, s.command.turn_rate,
        c.omega, c.com_height, s.robot.feet[int(s.clock.side), :3], s.ground.slope[:],
        s.footing.friction, s.robot.external[:], s.robot.lean[:],
    )  # fmt: skip
    fill_horizon(vector, says, knots)
    return vector


@compiled
def shift_cop(s: GaitState, c: GaitConstants) -> Array:
    """Return the CoP of the weight shift before the first step [m], shape (2,).

    It takes the DCM to where it has to be when the weight comes onto the first stance foot, and
    stays on the segment between the feet.
    """
    side, command = int(s.clock.side), step_command(s, c)
    strides = nominal_strides(command, c, s.command.yaw, side)
    goal = s.robot.feet[side, :2] + dcm_offset(strides, c.omega, command.duration)
    remaining = max(s.clock.phase_end - s.clock.time, c.shift_duration_min) + c.switch
    xi = dcm(s.robot.pendulum_com[:], s.robot.com_velocity[:], c.omega)
    cop = balancing_cop(xi, goal, c.omega, remaining)
    return onto_segment(cop, s.robot.feet[0, :2], s.robot.feet[1, :2])


@compiled
def onto_segment(p: Array, a: Array, b: Array) -> Array:
    """Return the point of the segment from `a` to `b` that is nearest to `p`, shape (2,) each."""
    d = b - a
    share = (d[0] * (p[0] - a[0]) + d[1] * (p[1] - a[1])) / max(d[0] * d[0] + d[1] * d[1], 1e-12)
    return a + min(max(share, 0.0), 1.0) * d
