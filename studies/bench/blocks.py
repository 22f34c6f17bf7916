"""Each block of the controller on recorded inputs, through its ports and events.

In front of each there is a block that computes the dynamics of its state, and is timed with it.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from time import perf_counter

import numpy as np
from pydrake.systems.analysis import InitializeParams, Simulator
from pydrake.systems.framework import Diagram, DiagramBuilder, LeafSystem

from drake_linefoot.centroidal import NO_WRENCH
from drake_linefoot.estimation.contact_estimator import ContactEstimator
from drake_linefoot.gait.gait_planner import GaitPlanner
from drake_linefoot.lab.scenario import Scenario
from drake_linefoot.layout import Layout, flat
from drake_linefoot.mpc import ecd
from drake_linefoot.mpc.centroidal_reference import CentroidalReference
from drake_linefoot.mpc.condensed_qp import CondensedQp
from drake_linefoot.mpc.ecd_mpc import EcdMpc, standing_plan
from drake_linefoot.mpc.models.model import CentroidalMeasurement
from drake_linefoot.mpc.models.registry import model_named
from drake_linefoot.mpc.solve import MpcSolver
from drake_linefoot.robot.dynamics import dynamics_by_drake, robot_dynamics
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.robot.state_dynamics import StateDynamics
from drake_linefoot.signals import CentroidalPlan, Reference, WholeBodyReport, layouts
from drake_linefoot.statuses import Solved
from drake_linefoot.wbc.whole_body_controller import WholeBodyController
from studies.bench.loops import State, time_of
from studies.bench.measures import Batch
from studies.common.recorder import MpcProblem, Tick
from studies.common.types import Array


def wired(humanoid: Humanoid, *blocks: LeafSystem) -> Diagram:
    """Return blocks behind that of the dynamics, each one connected to those before it.

    Ports of the same name are connected; the other input ports and all output ports are the
    diagram's, by their names.
    """
    builder = DiagramBuilder()
    dynamics = builder.AddSystem(StateDynamics(humanoid))
    builder.ExportInput(dynamics.get_state_input_port(), "state")
    outputs = {"dynamics": dynamics.get_dynamics_output_port()}
    for block in blocks:
        builder.AddSystem(block)
        for i in range(block.num_input_ports()):
            port = block.get_input_port(i)
            if port.get_name() in outputs:
                builder.Connect(outputs[port.get_name()], port)
            else:
                builder.ExportInput(port, port.get_name())
        for i in range(block.num_output_ports()):
            out = block.get_output_port(i)
            outputs[out.get_name()] = out
            builder.ExportOutput(out, out.get_name())
    return builder.Build()


def dynamics_of(humanoid: Humanoid, states: Sequence[State]) -> Batch:
    """Return a batch of the dynamics of each state, as they are and by Drake's calls."""
    scratch = humanoid.plant.CreateDefaultContext()

    def batch() -> dict[str, list[float]]:
        ways = {"dynamics": robot_dynamics, "dynamics_drake": dynamics_by_drake}
        return {
            name: [time_of(partial(way, humanoid, scratch, x)) for x, _ in states]
            for name, way in ways.items()
        }

    return batch


class WbcTick:
    """One tick of the whole-body controller, state, targets and plan in, torque out."""

    def __init__(self, humanoid: Humanoid, scenario: Scenario) -> None:
        """Build the block by itself."""
        self._block = wired(
            humanoid, WholeBodyController(humanoid, scenario.wbc, scenario.mpc.knots)
        )
        self._context = self._block.CreateDefaultContext()
        self._torque = self._block.GetOutputPort("torque")
        self._report = Layout(WholeBodyReport, humanoid.sizes)

    def set(self, tick: Tick) -> None:
        """Put the inputs of a tick on the ports."""
        inputs = {"state": tick.before.x, "targets": flat(tick.targets), "plan": flat(tick.plan)}
        for name, value in inputs.items():
            self._block.GetInputPort(name).FixValue(self._context, value)

    def run(self) -> Array:
        """Return the torque for the inputs that were set."""
        torque: Array = self._torque.Eval(self._context)
        return torque

    def status(self, tick: Tick) -> str:
        """Return the controller's word for how a tick's wrench program was solved."""
        self.set(tick)
        report = self._report.open(self._block.GetOutputPort("report").Eval(self._context))
        return Solved(int(report.status)).words

    def __call__(self, tick: Tick) -> tuple[float, Array]:
        """Return time [s] and torque."""
        self.set(tick)
        start = perf_counter()
        torque = self.run()
        return perf_counter() - start, torque


