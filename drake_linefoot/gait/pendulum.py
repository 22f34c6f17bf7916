"""The linear inverted pendulum and its divergent component of motion (DCM).

With w = sqrt(g / h) the DCM is xi = c + c' / w. It obeys xi' = w (xi - p) for a centre of
pressure p, and the CoM follows it: c' = w (xi - c). All quantities here are horizontal.
"""

import math

import numpy as np

from drake_linefoot.constants import STANDARD_GRAVITY
from drake_linefoot.math.compiled import compiled
from drake_linefoot.types import Array

# A piece of DCM trajectory, xi(t) = centre + amplitude exp(rate (t - begin)), see `GaitHorizon`;
# for rate = +w the centre is the CoP, a negative rate is that of a DCM that is captured. The last
# number is the w of the piece; 0 in a flight, of which the amplitude is the velocity.
BEGIN, END, CENTRE, AMPLITUDE, RATE, OMEGA = 0, 1, 2, 4, 6, 7


def natural_frequency(com_height: float) -> float:
    """Return w = sqrt(g / h) [1/s] for a CoM `com_height` [m] above the ground.

    Raises:
        ValueError: the height is not positive.
    """
    if not com_height > 0.0:
        raise ValueError(f"CoM height = {com_height}: must be positive")
    return float(np.sqrt(STANDARD_GRAVITY / com_height))


def switch_time(double_support: float, omega: float) -> float:
    """Return when the CoP may jump so that the DCM ends as if it had moved evenly.

    In double support the CoP moves at constant speed from the old to the new foot. The
    DCM at the end is the same as for a CoP that jumps at this time after the start.

    Args:
        double_support: length of the double support [s].
        omega: natural frequency [1/s].

    Returns:
        Time from the start of the double support [s]; near half of it.
    """
    a = omega * double_support
    if a < 1e-9:
        return 0.5 * double_support
    kappa = (np.expm1(a) - a) / a  # w times the integral of exp(w (T - t)) t / T
    return float(double_support - np.log1p(kappa) / omega)


@compiled
def balancing_cop(xi: Array, xi_goal: Array, omega: float, duration: float) -> Array:
    """Return the resting CoP that takes the DCM from `xi` to `xi_goal` in `duration`.

    Args:
        xi: DCM now [m], shape (2,).
        xi_goal: DCM desired after `duration` [m], shape (2,).
        omega: natural frequency [1/s].
        duration: [s], positive.

    Returns:
        The CoP [m], shape (2,).
    """
    growth = math.exp(omega * duration)
    return (growth * xi - xi_goal) / (growth - 1.0)


@compiled
def dcm(com: Array, com_velocity: Array, omega: float) -> Array:
    """Return the DCM ``c + c' / w``.

    Args:
        com: CoM [m], shape (2,) or, with a height that is left out, (3,).
        com_velocity: its velocity [m/s], shaped likewise.
        omega: natural frequency [1/s].

    Returns:
        [m], shape (2,).
    """
    return com[:2] + com_velocity[:2] / omega


@compiled
def propagate_dcm(xi: Array, cop: Array, omega: float, duration: float) -> Array:
    """Return the DCM after `duration` [s] with the CoP at rest.

    Args:
        xi: DCM [m], shape (2,).
        cop: centre of pressure [m], shape (2,).
        omega: natural frequency [1/s].
        duration: [s].

    Returns:
        p + (xi - p) exp(w t), shape (2,).
    """
    return cop + (xi - cop) * math.exp(omega * duration)


