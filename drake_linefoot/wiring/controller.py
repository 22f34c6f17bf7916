"""The controller as one Diagram: state in, torque out."""

from __future__ import annotations

from pydrake.systems.framework import Diagram, DiagramBuilder, OutputPort, System
from pydrake.systems.primitives import ZeroOrderHold

from drake_linefoot.contact.contact_estimator import ContactEstimator
from drake_linefoot.errors import InputError
from drake_linefoot.gait.gait_planner import GaitPlanner
from drake_linefoot.mpc.ecd_mpc import EcdMpc
from drake_linefoot.reference.centroidal_reference import CentroidalReference
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.robot.state_dynamics import StateDynamics
from drake_linefoot.scenario import Scenario
from drake_linefoot.wbc.whole_body_controller import WholeBodyController

# Block -> its input ports and, for those inside the controller, who drives them. A block of one's
# own may take the state itself, or what follows from it.
_STATE: dict[str, tuple[str, str] | None] = {"state": None, "dynamics": ("dynamics", "dynamics")}
CONNECTIONS: dict[str, dict[str, tuple[str, str] | None]] = {
    "dynamics": {"state": None},
    "estimator": {**_STATE, "applied_torque": None},
    "gait": {**_STATE, "command": None, "contact": ("estimator", "contact")},
    "reference": {**_STATE, "horizon": ("gait", "horizon")},
    "mpc": {**_STATE, "reference": ("reference", "reference")},
    "wbc": {**_STATE, "targets": ("gait", "targets"), "plan": ("mpc", "plan")},
}
# Exported output port -> the block that has it, under the same name.
EXPORTS = {
    "torque": "wbc",
    "dynamics": "dynamics",
    "contact": "estimator",
    "targets": "gait",
    "reference": "reference",
    "plan": "mpc",
    "report": "wbc",
}


def build_controller(
    humanoid: Humanoid,
    scenario: Scenario,
    *,
    estimator: System | None = None,
    gait: System | None = None,
    reference: System | None = None,
    mpc: System | None = None,
    wbc: System | None = None,
) -> Diagram:
    """Wire dynamics, estimator, gait, reference, MPC and whole-body controller.

    Input ports: `state` (nq + nv), `command` (4), `applied_torque` (na). Output ports:
    `torque` (na), and the signals `dynamics`, `contact`, `targets`, `reference`, `plan`, `report`.

    Args:
        humanoid: the robot.
        scenario: parameters of the blocks.
        estimator: used instead of `ContactEstimator`; so for the others. A block of one's
            own has ports of the same names (see `CONNECTIONS`); input ports it has no use
            for and output ports that only show something may be left out.
        gait: used instead of `GaitPlanner`.
        reference: used instead of `CentroidalReference`.
        mpc: used instead of `EcdMpc`.
        wbc: used instead of `WholeBodyController`.

    Returns:
        The diagram, named "controller".

    Raises:
        InputError: a block lacks an output port that another one needs.
    """
    s = scenario
    tick = s.plant.time_step
    builder = DiagramBuilder()
    blocks: dict[str, System] = {
        "dynamics": StateDynamics(humanoid),
        "estimator": estimator or ContactEstimator(humanoid, s.estimator, tick),
        "gait": gait or GaitPlanner(humanoid, s.gait, s.mpc.horizon, tick),
        "reference": reference or CentroidalReference(humanoid, s.mpc),
        "mpc": mpc or EcdMpc(humanoid, s.mpc),
        "wbc": wbc or WholeBodyController(humanoid, s.wbc),
    }
    for block in blocks.values():
        builder.AddSystem(block)
    sources = _sources(blocks)
    if s.mpc.late:
        sources["mpc", "plan"] = _later(builder, sources["mpc", "plan"], s.mpc.period)
    _connect(builder, blocks, sources)
    for port, owner in EXPORTS.items():
        if (owner, port) in sources:
            builder.ExportOutput(sources[owner, port], port)
    diagram = builder.Build()
    diagram.set_name("controller")
    return diagram


def _sources(blocks: dict[str, System]) -> dict[tuple[str, str], OutputPort]:
    """Return the output ports that are connected or exported, by block and name.

    Raises:
        InputError: a block lacks one that another block needs.
    """
    needed = {
        source
        for name, inputs in CONNECTIONS.items()
        for port, source in inputs.items()
        if source is not None and blocks[name].HasInputPort(port)
    }
    needed.add((EXPORTS["torque"], "torque"))
    shown = {(owner, port) for port, owner in EXPORTS.items() if blocks[owner].HasOutputPort(port)}
    return {(name, port): _output(blocks[name], port) for name, port in sorted(needed | shown)}


def _later(builder: DiagramBuilder, plan: OutputPort, period: float) -> OutputPort:
    """Return the plan of one period ago.

    A hold that takes in the plan at each update of the MPC takes the one before that update, as
    all unrestricted updates of a time see what was before it. Until it has one it gives the plan
    with which the MPC begins.
    """
    hold = builder.AddNamedSystem("late_plan", ZeroOrderHold(period, plan.Allocate()))
    builder.Connect(plan, hold.get_input_port())
    late: OutputPort = hold.get_output_port()
    return late


def _connect(
    builder: DiagramBuilder,
    blocks: dict[str, System],
    sources: dict[tuple[str, str], OutputPort],
) -> None:
    """Connect the input ports that the blocks have; export what comes from outside."""
    exported: set[str] = set()
    for name, inputs in CONNECTIONS.items():
        for port, source in inputs.items():
            if not blocks[name].HasInputPort(port):
                continue
            target = blocks[name].GetInputPort(port)
            if source is not None:
                builder.Connect(sources[source], target)
            elif port in exported:
                builder.ConnectInput(port, target)
            else:
                builder.ExportInput(target, port)
                exported.add(port)


def _output(block: System, port: str) -> OutputPort:
    """Return an output port by name; raise InputError when the block has none."""
    if not block.HasOutputPort(port):
        raise InputError("controller", block.get_name(), port, "the block has no such output port")
    return block.GetOutputPort(port)
