"""The plant's step alone, and the closed loop without a viewer."""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.scenario import Scenario
from drake_linefoot.scenario.edit import with_duration
from drake_linefoot.scenario.load import validate
from drake_linefoot.simulation.run import fall_reason
from drake_linefoot.simulation.scene import add_plant
from drake_linefoot.wiring.closed_loop import build_closed_loop
from studies.bench.measures import time_of
from studies.common.recorder import Tick

STEPS = 10  # of the plant between two looks at the clock
OTHER = 1_000_000  # numbers that push a step out of the caches: 8 MB
CHUNK = 0.04  # [s] of the closed loop between two looks: two updates of the MPC at 50 Hz
LONGEST = 1e4  # [s] of a loop; it never gets there


def at_500_hz(scenario: Scenario) -> Scenario:
    """Return a scenario whose plant, estimator and controller tick every 2 ms.

    Raises:
        ScenarioError: the rules of scenarios refuse it.
    """
    slow = replace(scenario, plant=replace(scenario.plant, time_step=0.002))
    validate(slow, "500 Hz")
    return slow


class PlantStep:
    """Steps of the simulated robot on its ground, nothing else in the diagram.

    Between two looks at the clock there are `STEPS` steps; or, cold, one, after other memory was
    used: so it is when the rest of a loop runs between two of them.
    """

    def __init__(self, humanoid: Humanoid, scenario: Scenario) -> None:
        """Build the plant as the closed loop has it."""
        builder = DiagramBuilder()
        self._plant, *_ = add_plant(builder, humanoid, scenario, drawn=False)
        self._simulator = Simulator(builder.Build())
        self._other = np.zeros(OTHER)

    def batch(self, ticks: Sequence[Tick]) -> list[float]:
        """Return the time of one step [s], from each state, its torque held for `STEPS` steps."""
        return [self._steps(tick, STEPS) / STEPS for tick in ticks]

    def cold(self, ticks: Sequence[Tick]) -> list[float]:
        """Return the time of one step [s], from each state, with nothing of it in the caches."""
        return [self._steps(tick, 1) for tick in ticks]

    def _steps(self, tick: Tick, steps: int) -> float:
        simulator, plant = self._simulator, self._plant
        root = simulator.get_mutable_context()
        root.SetTime(0.0)
        context = plant.GetMyMutableContextFromRoot(root)
        plant.SetPositionsAndVelocities(context, tick.before.x)
        plant.get_actuation_input_port().FixValue(context, tick.torque)
        simulator.Initialize()
        if steps == 1:
            self._other += 1.0
        return time_of(lambda: simulator.AdvanceTo(steps * plant.time_step()))


class LoopChunks:
    """The closed loop with its recorder, walking on and on."""

    def __init__(self, scenario: Scenario) -> None:
        """Build the loop and walk, untimed, into the last segment of the scenario."""
        self._loop = build_closed_loop(with_duration(scenario, LONGEST))
        self._simulator = self._loop.make_simulator()
        self._simulator.AdvanceTo(sum(s.duration for s in scenario.segments[:-1]))

    def batch(self, chunks: int) -> list[float]:
        """Return the time of one simulated millisecond [s], one for each chunk."""
        now = self._simulator.get_context().get_time()
        ends = [now + (i + 1) * CHUNK for i in range(chunks)]
        return [time_of(partial(self._simulator.AdvanceTo, end)) / (1e3 * CHUNK) for end in ends]

    def fell(self) -> str:
        """Return why the robot counts as fallen by now; empty when it walks."""
        plant = self._loop.plant
        q = plant.GetPositions(plant.GetMyContextFromRoot(self._simulator.get_context()))
        return fall_reason(self._loop.humanoid, q)
