"""The scenario: everything that makes a run what it is."""

from dataclasses import dataclass, field, fields
from typing import Annotated

from annotated_types import Ge, Len
from pydantic import AfterValidator, BeforeValidator, Strict

from drake_linefoot.checks import plain
from drake_linefoot.estimation.contact_parameters import EstimatorParameters
from drake_linefoot.estimation.parameters import OnboardParameters, StateEstimatorParameters
from drake_linefoot.facts import WithFacts
from drake_linefoot.fields import (
    Flag,
    Name,
    NameOrPath,
    NotNegative,
    Number,
    Pair,
    Positive,
    Unit,
    Whole,
    is_multiple,
    misfit,
    one_of,
    together,
)
from drake_linefoot.gait.parameters import GaitParameters
from drake_linefoot.lab.scenario.courses import LONGEST, TerrainParameters
from drake_linefoot.lab.scenario.disturbances import (
    ActuatorParameters,
    ErrorParameters,
    GroundParameters,
    PushParameters,
    SensorParameters,
)
from drake_linefoot.mpc.parameters import MpcParameters
from drake_linefoot.parameters import Parameters
from drake_linefoot.wbc.parameters import WbcParameters
from drake_linefoot.wiring.parameters import is_tick

SAID = {"name", "robot", "scene", "seed", "segments"}  # of a scenario, wherever it is shown


def _known_to_drake(value: object) -> object:
    from pydrake.multibody.plant import DiscreteContactApproximation  # takes a while

    known = [name.removeprefix("k").lower() for name in DiscreteContactApproximation.__members__]
    if value not in known:
        raise ValueError(f"must be one of {sorted(known)}, which this Drake has")
    return value


@dataclass
class Segment(Parameters):
    """A command that is held for a while: `Segment("walk", 3.0, walk=True, velocity=[0.5, 0.0])`.

    Without `walk` the robot stands on both feet. Its duration is in s, `velocity` is forward and
    left in m/s, `turn_rate` counter-clockwise in rad/s.
    """

    name: Name = "stand"
    """Shown in tables and metrics."""
    duration: Annotated[Positive, Unit("s", LONGEST)] = 1.0
    walk: Flag = False
    """False: stand on both feet."""
    velocity: Annotated[Pair, Unit("m/s")] = field(default_factory=lambda: [0.0, 0.0])
    """Forward, left, in the heading frame."""
    turn_rate: Annotated[Number, Unit("rad/s")] = 0.0
    """Counter-clockwise positive."""

    @together
    def _walks_to_move(self) -> None:
        if not self.walk and (any(self.velocity) or self.turn_rate):
            allowed = "must be true in a segment with a velocity or a turn rate"
            raise misfit("walk", self.walk, allowed)


@dataclass
class Perturbation(Parameters):
    """A random change of the initial state, uniform within these bounds."""

    joint_position: Annotated[NotNegative, Unit("rad")] = 0.0
    joint_velocity: Annotated[NotNegative, Unit("rad/s")] = 0.0
    base_velocity: Annotated[NotNegative, Unit("m/s")] = 0.0
    """Of the torso."""


@dataclass
class MujocoParameters(Parameters):
    """What MuJoCo is told of contacts. With its own defaults feet creep to half the speed."""

    cone: Annotated[str, one_of(("elliptic", "pyramidal"))] = "elliptic"
    """Of friction."""
    impratio: Annotated[Positive, Unit("-")] = 100.0
    """How much harder friction is than the normal force."""
    solref: Annotated[list[Positive], Strict(), Len(2, 2), Unit("-")] = field(
        default_factory=lambda: [0.004, 2.0]
    )
    """Time constant [s], at least two time steps, and damping ratio of contacts and of joints at
    their limits. At a ratio of 1 a foot that lands rebounds for 10 ms."""
    solimp: Annotated[list[Positive], Strict(), Len(5, 5), Unit("-")] = field(
        default_factory=lambda: [0.95, 0.99, 0.001, 0.5, 2.0]
    )
    """Impedance of both: least, greatest, width [m], midpoint and power."""
    integrator: Annotated[str, one_of(("euler", "implicit", "implicitfast", "rk4"))] = "euler"
    mjcf: NameOrPath | None = None
    """Path of a model with the robot and level ground, used with its own contacts and options
    instead of all above; none: one is made of the robot's description."""


@dataclass
class PlantParameters(Parameters):
    """How the robot is simulated."""

    time_step: Annotated[Number, AfterValidator(is_tick), Unit("s")] = 0.001
    """Also the period of estimator, gait and whole-body controller."""
    simulator: Annotated[str, one_of(("drake", "mujoco"))] = "drake"
    """MuJoCo needs the extra `mujoco`."""
    mujoco: MujocoParameters = field(default_factory=MujocoParameters)
    contact_approximation: Annotated[str, BeforeValidator(_known_to_drake)] = "lagged"
    """Drake's discrete contact approximation."""
    stiction_tolerance: Annotated[Positive, Unit("m/s")] = 1e-3
    """So fast a foot creeps at most that friction holds; Drake's own value."""


