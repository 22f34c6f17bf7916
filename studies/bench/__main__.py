"""`python -m studies.bench`: measures everything in one run and writes `bench.json`.

What is compared takes turns, round by round, so that it sees the same machine; what is said of
times are medians and 95th percentiles, and what has a bar is a ratio of medians. (pytest-benchmark
measures one function after the other, so ratios of its medians are of different minutes.)
"""

import gc
import sys
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import replace
from datetime import UTC, datetime
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated

import typer

from drake_linefoot.errors import LinefootError, ScenarioError
from drake_linefoot.lab.results.tables import wide_console
from drake_linefoot.mpc.parameters import ACTIVE_SET
from studies.bench import blocks, others, peers, processes, scaling
from studies.bench.dispatch import dispatch_over_workers
from studies.bench.known import with_map
from studies.bench.loops import LoopChunks, PlantStep, at_500_hz
from studies.bench.measures import (
    Batch,
    Effort,
    Results,
    by_part,
    each,
    machine,
    ratio,
    summarise,
    take_turns,
    versions,
)
from studies.bench.tables import tables
from studies.bench.tick_parts import tick_parts
from studies.common.command import Out, Quick, run
from studies.common.files import prepare, write_json
from studies.common.recorder import Walk, record
from studies.common.runs import paper_scenario
from studies.common.stamp import cpu_seconds, stamped

JSON = "bench.json"
SEGMENTS = (0.5, 1.0, 1.0)  # [s] lengths of the segments of the walk when quick
Report = Callable[[str], None]


FULL = Effort(False, 40, 25, 10, 4, 10, 8, 15, (60.0, 600.0))
QUICK = Effort(True, 16, 12, 5, 1, 5, 4, 7, None)


def measure(effort: Effort, placo: Path | None, other: Path | None, report: Report) -> Results:
    """Measure everything.

    Args:
        effort: how much.
        placo: interpreter that has PlaCo; None looks for one, see `placo_peer.interpreter`.
        other: interpreter that has another drake_linefoot or another Drake, to measure beside.
        report: called with what goes on.

    Raises:
        LinefootError: the walk that is measured on was not walked.
    """
    results = Results()
    results.rest = {
        "command": "python -m studies.bench" + (" --quick" if effort.quick else ""),
        "date": datetime.now(UTC).date().isoformat(),
        "quick": effort.quick,
        "machine": machine(),
        "versions": versions(),
    }
    report("recording a walk")
    walk = record(paper_scenario(effort.quick, segments=SEGMENTS))
    if walk.fall_reason:
        raise LinefootError(f"the walk to be measured on was not walked: {walk.fall_reason}")
    _take_turns(walk, effort, placo, results, report)
    _others(walk, effort, other, results, report)
    _processes(effort, results, report)
    _scaling(walk, effort, results, report)
    if effort.memory is None:
        left_out = "first_walk_cpu_s", "first_walk_wall_s", "memory_growth_mb"
        results.notes.update(dict.fromkeys(left_out, "left out by --quick"))
    else:
        report("compiling")
        results.values |= processes.first_walk()
        report("handing out runs")
        results.scaling["dispatch_over_workers"] = dispatch_over_workers()
        report(f"memory: walking for {effort.memory[1]:g} s")
        _memory(effort.memory, results)
    return results


