"""The judge of a run: whether it was upright, how well it walked, and why it was not upright."""

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from drake_linefoot.lab.results.clearance import smallest_leg_gap
from drake_linefoot.lab.results.fall_indicators import COLLISION
from drake_linefoot.lab.results.falls import diagnose
from drake_linefoot.lab.results.metrics import compute_metrics
from drake_linefoot.lab.results.viability import push_is_viable
from drake_linefoot.lab.scenario import paths
from drake_linefoot.lab.simulation.recording import Run


@dataclass(frozen=True)
class Column:
    """A column of a table of runs.

    Attributes:
        kind: Arrow's name of its type.
        unit: of the values; "-" for none.
        what: in words.
        metric: where `compute_metrics` has it, a dotted path; empty for what it does not have.
    """

    kind: str
    unit: str
    what: str
    metric: str = ""


OUTCOME = {
    "fell": Column("bool", "-", "whether the robot fell", "fell"),
    "fall_time": Column("double", "s", "when it did", "fall_time_s"),
    "fall_reason": Column("string", "-", "what was seen", "fall_reason"),
    "cause": Column("string", "-", "why not upright, see falls.diagnose; or 'upright'"),
    "onset": Column("double", "s", "when the fall began"),
    "fall_indicators": Column("string", "-", "what was seen then, and when; commas between"),
    "roll_max": Column("double", "rad", "largest roll of the torso", "roll_max_rad"),
    "pitch_max": Column("double", "rad", "largest pitch of the torso", "pitch_max_rad"),
    "speed_error": Column("double", "m/s", "largest of the segments, see compute_metrics"),
    "turn_error": Column("double", "rad/s", "largest of the segments"),
    "mpc_failures": Column("int64", "-", "updates without a solution", "solver_failures.mpc"),
    "wbc_failures": Column("int64", "-", "ticks without a solution", "solver_failures.wbc"),
    "contact_latency": Column("double", "ms", "of the estimator, median", "contact.latency_ms"),
    "false_contacts": Column("int64", "-", "of the estimator", "contact.false_positives"),
    "missed_contacts": Column("int64", "-", "by the estimator", "contact.missed"),
    "slip": Column("double", "m", "largest, of a foot", "slip_m"),
    "torque_max": Column("double", "-", "largest torque over its limit", "torque_max_ratio"),
    "slowed": Column("double", "-", "share of the time in which it followed another command"),
    "slowed_by": Column("string", "-", "why, the longest first; commas between"),
    "moved_footholds": Column(
        "int64", "-", "ticks in which one was moved to a reachable place", "limited.footholds"
    ),
    "leg_gap": Column(
        "double", "m", "smallest between the legs before a fall; below zero they are in each other"
    ),
    "legs_met": Column("double", "s", "when the legs first were in each other; none if never"),
    "viable": Column("bool", "-", "whether steps save a pendulum after the last push"),
    "steps": Column("int64", "-", "touchdowns after a swing", "steps"),
    "simulated": Column("double", "s", "length of what was simulated", "duration_s"),
    "state_hash": Column("string", "-", "of every state of the run, to the last bit"),
}


def judge(run: Run) -> dict[str, Any]:
    """Return the outcome of a run: a value for each column of `OUTCOME`.

    None stands for what is not known, or not finite.
    """
    metrics, fall = compute_metrics(run), diagnose(run)
    gap, met = smallest_leg_gap(run, np.inf if np.isnan(fall.onset) else fall.onset)
    errors = [s["error"] for s in metrics["segments"] if s["error"] is not None]
    values = {
        "cause": COLLISION if not run.fell and met is not None else fall.cause,
        "onset": fall.onset,
        "fall_indicators": fall.text,
        "speed_error": max((float(np.hypot(e[0], e[1])) for e in errors), default=None),
        "slowed": float(sum(part["share"] for part in metrics["slowed"])),
        "slowed_by": ", ".join(part["why"] for part in metrics["slowed"]),
        "turn_error": max((abs(e[2]) for e in errors), default=None),
        "leg_gap": gap,
        "legs_met": met,
        "viable": push_is_viable(run),
        "state_hash": state_hash(run),
    }
    values |= {name: paths.get(metrics, c.metric) for name, c in OUTCOME.items() if c.metric}
    unknown = {n for n, v in values.items() if isinstance(v, float) and not np.isfinite(v)}
    return {name: None if name in unknown else values[name] for name in OUTCOME}


def upright(outcome: Mapping[str, Any]) -> bool:
    """Return whether a run succeeded: no fall, no legs inside each other, and an outcome."""
    return outcome["fell"] is False and outcome["legs_met"] is None


def state_hash(run: Run) -> str:
    """Return a short hash of times, positions and velocities of a run, to the last bit."""
    content = hashlib.sha256()
    for values in (run.time, run.q, run.v):
        content.update(np.ascontiguousarray(values).tobytes())
    return content.hexdigest()[:16]
