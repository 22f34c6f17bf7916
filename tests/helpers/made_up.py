"""Runs with known answers, for the figures."""

import numpy as np

from drake_linefoot.lab.scenario import Segment
from tests.helpers.recorded_runs import make_run, yaw_quaternion

PERIOD = 20  # ticks between two updates of the MPC


def walk(seconds=2.0, **channels):
    """A robot that walks all the time and stays where it is, but for `channels`."""
    time = np.arange(round(1e3 * seconds) + 1) * 1e-3
    n = len(time)
    mpc_ms = np.full(n, np.nan)
    mpc_ms[::PERIOD] = 1.0
    command = np.zeros((n, 4))
    command[:, 3] = 1.0
    given = {
        "mode": np.full(n, 2.0),
        "mpc_ms": mpc_ms,
        "command": command,
        "planned_contact": np.ones((n, 2)),
        "acceleration_error": np.zeros((n, 6)),
    }
    walking = [Segment("walk", seconds, walk=True)]
    return make_run(time, segments=walking, **{**given, **channels})


def circle(time, speed, turn):
    """Positions, velocities and quaternions of a walk on a circle."""
    yaw = turn * time
    p = speed / turn * np.column_stack([np.sin(yaw), 1.0 - np.cos(yaw), np.zeros_like(yaw)])
    v = speed * np.column_stack([np.cos(yaw), np.sin(yaw), np.zeros_like(yaw)])
    return p, v, yaw_quaternion(yaw)


def age(n):
    """Ticks since the last update."""
    return np.arange(n) % PERIOD
