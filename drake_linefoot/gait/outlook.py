"""A horizon that is being written: contacts become phases, footholds and pieces of the DCM."""

from typing import NamedTuple

import numpy as np

from drake_linefoot.constants import STANDARD_GRAVITY
from drake_linefoot.gait.known_ground import slopes_of
from drake_linefoot.gait.pendulum import dcm, propagate_dcm
from drake_linefoot.gait.running import after_bounce, after_flight, bounce, com_above_ground
from drake_linefoot.gait.state import SIZE, GaitConstants, GaitState
from drake_linefoot.gait.swing import Swing
from drake_linefoot.math.compiled import compiled
from drake_linefoot.signals import GaitHorizon
from drake_linefoot.types import Array


class Outlook(NamedTuple):
    """A horizon that is being written, and where it has got to.

    Attributes:
        horizon: rows of its parts, the first of which are written.
        rows: how many phases, pieces of the DCM and footholds there are, shape (3,).
        feet: where they stand at the end of the last phase, or will, shape (2, 4).
        slopes: of the ground there, shape (2, 2).
        lands: when those land that swing then [s]; infinity for one that stands, shape (2,).
        swing: what else is known of their swings, as in the horizon, shape (2, 8).
        reference: likewise, shape (2, 3, 5).
        target: likewise, shape (2, 5).
        xi: DCM at the end of the last piece [m], shape (2,).
        com: CoM above the ground in a run, and its velocity, likewise [m, m/s], shape (2, 3).
        level: from where the height of the CoM counts at the end of the last step [m], shape (1,).
        at: the ends of the last piece and of the last phase [s], shape (2,).
    """

    horizon: GaitHorizon
    rows: Array
    feet: Array
    slopes: Array
    lands: Array
    swing: Array
    reference: Array
    target: Array
    xi: Array
    com: Array
    level: Array
    at: Array


PHASE, PIECE, FOOTHOLD = 0, 1, 2  # in `Outlook.rows`
OF_PIECES, OF_PHASES = 0, 1  # in `Outlook.at`


@compiled
def outlook(horizon: GaitHorizon, s: GaitState, c: GaitConstants) -> Outlook:
    """Return a horizon of which nothing is written, from a state on."""
    xi = dcm(s.robot.pendulum_com[:], s.robot.com_velocity[:], c.omega)
    now, still = np.full(2, s.clock.time), np.full(2, np.inf)
    swing, reference, target = np.zeros((2, 8)), np.zeros((2, 3, SIZE)), np.zeros((2, SIZE))
    feet, com = s.robot.feet.copy(), com_above_ground(s)
    level = np.full(1, s.terrain.level)
    return Outlook(
        horizon, np.zeros(3), feet, slopes_of(s), still, swing, reference, target, xi, com, level,
        now,
    )  # fmt: skip


@compiled
def add_piece(o: Outlook, cop: Array, end: float, omega: float) -> None:
    """Let the DCM move freely around `cop` until `end`."""
    if end > o.at[OF_PIECES]:
        write_piece(o, cop, end, omega, omega)
        o.xi[:] = propagate_dcm(o.xi, cop, omega, end - o.at[OF_PIECES])
        o.at[OF_PIECES] = end


@compiled
def add_bounce(o: Outlook, cop: Array, end: float, flight: float, c: GaitConstants) -> None:
    """Let the CoM bounce on a CoP until a foot is lifted at `end`, for a flight of so long [s]."""
    T = end - o.at[OF_PIECES]
    if T > 0.0:
        cubic, omega = bounce(o.com, T, flight, c)
        o.xi[:] = dcm(o.com[0], o.com[1], omega)
        write_rise(o, cubic, c)
        write_piece(o, cop, end, omega, omega)
        o.com[:] = after_bounce(o.com, cop, T, cubic, omega)
        o.at[OF_PIECES] = end


@compiled
def add_flight(o: Outlook, end: float, c: GaitConstants) -> None:
    """Let the CoM fly until a foot lands at `end` [s]."""
    T = end - o.at[OF_PIECES]
    if T > 0.0:
        o.xi[:] = o.com[1, :2]
        cubic = np.array((o.com[0, 2], o.com[1, 2], -0.5 * STANDARD_GRAVITY, 0.0))
        write_rise(o, cubic, c)
        write_piece(o, np.zeros(2), end, 0.0, 0.0)
        o.com[:] = after_flight(o.com, T)
        o.at[OF_PIECES] = end


