"""A walk that is simulated once, and what every block of the controller saw on the way.

Inputs are kept as the block gets them in its tick: the whole-body controller the state before
the plant's step, estimator and gait the state after it with their own state from before.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydrake.systems.framework import Context, EventStatus, System

from drake_linefoot.errors import LinefootError
from drake_linefoot.gait.horizon import GaitHorizon
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.scenario import Scenario
from drake_linefoot.signals import (
    CentroidalPlan,
    ContactEstimate,
    GaitTargets,
    Reference,
    WholeBodyReport,
)
from drake_linefoot.simulation.quiet import quieten_drake
from drake_linefoot.simulation.run import fall_reason
from drake_linefoot.wiring.closed_loop import ClosedLoop, build_closed_loop

Array = NDArray[np.float64]

TICKS = 7  # between two ticks that are kept; prime to the period of the MPC


@dataclass(frozen=True)
class Moment:
    """What there is between two ticks.

    Attributes:
        time: [s].
        x: state of the robot, shape (nq + nv,).
        applied: torque of the actuators over the last step, shape (na,).
        command: shape (4,).
        contact: of the estimator.
        estimator: its discrete state, group by group.
        gait: discrete state of the gait planner.
    """

    time: float
    x: Array
    applied: Array
    command: Array
    contact: ContactEstimate
    estimator: tuple[Array, ...]
    gait: Array


@dataclass(frozen=True)
class Tick:
    """One tick.

    Attributes:
        before, after: the moments.
        targets, plan: inputs of the whole-body controller.
        torque: its output, shape (na,).
        report: what it did.
    """

    before: Moment
    after: Moment
    targets: GaitTargets
    plan: CentroidalPlan
    torque: Array
    report: WholeBodyReport


@dataclass(frozen=True)
class MpcProblem:
    """One update of the MPC.

    Attributes:
        x: state of the robot, shape (nq + nv,).
        gait: discrete state of the gait planner.
        horizon: of the gait.
        reference: what was asked for.
        previous: plan before.
        plan: plan after.
    """

    x: Array
    gait: Array
    horizon: GaitHorizon
    reference: Reference
    previous: CentroidalPlan
    plan: CentroidalPlan


@dataclass(frozen=True)
class Walk:
    """A recorded walk.

    Attributes:
        scenario: what was walked.
        humanoid: the robot.
        ticks: every `TICKS`-th.
        problems: all of the MPC, in their order.
    """

    scenario: Scenario
    humanoid: Humanoid
    ticks: tuple[Tick, ...]
    problems: tuple[MpcProblem, ...]

    def walking_ticks(self, count: int) -> list[Tick]:
        """Return `count` ticks, evenly spread over the time that the robot walks."""
        return spread([t for t in self.ticks if t.before.command[3] > 0.5], count)

    def walking_problems(self, count: int) -> list[MpcProblem]:
        """Return `count` problems of the MPC, evenly spread over walking."""
        began = min((t.before.time for t in self.ticks if t.before.command[3] > 0.5), default=0.0)
        return spread([p for p in self.problems if p.reference.times[0] > began], count)


def spread(items: list[Any], count: int) -> list[Any]:
    """Return `count` of the items (or all, when there are fewer), evenly spread."""
    if len(items) <= count:
        return items
    return [items[i] for i in np.linspace(0, len(items) - 1, count).round().astype(int)]


def record(scenario: Scenario) -> Walk:
    """Simulate a scenario and keep what its blocks saw.

    Raises:
        LinefootError: the robot fell.
    """
    quieten_drake()
    loop = build_closed_loop(scenario)
    simulator = loop.make_simulator()
    tape = _Tape(loop)
    simulator.set_monitor(tape)
    simulator.AdvanceTo(scenario.duration)
    reason = fall_reason(loop.humanoid, tape.last.x[: loop.humanoid.nq])
    if reason:
        raise LinefootError(f"the walk to be measured on was not walked: {reason}")
    return Walk(scenario, loop.humanoid, tuple(tape.ticks), tuple(tape.problems))


class _Tape:
    """Monitor of a simulator that keeps what ports and states say."""

    def __init__(self, loop: ClosedLoop) -> None:
        self._loop = loop
        self._step = loop.scenario.plant.time_step
        self._mpc_ticks = round(loop.scenario.mpc.period / self._step)
        self._blocks: dict[str, System] = {
            name: loop.controller.GetSubsystemByName(name)
            for name in ("contact_estimator", "gait_planner")
        }
        self._pending_tick: dict[str, Any] | None = None
        self._pending_problem: dict[str, Any] | None = None
        self.ticks: list[Tick] = []
        self.problems: list[MpcProblem] = []
        self.last: Moment

    def __call__(self, root: Context) -> EventStatus:
        context = self._loop.controller.GetMyContextFromRoot(root)
        now = self.last = self._moment(root, context)
        plan = self._port(context, "plan")
        if self._pending_tick is not None:
            self.ticks.append(Tick(after=now, **self._pending_tick))
        if self._pending_problem is not None:
            self.problems.append(MpcProblem(plan=plan, **self._pending_problem))
        self._pending_tick = self._pending_problem = None
        tick = round(root.get_time() / self._step)
        if tick % TICKS == 0:
            names = ("targets", "plan", "torque", "report")
            values = {name: self._port(context, name) for name in names}
            self._pending_tick = {"before": now, **values}
        if tick % self._mpc_ticks == 0:
            gait = self._blocks["gait_planner"]
            horizon = gait.GetOutputPort("horizon").Eval(gait.GetMyContextFromRoot(root))
            self._pending_problem = {
                "x": now.x,
                "gait": now.gait,
                "horizon": horizon,
                "reference": self._port(context, "reference"),
                "previous": plan,
            }
        return EventStatus.DidNothing()

    def _port(self, context: Context, name: str) -> Any:
        return self._loop.controller.GetOutputPort(name).Eval(context)

    def _moment(self, root: Context, context: Context) -> Moment:
        plant = self._loop.plant
        state = {
            name: [
                block.GetMyContextFromRoot(root).get_discrete_state(i).value().copy()
                for i in range(block.num_discrete_state_groups())
            ]
            for name, block in self._blocks.items()
        }
        controller = self._loop.controller
        return Moment(
            time=root.get_time(),
            x=plant.GetPositionsAndVelocities(plant.GetMyContextFromRoot(root)),
            applied=controller.GetInputPort("applied_torque").Eval(context),
            command=controller.GetInputPort("command").Eval(context),
            contact=self._port(context, "contact"),
            estimator=tuple(state["contact_estimator"]),
            gait=state["gait_planner"][0],
        )
