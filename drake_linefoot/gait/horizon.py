"""The gait over a horizon: phases, footholds and the DCM that goes with them.

Phases follow from touchdowns and d alone: a foot lifts d after the other one has landed, whether d
is above 0, as in a walk, or below.
"""

import numpy as np

from drake_linefoot.gait.contacts import (
    in_contact,
    in_double_support,
    in_final_step,
    is_stepping,
    standing_still,
)
from drake_linefoot.gait.footholds import cop_reach, cop_towards, known_foothold
from drake_linefoot.gait.footsteps import (
    foot_heading,
    nearest_turn,
    nominal_strides,
    settle_time,
    step_command,
    swing_time,
    weight_shift,
)
from drake_linefoot.gait.known_ground import (
    height_at,
    is_felt,
    level_between,
    patch_at,
    point_of,
    slope_at,
    snapped,
)
from drake_linefoot.gait.outlook import (
    FOOTHOLD,
    OF_PIECES,
    PHASE,
    PIECE,
    Outlook,
    add_bounce,
    add_contacts,
    add_flight,
    add_piece,
    add_swing,
    outlook,
    write_level,
    write_phase,
    write_piece,
)
from drake_linefoot.gait.patches import line_on_ground, line_pitch
from drake_linefoot.gait.pendulum import balancing_cop, dcm, dcm_offset, propagate_dcm
from drake_linefoot.gait.running import bounce_cop, run_foothold
from drake_linefoot.gait.state import (
    PITCH,
    PLACE,
    SIZE,
    YAW,
    GaitConstants,
    GaitState,
    Records,
)
from drake_linefoot.gait.swing import Swing
from drake_linefoot.gait.swing_foot import present_swing, step_of
from drake_linefoot.layout import Layout
from drake_linefoot.math.compiled import compiled, inlined
from drake_linefoot.parts import FOREVER
from drake_linefoot.signals import GaitHorizon, fill_horizon, open_horizon
from drake_linefoot.types import Array

_AT_0 = Layout(GaitHorizon, {"knots": 0}).size  # of the vector, which grows with the knots
_PER_KNOT = Layout(GaitHorizon, {"knots": 1}).size - _AT_0


@compiled
def add_stance(o: Outlook, start: float, s: GaitState, c: GaitConstants) -> None:
    """Stand on both feet for ever, the DCM going to the middle between them."""
    add_contacts(o, start)
    write_phase(o, FOREVER)
    if not is_felt(s, int(s.terrain.under[int(s.clock.side)])):
        lower = min(o.feet[0, 2], o.feet[1, 2])
        o.level[0] = lower
        write_level(o, start - 1.0, start, lower, s.robot.feet[int(s.clock.side), 2])
    middle = 0.5 * (o.feet[0, :2] + o.feet[1, :2])
    write_piece(o, middle, FOREVER, -c.capture_rate, c.omega)


@compiled
def add_step(
    o: Outlook, start: float, lift: float, side: int, s: GaitState, c: GaitConstants
) -> float:
    """Append the rest of a step onto `side`, which bears from `start` on.

    Args:
        o: the horizon.
        start: when `side` touches down [s].
        lift: when the other foot is lifted: later by d [s].
        side: 0 left, 1 right.
        s: state of the gait.
        c: constants.

    Returns:
        When the other foot lands [s].
    """
    command, switch, known = step_command(s, c), weight_shift(s, c)[1], int(s.clock.side)
    foot, before = 1 - side, o.feet[1 - side].copy()
    land, stance = lift + swing_time(s, c), o.feet[side, :2].copy()
    after = land - s.clock.time
    if s.command.flight > 0.0:
        add_stride(o, side, land, s, c)
        heading, place = run_foothold(s, o.com, after, foot, c)
        place, patch = snapped(s, place, heading, c)
    else:
        add_level(o, start, land, o.level[0], s)
        add_piece(o, before[:2], start + switch, c.omega)
        heading = foot_heading(s.command.yaw, s.command.turn_rate, after, command.duration)
        left = land + switch - o.at[OF_PIECES]
        xi = propagate_dcm(o.xi, stance, c.omega, left)
        place, patch, aim = known_foothold(s, xi, stance, heading, foot, command, c)
        reach = cop_reach(s, patch, c)
        level = level_between(o.feet[side, 2], height_at(s, patch, known, place))
        add_level(o, start, land, level, s)
        cop = cop_towards(o.xi, aim, o.feet[side], c.omega, left, reach)
        add_piece(o, cop, land + switch, c.omega)
        o.level[0] = level
    reference = np.zeros((3, SIZE))
    reference[0, :3], reference[0, YAW] = before[:3], before[3]
    stood = patch_at(s, before)
    reference[0, PITCH] = line_pitch(slope_at(s, stood), before[3])
    yaw = nearest_turn(heading, before[3])
    target = line_on_ground(slope_at(s, patch), point_of(s, patch, known), place, yaw)
    lands, height = target[:4].copy(), s.swing.height[foot]
    lands[3] = heading
    add_contacts(o, lift)
    heel, settle = s.swing.heel[foot], settle_time(s, c)
    step = step_of(s, stood, known, target, c)
    swing = Swing(lift, land, lift, reference, target, height, settle, heel[0], heel[1], step)
    add_swing(o, foot, lands, slope_at(s, patch), swing)
    return land


