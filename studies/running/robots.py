"""Robots of the zoo that run: each described from its model alone, faster and faster."""

import math
import tempfile
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from drake_linefoot.constants import STANDARD_GRAVITY
from drake_linefoot.errors import ModelError
from drake_linefoot.lab.new_robot.analysis import analyse
from drake_linefoot.lab.new_robot.folder import write_folder
from drake_linefoot.lab.results.judge import judge, upright
from drake_linefoot.lab.results.metrics import compute_metrics
from drake_linefoot.lab.scenario.load import load_scenario
from drake_linefoot.lab.simulation.run import simulate
from drake_linefoot.lab.wiring.closed_loop import build_closed_loop
from drake_linefoot.robot.description import LINE, SCENARIO
from drake_linefoot.robot.scaling import units_of
from studies.common.trial import walk
from studies.common.types import Data
from studies.envelope.walks import tracked
from studies.zoo.robots import G1, HEAVY, SMALL, make, published

NAMES = (
    *("mit_humanoid", "half_mass", SMALL, HEAVY, "no_arms", "long_legs", "backward_knees"),
    *(G1, "talos_reduced", "icub_reduced", "soled_60"),
)
QUICK_NAMES = ("no_arms",)
SHARES, QUICK_SHARES = np.arange(0.5, 1.06, 0.05).round(2).tolist(), [0.7]  # of sqrt(g h)
TIME = 10.0  # [s] of a robot of the MIT Humanoid's size
PATIENCE = 2  # shares one after the other that are not run, after which it ends


@dataclass(frozen=True)
class Robot:
    """A robot that is tried."""

    name: str
    quick: bool

    @property
    def key(self) -> str:
        """What makes it one trial."""
        return f"robot {self.name}{' quick' * self.quick}"


def ran(robot: Robot) -> Data:
    """Run a robot faster and faster.

    Returns:
        `key`, `case`, `label`: its name; `speed`: the largest measured in a run that was upright,
        with flights, and followed its command [m/s]; `share`: of sqrt(g h) [-]; 0 without one;
        `reason`: what ended it.
    """
    row = {"key": robot.key, "case": "robot", "label": robot.name, "speed": 0.0, "share": 0.0}
    files, _ = published()
    with tempfile.TemporaryDirectory() as scratch:
        folder, failed = Path(scratch) / "robot", 0
        try:
            model = files.get(robot.name) or make(robot.name, Path(scratch))
            found = analyse(model, contact=LINE)
        except (ModelError, KeyError) as error:
            return {**row, "reason": f"not there: {error}"}
        write_folder(folder, found)
        base, humanoid = load_scenario(str(folder / SCENARIO)), found.humanoid
        time = round(TIME * units_of(humanoid)["s"], 1)  # whole ticks
        unit = math.sqrt(STANDARD_GRAVITY * humanoid.com_height)
        base = replace(base, seed=0, gait=replace(base.gait, forward_max=SHARES[-1] * unit))
        for share in QUICK_SHARES if robot.quick else SHARES:
            command = (share * unit, 0.0, 0.0)
            loop = build_closed_loop(walk(base, command, time))
            run = simulate(loop)
            segment = compute_metrics(run)["segments"][-1]
            flies = bool(segment["gait"]) and segment["gait"]["flight_s"] is not None
            if upright(judge(run)) and flies and tracked(command, segment["measured"]):
                speed, failed = segment["measured"][0], 0
                row |= {"speed": speed, "share": speed / unit}
            else:
                failed += 1
                fast = "" if segment["measured"] is None else f"{segment['measured'][0]:.2f} m/s, "
                followed = f"{fast}{'' if flies else 'no '}flights"
                row["reason"] = f"{share:g}: {run.fall_reason or followed}"
            loop.recorder.keep_last(0)
            if failed == PATIENCE:
                break
    return {"reason": "", **row}
