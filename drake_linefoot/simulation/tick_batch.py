"""What is recorded of a tick, and many ticks written into the channels together.

The numbers of a tick go into one row as they come, in one call; written one by one into the
channels, each would cost a call of numpy, and kept as objects they would be long out of the
processor's caches when they are written.
"""

from __future__ import annotations

from array import array
from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import groupby
from math import prod
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydrake.multibody.plant import ContactResults

from drake_linefoot.errors import SignalError
from drake_linefoot.robot.dynamics import GRAVITY, RobotDynamics
from drake_linefoot.signals import CentroidalPlan, ContactEstimate, GaitTargets, WholeBodyReport
from drake_linefoot.simulation.kernels import add_contacts, planned_motion
from drake_linefoot.simulation.recording import FORESEEN, MODES, com_ahead

Array = NDArray[np.float64]
Rows = Mapping[str, Array]  # of each channel, one for each tick
Parts = tuple[tuple[float, ...], tuple[Array, ...]]  # numbers and arrays of a signal

_MOTION = ("mpc_com", "mpc_velocity", "mpc_acceleration", "mpc_momentum", "mpc_momentum_rate")
_STATE = ("q", "v", "com", "command", "torque", "applied_torque")
_CONTACTS = ("true_force", "true_normal", "slip_speed")
_NOWHERE = np.full(3, np.nan)
_MODE_NUMBERS = {mode: float(i) for i, mode in enumerate(MODES)}
_LINES = 46  # numbers of `RobotDynamics.lines` and `R_WC`


class Kept(NamedTuple):
    """Channels that a signal is recorded in, in the order in which `parts` gives them.

    Attributes:
        numbers: channels of the numbers.
        arrays: channels of the arrays.
        parts: gives both of the signal.
    """

    numbers: tuple[str, ...]
    arrays: tuple[str, ...]
    parts: Callable[[Any], Parts]


def _estimate_parts(e: ContactEstimate) -> Parts:
    return e.contact, (e.wrench,)


def _target_parts(t: GaitTargets) -> Parts:
    numbers = (
        _MODE_NUMBERS[t.mode], *t.contact, t.yaw, t.steps, t.moved_footholds, t.clipped_commands,
    )  # fmt: skip
    swing = _NOWHERE if t.swing is None else t.swing.p_WC
    return numbers, (t.command, t.foothold, swing)


def _report_parts(r: WholeBodyReport) -> Parts:
    numbers = (r.success, r.dropped_rows, r.clipped, r.milliseconds)
    return numbers, (r.wrench, r.wrench_error, r.acceleration_error)


def _push_parts(push: Array) -> Parts:
    return (), (push,)


SIGNALS = {
    "contact": Kept(("contact_flag",), ("contact_wrench",), _estimate_parts),
    "targets": Kept(
        ("mode", "planned_contact", "reference_yaw", "gait_steps", "moved_footholds",
         "clipped_commands"),
        ("reference_command", "foothold", "swing_position"),
        _target_parts,
    ),
    "report": Kept(
        ("wbc_success", "dropped_rows", "clipped_torques", "wbc_ms"),
        ("wbc_wrench", "wrench_error", "acceleration_error"),
        _report_parts,
    ),
    "push": Kept((), ("push",), _push_parts),
}  # fmt: skip


def tick_row(
    time: float,
    x: Array,
    dynamics: RobotDynamics,
    inputs: Iterable[Array],
    signals: Iterable[tuple[str, Any]],
) -> bytes:
    """Return the numbers of a tick in one row, as bytes: joining them is the fastest there is.

    Args:
        time: [s].
        x: state of the robot, shape (nq + nv,).
        dynamics: quantities of it.
        inputs: command, torque and applied torque.
        signals: names and values of those of `SIGNALS` that there are; their arrays are of
            floats (`check_arrays`).
    """
    numbers: list[float] = [time]
    arrays: list[Any] = [x, dynamics.p_WG, *inputs]
    for name, value in signals:
        more, further = SIGNALS[name].parts(value)
        numbers += more
        arrays += further
    arrays += (dynamics.lines, dynamics.R_WC)
    first = array("d", numbers)
    try:
        return b"".join((first, *arrays))
    except TypeError:  # one is not in the order of its rows
        return b"".join((first, *(part.tobytes() for part in arrays)))