@compiled
def add_level(o: Outlook, begin: float, end: float, level: float, s: GaitState) -> None:
    """Let the CoM go to another height in the piece that follows, see `write_level`.

    Over ground that is felt it goes along its slope.
    """
    if not is_felt(s, int(s.terrain.under[int(s.clock.side)])):
        write_level(o, begin, end, level, s.robot.feet[int(s.clock.side), 2])


@compiled
def add_stride(o: Outlook, side: int, land: float, s: GaitState, c: GaitConstants) -> None:
    """Let the CoM bounce on a foot, and fly until the other one lands at `land` [s]."""
    flight = s.command.flight
    add_bounce(o, bounce_cop(o.feet[side], c), land - flight, flight, c)
    add_flight(o, land, c)


@compiled
def walk_on(
    o: Outlook, start: float, side: int, length: float, s: GaitState, c: GaitConstants
) -> None:
    """Append steps, each from its touchdown to the next, until a `length` [s] is covered.

    At `start` the foot `side` touches down, or the weight begins to go onto it.
    """
    end, overlap = s.clock.time + length, weight_shift(s, c)[0]
    known = min(start, start + overlap)  # then the next foot is lifted, or this one lands
    add_contacts(o, known)
    while known < end and o.rows[PHASE] < len(o.horizon.ends):
        start, side = add_step(o, start, start + overlap, side, s, c), 1 - side
        known = min(start, start + overlap)
        add_contacts(o, known)


@inlined
def add_phases(o: Outlook, length: float, s: GaitState, c: GaitConstants) -> None:
    """Append all phases of a horizon of a `length` [s]."""
    time, side = s.clock.time, int(s.clock.side)
    start = s.clock.touchdown[side]
    if standing_still(s):
        add_stance(o, time, s, c)
    elif not is_stepping(s):
        add_piece(o, shift_cop(s, c), start + c.switch, c.omega)
        walk_on(o, start, side, length, s, c)
    elif in_double_support(s):
        land = add_step(o, start, s.clock.lift_off[1 - side], side, s, c)
        walk_on(o, land, 1 - side, length, s, c)
    else:
        for foot in (side, 1 - side):  # as they land
            if not in_contact(s, foot):
                lands, slope = s.swing.target[foot][PLACE], o.slopes[foot].copy()
                add_swing(o, foot, lands, slope, present_swing(s, foot, c))
        end = s.clock.touchdown[1 - side]
        if s.command.flight > 0.0:
            if not in_contact(s, side):
                add_flight(o, s.clock.touchdown[side], c)
            add_stride(o, side, end, s, c)
        else:
            reach = cop_reach(s, int(s.terrain.under[1 - side]), c)
            aim, left = s.swing.aim[1 - side], end + weight_shift(s, c)[1] - time
            level = level_between(s.robot.feet[side, 2], s.swing.target[1 - side, 2])
            add_level(o, start, end, level, s)
            cop = cop_towards(o.xi, aim, s.robot.feet[side], c.omega, left, reach)
            add_piece(o, cop, end, c.omega)
            o.level[0] = level
        if in_final_step(s):
            add_stance(o, end, s, c)
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
    o = outlook(h, s, c)
    add_phases(o, length, s, c)
    says = GaitHorizon(
        s.clock.time, o.rows[PHASE], h.ends, h.contact, h.slopes, h.feet, h.swing, h.reference,
        h.target, o.rows[PIECE], h.dcm, h.rise, o.rows[FOOTHOLD], h.footholds, s.command.yaw,
        s.command.turn_rate,
        c.omega, c.com_height, s.robot.feet[int(s.clock.side), :3], s.ground.slope[:],
        s.footing.friction, s.robot.external[:], s.robot.lean[:], c.arm_swing,
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
    start = s.clock.touchdown[side]
    remaining = max(start - s.clock.time, c.shift_duration_min) + c.switch
    xi = dcm(s.robot.pendulum_com[:], s.robot.com_velocity[:], c.omega)
    cop = balancing_cop(xi, goal, c.omega, remaining)
    return onto_segment(cop, s.robot.feet[0, :2], s.robot.feet[1, :2])


@compiled
def onto_segment(p: Array, a: Array, b: Array) -> Array:
    """Return the point of the segment from `a` to `b` that is nearest to `p`, shape (2,) each."""
    d = b - a
    share = (d[0] * (p[0] - a[0]) + d[1] * (p[1] - a[1])) / max(d[0] * d[0] + d[1] * d[1], 1e-12)
    return a + min(max(share, 0.0), 1.0) * d