def _take_turns(
    walk: Walk, effort: Effort, placo: Path | None, results: Results, report: Report
) -> None:
    """Measure blocks, plant, loops and peers, which take turns."""
    loops: dict[str, LoopChunks] = {}
    with ExitStack() as stack:
        report("preparing blocks and loops")
        batches = _block_batches(walk, effort, results)
        loops["loop_1khz"] = LoopChunks(walk.scenario)
        folder = Path(stack.enter_context(TemporaryDirectory()))
        loops["loop_with_map"] = LoopChunks(with_map(walk.scenario, folder))
        try:
            loops["loop_500hz"] = LoopChunks(at_500_hz(walk.scenario))
        except ScenarioError as error:
            reason = f"refused by the scenario's rules: {error}"
            results.notes["realtime_rate_500hz"] = reason
        batches |= {name: partial(loop.batch, effort.chunks) for name, loop in loops.items()}
        report("PlaCo")
        peer = peers.placo(walk, effort.states, placo, results, stack)
        if peer is not None:
            batches["placo_tick"] = peer.batch
        simulated = peers.mujoco(walk, results)
        if simulated is not None:
            ticks = walk.walking_ticks(effort.states)
            batches["mujoco_step"] = lambda: simulated.batch(ticks)
        report("accuracy of the solvers")
        batches |= peers.solver_batches(walk, effort.states, results)
        gc.collect()
        gc.freeze()  # the recorded walk is not looked through again and again
        times = take_turns(batches, effort.rounds, report)
        gc.unfreeze()
    results.times |= {name: summarise(t) for name, t in times.items()}
    results.times[peers.SHIPPED_TIME] = results.times["mpc_solve"]
    for name, loop in loops.items():
        if loop.fell():
            results.notes[name] = f"the robot fell while it was measured: {loop.fell()}"
    _ratios(results)


def _others(
    walk: Walk, effort: Effort, other: Path | None, results: Results, report: Report
) -> None:
    """Measure beside a busy core, and beside another environment."""
    states = walk.walking_states(effort.states)
    report("beside another process")
    others.beside_another(walk, states, effort.chunks, results)
    problem = "for want of --against PYTHON"
    if other is not None:
        report(f"beside {other}")
        try:
            others.against(walk, states, other, effort, results)
            return
        except LinefootError as error:
            problem = str(error)
    results.notes |= dict.fromkeys(others.AGAINST, problem)


def _block_batches(walk: Walk, effort: Effort, results: Results) -> dict[str, Batch]:
    """Return the batches of the blocks and of the plant."""
    h, s = walk.humanoid, walk.scenario
    ticks, problems = walk.walking_ticks(effort.states), walk.walking_problems(effort.states)
    states = walk.walking_states(effort.states)
    wbc, plant, mpc = blocks.WbcTick(h, s), PlantStep(h, s), blocks.MpcUpdate(h, s)
    exact = blocks.MpcUpdate(h, replace(s, mpc=replace(s.mpc, solver=ACTIVE_SET)))
    estimator, gait = blocks.estimator_update(h, s), blocks.gait_update(h, s)
    ways = [f"wbc_tick: {wbc.status(tick)}" for tick in ticks]
    results.rest["measured_on"] = {"scenario": s.name, "ticks": len(ticks), "mpc": len(problems)}

    def wbc_ticks() -> dict[str, list[float]]:
        """Give the times of all ticks, and by how the wrench program was solved."""
        wbc(ticks[0])
        times = [wbc(tick)[0] for tick in ticks]
        rows = zip(ways, times, strict=True)
        return by_part({"wbc_tick": time, way: time} for way, time in rows)

    return {
        "plant_step": partial(plant.batch, states),
        "plant_step_cold": partial(plant.cold, states),
        "dynamics": blocks.dynamics_of(h, states),
        "wbc_tick": wbc_ticks,
        "estimator_update": each(lambda t: estimator(t, t.before.estimator)[0], ticks),
        "gait_update": each(lambda t: gait(t, [t.before.gait])[0], ticks),
        "mpc_update": each(lambda p: mpc.whole(p)[0], problems),
        "mpc_update_active_set": each(lambda p: exact.whole(p)[0], problems),
        "mpc_parts": lambda: by_part([mpc.parts(p) for p in problems], "mpc_"),
    }


