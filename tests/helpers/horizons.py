"""Phases and pieces of the DCM of a `GaitHorizon` by name, and horizons written down by hand."""

from typing import NamedTuple

import numpy as np

from drake_linefoot.gait import schedule
from drake_linefoot.gait.horizon import plan_horizon
from drake_linefoot.gait.state import SIZE
from drake_linefoot.gait.swing import Swing
from drake_linefoot.parts import FOREVER, KNOTS
from drake_linefoot.signals import GaitHorizon


class Phase(NamedTuple):
    """An interval in which the same feet stand; where they do, or will."""

    start: float
    end: float
    contact: tuple
    feet: np.ndarray
    swings: tuple[Swing | None, Swing | None] = (None, None)

    @property
    def swing_side(self):
        """Side of the only foot in the air, or None."""
        assert any(self.contact)
        return None if all(self.contact) else self.contact.index(0.0)

    @property
    def swing(self):
        """The only swing, or None."""
        return None if all(self.contact) else self.swings[self.swing_side]


class Piece(NamedTuple):
    """A piece of a DCM, xi(t) = centre + amplitude exp(rate (t - start))."""

    start: float
    end: float
    centre: np.ndarray
    amplitude: np.ndarray
    rate: float
    omega: float


def horizon_at(state, constants, length, knots=KNOTS):
    """The horizon of a state of the gait."""
    return plan_horizon(np.array([state]), np.array([constants]), length, knots)


def swing_of(horizon, phase, side):
    """The swing of a foot in a phase; None where it stands."""
    return None if horizon.contact[phase, side] else schedule.swing_of(horizon, phase, side)


def phases_of(horizon):
    """All phases of a horizon."""
    h = horizon
    return [
        Phase(
            *h.ends[i],
            tuple(h.contact[i]),
            h.feet[i],
            tuple(swing_of(h, i, side) for side in (0, 1)),
        )
        for i in range(int(h.phases))
    ]


def piece_of(row):
    """The piece in a row of `GaitHorizon.dcm`."""
    start, end, rate, omega = row[[0, 1, 6, 7]]
    return Piece(start, end, row[2:4], row[4:6], rate, omega)


def pieces_of(horizon):
    """All pieces of a horizon's DCM."""
    return [piece_of(row) for row in horizon.dcm[: int(horizon.pieces)]]


def rows_of(pieces):
    """Rows of `GaitHorizon.dcm`."""
    return np.array([(p.start, p.end, *p.centre, *p.amplitude, p.rate, p.omega) for p in pieces])


def horizon_of(phases, slope=(0.0, 0.0)):
    """A horizon of phases; its DCM rests, and all that they do not say is zero."""
    still = Swing(0.0, 0.0, 0.0, np.zeros((3, SIZE)), np.zeros(SIZE), 0.0, 0.0)
    swings = [[swing or still for swing in p.swings] for p in phases]
    landings = {
        (swing.end, side): p.feet[side]
        for p in phases for side, swing in enumerate(p.swings) if swing
    }  # fmt: skip
    places = [landings[at] for at in sorted(landings)]
    return GaitHorizon(
        time=phases[0].start, phases=float(len(phases)),
        ends=np.array([(p.start, p.end) for p in phases]),
        contact=np.array([p.contact for p in phases], dtype=float),
        slopes=np.tile(slope, (len(phases), 2, 1)), feet=np.array([p.feet for p in phases]),
        swing=np.array([[(*s[:3], *s[5:]) for s in p] for p in swings]),
        reference=np.array([[s.reference for s in p] for p in swings]),
        target=np.array([[s.target for s in p] for p in swings]),
        pieces=1.0,
        dcm=rows_of([Piece(phases[0].start, FOREVER, [0.0, 0.0], [0.0, 0.0], 1.0, 1.0)]),
        rise=np.zeros((1, 4)),
        coming=float(len(places)), footholds=np.array(places).reshape(-1, 4),
        yaw=0.0, turn_rate=0.0, omega=1.0, com_height=0.0, ground=np.zeros(3),
        slope=np.array(slope), friction=1.0, external=np.zeros(6), lean=np.zeros(2),
        arm_swing=0.0,
    )  # fmt: skip
