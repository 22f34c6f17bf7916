"""`linefoot bench`: measures everything in one run and writes `bench.json`.

What is compared takes turns, round by round, so that it sees the same machine; what is told of
times are medians and 95th percentiles, and what has a bar is a ratio of medians. (pytest-benchmark
measures one function after the other, so ratios of its medians are of different minutes.)
"""

from __future__ import annotations

import gc
import json
import os
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

from drake_linefoot.benchmark import blocks, machine, peers, processes, scaling, scenarios
from drake_linefoot.benchmark.loops import LoopChunks, PlantStep, at_500_hz
from drake_linefoot.benchmark.recording import Walk, record
from drake_linefoot.benchmark.results import Results
from drake_linefoot.benchmark.statistics import Batch, ratio, summarise, take_turns
from drake_linefoot.errors import LinefootError, OutputError, ScenarioError

if TYPE_CHECKING:
    from rich.console import Console

JSON = "bench.json"
Tell = Callable[[str], None]


@dataclass(frozen=True)
class Effort:
    """How much is measured.

    Attributes:
        quick: a shorter walk to record.
        states: ticks and problems that are measured on.
        rounds: in which contestants take turns.
        chunks: of the closed loop in each round.
        scaling_problems, scaling_rounds: the same for what grows.
        starts: of each process.
        memory: times at which memory is looked at [s]; None leaves it out.
    """

    quick: bool
    states: int
    rounds: int
    chunks: int
    scaling_problems: int
    scaling_rounds: int
    starts: int
    memory: tuple[float, float] | None


FULL = Effort(False, 40, 25, 10, 10, 8, 15, (60.0, 600.0))
QUICK = Effort(True, 16, 12, 5, 5, 4, 7, None)


def measure(effort: Effort, placo: Path | None, tell: Tell) -> Results:
    """Measure everything.

    Args:
        effort: how much.
        placo: interpreter that has PlaCo; None looks for one, see `placo_peer.interpreter`.
        tell: hears of the progress.

    Raises:
        LinefootError: the walk that is measured on was not walked.
    """
    results = Results()
    results.rest = {
        "command": "linefoot bench" + (" --quick" if effort.quick else ""),
        "date": datetime.now(UTC).date().isoformat(),
        "quick": effort.quick,
        "machine": machine.machine(),
        "versions": machine.versions(),
    }
    tell("recording a walk")
    walk = record(scenarios.walking(effort.quick))
    _take_turns(walk, effort, placo, results, tell)
    _processes(effort, results, tell)
    _scaling(walk, effort, results, tell)
    if effort.memory is None:
        results.notes["memory_growth_mb"] = "left out by --quick"
    else:
        tell(f"memory: walking for {effort.memory[1]:g} s")
        _memory(effort.memory, results)
    return results


def _take_turns(
    walk: Walk, effort: Effort, placo: Path | None, results: Results, tell: Tell
) -> None:
    """Measure blocks, plant, loops and peers, which take turns."""
    loops: dict[str, LoopChunks] = {}
    with ExitStack() as stack:
        tell("preparing blocks and loops")
        batches = _block_batches(walk, effort, results)
        parts = batches.pop("mpc_parts")
        loops["loop_1khz"] = LoopChunks(walk.scenario)
        try:
            loops["loop_500hz"] = LoopChunks(at_500_hz(walk.scenario))
        except ScenarioError as error:
            reason = f"refused by the scenario's rules: {error}"
            results.notes["realtime_rate_500hz"] = reason
        for name, loop in loops.items():
            batches[name] = _loop_batch(loop, effort.chunks)
        tell("PlaCo")
        peer = peers.placo(walk, effort.states, placo, results, stack)
        if peer is not None:
            batches["placo_tick"] = peer.batch
        tell("accuracy of the solvers")
        batches |= peers.solver_batches(walk, effort.states, results)
        part_times: dict[str, list[float]] = {}
        batches["mpc_parts"] = _into(parts, part_times)
        gc.collect()
        gc.freeze()  # the recorded walk is not looked through again and again
        times = take_turns(batches, effort.rounds, tell)
        gc.unfreeze()
    times.pop("mpc_parts")
    times |= _by_status(times["wbc_tick"], walk, effort)
    results.times |= {name: summarise(t) for name, t in (times | part_times).items()}
    results.times[peers.SHIPPED_TIME] = results.times["mpc_solve"]
    for name, loop in loops.items():
        if loop.fell():
            results.notes[name] = f"the robot fell while it was measured: {loop.fell()}"
    _ratios(results)


