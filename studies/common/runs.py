"""The walk the figures show: simulated once in a process, whoever asks for it."""

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drake_linefoot.constants import STANDARD_GRAVITY
from drake_linefoot.lab.scenario import Scenario
from drake_linefoot.lab.scenario.load import dump_scenario, load_scenario
from drake_linefoot.lab.simulation.recording import Run
from drake_linefoot.lab.simulation.run import simulate
from drake_linefoot.lab.wiring.closed_loop import build_closed_loop
from drake_linefoot.robot.dynamics import robot_dynamics
from drake_linefoot.robot.humanoid import load_humanoid
from studies.common.types import Array, Data

SCENARIO = "paper"
MODELS = {  # of the MPC, in words
    "ecd": "ECD",
    "srbm": "Base MPC",
    "srbm_momentum": "Base, whole momentum",
    "contact_consistent": "contact-consistent",
}
QUICK_SEGMENTS = (0.5, 2.0, 1.5)  # [s] lengths of the segments in quick runs
SAMPLES = 5  # ticks between two points of a curve that spans the whole run
DIGITS = 6  # significant, of what is written
RESAMPLES = 2000  # of a bootstrap
CONTROL_PERIOD = 0.001  # [s] of the whole-body controller and of the samples

_simulated: dict[str, Run] = {}


def paper_scenario(
    quick: bool,
    model: str | None = None,
    seed: int | None = None,
    segments: Sequence[float] = QUICK_SEGMENTS,
) -> Scenario:
    """Return the scenario of the figures and of the benchmark.

    Quick has shorter `segments` [s], everything else the same. The `model` of the MPC, of `MODELS`,
    and the `seed` of the initial perturbation are as shipped unless given.
    """
    given = {"mpc.model": model, "seed": seed}
    scenario = load_scenario(SCENARIO, {k: v for k, v in given.items() if v is not None})
    if quick:
        for segment, length in zip(scenario.segments, segments, strict=True):
            segment.duration = length
    return scenario


def simulated(scenario: Scenario) -> Run:
    """Simulate a scenario; one that this process simulated before is not run again."""
    key = dump_scenario(scenario)
    if key not in _simulated:
        _simulated[key] = simulate(build_closed_loop(scenario))
    return _simulated[key]


def facts(run: Run) -> Data:
    """Return what every figure's data says about the run it shows."""
    return {
        "scenario": dump_scenario(run.scenario),
        "seeds": [run.scenario.seed],
        "fell": run.fell,
        "fall_time": run.fall_time,
        "fall_reason": run.fall_reason,
        "segments": [[s.name, s.duration] for s in run.scenario.segments],
        "end": float(run.time[-1]),
    }


def facts_of_rows(scenario: Scenario, seeds: Sequence[int], fallen: Sequence[Data]) -> Data:
    """Return what a figure's data says about many walks; `fallen` are those that should not."""
    return {
        "scenario": dump_scenario(scenario),
        "seeds": list(seeds),
        "fell": bool(fallen),
        "fall_time": fallen[0].get("fall_time") if fallen else None,
        "fall_reason": "; ".join(sorted({row["fall_reason"] for row in fallen})),
    }


def walking(run: Run) -> NDArray[np.bool_]:
    """Return in which samples the robot walks, beginning with its first step."""
    stepping = run.mode >= 2  # swing or double support between steps, see MODES
    started = np.cumsum(stepping) > 0
    result: NDArray[np.bool_] = started & (run.command[:, 3] > 0.5)
    return result


def updates(run: Run) -> NDArray[np.intp]:
    """Return the samples at which the whole-body controller first uses a new plan."""
    return np.flatnonzero(~np.isnan(run.mpc_ms))


def uses_of_plans(run: Run) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return the first and the last sample of the use of each plan while the robot walks."""
    begins, ends = updates(run)[:-1], updates(run)[1:] - 1
    used = walking(run)[begins] & (ends > begins)
    return begins[used], ends[used]


def at_the_end(run: Run, window: float) -> tuple[NDArray[np.bool_], list[float]]:
    """Return which samples are in the last `window` [s] of a run, and its begin and end [s]."""
    end = float(run.time[-1])
    return run.time >= end - window, [max(end - window, 0.0), end]


def centroidal(run: Run) -> dict[str, Array]:
    """Return the measured centroidal motion of a run, from its states.

    Returns:
        `r`, `v`: CoM [m, m/s]; `L`: angular momentum about it [kg m^2/s]; shapes (n, 3).
    """
    humanoid = load_humanoid(run.scenario.robot)
    context = humanoid.plant.CreateDefaultContext()
    rows = []
    for q, v in zip(run.q, run.v, strict=True):
        d = robot_dynamics(humanoid, context, np.concatenate([q, v]))
        rows.append(np.concatenate([d.p_WG, d.v_WG, d.L_G]))
    return dict(zip("rvL", np.split(np.array(rows), 3, axis=1), strict=True))


def weight(run: Run) -> float:
    """Return the robot's weight [N]."""
    return STANDARD_GRAVITY * float(load_humanoid(run.scenario.robot).mass)


