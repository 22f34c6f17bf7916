"""A closed loop that was wired: its systems, and a simulator of it from where a run begins."""

from dataclasses import InitVar, dataclass
from typing import Any

from pydrake.geometry import Meshcat
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Context, Diagram, DiagramBuilder, System
from pydrake.systems.primitives import RandomSource

from drake_linefoot.estimation.state_estimator import StateEstimator
from drake_linefoot.facts import WithFacts
from drake_linefoot.lab.plants.ground import Ground
from drake_linefoot.lab.plants.initial_state import initial_state
from drake_linefoot.lab.plants.plant import Plant
from drake_linefoot.lab.scenario import Scenario
from drake_linefoot.lab.simulation.actuators import Actuators
from drake_linefoot.lab.simulation.push import Push
from drake_linefoot.lab.simulation.recorder import Recorder
from drake_linefoot.lab.simulation.sensors import Onboard, seed_noise
from drake_linefoot.late import late
from drake_linefoot.layout import Layout
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.signals import SIGNALS


@dataclass(eq=False, repr=False)
class ClosedLoop(WithFacts, Diagram):
    """A closed loop, ready to be simulated: a Drake Diagram that knows its systems.

    Its default context has the robot where a run begins, at rest: `Simulator(loop)` works.
    `make_simulator` gives it the velocities of a perturbation as well, the model error and the
    seeds of noise.

    Attributes:
        builder: has everything in it; its systems are named.
        plant: the robot on its ground; `plant.system` is Drake's MultibodyPlant, where it is one.
        controller: state in, torque out.
        command: plays the scenario's command, or what was given for it.
        push: pushes the torso; None when nothing can push.
        actuators: make of the torque what motors do; None when they apply it as it is.
        noise: of the sensors; None when they are perfect.
        onboard: sensors that the state is estimated with; None when it is measured.
        estimator: of the state; None when it is measured.
        recorder: keeps what happens.
        ground: where the ground is.
        humanoid: the robot's facts.
        scenario: what will be run.
        meshcat: where it is shown; None when it is not.
    """

    builder: InitVar[DiagramBuilder]
    plant: Plant
    controller: System
    command: System
    push: Push | None
    actuators: Actuators | None
    noise: RandomSource | None
    onboard: Onboard | None
    estimator: StateEstimator | None
    recorder: Recorder
    ground: Ground
    humanoid: Humanoid
    scenario: Scenario
    meshcat: Meshcat | None

    def __post_init__(self, builder: DiagramBuilder) -> None:
        """Build the diagram."""
        Diagram.__init__(self)
        builder.BuildInto(self)
        self.set_name("closed_loop")

    def _title(self) -> str:
        return f"Closed loop of {self.scenario.name!r}"

    def _facts(self) -> dict[str, object]:
        humanoid = self.humanoid
        return {
            "robot": f"{self.scenario.robot}: {humanoid.mass:.2f} kg, {humanoid.na} motors",
            "systems": ", ".join(system.get_name() for system in self.GetSystems()),
            "simulates": f"{self.scenario.duration:g} s, a tick each {self.scenario.period:g} s",
            "look": "simulate(loop), loop.make_simulator(), loop.draw()",
        }

    def make_simulator(self) -> Simulator:
        """Return a simulator at time 0 in the scenario's initial state."""
        simulator = Simulator(self)
        self.prepare(simulator.get_mutable_context())
        start = initial_state(self.humanoid, self.scenario)
        self.plant.place(simulator.get_mutable_context(), start)
        return simulator

    def look(self, name: str, root: Context) -> Any:
        """Return what is on an output port of the controller, a signal opened.

        Args:
            name: of the port.
            root: context of the diagram.
        """
        port = self.controller.GetOutputPort(name)
        value: Any = port.Eval(self.controller.GetMyContextFromRoot(root))
        if name not in SIGNALS:
            return value
        sizes = {**self.humanoid.sizes, "knots": self.scenario.mpc.knots}
        return Layout(SIGNALS[name], sizes).open(value)

    def draw(self, system: str = "") -> Any:
        """Return a `Picture` of it, or of one of its systems, which a notebook shows.

        Args:
            system: its path (`controller.ecd_mpc`) or the path's end (`ecd_mpc`); all without.

        Raises:
            InputError: there is no system of that name.
        """
        return late("lab.wiring.draw", "picture_of_part")(self, self.scenario, system)

    def prepare(self, root: Context) -> None:
        """Put what the scenario says of the hardware into a context of the diagram."""
        if self.noise is not None:
            context = self.noise.GetMyMutableContextFromRoot(root)
            seed_noise(self.noise, context, self.scenario.seed)
        if self.onboard is not None:
            context = self.onboard.GetMyMutableContextFromRoot(root)
            self.onboard.switch_on(context, self.scenario.seed)
        self.plant.prepare(root)
