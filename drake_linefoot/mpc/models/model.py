"""What a model of the MPC is: the terms in which the models differ, under a name."""

from collections.abc import Callable
from dataclasses import dataclass

from drake_linefoot.gait.schedule import knots
from drake_linefoot.mpc.ecd import Linearisation
from drake_linefoot.mpc.models.motion import LinePlan, Robot
from drake_linefoot.signals import GaitHorizon, Reference, RobotDynamics
from drake_linefoot.types import Array


@dataclass(frozen=True)
class CentroidalMeasurement:
    """What the MPC starts from.

    Attributes:
        r, v: CoM [m, m/s], shape (3,).
        L: angular momentum about the CoM [kg m^2/s], shape (3,).
        R_WB: torso orientation, shape (3, 3).
    """

    r: Array
    v: Array
    L: Array
    R_WB: Array


def measure_centroidal(dynamics: RobotDynamics) -> CentroidalMeasurement:
    """Return the centroidal state of the whole robot.

    Args:
        dynamics: of the state.
    """
    d = dynamics
    return CentroidalMeasurement(r=d.p_WG, v=d.v_WG, L=d.L_G, R_WB=d.R_WB)


def phase_knots(
    horizon: GaitHorizon, begin: float, count: int, step: float, period: float
) -> Array:
    """Return knots at most `step` apart, whatever the period; see `Model`."""
    return knots(horizon, begin, count, step)


@dataclass(frozen=True)
class Model:
    """How the MPC counts with momentum and rotation; all models share (36)-(39) and (43)-(48).

    Attributes:
        name: in `MpcParameters.model`, and so in scenarios and on the command line.
        title: for people, a few words.
        write_reference: called with

            reference: vector of a `Reference`, see `open_reference`. It has times, CoM, torso and
                contacts; I_B, L and L_mid are to be written, see `write_momentum`, and E where
                `linearise` gives it.
            lines: planned in the middles of the intervals.
            dynamics: vector of the `RobotDynamics` of the present state, see `open_dynamics`.
            robot: what is to know of it.

            returns the largest residual of legs that have to reach something [m, rad], or 0.
        knots: called with the horizon, the first knot [s], the number of intervals, the longest
            interval [s] and the period of the MPC [s]; returns the knots [s], increasing, shape
            (count + 1,). No foot may switch between two.
        measure: takes the `RobotDynamics` of a state to what the MPC starts from.
        linearise: takes a reference to what the torso's rate is linearised about, (28)-(31).
            The default locks the joints, (25); one that gives `E` as well takes the rate from it.
    """

    name: str
    title: str
    write_reference: Callable[[Array, LinePlan, Array, Robot], float]
    knots: Callable[[GaitHorizon, float, int, float, float], Array] = phase_knots
    measure: Callable[[RobotDynamics], CentroidalMeasurement] = measure_centroidal
    linearise: Callable[[Reference], Linearisation] = Linearisation.of
