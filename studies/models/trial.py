"""One trial: simulated, judged, and what came of it as plain data."""

from drake_linefoot.lab.results.judge import judge, upright
from drake_linefoot.lab.scenario import Scenario
from drake_linefoot.lab.simulation.closed_loop import ClosedLoop
from drake_linefoot.lab.simulation.run import simulate
from drake_linefoot.lab.wiring.closed_loop import build_closed_loop
from drake_linefoot.mpc.centroidal_reference import CentroidalReference
from drake_linefoot.robot.humanoid import load_humanoid
from drake_linefoot.robot.scaling import scaled
from drake_linefoot.wiring.controller import build_controller
from studies.common import runs
from studies.common.stamp import Probed
from studies.common.types import Data
from studies.models.cases import BASE, VARIANTS, Trial, Variant, scenario
from studies.models.pendulum import PendulumPlan
from studies.models.relinearised import Relinearised

LIMIT = 1800.0  # [s] of wall time


def built(variant: Variant, made: Scenario) -> ClosedLoop:
    """Return the closed loop of a variant."""
    if not variant.pendulum and variant.rounds == 1:
        return build_closed_loop(made)
    humanoid = load_humanoid(made.robot)
    of = scaled(made, humanoid)
    if variant.pendulum:
        controller = build_controller(humanoid, made, mpc=PendulumPlan(humanoid, of))
    else:
        generator = Relinearised(humanoid, of.mpc, variant.rounds)
        reference = CentroidalReference(humanoid, made.mpc, generator)
        controller = build_controller(humanoid, made, reference=reference)
    return build_closed_loop(made, controller=controller)


def tried(trial: Trial) -> Data:
    """Simulate and judge a trial.

    Returns:
        `key`, `variant`, `index`; `upright`, `reason` why it was not; of a run that was,
        `roll`, `pitch`: RMS [rad], and `speed_error` [m/s], else None.
    """
    loop = built(VARIANTS[trial.variant], scenario(trial))
    run = simulate(loop)
    outcome = judge(run)
    row = named(trial) | {"upright": upright(outcome), "reason": ""}
    if row["upright"]:
        w = runs.walking(run)
        row |= {name: runs.rms(run.rpy[w, i]) for i, name in enumerate(("roll", "pitch"))}
        row["speed_error"] = outcome["speed_error"]
    else:
        row["reason"] = outcome["fall_reason"] or outcome["cause"]
    loop.recorder.keep_last(0)
    return row


def named(trial: Trial) -> Data:
    """Return which trial a row is of, without an outcome."""
    nothing = dict.fromkeys(("roll", "pitch", "speed_error"))
    return {"key": trial.key, "variant": trial.variant, "index": trial.index, **nothing}


def lost(trial: Trial, error: str) -> Data:
    """Return what stands for `tried` of a trial whose process crashed or took too long."""
    return named(trial) | {"upright": False, "reason": error}


def limit(_: Trial) -> float:
    """Return how long a trial may take [s]."""
    return LIMIT


def probe() -> dict[str, Probed]:
    """Return a quick form of the study: a draw with the base model."""
    row = tried(Trial(BASE, 0))
    found = {"upright": Probed(float(row["upright"]), 0.0)}
    if row["upright"]:
        found["pitch_rad"] = Probed(row["pitch"], 0.01)
        found["speed_error_m_s"] = Probed(row["speed_error"], 0.03)
    return found