def check_arrays(signals: Iterable[tuple[str, Any]]) -> None:
    """Check that the arrays of signals can be recorded.

    Raises:
        SignalError: one does not hold floats of 64 bits; the message names it.
    """
    for name, value in signals:
        kept = SIGNALS[name]
        for channel, values in zip(kept.arrays, kept.parts(value)[1], strict=True):
            if values.dtype != np.float64:
                raise SignalError(
                    f"recorder.{name}", f"{channel} is of {values.dtype}: must be of float64"
                )


def write_ticks(ticks: Array, rows: Rows, signals: Iterable[str], half_length: float) -> None:
    """Write ticks into their channels.

    Args:
        ticks: numbers of `tick_row`, shape (n, ...).
        rows: of the channels.
        signals: names of those that there were.
        half_length: of the contact lines [m].
    """
    kept = [SIGNALS[name] for name in signals]
    numbers = ("time", *(name for one in kept for name in one.numbers))
    arrays = (*_STATE, *(name for one in kept for name in one.arrays))
    rows["push"][:] = 0.0
    at = 0
    for name in (*numbers, *arrays):
        end = at + prod(rows[name].shape[1:])
        rows[name][:] = ticks[:, at:end].reshape(rows[name].shape)
        at = end
    lines, R_WC = ticks[:, -_LINES:-18].reshape(-1, 2, 14), ticks[:, -18:].reshape(-1, 2, 3, 3)
    ends = np.array([[-half_length], [half_length]])
    middle, along = lines[:, :, None, :3], R_WC[:, :, None, :, 0]
    rows["contact_points"][:] = middle + ends * along


def write_contacts(results: Sequence[ContactResults], rows: Rows, feet: Mapping[int, int]) -> None:
    """Write true forces; after the contact points.

    Args:
        results: of the plant in each tick.
        rows: of the channels.
        feet: side of each foot, by the index of its body.
    """
    for name in _CONTACTS:
        rows[name][:] = 0.0
    infos = [
        (tick, one.point_pair_contact_info(k))
        for tick, one in enumerate(results)
        for k in range(one.num_point_pair_contacts())
    ]
    if not infos:
        return
    add_contacts(
        np.array([tick for tick, _ in infos]),
        np.array([feet.get(int(info.bodyA_index()), -1) for _, info in infos]),
        np.array([feet.get(int(info.bodyB_index()), -1) for _, info in infos]),
        np.concatenate([info.contact_force() for _, info in infos]),
        np.concatenate([info.contact_point() for _, info in infos]),
        np.array([info.slip_speed() for _, info in infos]),
        rows["contact_points"],
        *(rows[name] for name in _CONTACTS),
    )


def write_plans(plans: Sequence[CentroidalPlan], rows: Rows, before: CentroidalPlan | None) -> None:
    """Write what the MPC planned; after the times.

    Args:
        plans: of each tick.
        rows: of the channels.
        before: plan of the tick before these.
    """
    at = 0
    for _, same in groupby(plans, key=id):
        run = list(same)
        part = {name: values[at : at + len(run)] for name, values in rows.items()}
        _write_plan(run[0], part)
        # A plan that was given, and not solved for, took no time.
        new = run[0] is not before and run[0].report.milliseconds > 0.0
        part["mpc_ms"][:] = np.nan
        if new:
            part["mpc_ms"][0] = run[0].report.milliseconds
        before = run[0]
        at += len(run)


def _write_plan(plan: CentroidalPlan, rows: Rows) -> None:
    """Write what one plan says at the times of all `rows`."""
    k = plan.intervals(rows["time"])
    force, moment = plan.resultants
    motion, rows["mpc_orientation"][:] = planned_motion(
        rows["time"], k, plan.times, plan.states, plan.r_G, force, moment, plan.mass, GRAVITY
    )
    for name, values in zip(_MOTION, motion, strict=True):
        rows[name][:] = values
    rows["mpc_wrench"][:] = plan.wrench[k]
    way, length = plan.states[-1, :3] - plan.states[0, :3], plan.times[-1] - plan.times[0]
    rows["mpc_mean_velocity"][:] = way / length
    coming = plan.footholds[:FORESEEN]
    rows["mpc_footholds"][:] = np.nan
    rows["mpc_footholds"][:, : len(coming)] = coming
    rows["mpc_horizon"][:] = com_ahead(plan)
    rows["mpc_success"][:] = plan.report.success
    rows["mpc_failures"][:] = plan.failures