class DiscreteUpdate:
    """The periodic update of a block with discrete state only."""

    def __init__(self, block: Diagram, read: Callable[[Tick], dict[str, object]]) -> None:
        """Keep the block; `read` gives its inputs by port."""
        self._block, self._read = block, read
        self._context = block.CreateDefaultContext()

    def __call__(self, tick: Tick, state: Sequence[Array]) -> tuple[float, list[Array]]:
        """Return time [s] and the discrete state after the update, group by group."""
        context = self._context
        context.SetTime(tick.before.time)
        for name, value in self._read(tick).items():
            self._block.GetInputPort(name).FixValue(context, value)
        for i, group in enumerate(state):
            context.SetDiscreteState(i, group)
        start = perf_counter()
        after = self._block.EvalUniquePeriodicDiscreteUpdate(context)
        elapsed = perf_counter() - start
        return elapsed, [after.value(i).copy() for i in range(after.num_groups())]


def estimator_update(humanoid: Humanoid, scenario: Scenario) -> DiscreteUpdate:
    """Return the update of the contact estimator."""
    estimator = ContactEstimator(humanoid, scenario.estimator, scenario.plant.time_step)

    def read(tick: Tick) -> dict[str, object]:
        return {"state": tick.after.x, "applied_torque": tick.after.applied}

    return DiscreteUpdate(wired(humanoid, estimator), read)


def gait_update(humanoid: Humanoid, scenario: Scenario) -> DiscreteUpdate:
    """Return the update of the gait planner."""

    def read(tick: Tick) -> dict[str, object]:
        now = tick.before
        return {"state": tick.after.x, "command": now.command, "contact": flat(now.contact)}

    return DiscreteUpdate(wired(humanoid, _planner(humanoid, scenario)), read)


def _planner(humanoid: Humanoid, scenario: Scenario) -> GaitPlanner:
    mpc, tick = scenario.mpc, scenario.plant.time_step
    return GaitPlanner(humanoid, scenario.gait, mpc.horizon, tick, mpc.knots)


