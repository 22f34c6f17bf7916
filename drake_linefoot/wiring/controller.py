"""The controller as one Diagram: state in, torque out."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import is_dataclass

from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import Diagram, DiagramBuilder, OutputPort, System

from drake_linefoot.checks import check, plain
from drake_linefoot.errors import InputError
from drake_linefoot.estimation.contact_estimator import ContactEstimator
from drake_linefoot.gait.gait_planner import GaitPlanner
from drake_linefoot.late import late
from drake_linefoot.mpc.centroidal_reference import CentroidalReference
from drake_linefoot.mpc.ecd_mpc import EcdMpc
from drake_linefoot.mpc.late_plan import LatePlan
from drake_linefoot.mpc.process_mpc import ProcessMpc
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.robot.scaling import scaled
from drake_linefoot.robot.state_dynamics import StateDynamics
from drake_linefoot.wbc.tasks.task import Task
from drake_linefoot.wbc.whole_body_controller import WholeBodyController
from drake_linefoot.wiring.parameters import ControllerParameters, ParametersOfBlocks

# Signal -> the block that makes it. Every input port of a block is connected to the signal of its
# name, so a block of one's own may take the state itself, or what follows from it.
SOURCES = {
    "torque": "wbc",
    "dynamics": "dynamics",
    "contact": "estimator",
    "targets": "gait",
    "horizon": "gait",
    "reference": "reference",
    "plan": "mpc",
    "report": "wbc",
}
EXPORTS = [name for name in SOURCES if name != "horizon"]  # output ports of the controller
INPUTS = ("state", "command", "applied_torque", "terrain")  # its input ports


def build_controller(
    humanoid: Humanoid,
    parameters: ParametersOfBlocks | None = None,
    *,
    estimator: System | None = None,
    gait: System | None = None,
    reference: System | None = None,
    mpc: System | None = None,
    wbc: System | None = None,
    tasks: Sequence[Task] = (),
) -> Diagram:
    """Wire dynamics, estimator, gait, reference, MPC and whole-body controller.

    Input ports: `state` (nq + nv), `command` (4), `applied_torque` (na). Output ports:
    `torque` (na), and the signals `dynamics`, `contact`, `targets`, `reference`, `plan`, `report`.

    Args:
        humanoid: the robot.
        parameters: of the blocks, a `ControllerParameters` or a `Scenario`; the defaults without.
        estimator: used instead of `ContactEstimator`; so for the others. A block of one's
            own has ports of the same names (see `SOURCES`); input ports it has no use
            for and output ports that only show something may be left out.
        gait: used instead of `GaitPlanner`.
        reference: used instead of `CentroidalReference`.
        mpc: used instead of `EcdMpc`.
        wbc: used instead of `WholeBodyController`.
        tasks: of one's own, beside those of the `WholeBodyController`.

    Returns:
        The diagram, named "controller".

    Raises:
        InputError: a block lacks an output port that another one needs, or a parameter cannot
            be used.
    """
    given = parameters or ControllerParameters()
    if is_dataclass(given):  # of lists, where tuples or arrays were given
        given = check(plain(given), type(given), "parameters", together=False)
    late("wiring.warm_up", "compile_controller")()
    s = scaled(given, humanoid)
    builder = DiagramBuilder()
    own = {"estimator": estimator, "gait": gait, "reference": reference, "mpc": mpc, "wbc": wbc}
    blocks = {name: own.get(name) or make() for name, make in makers(humanoid, s, tasks).items()}
    for block in blocks.values():
        builder.AddSystem(block)
    sources = {
        name: blocks[owner].GetOutputPort(name)
        for name, owner in SOURCES.items()
        if blocks[owner].HasOutputPort(name)
    }
    _check_sources(blocks, sources)
    if s.mpc.late and not s.mpc.process:  # which is late by itself
        sources["plan"] = _later(builder, sources["plan"], s.mpc.period)
    _connect(builder, blocks, sources)
    for name in EXPORTS:
        if name in sources:
            builder.ExportOutput(sources[name], name)
    diagram = builder.Build()
    diagram.set_name("controller")
    return diagram


def makers(
    humanoid: Humanoid, parameters: ParametersOfBlocks, tasks: Sequence[Task] = ()
) -> dict[str, Callable[[], System]]:
    """Return what makes the blocks of this package, by their names in `SOURCES`.

    Args:
        humanoid: the robot.
        parameters: of the blocks.
        tasks: of one's own.
    """
    s, tick = parameters, parameters.period
    return {
        "dynamics": lambda: StateDynamics(humanoid),
        "estimator": lambda: ContactEstimator(humanoid, s.estimator, tick),
        "gait": lambda: GaitPlanner(humanoid, s.gait, s.mpc.horizon, tick, s.mpc.knots),
        "reference": lambda: CentroidalReference(humanoid, s.mpc),
        "mpc": lambda: (ProcessMpc if s.mpc.process else EcdMpc)(humanoid, s.mpc),
        "wbc": lambda: WholeBodyController(humanoid, s.wbc, s.mpc.knots, tasks),
    }


def check_plant(plant: MultibodyPlant, period: float) -> None:
    """Check that a plant suits the controller, which has to see state and torque of one step.

    A discrete plant with sampled output ports (Drake's default) steps before the updates of the
    controller, and then shows the state after the step beside the torque of that step. Any other
    plant shows the estimator (21) the torque of another time.

    Args:
        plant: to be connected to a controller.
        period: of estimator, gait and whole-body controller [s].

    Raises:
        InputError: the plant is continuous, steps with another period, or its output ports are
            not sampled.
    """
    if plant.time_step() != period:
        allowed = f"must be {period} s, the period of the contact estimator"
        raise InputError("plant", "time_step", plant.time_step(), allowed)
    if not plant.has_sampled_output_ports():
        allowed = "must be sampled: the contact estimator needs the torque of the last step"
        raise InputError("plant", "use_sampled_output_ports", False, allowed)


def _check_sources(blocks: dict[str, System], sources: dict[str, OutputPort]) -> None:
    """Raise InputError when a block lacks an output port that another block needs."""
    for name, owner in SOURCES.items():
        needed = name == "torque" or any(block.HasInputPort(name) for block in blocks.values())
        if needed and name not in sources:
            allowed = "the block has no such output port"
            raise InputError("controller", blocks[owner].get_name(), name, allowed)


def _later(builder: DiagramBuilder, plan: OutputPort, period: float) -> OutputPort:
    """Return the plan of one period ago."""
    hold = builder.AddSystem(LatePlan(plan.size(), period))
    builder.Connect(plan, hold.GetInputPort("newest"))
    return hold.GetOutputPort("plan")


def connect_by_name(
    builder: DiagramBuilder, system: System, sources: Mapping[str, OutputPort]
) -> None:
    """Connect every input port of a system to the source of its name, when there is one."""
    for name, port in sources.items():
        if system.HasInputPort(name):
            builder.Connect(port, system.GetInputPort(name))


def _connect(
    builder: DiagramBuilder, blocks: dict[str, System], sources: dict[str, OutputPort]
) -> None:
    """Connect the input ports that the blocks have; export what comes from outside."""
    for block in blocks.values():
        connect_by_name(builder, block, sources)
    for name in INPUTS:
        targets = [b.GetInputPort(name) for b in blocks.values() if b.HasInputPort(name)]
        for i, target in enumerate(targets):
            if i == 0:
                builder.ExportInput(target, name)
            else:
                builder.ConnectInput(name, target)
