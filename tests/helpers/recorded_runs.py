"""Runs for tests: made by hand, and simulated once for all."""

import io
from functools import cache

import numpy as np
from pydrake.systems.framework import LeafSystem

from drake_linefoot.lab.scenario import Scenario, Segment
from drake_linefoot.lab.simulation.log import LogFile
from drake_linefoot.lab.simulation.mcap_log import RATE, write_mcap
from drake_linefoot.lab.simulation.recorder import dtype_of
from drake_linefoot.lab.simulation.recording import CHANNELS, LOG, Run
from drake_linefoot.lab.simulation.run import simulate
from drake_linefoot.lab.wiring.closed_loop import build_closed_loop

SIZES = {"nq": 25, "nv": 24, "na": 18, "nw": 5, "nc": 2}
SIDES = ("left", "right")


def make_run(time, fell=False, segments=None, **channels):
    """A robot that stands still at the origin, but for the channels that are given."""
    n = len(time)
    arrays = {name: np.zeros((n, *channel.shape(SIZES))) for name, channel in CHANNELS.items()}
    arrays["time"] = np.asarray(time, dtype=float)
    arrays["q"][:, 0] = 1.0
    arrays["q"][:, 6] = 0.65
    arrays["true_normal"][:] = 60.0
    arrays["true_force"][:, :, 2] = 120.0
    arrays["contact_flag"][:] = 1.0
    arrays["wbc_success"][:] = 1.0
    arrays.update(channels)
    if "com" not in channels:
        arrays["com"] = arrays["q"][:, 4:7]
    names = ("hip_yaw", "hip_abad", "hip_pitch", "knee", "ankle", "s_pitch", "s_abad", "s_yaw", "e")
    return Run(
        scenario=Scenario(segments=segments or [Segment("stand", float(time[-1]))]),
        version="0",
        joint_names=tuple(f"{side}_{name}" for side in SIDES for name in names),
        effort_limits=np.full(18, 40.0),
        fell=fell,
        fall_time=float(time[-1]) if fell else None,
        fall_reason="torso low" if fell else "",
        wall_seconds=2.0 * float(time[-1]),
        ended=True,
        **arrays,
    )


def leave_unfinished(part, run, n):
    """Leave the first `n` samples of a run in a folder, as a process that is killed does."""
    rows = np.empty(n, dtype_of(CHANNELS, SIZES))
    for name in CHANNELS:
        rows[name] = getattr(run, name)[:n]
    part.mkdir(exist_ok=True)
    LogFile(part / LOG, rows.dtype, CHANNELS, run.facts()[0]).append(rows)


def mcap_log(run, rate=RATE):
    """A run as the content of an MCAP file."""
    content = io.BytesIO()
    write_mcap(run, content, rate)
    return content.getvalue()


def yaw_quaternion(yaw):
    """Quaternions w, x, y, z of turns about z, shape (n, 4)."""
    zero = np.zeros_like(yaw)
    return np.column_stack([np.cos(0.5 * yaw), zero, zero, np.sin(0.5 * yaw)])


SHORT = Scenario(
    name="short", segments=[Segment("stand", 0.1), Segment("step", 0.3, True, [0.1, 0.0])]
)


@cache
def short_run():
    """A run of 0.4 s under the controller, simulated once."""
    return simulate(build_closed_loop(SHORT))


class Limp(LeafSystem):
    """A controller without any of the optional ports, which gives no torque at all."""

    def __init__(self, torque=0.0):
        super().__init__()
        self.set_name("limp")
        self.DeclareVectorInputPort("state", SIZES["nq"] + SIZES["nv"])
        self.DeclareVectorInputPort("command", 4)
        self.DeclareVectorInputPort("applied_torque", SIZES["na"])
        value = np.full(SIZES["na"], torque)
        self.DeclareVectorOutputPort(
            "torque",
            SIZES["na"],
            lambda context, output: output.SetFromVector(value),
            prerequisites_of_calc={self.nothing_ticket()},
        )