def _ratios(results: Results) -> None:
    """Set what follows from the times."""
    times, values, notes = results.times, results.values, results.notes
    for name, above, below in (
        ("wbc_tick_over_placo", "wbc_tick", "placo_tick"),
        ("estimator_over_plant_step", "estimator_update", "plant_step"),
        ("mpc_update_over_daqp", "mpc_update", "solve_daqp"),
        ("mpc_active_set_over_daqp", "mpc_update_active_set", "solve_daqp"),
        ("closed_loop_over_plant_step", "loop_1khz", "plant_step"),
        ("map_over_none", "loop_with_map", "loop_1khz"),
    ):
        values[name] = ratio(times.get(above), times.get(below))
        if values[name] is None and below in notes:
            notes[name] = notes[below]
    for name, loop in (("realtime_rate_1khz", "loop_1khz"), ("realtime_rate_500hz", "loop_500hz")):
        summary = times.get(loop)
        if summary is not None:
            values[name] = 1e-3 / summary.median


def _processes(effort: Effort, results: Results, report: Report) -> None:
    """Measure imports and start-up, each in a process of its own."""
    report("imports and start-up")
    times_of: dict[str, Callable[[], float]] = {
        "import_pydrake": partial(processes.import_time, "pydrake.multibody.plant"),
        "import_drake_linefoot": partial(processes.import_time, "drake_linefoot"),
        "help": processes.help_time,
        "walk_to_first_step": processes.first_step_time,
    }
    for time in times_of.values():
        time()  # files in the cache of the system
    batches = {name: lambda time=time: [time()] for name, time in times_of.items()}
    times = take_turns(batches, effort.starts)
    results.times |= {name: summarise(t) for name, t in times.items()}
    below = results.times["import_pydrake"]
    results.values["import_over_pydrake"] = ratio(results.times["import_drake_linefoot"], below)
    results.values["help_over_pydrake"] = ratio(results.times["help"], below)


def _scaling(walk: Walk, effort: Effort, results: Results, report: Report) -> None:
    """Measure how times grow, and where they go."""
    problems, rounds = effort.scaling_problems, effort.scaling_rounds
    found = results.scaling
    report("MPC over knots")
    found["mpc_over_knots"] = over = scaling.mpc_over_knots(walk, problems, rounds)
    whole = dict(zip(over["knots"], over["median_ms"][scaling.WHOLE], strict=True))
    results.values["mpc_40_over_10_knots"] = whole[40] / whole[10]
    report("MPC with each model")
    found["mpc_over_models"] = scaling.mpc_over_models(walk, problems, rounds)
    report("MPC over horizon and contacts")
    found["mpc_over_knot_step"] = scaling.mpc_over_knot_step(walk, problems, rounds)
    found["mpc_over_contacts"] = scaling.mpc_over_contacts(walk, rounds)
    report("whole-body controller over joints")
    ticks, some = walk.walking_ticks(effort.states), walk.walking_problems(effort.states)
    found["wbc_over_joints"] = scaling.wbc_over_joints(walk, ticks, 2 * rounds)
    wbc = blocks.WbcTick(walk.humanoid, walk.scenario)
    mpc = blocks.MpcUpdate(walk.humanoid, walk.scenario)
    report("where a tick goes")
    found["where_a_tick_goes"] = tick_parts(walk.scenario, effort.rounds * effort.chunks)
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


def bench(
    out: Out = Path("out/bench"),
    quick: Quick = False,
    placo: Annotated[
        Path | None, typer.Option(metavar="PYTHON", help="Interpreter that has PlaCo 0.10.")
    ] = None,
    against: Annotated[
        Path | None,
        typer.Option(
            metavar="PYTHON", help="Interpreter of another checkout, or of another Drake."
        ),
    ] = None,
) -> None:
    """Measure speed and memory, beside other packages; write bench.json."""
    prepare(out)
    screen = wide_console()
    with screen.status("measuring") as status:
        data = measure(QUICK if quick else FULL, placo, against, status.update).as_dict()
    data |= stamped("bench", cpu_seconds())
    write_json(out / JSON, data)
    screen.print(*tables(data), sep="\n")


if __name__ == "__main__":
    sys.exit(run(bench, "bench"))