@compiled
def dcm_offset(strides: Array, omega: float, step_duration: float) -> Array:
    """Return where the DCM has to be, relative to a foot, when the weight comes onto it.

    The only offset from which the planned strides never diverge:
    ``b = sum_j exp(-w T (j + 1)) s_j``, with the last stride repeated with alternating
    lateral sign being far enough away to be left out.

    Args:
        strides: displacements from each foothold to the next [m], shape (n, 2); the
            first leaves the foot in question.
        omega: natural frequency [1/s].
        step_duration: T, from one switch of the CoP to the next [s].

    Returns:
        xi - p at the switch [m], shape (2,).
    """
    offset = np.zeros(2)
    for j in range(len(strides)):
        decay = math.exp(-omega * step_duration * (j + 1))
        offset[0] += decay * strides[j, 0]
        offset[1] += decay * strides[j, 1]
    return offset


@compiled
def rise_at(pieces: Array, rise: Array, times: Array) -> Array:
    """Return how far the CoM is above its usual height, its rate, at increasing times.

    Args:
        pieces: as of `follow_dcm`.
        rise: of each piece, rows of `GaitHorizon.rise`.
        times: not before the first piece [s], shape (n,).

    Returns:
        [m] and [m/s], shape (2, n).
    """
    out, k = np.empty((2, len(times))), 0
    for i in range(len(times)):
        while k < len(pieces) - 1 and times[i] >= pieces[k, END]:
            k += 1
        t, a = times[i] - pieces[k, BEGIN], rise[k]
        out[0, i] = a[0] + t * (a[1] + t * (a[2] + t * a[3]))
        out[1, i] = a[1] + t * (2.0 * a[2] + t * 3.0 * a[3])
    return out


@compiled
def responses(rate: float, omega: float, tau: float) -> tuple[float, float]:
    """Return how the CoM follows after `tau` [s]: from its own start, and from the DCM's.

    The second is ``w (exp(rate t) - exp(-w t)) / (rate + w)``, here without the difference
    of two near numbers, so that a DCM that decays just as fast as the CoM is no exception.
    """
    decay = math.exp(-omega * tau)
    x = (rate + omega) * tau
    growth = 1.0 if abs(x) < 1e-12 else math.expm1(x) / x
    return decay, omega * tau * decay * growth


@compiled
def follow_dcm(com: Array, pieces: Array, times: Array) -> tuple[Array, Array]:
    """Return the CoM that follows a DCM trajectory, c' = w (xi - c), in closed form.

    In a flight it goes straight on.

    Args:
        com: CoM at the start of the first piece [m], shape (2,).
        pieces: consecutive, rows of `GaitHorizon.dcm`; the last is held.
        times: increasing times not before the first piece [s], shape (n,).

    Returns:
        (position, velocity) of the CoM at `times`, each of shape (n, 2).
    """
    position, velocity = np.empty((len(times), 2)), np.empty((len(times), 2))
    now = com.copy()  # where the CoM is when the piece starts
    k, last = 0, len(pieces) - 1
    for i in range(len(times)):
        while k < last and times[i] >= pieces[k, END]:
            p = pieces[k]
            if p[OMEGA] > 0.0:
                free, forced = responses(p[RATE], p[OMEGA], p[END] - p[BEGIN])
                for j in range(2):
                    centre, amplitude = p[CENTRE + j], p[AMPLITUDE + j]
                    now[j] = centre + free * (now[j] - centre) + forced * amplitude
            else:
                now += (p[END] - p[BEGIN]) * p[AMPLITUDE : AMPLITUDE + 2]
            k += 1
        p = pieces[k]
        omega = p[OMEGA]
        if omega == 0.0:
            velocity[i] = p[AMPLITUDE : AMPLITUDE + 2]
            position[i] = now + (times[i] - p[BEGIN]) * velocity[i]
            continue
        free, forced = responses(p[RATE], omega, times[i] - p[BEGIN])
        growth = math.exp(p[RATE] * (times[i] - p[BEGIN]))
        for j in range(2):
            centre, amplitude = p[CENTRE + j], p[AMPLITUDE + j]
            position[i, j] = centre + free * (now[j] - centre) + forced * amplitude
            velocity[i, j] = omega * (centre + amplitude * growth - position[i, j])
    return position, velocity
