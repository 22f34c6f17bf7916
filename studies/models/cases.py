"""What is tried: models, horizons, and errors in one thing at a time, all with the same pushes."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from drake_linefoot.lab.scenario import Scenario, paths
from drake_linefoot.lab.scenario.load import make_scenario, scenario_data
from drake_linefoot.lab.sweep.jobs import scenario_of
from studies.common.sweeps import sweep_of
from studies.common.trials import FRESH

SWEEP = Path("examples/sweeps/models.yaml")
RUNS, QUICK_RUNS = 100, 1  # of each
# [N s] of the push. After 20 nearly all stay upright, whatever the model: 35 tells them apart.
HARD, GENTLE = 35, 20
PENDULUM = "pendulum"


@dataclass(frozen=True)
class Variant:
    """One way to walk.

    Attributes:
        what: in words.
        entries: of the scenario that differ, by dotted path.
        impulse: of the push [N s].
        rounds: of planning, each linearised about the plan before.
        pendulum: whether there is no MPC.
    """

    what: str
    entries: Mapping[str, Any] = field(default_factory=dict)
    impulse: float = HARD
    rounds: int = 1
    pendulum: bool = False


BASE = "contact_consistent"
MODELS = {
    BASE: Variant("contact-consistent model"),
    "twice": Variant("the same, linearised about its own plan once more", rounds=2),
    "thrice": Variant("the same, twice more", rounds=3),
    "ecd": Variant("ECD", {"mpc.model": "ecd"}),
    "srbm": Variant("single rigid body", {"mpc.model": "srbm"}),
    "srbm_momentum": Variant(
        "single rigid body, of the whole momentum", {"mpc.model": "srbm_momentum"}
    ),
    PENDULUM: Variant("pendulum without MPC", pendulum=True),
}
HORIZON = "knots"  # 14 are those of `BASE`
HORIZONS = {
    f"{HORIZON}_{n}": Variant(f"horizon of {n} intervals", {"mpc.knots": n}) for n in (1, 4, 7, 20)
}


@dataclass(frozen=True)
class Factor:
    """Something that differs from what the controller counts on."""

    entry: str  # of the scenario
    label: str
    levels: tuple[float, ...]  # `usual` among them
    usual: float


FACTORS = {
    "mass": Factor("error.torso_mass", "mass added to the torso [kg]", (-6, 0, 6, 12, 18), 0.0),
    "friction": Factor(
        "ground.friction", "friction of the ground [-]", (0.2, 0.25, 0.3, 0.4, 0.8), 0.8
    ),
    "delay": Factor("actuators.delay", "delay of torques [s]", (0, 0.002, 0.004, 0.006), 0.0),
}


def level(factor: str, value: float) -> str:
    """Return the name of the variant of a factor that has a value; all share the usual one."""
    usual = value == FACTORS[factor].usual
    return "usual" if usual else f"{factor}_{value:g}"


ONE_AT_A_TIME = {
    level(name, value): Variant(
        f"{one.label}: {value:g}" if value != one.usual else "nothing differs",
        {} if value == one.usual else {one.entry: float(value)},
        GENTLE,
    )
    for name, one in FACTORS.items()
    for value in one.levels
}
VARIANTS = MODELS | HORIZONS | ONE_AT_A_TIME


@dataclass(frozen=True)
class Trial:
    """A run of a variant."""

    variant: str
    index: int  # of the draw: run i of every variant has the same commands and push

    @property
    def key(self) -> str:
        """What makes it one trial."""
        return f"{self.variant} {VARIANTS[self.variant].impulse:g} N s {self.index}"


def trials(runs: int, first: int = FRESH) -> Iterator[Trial]:
    """Yield what there is to try, every variant of a draw after each other."""
    for index in range(first, first + runs):
        yield from (Trial(name, index) for name in VARIANTS)


def scenario(trial: Trial) -> Scenario:
    """Return what a trial simulates."""
    sweep, variant = sweep_of(SWEEP), VARIANTS[trial.variant]
    drawn = scenario_of(sweep, BASE, trial.index)
    push = replace(drawn.pushes[0], impulse=variant.impulse)
    data = scenario_data(replace(drawn, pushes=[push]))
    for entry, value in variant.entries.items():
        paths.put(data, entry, value)
    return make_scenario(data)
