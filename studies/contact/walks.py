"""Recorded walks with the true wrench on each foot, as a study of the contact estimator needs."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from pydrake.systems.framework import Context

from drake_linefoot.lab.results.falls import diagnose
from drake_linefoot.lab.scenario import Scenario
from drake_linefoot.lab.scenario.edit import with_duration
from drake_linefoot.lab.simulation.closed_loop import ClosedLoop
from drake_linefoot.lab.simulation.recording import Run
from drake_linefoot.lab.simulation.run import simulate
from drake_linefoot.lab.sweep.file import load_sweep
from drake_linefoot.lab.sweep.jobs import scenario_of
from drake_linefoot.lab.wiring.closed_loop import build_closed_loop
from drake_linefoot.robot.dynamics import robot_dynamics
from studies.common.types import Array

PUSHED = "pushed"  # the only kind of walk that is
KINDS = {  # sweep and group of each kind of walk, by what it is called
    "nominal": ("robustness", "wide"),
    "rough": ("robustness", "wide_rough"),
    PUSHED: ("robustness", "wide_push_10"),
    "noisy": ("robustness", "wide_model_error"),
}


@dataclass(frozen=True)
class Walk:
    """A recorded walk."""

    kind: str  # one of `KINDS`
    index: int  # of the run within its group
    run: Run  # what was recorded
    wrench: Array  # true one on each foot, forces in W, torques in C [N, N m], shape (n, 2, 5)
    end: int  # samples up to the fall, all without one


class Truth:
    """Keeps the true wrench on each foot at every step of a simulation."""

    def __init__(self, loop: ClosedLoop) -> None:
        """Look at `loop`."""
        self.wrenches: list[Array] = []
        self._loop, self._scratch = loop, loop.humanoid.plant.CreateDefaultContext()
        self._feet = {
            int(loop.humanoid.names_in(loop.plant.system).frame(foot.frame).body().index()): side
            for side, foot in enumerate(loop.humanoid.description.feet)
        }

    def __call__(self, root: Context) -> None:
        """Keep the wrenches of the step that ended; `root` is the diagram's context."""
        plant = self._loop.plant.system
        context = plant.GetMyContextFromRoot(root)
        results = plant.get_contact_results_output_port().Eval(context)
        x = plant.GetPositionsAndVelocities(context)
        d = robot_dynamics(self._loop.humanoid, self._scratch, x)
        wrench = np.zeros((2, 5))
        for k in range(results.num_point_pair_contacts()):
            info = results.point_pair_contact_info(k)
            for body, sign in ((info.bodyA_index(), -1.0), (info.bodyB_index(), 1.0)):
                side = self._feet.get(int(body))
                if side is None:
                    continue
                force = sign * info.contact_force()
                torque = d.R_WC[side].T @ np.cross(info.contact_point() - d.p_WC[side], force)
                wrench[side] += [*force, *torque[1:]]
        self.wrenches.append(wrench)


def recorded_walk(scenario: Scenario, kind: str, index: int) -> Walk:
    """Simulate a scenario and keep the true wrenches."""
    loop = build_closed_loop(scenario)
    truth = Truth(loop)
    run = simulate(loop, look=truth)
    loop.recorder.keep_last(0)
    end = n = min(len(run.time), len(truth.wrenches))
    if run.fell:
        end = min(n, int(np.searchsorted(run.time, diagnose(run).onset)))
    return Walk(kind, index, run, np.array(truth.wrenches[:n]), end)


def scenarios(
    files: Sequence[Path], walks: int, duration: float | None = None
) -> list[tuple[Scenario, str, int]]:
    """Return scenario, kind and index of the first `walks` runs of each of `KINDS`.

    The sweeps that have them are in the files; walks last `duration` [s], or as long as theirs do.
    Pushes of their groups are left out but of those that are `PUSHED`.

    Raises:
        InputError: a sweep is not usable.
    """
    sweeps = {sweep.name: sweep for sweep in map(load_sweep, files)}
    chosen = []
    for kind, (name, group) in KINDS.items():
        for index in range(walks):
            scenario = scenario_of(sweeps[name], group, index)
            pushes = scenario.pushes if kind == PUSHED else []
            scenario = replace(scenario, name=f"{kind} {index}", pushes=pushes)
            if duration is not None:
                scenario = with_duration(scenario, duration)
            chosen.append((scenario, kind, index))
    return chosen