class MpcUpdate:
    """One update of the MPC, whole (reference and MPC as blocks) and in parts.

    The parts: `references`, the block that gives the reference; `matrices` of the linearised
    dynamics; `condensing`, what else there is to building the program; `solve`, what else there
    is to a plan.
    """

    PARTS = ("references", "matrices", "condensing", "solve")

    def __init__(self, humanoid: Humanoid, scenario: Scenario) -> None:
        """Build the two blocks, wired, and the solver by itself."""
        self._humanoid, self._scratch = humanoid, humanoid.plant.CreateDefaultContext()
        self._model = model_named(scenario.mpc.model)
        self._solver = MpcSolver(scenario.mpc, humanoid.mass, humanoid.contact)
        self._reference = wired(humanoid, CentroidalReference(humanoid, scenario.mpc))
        self._alone = self._reference.CreateDefaultContext()
        self._mpc = EcdMpc(humanoid, scenario.mpc)
        self._diagram = wired(humanoid, CentroidalReference(humanoid, scenario.mpc), self._mpc)
        self._simulator = Simulator(self._diagram)
        self._layouts = layouts(humanoid.sizes, scenario.mpc.knots)

    def set(self, problem: MpcProblem) -> None:
        """Put the inputs of an update on the ports, and the plan before it into the MPC."""
        simulator, context = self._simulator, self._simulator.get_mutable_context()
        self._diagram.GetInputPort("state").FixValue(context, problem.x)
        self._diagram.GetInputPort("horizon").FixValue(context, flat(problem.horizon))
        own = self._mpc.GetMyMutableContextFromRoot(context)
        own.SetDiscreteState(flat(problem.previous))
        context.SetTime(0.0)
        params = InitializeParams()
        params.suppress_initialization_events = True
        simulator.Initialize(params)

    def run(self) -> None:
        """Update once, with what was set."""
        self._simulator.AdvanceTo(1e-6)  # the update at time 0, and no other

    def whole(self, problem: MpcProblem) -> tuple[float, CentroidalPlan]:
        """Return time [s] of a whole update, and its plan."""
        self.set(problem)
        start = perf_counter()
        self.run()
        elapsed = perf_counter() - start
        own = self._mpc.GetMyContextFromRoot(self._simulator.get_context())
        vector = own.get_discrete_state_vector().value().copy()
        return elapsed, self._layouts["plan"].open(vector)

    def reference(self, problem: MpcProblem) -> tuple[float, Reference]:
        """Return time [s] of the reference, and the reference."""
        self._reference.GetInputPort("state").FixValue(self._alone, problem.x)
        self._reference.GetInputPort("horizon").FixValue(self._alone, flat(problem.horizon))
        start = perf_counter()
        vector = self._reference.GetOutputPort("reference").Eval(self._alone)
        return perf_counter() - start, self._layouts["reference"].open(vector)

    def parts(self, problem: MpcProblem) -> dict[str, float]:
        """Return the time of each part [s]; those that are differences are of this problem."""
        references, _ = self.reference(problem)
        measured, ref, mass = self._measure(problem), problem.reference, self._humanoid.mass
        marks = [perf_counter()]
        ecd.system_matrices(self._model.linearise(ref), measured.r, mass, NO_WRENCH)
        ecd.input_matrices(ref.p_WC, ref.R_WC, measured.r, mass, self._humanoid.contact.size)
        marks.append(perf_counter())
        self._solver.build(ref, measured)
        marks.append(perf_counter())
        self._solver.solve(ref, measured, problem.previous)
        marks.append(perf_counter())
        matrices, build, plan = np.diff(marks).tolist()
        times = (references, matrices, max(build - matrices, 0.0), max(plan - build, 0.0))
        return dict(zip(self.PARTS, times, strict=True))

    def program(self, problem: MpcProblem) -> CondensedQp:
        """Return the condensed program of a problem."""
        return self._solver.build(problem.reference, self._measure(problem))

    def _measure(self, problem: MpcProblem) -> CentroidalMeasurement:
        return self._model.measure(robot_dynamics(self._humanoid, self._scratch, problem.x))


def with_other_horizon(
    humanoid: Humanoid, scenario: Scenario, problems: Sequence[MpcProblem]
) -> list[MpcProblem]:
    """Return consecutive problems as they would have been with the knots of `scenario`.

    All but the first: a problem's previous plan is that of the one before.
    """
    planner, update = _planner(humanoid, scenario), MpcUpdate(humanoid, scenario)
    context = planner.CreateDefaultContext()
    found: list[MpcProblem] = []
    plan = standing_plan(humanoid, scenario.mpc)  # the first to be used has as many knots
    for i, problem in enumerate(problems):
        context.SetDiscreteState(problem.gait)
        ahead = planner.GetOutputPort("horizon").Eval(context)
        horizon = layouts(humanoid.sizes, scenario.mpc.knots)["horizon"].open(ahead)
        other = replace(problem, horizon=horizon, previous=plan)
        other = replace(other, reference=update.reference(other)[1])
        plan = update.whole(other)[1]
        if i > 0:
            found.append(replace(other, plan=plan))
    return found