@dataclass(repr=False)
class Scenario(WithFacts, Parameters):
    """A run: which robot on which ground, what it is told, what disturbs it, every parameter.

        Scenario(segments=[Segment("stand", 0.5), Segment("walk", 3.0, walk=True)])

    Each field has a default, and so has each field of the parameters inside: `GaitParameters`,
    `MpcParameters`, `WbcParameters` and the others, whose docstrings say what they mean, with
    their units; a mapping does as well, `mpc={"model": "srbm"}`. `validate` of
    `drake_linefoot.lab.scenario.load` holds them against their bounds, as `build_closed_loop`
    does; `dump_scenario` there writes every number as YAML.
    """

    name: Name = "walk"
    robot: NameOrPath = "mit_humanoid"
    """A shipped model, or the path of a description or its folder."""
    scene: NameOrPath = "flat_ground"
    """A shipped scene, or the path of one."""
    ground: GroundParameters = field(default_factory=GroundParameters)
    """Instead of the scene's."""
    terrain: TerrainParameters = field(default_factory=TerrainParameters)
    """What the controller knows of the ground."""
    seed: Annotated[Whole, Ge(0)] = 0
    """Of everything random."""
    segments: Annotated[list[Segment], Strict()] = field(default_factory=lambda: [Segment()])
    perturbation: Perturbation = field(default_factory=Perturbation)
    pushes: Annotated[list[PushParameters], Strict()] = field(default_factory=list)
    error: ErrorParameters = field(default_factory=ErrorParameters)
    actuators: ActuatorParameters = field(default_factory=ActuatorParameters)
    sensors: SensorParameters = field(default_factory=SensorParameters)
    estimation: Flag = False
    """The controller gets an estimate of the state, from the sensors on board."""
    onboard: OnboardParameters = field(default_factory=OnboardParameters)
    """The sensors of the estimation."""
    state_estimator: StateEstimatorParameters = field(default_factory=StateEstimatorParameters)
    plant: PlantParameters = field(default_factory=PlantParameters)
    estimator: EstimatorParameters = field(default_factory=EstimatorParameters)
    gait: GaitParameters = field(default_factory=GaitParameters)
    mpc: MpcParameters = field(default_factory=MpcParameters)
    wbc: WbcParameters = field(default_factory=WbcParameters)

    @property
    def period(self) -> float:
        """Of plant, estimator, gait and whole-body controller [s]."""
        return self.plant.time_step

    @property
    def duration(self) -> float:
        """Length of all segments [s]."""
        return sum(segment.duration for segment in self.segments)

    def _title(self) -> str:
        return f"Scenario {self.name!r}"

    def _facts(self) -> dict[str, object]:
        segments = [
            f"{s.name} {s.duration} s" + (f" {[*s.velocity, s.turn_rate]}" if s.walk else "")
            for s in self.segments
        ]
        usual = {e.name: e.default_factory for e in fields(self) if callable(e.default_factory)}
        kept = {name for name, make in usual.items() if plain(getattr(self, name)) == plain(make())}
        changed = [name for name in usual if name not in SAID | kept]
        return {
            "robot": f"{self.robot} on {self.scene}, seed {self.seed}",
            "segments": ", ".join(segments),
            "changed": ", ".join(changed) or "nothing else",
            "look": "dump_scenario(scenario) has every number as YAML",
        }

    @together
    def _can_be_run(self) -> None:
        if not self.segments:
            raise misfit("segments", [], "must have at least one segment")
        if self.duration > LONGEST:
            allowed = f"must take at most {LONGEST:g} s together"
            raise misfit("segments", f"{self.duration:g} s", allowed)
        if self.estimation and not self.sensors.are_perfect:
            allowed = "must be false with noise of `sensors`: those of `onboard` have their own"
            raise misfit("estimation", self.estimation, allowed)
        tick = self.plant.time_step
        # Events that nearly coincide have no certain order.
        whole = {f"pushes[{i}].duration": push.duration for i, push in enumerate(self.pushes)}
        whole |= {"actuators.delay": self.actuators.delay, "mpc.period": self.mpc.period}
        whole["mpc.run_period"] = self.mpc.shortest_period
        whole["onboard.imu_delay"] = self.onboard.imu_delay
        for entry, value in whole.items():
            if not is_multiple(value, tick):
                raise misfit(entry, value, f"must be a multiple of {tick:g} s, plant.time_step")
