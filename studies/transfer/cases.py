"""What is walked in each simulator, and what came of it."""

import math
import time
from dataclasses import replace
from typing import Any

import numpy as np

from drake_linefoot.constants import STANDARD_GRAVITY
from drake_linefoot.lab.results.judge import judge, upright
from drake_linefoot.lab.scenario import PlantParameters, Scenario
from drake_linefoot.lab.scenario.disturbances import ActuatorParameters, PushParameters
from drake_linefoot.lab.scenario.load import dump_scenario, parse_scenario
from drake_linefoot.lab.simulation.run import simulate
from drake_linefoot.lab.wiring.closed_loop import build_closed_loop
from studies.common.paired import ITS_OWN, tilt
from studies.common.stamp import Probed
from studies.common.trial import walk
from studies.common.types import Data

LENGTH, SHORT = 5.0, 3.0  # [s] of a walk
PUSH = PushParameters(time=2.0, impulse=10.0, direction=1.57)  # to the left, 10 N s
ESTIMATE, LATE = "0.8 m/s, on the estimate", "0.8 m/s, torques 5 ms late"
# What a run is told, forward, left [m/s] and turn rate [rad/s], and what else is changed.
CASES: dict[str, tuple[tuple[float, float, float], dict[str, Any]]] = {
    "0.4 m/s": ((0.4, 0.0, 0.0), {}),
    "0.8 m/s": ((0.8, 0.0, 0.0), {}),
    "1.2 m/s": ((1.2, 0.0, 0.0), {}),
    "0.3 m/s, turn 0.5 rad/s": ((0.3, 0.0, 0.5), {}),
    "0.2 m/s to the left": ((0.0, 0.2, 0.0), {}),
    "0.4 m/s, pushed with 10 N s": ((0.4, 0.0, 0.0), {"pushes": [PUSH]}),
    ESTIMATE: ((0.8, 0.0, 0.0), {"estimation": True}),
    LATE: ((0.8, 0.0, 0.0), {"actuators": ActuatorParameters(delay=0.005)}),
}
MUJOCO, OWN, DRAKE = "MuJoCo", "MuJoCo, its own contacts", "Drake"
MUJOCO_2, DRAKE_2, LATE_PLANS = "MuJoCo, 2 ms", "Drake, 2 ms", "Drake, late plans"
PLANTS = {
    MUJOCO: PlantParameters(simulator="mujoco"),
    OWN: PlantParameters(simulator="mujoco", mujoco=ITS_OWN),
    MUJOCO_2: PlantParameters(simulator="mujoco", time_step=0.002),
    DRAKE: PlantParameters(),
    DRAKE_2: PlantParameters(time_step=0.002),
    LATE_PLANS: PlantParameters(),
}
RUNS = 100  # of each group of the sweep
NUMBERS = "speed_error", "contact_latency", "false_contacts", "missed_contacts"  # of `OUTCOME`


def scenario_of(case: str, plant: str, length: float) -> Scenario:
    """Return what a case is in a plant, with a length [s]."""
    command, changes = CASES[case]
    made = replace(walk(Scenario(), command, length), plant=PLANTS[plant], **changes)
    delay, step = made.actuators.delay, made.plant.time_step
    steps = math.ceil(delay / step - 1e-9)  # whole ones: 6 ms at steps of 2
    return replace(
        made,
        actuators=replace(made.actuators, delay=steps * step),
        mpc=replace(made.mpc, late=plant == LATE_PLANS),
    )


def walked(job: tuple[str, str, str]) -> Data:
    """Simulate and judge a case in a plant; the third of a job is the scenario as YAML."""
    loop = build_closed_loop(parse_scenario(job[2]))
    start = time.process_time()
    done = simulate(loop)
    seconds = time.process_time() - start
    outcome = judge(done)
    kept = {name: outcome[name] for name in (*NUMBERS, "fall_reason")}
    kept["tilt"] = tilt(outcome)
    force = np.linalg.norm(done.true_force, axis=-1)
    kept["force"] = float(force.max()) / (loop.humanoid.mass * STANDARD_GRAVITY)
    rate = float(done.time[-1]) / seconds
    return {"case": job[0], "plant": job[1], "upright": upright(outcome), **kept, "rate": rate}


def lost(job: tuple[str, str, str], error: str) -> Data:
    """Return what stands for `walked` of a run whose process crashed or took too long."""
    row = {"case": job[0], "plant": job[1], "upright": False, "fall_reason": error}
    return {**row, **dict.fromkeys((*NUMBERS, "tilt", "force", "rate"))}


def probe() -> dict[str, Probed]:
    """Return a quick form of the study: a short walk in MuJoCo."""
    case = "0.8 m/s"
    row = walked((case, MUJOCO, dump_scenario(scenario_of(case, MUJOCO, SHORT))))
    found = {"upright": Probed(float(row["upright"]), 0.0)}
    if row["speed_error"] is not None:
        found["speed_error_m_s"] = Probed(row["speed_error"], 0.015)
    return found