def in_heading(run: Run, vector: Array, ahead: Array | float = 0.0) -> Array:
    """Turn vectors from the world into the robot's heading frame, its yaw and `ahead` [rad] more.

    Rows are x and y in W, then whatever, shape (n, m), and become forward and left, then whatever.
    """
    yaw = run.rpy[:, 2] + ahead
    c, s = np.cos(yaw), np.sin(yaw)
    turned = vector.copy()
    turned[:, 0] = c * vector[:, 0] + s * vector[:, 1]
    turned[:, 1] = c * vector[:, 1] - s * vector[:, 0]
    return turned


def stride_mean(time: Array, values: Array, window: float) -> Array:
    """Return the running mean over `window` [s], cut at the ends of the run.

    Samples in `time` are evenly spaced, shape (n,); values have shape (n,) or (n, m), NaN spreads.
    """
    if len(time) < 2:
        return values.copy()
    half = max(round(0.5 * window / float(time[1] - time[0])), 1)
    total = np.concatenate([np.zeros((1, *values.shape[1:])), np.cumsum(values, axis=0)])
    index = np.arange(len(time))
    first, last = np.maximum(index - half, 0), np.minimum(index + half + 1, len(time))
    count = (last - first).reshape(-1, *([1] * (values.ndim - 1)))
    result: Array = (total[last] - total[first]) / count
    return result


def stride_time(scenario: Scenario) -> float:
    """Return the length of a stride, two steps [s]."""
    return 2.0 * (scenario.gait.single_support + scenario.gait.double_support)


def turn_rate(run: Run) -> Array:
    """Return the rate of the torso's yaw [rad/s], shape (n,)."""
    if len(run.time) < 2:
        return np.zeros(len(run.time))
    rate: Array = np.gradient(run.rpy[:, 2], run.time)
    return rate


def decimated(values: Array, step: int = SAMPLES) -> list[Any]:
    """Return every `step`-th row, rounded, as JSON takes it; NaN becomes None."""
    rows = np.asarray(values, dtype=float)[::step]
    return _rounded(rows.tolist())


def _rounded(value: Any) -> Any:
    if isinstance(value, list):
        return [_rounded(entry) for entry in value]
    return float(f"{value:.{DIGITS}g}") if np.isfinite(value) else None


def _finite(values: Array) -> Array:
    values = np.asarray(values, dtype=float)
    return values[np.isfinite(values)]


def rms(values: Array) -> float:
    """Return the root of the mean square, NaN left out; NaN of nothing."""
    values = _finite(values)
    return float(np.sqrt(np.mean(values**2))) if values.size else float("nan")


def percentile(values: Array, share: float) -> float:
    """Return a percentile, NaN left out; NaN of nothing."""
    values = _finite(values)
    return float(np.percentile(values, share)) if values.size else float("nan")


def jsonable(value: float) -> float | None:
    """Return a number as JSON takes it: None when it is not finite."""
    return float(value) if np.isfinite(value) else None


def quantiles(values: Array, **shares: float) -> dict[str, float | None]:
    """Return percentiles by name, NaN left out; None of nothing."""
    return {name: jsonable(percentile(values, share)) for name, share in shares.items()}


def compared(pairs: Iterable[Sequence[float | None]]) -> Data:
    """Return `ratio` of the RMS of the first of each pair to that of the second; None without one.

    With its 95 % `interval`, by a bootstrap over the pairs, and, as a few large values decide an
    RMS, in how many of the `pairs` the first is `lower`. A pair with None in it is left out.
    """
    from scipy.stats import bootstrap

    known = [pair for pair in pairs if None not in pair]
    ours, theirs = np.array(known, dtype=float).reshape(-1, 2).T
    found: Data = {"ratio": None, "interval": None}
    found |= {"lower": int(np.sum(ours < theirs)), "pairs": len(known)}
    if not (below := rms(theirs)) > 0.0:
        return found
    found["ratio"] = jsonable(rms(ours) / below)
    if len(known) < 2:
        return found

    def of(a: Array, b: Array, axis: int) -> Array:
        squares: Array = np.sum(a**2, axis=axis) / np.sum(b**2, axis=axis)
        return np.sqrt(squares)

    how: Data = {"paired": True, "method": "percentile", "n_resamples": RESAMPLES, "rng": 0}
    interval = bootstrap((ours, theirs), of, **how).confidence_interval
    return {**found, "interval": [float(bound) for bound in interval]}


def compared_where_both_stand(pairs: Iterable[tuple[Data, Data]], key: str) -> Data:
    """Return what `compared` says of a quantity of pairs of walks of which neither fell."""
    return compared([(a[key], b[key]) for a, b in where_both_stand(pairs)])


def where_both_stand(pairs: Iterable[tuple[Data, Data]]) -> list[tuple[Data, Data]]:
    """Return the pairs of walks of which neither fell."""
    return [(a, b) for a, b in pairs if not (a["fell"] or b["fell"])]
