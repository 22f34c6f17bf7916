"""What is tried of a run: cases, their sizes and seeds, and the scenario of each trial.

The order of the cases is that in which they are carried out.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from drake_linefoot.lab.scenario import Perturbation, Scenario, Segment
from drake_linefoot.lab.scenario.disturbances import GroundParameters, PushParameters
from drake_linefoot.lab.sweep.jobs import scenario_of
from studies.common.command import SWEEPS
from studies.common.sweeps import sweep_of
from studies.common.trials import FRESH
from studies.common.types import Array

STAND = 0.5  # [s] before anything
SEEDS, TIME = 5, 20.0  # of each command, [s] of it
QUICK_TIME, QUICK_RUNS = 7.0, 1  # [s], of each command or group
SPEED = 1.5  # [m/s] of what is turned, moved aside, pushed, and runs on other ground
START = Perturbation(0.01, 0.1, 0.05)  # [rad], [rad/s], [m/s]: what seeds differ by
FAST, SLOW, REST = 2.0, 4.0, 2.0  # [m/s] between stands; [s] of slowing down, and of standing
PUSHED, PUSH, PHASE = 5.0, 10.0, 0.34  # [s], [N s], [s] of two steps
SLOPE = float(np.radians(5.0))  # [rad]
TIMES = {"stand_run_stand": 6.0, "run_push": 9.0, "run_rough": 7.0, "run_slope_5": 10.0}
"""Of the command of a group [s]; on tiles it ends where they do."""
WALK_TIME = 6.0  # [s] of the undisturbed walks


@dataclass(frozen=True)
class Ladder:
    """Commands one faster than the other: `fixed` plus a size along an `axis`."""

    axis: int  # 0 forward, 1 left, 2 turn rate
    sizes: tuple[float, ...]
    fixed: tuple[float, float, float] = (0.0, 0.0, 0.0)
    gait: dict[str, Any] = field(default_factory=dict)  # what is set of it
    mpc: dict[str, Any] = field(default_factory=dict)  # likewise
    what: str = ""  # in words, of `VARIANTS`

    def command(self, size: float) -> Array:
        """Return forward, left [m/s] and turn rate [rad/s]."""
        command = np.array(self.fixed)
        command[self.axis] += size
        return command


WALK_ONLY = {"flight": 0.0, "walk_max": 2.0}
ALWAYS_RUN = {"flight": 0.06}
LADDERS = {
    "walk_forward": Ladder(0, (1.2, 1.3, 1.4, 1.5, 1.6, 1.7, 1.8), gait=WALK_ONLY),
    "run_forward": Ladder(0, (1.5, 1.8, 2.0, 2.2, 2.4, 2.5, 2.6)),
    "run_back": Ladder(0, (-0.8, -1.0, -1.2, -1.4), gait=ALWAYS_RUN),
    "run_aside": Ladder(1, (0.2, 0.4, 0.6, 0.7), (SPEED, 0.0, 0.0), {"lateral_max": 0.8}),
    "run_turn": Ladder(2, (0.5, 1.0, 1.2), (SPEED, 0.0, 0.0)),
}
_SLOW, _FAST = (0.4, 0.8, 1.2), (1.5, 2.0, 2.6)
_QUICK_STEPS = {"single_support": 0.17, "single_support_min": 0.12}
_ARMS_HELD: dict[str, Any] = {"arm_swing": 0.0}
_ON_ONE_FOOT = {"double_support": 0.002, "double_support_min": 0.002}
VARIANTS = {  # what else a gait could be, each with what it brings
    "walk_quick_steps": Ladder(
        0,
        (1.2, 1.4, 1.6, 1.8),
        gait=WALK_ONLY | _QUICK_STEPS | _ON_ONE_FOOT,
        what="Walk with steps of 0.17 s and 2 ms on both feet",
    ),
    "walk_long_steps": Ladder(
        0, _SLOW, gait={"single_support": 0.35, "step_length": 0.5}, what="Walk, steps of 0.38 s"
    ),
    "walk_toe_off": Ladder(
        0, _SLOW, gait={"toe_off": 0.15}, what="Walk on toes as feet are lifted"
    ),
    "walk_arms_held": Ladder(0, _SLOW, gait=_ARMS_HELD, what="Walk with arms that do not swing"),
    "walk_as_it_is": Ladder(0, _SLOW, what="For comparison: walk, steps of 0.23 s"),
    "run_low": Ladder(0, _FAST, gait={"run_flight": 0.03}, what="Run with flights of 30 ms"),
    "run_ecd": Ladder(0, _FAST, mpc={"model": "ecd"}, what="Run, the MPC with ECD"),
    "run_srbm": Ladder(0, _FAST, mpc={"model": "srbm"}, what="Run, the MPC with a single body"),
    "run_50_hz": Ladder(0, _FAST, mpc={"run_period": 0.02}, what="Run, the MPC at 50 Hz"),
    "run_arms_held": Ladder(0, _FAST, gait=_ARMS_HELD, what="Run with arms that do not swing"),
    "run_as_it_is": Ladder(
        0, _FAST, what="For comparison: run, contact-consistent model, MPC at 100 Hz"
    ),
}
EVERY = LADDERS | VARIANTS
QUICK_SIZES = {
    "walk_forward": (1.4,),
    "run_forward": (2.0,),
    "run_back": (-1.0,),
    "run_aside": (0.2,),
    "run_turn": (0.5,),
}
VARIANT_SEEDS = 2  # of `QUICK_TIME` each
WALKS = {  # below the speeds of a run
    "0.4": (0.4, 0.0, 0.0),
    "0.8": (0.8, 0.0, 0.0),
    "1.1": (1.1, 0.0, 0.0),
    "back": (-0.6, 0.0, 0.0),
    "aside": (0.2, 0.25, 0.0),
    "turn": (0.5, 0.0, 0.8),
}
GROUPS = {  # runs of each
    "stand_run_stand": 20,
    "run_on_estimate": 20,
    "run_push": 100,
    "run_rough": 100,
    "run_slope_5": 100,
}
PAIRS = 5  # runs of each group of the sweep of robustness
DRAWN = 1  # seed of that sweep when walks were kept, to compare with
PICTURE = "picture"  # the run that is drawn


@dataclass(frozen=True)
class Trial:
    """A run to carry out."""

    case: str  # of `LADDERS`, `VARIANTS` or `GROUPS`, "walk", "pair" or `PICTURE`
    label: str  # size of a ladder, name of a walk or of a group of the sweep
    index: int  # of the seed
    time: float = TIME  # [s] of its command

    @property
    def key(self) -> str:
        """What makes it one trial."""
        return f"{self.case} {self.label} {self.index} {self.time:g}"


def trials(quick: bool, first: int = FRESH) -> Iterator[Trial]:
    """Yield what there is to try; quick is one of each command and of each group."""
    seeds, time = (QUICK_RUNS, QUICK_TIME) if quick else (SEEDS, TIME)
    yield Trial(PICTURE, "", 0, QUICK_TIME)
    for name, ladder in LADDERS.items():
        for size in QUICK_SIZES[name] if quick else ladder.sizes:
            yield from (Trial(name, f"{size:g}", seed, time) for seed in range(seeds))
    for name, ladder in VARIANTS.items():
        for size in ladder.sizes[:1] if quick else ladder.sizes:
            some = range(QUICK_RUNS if quick else VARIANT_SEEDS)
            yield from (Trial(name, f"{size:g}", seed, QUICK_TIME) for seed in some)
    for name in WALKS:
        yield from (Trial("walk", name, seed, WALK_TIME) for seed in range(seeds))
    for name, runs in GROUPS.items():
        lasts = TIMES.get(name, time)
        some = range(first, first + (QUICK_RUNS if quick else runs))
        yield from (Trial(name, "", i, lasts) for i in some)
    for group in sweep_of(SWEEPS[0]).groups[: 1 if quick else None]:
        yield from (Trial("pair", group.name, i) for i in range(QUICK_RUNS if quick else PAIRS))


def scenario(trial: Trial) -> Scenario:
    """Return what is simulated."""
    if trial.case == "pair":
        sweep = replace(sweep_of(SWEEPS[0]), seed=DRAWN)
        return scenario_of(sweep, trial.label, trial.index)
    made = Scenario(name=trial.case, seed=trial.index, perturbation=START)
    if ladder := EVERY.get(trial.case):
        made = replace(made, gait=replace(made.gait, **ladder.gait))
        made = replace(made, mpc=replace(made.mpc, **ladder.mpc))
        return _told(made, ladder.command(float(trial.label)), trial.time)
    if trial.case == "walk":  # as before there was a run
        made = replace(made, gait=replace(made.gait, **_ARMS_HELD))
        return _told(made, np.array(WALKS[trial.label]), trial.time)
    return _of_group(trial, made)


def _of_group(trial: Trial, made: Scenario) -> Scenario:
    """Return the scenario of one of `GROUPS`, or of the run that is drawn."""
    name, rng = trial.case, np.random.default_rng([trial.index, *trial.case.encode()])
    fast = FAST if name in ("stand_run_stand", PICTURE) else SPEED
    made = _told(made, np.array([fast, 0.0, 0.0]), trial.time)
    if name == "stand_run_stand":
        made.segments += [Segment("slow", SLOW, walk=True), Segment("rest", REST)]
    elif name == "run_push":
        begin, to = PUSHED + float(rng.uniform(0.0, PHASE)), float(rng.uniform(-np.pi, np.pi))
        made.pushes = [PushParameters(time=begin, impulse=PUSH, direction=to)]
    elif name == "run_rough":
        made.scene = "rough"
    elif name == "run_slope_5":
        heading = float(rng.choice([0.0, np.pi]))
        made.scene, made.ground = "slope_10", GroundParameters(slope=SLOPE, slope_heading=heading)
    elif name == "run_on_estimate":
        made.estimation = True
    return made


def _told(made: Scenario, command: Array, time: float) -> Scenario:
    """Return a scenario that stands, and goes as it is told for a time [s]."""
    vx, vy, turn = command.tolist()
    return replace(
        made, segments=[Segment("stand", STAND), Segment("go", time, True, [vx, vy], turn)]
    )