def _block_batches(walk: Walk, effort: Effort, results: Results) -> dict[str, Any]:
    """Return the batches of the blocks and of the plant; `mpc_parts` gives dicts."""
    h, s = walk.humanoid, walk.scenario
    ticks, problems = walk.walking_ticks(effort.states), walk.walking_problems(effort.states)
    wbc, plant = blocks.WbcTick(h, s), PlantStep(h, s)
    estimator, gait = blocks.estimator_update(h, s), blocks.gait_update(h, s)
    mpc = blocks.MpcUpdate(h, s)
    results.rest["measured_on"] = {"scenario": s.name, "ticks": len(ticks), "mpc": len(problems)}
    return {
        "plant_step": lambda: plant.batch(ticks),
        "wbc_tick": _each(lambda t: wbc(t)[0], ticks),
        "estimator_update": _each(lambda t: estimator(t, t.before.estimator)[0], ticks),
        "gait_update": _each(lambda t: gait(t, [t.before.gait])[0], ticks),
        "mpc_update": _each(lambda p: mpc.whole(p)[0], problems),
        "mpc_parts": lambda: [mpc.parts(p) for p in problems],
    }


def _by_status(times: list[float], walk: Walk, effort: Effort) -> dict[str, list[float]]:
    """Return the times of the whole-body controller by how its wrench program was solved."""
    wbc = blocks.WbcTick(walk.humanoid, walk.scenario)
    ways = [wbc.status(tick) for tick in walk.walking_ticks(effort.states)]
    found: dict[str, list[float]] = {}
    for i, time in enumerate(times):
        found.setdefault(f"wbc_tick: {ways[i % len(ways)]}", []).append(time)
    return found


def _each(time: Callable[[Any], float], inputs: Sequence[Any]) -> Batch:
    """Return a batch of all inputs; an untimed call before them wakes the caches."""

    def batch() -> list[float]:
        time(inputs[0])
        return [time(one) for one in inputs]

    return batch


def _loop_batch(loop: LoopChunks, chunks: int) -> Batch:
    return lambda: loop.batch(chunks)


def _into(parts: Callable[[], list[dict[str, float]]], times: dict[str, list[float]]) -> Batch:
    """Return a batch that keeps the times of parts by name, and gives none itself."""

    def batch() -> list[float]:
        for found in parts():
            for name, time in found.items():
                times.setdefault(f"mpc_{name}", []).append(time)
        return []

    return batch


def _ratios(results: Results) -> None:
    """Set what follows from the times."""
    times, values, notes = results.times, results.values, results.notes
    for name, above, below in (
        ("wbc_tick_over_placo", "wbc_tick", "placo_tick"),
        ("estimator_over_plant_step", "estimator_update", "plant_step"),
        ("mpc_update_over_daqp", "mpc_update", "solve_daqp"),
        ("closed_loop_over_plant_step", "loop_1khz", "plant_step"),
    ):
        values[name] = ratio(times.get(above), times.get(below))
        if values[name] is None and below in notes:
            notes[name] = notes[below]
    for name, loop in (("realtime_rate_1khz", "loop_1khz"), ("realtime_rate_500hz", "loop_500hz")):
        summary = times.get(loop)
        if summary is not None:
            values[name] = 1e-3 / summary.median