@compiled
def write_level(o: Outlook, begin: float, end: float, level: float, base: float) -> None:
    """Write the height of the CoM in a piece of a step over ground that is known.

    Args:
        o: the horizon.
        begin: when a foot touched down [s].
        end: when the next one does [s].
        level: what its height counts from then [m].
        base: from where it counts in the horizon [m].
    """
    row, T = int(o.rows[PIECE]), end - begin
    if row < len(o.horizon.rise):
        a, d = min((o.at[OF_PIECES] - begin) / T, 1.0), level - o.level[0]
        o.horizon.rise[row, 0] = o.level[0] + d * a * a * (3.0 - 2.0 * a) - base
        if a < 1.0:
            o.horizon.rise[row, 1] = 6.0 * d * a * (1.0 - a) / T
            o.horizon.rise[row, 2] = d * (3.0 - 6.0 * a) / T**2
            o.horizon.rise[row, 3] = -2.0 * d / T**3


@compiled
def write_rise(o: Outlook, cubic: Array, c: GaitConstants) -> None:
    """Write the height of the CoM above the ground in the piece that follows."""
    row = int(o.rows[PIECE])
    if row < len(o.horizon.rise):
        o.horizon.rise[row] = cubic
        o.horizon.rise[row, 0] -= c.com_height


@compiled
def write_piece(o: Outlook, centre: Array, end: float, rate: float, omega: float) -> None:
    """Append a piece of the DCM; beyond the last row it is left out."""
    row = int(o.rows[PIECE])
    if row < len(o.horizon.dcm):
        piece = o.horizon.dcm[row]
        piece[0], piece[1], piece[6], piece[7] = o.at[OF_PIECES], end, rate, omega
        piece[2:4], piece[4:6] = centre, o.xi - centre
        o.rows[PIECE] += 1.0


@compiled
def write_phase(o: Outlook, end: float) -> None:
    """Append a phase in which feet stand or swing as they do; beyond the last row none."""
    row = int(o.rows[PHASE])
    if row < len(o.horizon.ends) and end > o.at[OF_PHASES]:
        o.horizon.ends[row, 0], o.horizon.ends[row, 1] = o.at[OF_PHASES], end
        o.horizon.feet[row], o.horizon.slopes[row] = o.feet, o.slopes
        for foot in range(2):
            stands = o.lands[foot] == np.inf
            o.horizon.contact[row, foot] = stands
            if not stands:
                o.horizon.swing[row, foot] = o.swing[foot]
                o.horizon.reference[row, foot] = o.reference[foot]
                o.horizon.target[row, foot] = o.target[foot]
        o.rows[PHASE] += 1.0
    o.at[OF_PHASES] = max(end, o.at[OF_PHASES])


@compiled
def add_contacts(o: Outlook, end: float) -> None:
    """Append phases until `end`: one ends wherever a foot lands, and there."""
    while True:
        first = 0 if o.lands[0] <= o.lands[1] else 1
        if o.lands[first] > end:
            break
        write_phase(o, o.lands[first])
        o.lands[first] = np.inf
    write_phase(o, end)


@compiled
def add_swing(o: Outlook, foot: int, lands: Array, slope: Array, swing: Swing) -> None:
    """Lift a foot at the end of the last phase.

    Args:
        o: the horizon.
        foot: 0 left, 1 right.
        lands: where it will, place and heading [x, y, z, yaw].
        slope: of the ground there, shape (2,).
        swing: of it.
    """
    o.feet[foot], o.slopes[foot], o.lands[foot] = lands, slope, swing.end
    foothold = int(o.rows[FOOTHOLD])
    if foothold < len(o.horizon.footholds):
        o.horizon.footholds[foothold] = lands
        o.rows[FOOTHOLD] += 1.0
    about = (
        swing.start,
        swing.end,
        swing.now,
        swing.height,
        swing.settle,
        swing.heel,
        swing.raised,
        swing.step,
    )
    for i in range(len(about)):
        o.swing[foot, i] = about[i]
    o.reference[foot], o.target[foot] = swing.reference, swing.target
