"""Walks that are simulated with something looking at every step: the blocks' inputs, for one.

Inputs are kept as the block gets them in its tick: the whole-body controller the state before
the plant's step, estimator and gait the state after it with their own state from before.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from pydrake.systems.framework import Context, System

from drake_linefoot.lab.scenario import Scenario
from drake_linefoot.lab.simulation.closed_loop import ClosedLoop
from drake_linefoot.lab.simulation.run import simulate
from drake_linefoot.lab.wiring.closed_loop import build_closed_loop
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.signals import (
    CentroidalPlan,
    ContactEstimate,
    GaitHorizon,
    GaitTargets,
    Reference,
    WholeBodyReport,
    layouts,
)
from studies.common.types import Array

TICKS = 7  # between two ticks that are kept; prime to the period of the MPC


@dataclass(frozen=True)
class Moment:
    """What there is between two ticks."""

    time: float  # [s]
    x: Array  # state of the robot, shape (nq + nv,)
    applied: Array  # torque of the actuators over the last step, shape (na,)
    command: Array  # shape (4,)
    contact: ContactEstimate  # of the estimator
    estimator: tuple[Array, ...]  # its discrete state, group by group
    gait: Array  # discrete state of the gait planner


@dataclass(frozen=True)
class Tick:
    """One tick."""

    before: Moment  # when it begins
    after: Moment  # when the next one begins
    targets: GaitTargets  # of the gait, given to the whole-body controller
    plan: CentroidalPlan  # of the MPC, likewise
    torque: Array  # of the whole-body controller, shape (na,)
    report: WholeBodyReport  # what it did


@dataclass(frozen=True)
class MpcProblem:
    """One update of the MPC."""

    x: Array  # state of the robot, shape (nq + nv,)
    gait: Array  # discrete state of the gait planner
    horizon: GaitHorizon  # of the gait
    reference: Reference  # what was asked for
    previous: CentroidalPlan  # plan before
    plan: CentroidalPlan  # plan after


@dataclass(frozen=True)
class Walk:
    """A recorded walk."""

    scenario: Scenario  # what was walked
    humanoid: Humanoid  # the robot
    ticks: tuple[Tick, ...]  # every so many
    problems: tuple[MpcProblem, ...]  # all of the MPC, in their order
    fall_reason: str  # why the robot fell; empty when it did not

    def walking_ticks(self, count: int) -> list[Tick]:
        """Return `count` ticks, evenly spread over the time that the robot walks."""
        return spread([t for t in self.ticks if t.before.command[3] > 0.5], count)

    def walking_states(self, count: int) -> list[tuple[Array, Array]]:
        """Return `count` states and the torques they have, as `walking_ticks`."""
        return [(tick.before.x, tick.torque) for tick in self.walking_ticks(count)]

    def walking_problems(self, count: int) -> list[MpcProblem]:
        """Return `count` problems of the MPC, evenly spread over walking."""
        began = min((t.before.time for t in self.ticks if t.before.command[3] > 0.5), default=0.0)
        return spread([p for p in self.problems if p.reference.times[0] > began], count)


def spread(items: list[Any], count: int) -> list[Any]:
    """Return `count` of the items (or all, when there are fewer), evenly spread."""
    if len(items) <= count:
        return items
    return [items[i] for i in np.linspace(0, len(items) - 1, count).round().astype(int)]


def record(scenario: Scenario, every: int = TICKS) -> Walk:
    """Simulate a scenario and keep what its blocks saw, of every so many ticks."""
    loop = build_closed_loop(scenario)
    tape = _Tape(loop, every)
    run = simulate(loop, look=tape)
    ticks, problems = tuple(tape.ticks), tuple(tape.problems)
    return Walk(scenario, loop.humanoid, ticks, problems, run.fall_reason)


class _Tape:
    """Keeps what ports and states say."""

    def __init__(self, loop: ClosedLoop, every: int) -> None:
        self._loop, self._every = loop, every
        self._layouts = layouts(loop.humanoid.sizes, loop.scenario.mpc.knots)
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

    def __call__(self, root: Context) -> None:
        context = self._loop.controller.GetMyContextFromRoot(root)
        now = self._moment(root, context)
        plan = self._port(context, "plan")
        if self._pending_tick is not None:
            self.ticks.append(Tick(after=now, **self._pending_tick))
        if self._pending_problem is not None:
            self.problems.append(MpcProblem(plan=plan, **self._pending_problem))
        self._pending_tick = self._pending_problem = None
        tick = round(root.get_time() / self._step)
        if tick % self._every == 0:
            names = ("targets", "plan", "torque", "report")
            values = {name: self._port(context, name) for name in names}
            self._pending_tick = {"before": now, **values}
        if tick % self._mpc_ticks == 0:
            gait = self._blocks["gait_planner"]
            ahead = gait.GetOutputPort("horizon").Eval(gait.GetMyContextFromRoot(root))
            horizon = self._layouts["horizon"].open(ahead)
            self._pending_problem = {
                "x": now.x,
                "gait": now.gait,
                "horizon": horizon,
                "reference": self._port(context, "reference"),
                "previous": plan,
            }

    def _port(self, context: Context, name: str) -> Any:
        value: Any = self._loop.controller.GetOutputPort(name).Eval(context)
        return self._layouts[name].open(value) if name in self._layouts else value

    def _moment(self, root: Context, context: Context) -> Moment:
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
            x=self._loop.plant.state(root),
            applied=controller.GetInputPort("applied_torque").Eval(context),
            command=controller.GetInputPort("command").Eval(context),
            contact=self._port(context, "contact"),
            estimator=tuple(state["contact_estimator"]),
            gait=state["gait_planner"][0],
        )
