"""The plant's step alone, and the closed loop without a viewer.

Run as a script, by any interpreter that has drake_linefoot, it is a worker that measures that
package with that Drake, see `main`: so it imports nothing of the studies.
"""

import json
import platform
import sys
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from importlib.metadata import version
from time import perf_counter
from typing import Any

import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

from drake_linefoot.lab.plants.scene import add_plant
from drake_linefoot.lab.scenario import Scenario
from drake_linefoot.lab.scenario.edit import with_duration
from drake_linefoot.lab.scenario.load import load_scenario, validate
from drake_linefoot.lab.simulation.run import fall_reason
from drake_linefoot.lab.wiring.closed_loop import build_closed_loop
from drake_linefoot.robot.humanoid import Humanoid, load_humanoid
from drake_linefoot.types import Array

STEPS = 10  # of the plant between two looks at the clock
OTHER = 1_000_000  # numbers that push a step out of the caches: 8 MB
CHUNK = 0.04  # [s] of the closed loop between two looks: two updates of the MPC at 50 Hz
LONGEST = 1e4  # [s] of a loop; it never gets there

State = tuple[Array, Array]  # of the robot, shape (nq + nv,), and the torque it has, shape (na,)


def time_of(function: Callable[[], object]) -> float:
    """Return how long a function takes [s]."""
    start = perf_counter()
    function()
    return perf_counter() - start


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

    def batch(self, states: Sequence[State]) -> list[float]:
        """Return the time of one step [s], from each state, its torque held for `STEPS` steps."""
        return [self._steps(state, STEPS) / STEPS for state in states]

    def cold(self, states: Sequence[State]) -> list[float]:
        """Return the time of one step [s], from each state, with nothing of it in the caches."""
        return [self._steps(state, 1) for state in states]

    def _steps(self, state: State, steps: int) -> float:
        simulator, plant = self._simulator, self._plant
        root = simulator.get_mutable_context()
        root.SetTime(0.0)
        context = plant.GetMyMutableContextFromRoot(root)
        plant.SetPositionsAndVelocities(context, state[0])
        plant.get_actuation_input_port().FixValue(context, state[1])
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
        x = self._loop.plant.state(self._simulator.get_context())
        return fall_reason(self._loop.humanoid, x[: self._loop.humanoid.nq])


def sweep_run(file: str, index: int) -> float:
    """Return how long a run of the first group of a sweep takes [s], judged and all.

    Raises:
        RuntimeError: the run had an error.
    """
    from drake_linefoot.lab.sweep.file import load_sweep
    from drake_linefoot.lab.sweep.jobs import job
    from drake_linefoot.lab.sweep.worker import carry_out

    sweep = load_sweep(file)
    row, _ = carry_out(job(sweep, sweep.groups[0], index))
    if row["error"]:
        raise RuntimeError(f"run {index} of {file}: {row['error']}")
    return float(row["wall_seconds"])


def main() -> None:
    """Answer lines of JSON on stdin until it ends.

    The first has `scenario`, its name, `durations` of its first segments [s], which are
    walked, and `states`. The answer has the versions. Later ones have `loop`, a number of chunks;
    `plant`, anything; or `run`, a sweep's file and an index: the answer has `times` [s].
    """
    setup = json.loads(sys.stdin.readline())
    scenario = load_scenario(setup["scenario"])
    del scenario.segments[len(setup["durations"]) :]
    for segment, duration in zip(scenario.segments, setup["durations"], strict=True):
        segment.duration = duration
    states = [(np.array(x), np.array(torque)) for x, torque in setup["states"]]
    plant, loop = PlantStep(load_humanoid(scenario.robot), scenario), LoopChunks(scenario)
    packages = "drake_linefoot", "drake", "numpy"
    versions = {"python": platform.python_version()} | {name: version(name) for name in packages}
    print(json.dumps({"versions": versions}), flush=True)
    for line in sys.stdin:
        question: dict[str, Any] = json.loads(line)
        if "loop" in question:
            times = loop.batch(question["loop"])
        elif "plant" in question:
            times = plant.batch(states)
        else:
            times = [sweep_run(*question["run"])]
        print(json.dumps({"times": times, "fell": loop.fell()}), flush=True)


if __name__ == "__main__":
    main()
