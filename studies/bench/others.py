"""The closed loop in processes of its own: beside a busy core, and with another package or Drake.

An environment of its own has the other one: a checkout of an older commit, or this one with a
newer Python, which gets a newer Drake.
"""

import sys
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from functools import partial
from itertools import count
from pathlib import Path
from typing import Any

from drake_linefoot.errors import LinefootError
from studies.bench import loops
from studies.bench.dispatch import SWEEP
from studies.bench.line_worker import LineWorker
from studies.bench.measures import Batch, Effort, Results, ratio, summarise, take_turns
from studies.common.recorder import Walk

BUSY_ROUNDS = 5  # in which loop and plant take turns beside another loop
MEANWHILE = 100_000  # chunks of it: more than it has time for
AGAINST = {  # what is said of two environments, and of which times it is the ratio
    "closed_loop_over_other": ("own_loop", "other_loop"),
    "plant_step_over_other": ("own_plant_step", "other_plant_step"),
    "sweep_runs_per_core_minute": ("other_sweep_run", "own_sweep_run"),
}


class LoopWorker(LineWorker):
    """A process that measures with the package and the Drake of an interpreter.

    Attributes:
        versions: of Python, package and Drake.
    """

    def __init__(self, python: Path, walk: Walk, states: Sequence[loops.State]) -> None:
        """Start it, and let it walk as the recorded walk was.

        Raises:
            LinefootError: that interpreter has no drake_linefoot, or one that cannot do it.
        """
        super().__init__(str(python), [str(python), "-P", loops.__file__])
        durations = [segment.duration for segment in walk.scenario.segments]
        listed = [(x.tolist(), torque.tolist()) for x, torque in states]
        setup = {"scenario": walk.scenario.name, "durations": durations, "states": listed}
        self._runs = count()
        self.versions: dict[str, str] = self.ask(setup)["versions"]

    def times(self, **question: Any) -> list[float]:
        """Ask for times [s], see `loops.main`.

        Raises:
            LinefootError: the worker had an error, or its robot fell.
        """
        answer = self.ask(question)
        if answer["fell"]:
            raise LinefootError(f"{self._name}: the robot fell: {answer['fell']}")
        times: list[float] = answer["times"]
        return times

    def sweep_run(self) -> list[float]:
        """Return the time of the next run of the sweep [s]."""
        return self.times(run=(str(SWEEP.resolve()), next(self._runs)))

    @contextmanager
    def walking(self) -> Iterator[None]:
        """Let it walk until the `with` block ends, and end it then."""
        self.send({"loop": MEANWHILE})
        try:
            yield
        finally:
            self._process.kill()


def beside_another(
    walk: Walk, states: Sequence[loops.State], chunks: int, results: Results
) -> None:
    """Measure loop and plant while another process walks, too."""
    plant, loop = loops.PlantStep(walk.humanoid, walk.scenario), loops.LoopChunks(walk.scenario)
    batches: dict[str, Batch] = {
        "loop_busy": partial(loop.batch, chunks),
        "plant_step_busy": partial(plant.batch, states),
    }
    with LoopWorker(Path(sys.executable), walk, states) as other, other.walking():
        times = take_turns(batches, BUSY_ROUNDS)
    results.times |= {name: summarise(found) for name, found in times.items()}
    name = "closed_loop_over_plant_step_busy"
    results.values[name] = ratio(results.times["loop_busy"], results.times["plant_step_busy"])


def against(
    walk: Walk, states: Sequence[loops.State], python: Path, effort: Effort, results: Results
) -> None:
    """Measure this environment and another, each in a process of its own; they take turns.

    Raises:
        LinefootError: one of them cannot.
    """
    with ExitStack() as stack:
        workers = {
            side: stack.enter_context(LoopWorker(path, walk, states))
            for side, path in (("own", Path(sys.executable)), ("other", python))
        }
        batches: dict[str, Batch] = {}
        for side, worker in workers.items():
            batches[f"{side}_loop"] = partial(worker.times, loop=effort.chunks)
            batches[f"{side}_plant_step"] = partial(worker.times, plant=True)
        times = take_turns(batches, effort.rounds)
        for worker in workers.values():
            worker.sweep_run()  # loads machine code
        runs: dict[str, Batch] = {f"{side}_sweep_run": w.sweep_run for side, w in workers.items()}
        times |= take_turns(runs, effort.runs)
    results.rest["against"] = workers["other"].versions
    results.times |= {name: summarise(found) for name, found in times.items()}
    for key, (above, below) in AGAINST.items():
        results.values[key] = ratio(results.times[above], results.times[below])
