"""The MPC in a process of its own: the plans of `late`, to the bit; what it takes to end it."""

import os
import select
import signal
import time
from dataclasses import replace

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator

from drake_linefoot.errors import LinefootError, SignalError
from drake_linefoot.lab.simulation.run import simulate
from drake_linefoot.lab.wiring.closed_loop import build_closed_loop
from drake_linefoot.mpc.ecd_mpc import EcdMpc
from drake_linefoot.mpc.parameters import MpcParameters
from drake_linefoot.mpc.planner import Planner, Setting
from drake_linefoot.mpc.process_mpc import ProcessMpc
from drake_linefoot.mpc.worker import Worker
from drake_linefoot.robot.scaling import scaled
from drake_linefoot.statuses import Solved
from tests.helpers.ports import look, put
from tests.helpers.recorded_runs import SHORT
from tests.helpers.walking import dynamics_of, recorded_walk


class Bench:
    """A block whose inputs are those of recorded updates."""

    def __init__(self, block, humanoid, **parameters):
        self.system = block(humanoid, MpcParameters(**{"model": "ecd", "late": True, **parameters}))
        self.simulator = Simulator(self.system)
        self.context = self.simulator.get_mutable_context()

    def go_on(self, record):
        """One update on; return its plan without the time it took."""
        put(self.system, self.context, "dynamics", dynamics_of(record.x))
        put(self.system, self.context, "reference", record.reference)
        self.simulator.AdvanceTo(0.02 * (round(self.context.get_time() / 0.02) + 1))
        return self.plan()

    def plan(self):
        plan = look(self.system.get_plan_output_port(), self.context)
        return plan._replace(milliseconds=0.0)


@pytest.fixture(scope="module")
def records():
    return recorded_walk().mpc[5:12]


def same(one, other):
    return all(np.array_equal(a, b) for a, b in zip(one, other, strict=True))


def answered(worker):
    """Wait until there is an answer."""
    assert select.select([worker._of], [], [], 60.0)[0]


def test_its_plans_are_those_of_the_block_one_update_later(humanoid, records):
    here, there = Bench(EcdMpc, humanoid), Bench(ProcessMpc, humanoid, process=True)
    plans = [[bench.go_on(record) for record in records] for bench in (here, there)]
    assert not same(plans[0][-1], plans[1][-1])
    for now, later in zip(plans[0], plans[1][1:], strict=False):
        assert same(now, later)


def test_a_context_that_is_set_back_goes_on_as_it_did(humanoid, records):
    bench = Bench(ProcessMpc, humanoid, process=True)
    bench.go_on(records[0])
    before = bench.context.Clone()
    plans = [bench.go_on(record) for record in records[1:4]]
    bench.context.SetTimeStateAndParametersFrom(before)
    bench.simulator.Initialize()
    again = [bench.go_on(record) for record in records[1:4]]
    assert all(same(one, other) for one, other in zip(plans, again, strict=True))


def test_weights_of_the_context_reach_the_process(humanoid, records):
    plans = []
    for force in (1e-5, 1e-3):
        bench = Bench(ProcessMpc, humanoid, process=True)
        bench.system.set_parameters(bench.context, weights={"force": force})
        plans.append([bench.go_on(record) for record in records[:3]][-1])
    assert np.abs(plans[0].wrench - plans[1].wrench).max() > 1.0


def test_who_has_no_patience_goes_on_with_the_plan_there_is(humanoid, records):
    bench = Bench(ProcessMpc, humanoid, process=True)
    bench.go_on(records[0])
    answered(bench.system.worker)
    os.kill(bench.system.worker.pid, signal.SIGSTOP)
    held = bench.go_on(records[1])
    bench.system.patience = 0.0
    for failures in (1.0, 2.0):
        plan = bench.go_on(records[2])
        assert (plan.status, plan.failures) == (Solved.LATE, failures)
        assert same(plan._replace(status=held.status, failures=held.failures), held)
    os.kill(bench.system.worker.pid, signal.SIGCONT)
    bench.system.patience = np.inf
    assert bench.go_on(records[3]).status < Solved.ITERATION_LIMIT
    assert bench.system.worker.begun == 1


def test_a_process_that_is_killed_is_begun_anew(humanoid, records):
    whole = Bench(ProcessMpc, humanoid, process=True)
    hit = Bench(ProcessMpc, humanoid, process=True)
    for k, record in enumerate(records[:5]):
        plan = whole.go_on(record)
        if k in (1, 3):
            os.kill(hit.system.worker.pid, signal.SIGKILL)
            time.sleep(0.1 * (k - 1))  # while it is asked, and before
        assert same(hit.go_on(record), plan)
    assert hit.system.worker.begun == 3


def test_meanwhile_the_plan_goes_on(humanoid, records):
    bench = Bench(ProcessMpc, humanoid, process=True)
    os.kill(bench.system.worker.pid, signal.SIGSTOP)  # so that nothing is answered
    bench.go_on(records[0])
    bench.system.patience = 0.5
    os.kill(bench.system.worker.pid, signal.SIGKILL)
    assert bench.go_on(records[1]).status == Solved.LATE
    deadline = time.monotonic() + 60.0
    while bench.go_on(records[2]).status == Solved.LATE:
        assert time.monotonic() < deadline
    assert bench.system.worker.begun == 2


def test_what_goes_wrong_there_is_said_here(humanoid):
    parameters = scaled(MpcParameters(process=True), humanoid)
    setting = Setting(parameters, humanoid.mass, humanoid.contact, humanoid.sizes)
    worker = Worker(setting._replace(parameters=replace(parameters, model="of another process")))
    sizes = [layout.size for layout in Planner(setting).layouts.values()]
    with pytest.raises(LinefootError, match="of another process"):
        worker.answer(np.zeros(sum(sizes)), np.inf)


def test_problems_that_nobody_asks_for_any_more_fill_no_pipe(humanoid, records):
    """More of them than pipes hold, as of a walk that is begun anew again and again."""
    bench = Bench(ProcessMpc, humanoid, process=True)
    bench.go_on(records[0])
    worker, problem = bench.system.worker, bench.context.get_discrete_state(1).value()[1:].copy()
    for k in range(40):
        problem[0] = 1e-5 * (1.0 + 0.01 * k)
        worker.ask(problem)
    assert same(bench.go_on(records[1]), Bench(EcdMpc, humanoid).go_on(records[0]))


def test_what_is_not_finite_is_not_sent(humanoid, records):
    bench = Bench(ProcessMpc, humanoid, process=True)
    bench.go_on(records[0])
    x = records[1].x.copy()
    x[5] = np.nan
    with pytest.raises(SignalError, match="dynamics"):
        bench.go_on(replace(records[1], x=x))


def test_it_ends_with_the_block(humanoid):
    bench = Bench(ProcessMpc, humanoid, process=True)
    pid = bench.system.worker.pid
    os.kill(pid, 0)
    bench.system.worker.close()
    with pytest.raises(ProcessLookupError):
        os.kill(pid, 0)


@pytest.mark.slow
def test_a_walk_is_that_of_late_plans_to_the_bit():
    late, process = (
        simulate(build_closed_loop(replace(SHORT, mpc=MpcParameters(**{name: True}))))
        for name in ("late", "process")
    )
    for name in ("q", "v", "torque", "mpc_wrench"):
        np.testing.assert_array_equal(getattr(process, name), getattr(late, name))