def _processes(effort: Effort, results: Results, tell: Tell) -> None:
    """Measure imports and start-up, each in a process of its own."""
    tell("imports and start-up")
    batches: dict[str, Batch] = {
        "import_pydrake": lambda: [processes.import_time("pydrake.multibody.plant")],
        "import_drake_linefoot": lambda: [processes.import_time("drake_linefoot")],
        "help": lambda: [processes.help_time()],
        "walk_to_first_step": lambda: [processes.first_step_time()],
    }
    for batch in batches.values():
        batch()  # files in the cache of the system
    times = take_turns(batches, effort.starts)
    results.times |= {name: summarise(t) for name, t in times.items()}
    below = results.times["import_pydrake"]
    results.values["import_over_pydrake"] = ratio(results.times["import_drake_linefoot"], below)
    results.values["help_over_pydrake"] = ratio(results.times["help"], below)


def _scaling(walk: Walk, effort: Effort, results: Results, tell: Tell) -> None:
    """Measure how times grow, and where they go."""
    problems, rounds = effort.scaling_problems, effort.scaling_rounds
    found = results.scaling
    tell("MPC over knots")
    found["mpc_over_knots"] = over = scaling.mpc_over_knots(walk, problems, rounds)
    whole = dict(zip(over["knots"], over["median_ms"][scaling.WHOLE], strict=True))
    results.values["mpc_40_over_10_knots"] = whole[40] / whole[10]
    tell("MPC over horizon and contacts")
    found["mpc_over_knot_step"] = scaling.mpc_over_knot_step(walk, problems, rounds)
    found["mpc_over_contacts"] = scaling.mpc_over_contacts(walk, rounds)
    tell("whole-body controller over joints")
    ticks, some = walk.walking_ticks(effort.states), walk.walking_problems(effort.states)
    found["wbc_over_joints"] = scaling.wbc_over_joints(walk, ticks, 2 * rounds)
    wbc = blocks.WbcTick(walk.humanoid, walk.scenario)
    mpc = blocks.MpcUpdate(walk.humanoid, walk.scenario)
    found["where_time_goes"] = {
        "wbc_tick": scaling.where_time_goes(wbc, ticks),
        "mpc_update": scaling.where_time_goes(mpc, some),
    }


def _memory(times: tuple[float, float], results: Results) -> None:
    """Measure how memory grows over a long walk."""
    try:
        found = processes.memory_growth(*times)
    except LinefootError as error:
        results.notes["memory_growth_mb"] = str(error)
        return
    results.rest["memory"] = found
    results.values["memory_growth_mb"] = found["growth_mb"]
    if found["fell"]:
        results.notes["memory_growth_mb"] = f"the robot fell {found['fell']}"


def main_bench(out: Path, *, quick: bool, placo: Path | None, console: Console) -> None:
    """Measure, write `bench.json`, print tables.

    Args:
        out: folder of the results; made when missing.
        quick: less of everything, and no long walk for the memory.
        placo: interpreter that has PlaCo.
        console: where progress and tables go.

    Raises:
        OutputError: `out` cannot be written.
        LinefootError: the walk that is measured on was not walked.
    """
    from drake_linefoot.benchmark.tables import tables

    try:
        out.mkdir(parents=True, exist_ok=True)
        scratch = out / f".{JSON}.new"
        scratch.touch()
    except OSError as error:
        raise OutputError(out, error.strerror or str(error)) from error
    try:
        with console.status("measuring") as status:
            data = measure(QUICK if quick else FULL, placo, status.update).as_dict()
        text = json.dumps(data, indent=2, allow_nan=False) + "\n"
        scratch.write_text(text, encoding="utf-8")
        os.replace(scratch, out / JSON)
    except OSError as error:
        raise OutputError(out, error.strerror or str(error)) from error
    finally:
        scratch.unlink(missing_ok=True)
    console.print(*tables(data), sep="\n")
