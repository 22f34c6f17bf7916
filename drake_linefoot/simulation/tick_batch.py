"""What is recorded of a tick, and many ticks written into the channels together.

Written one by one, each number would cost a call of numpy.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import groupby
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drake_linefoot.robot.dynamics import GRAVITY
from drake_linefoot.signals import CentroidalPlan, ContactEstimate, GaitTargets, WholeBodyReport
from drake_linefoot.simulation.kernels import add_contacts, planned_motion
from drake_linefoot.simulation.recording import FORESEEN, MODES, com_ahead

Array = NDArray[np.float64]
Rows = Mapping[str, Array]  # of each channel, one for each tick

_MOTION = ("mpc_com", "mpc_velocity", "mpc_acceleration", "mpc_momentum", "mpc_momentum_rate")
_CONTACTS = ("true_force", "true_normal", "slip_speed")
_NOWHERE, _NOTHING = np.full(3, np.nan), np.zeros(3)


class Contacts(NamedTuple):
    """Contacts of the simulator over many ticks, as columns.

    Attributes:
        tick: number of the tick.
        body_A, body_B: indices.
        force: on B in W [N], shape (3,) each.
        point: where, in W [m], shape (3,) each.
        slip_speed: [m/s].
    """

    tick: list[int]
    body_A: list[int]
    body_B: list[int]
    force: list[Array]
    point: list[Array]
    slip_speed: list[float]


class Tick(NamedTuple):
    """What is kept of a tick until it is written: arrays and signals, which nobody changes.

    Attributes:
        time: [s].
        q, v, com: of the robot, shapes (nq,), (nv,), (3,).
        p_WC, R_WC: contact frames, left and right, shapes (2, 3) and (2, 3, 3).
        command, torque, applied_torque: on the ports.
        contact, targets, plan, report, push: on the ports; None where a port has no value.
    """

    time: float
    q: Array
    v: Array
    com: Array
    p_WC: Array
    R_WC: Array
    command: Array
    torque: Array
    applied_torque: Array
    contact: ContactEstimate | None
    targets: GaitTargets | None
    plan: CentroidalPlan | None
    report: WholeBodyReport | None
    push: Array | None


def write_robot(ticks: Sequence[Tick], rows: Rows, half_length: float) -> None:
    """Write time, state, inputs and contact points."""
    rows["time"][:] = [tick.time for tick in ticks]
    for name in ("q", "v", "com", "command", "torque", "applied_torque"):
        _put(rows[name], [getattr(tick, name) for tick in ticks])
    shape = (len(ticks), 2, 1, 3)
    middle = np.concatenate([tick.p_WC for tick in ticks]).reshape(shape)
    along = np.concatenate([tick.R_WC for tick in ticks])[..., 0].reshape(shape)
    rows["contact_points"][:] = middle + np.array([[-half_length], [half_length]]) * along


def write_contacts(contacts: Contacts, first: int, rows: Rows, feet: Mapping[int, int]) -> None:
    """Write true forces; after the contact points.

    Args:
        contacts: with those of the ticks to be written, and of others.
        first: number of the first tick to be written.
        rows: of the channels.
        feet: side of each foot, by the index of its body.
    """
    for name in _CONTACTS:
        rows[name][:] = 0.0
    if not contacts.tick:
        return
    on_B = [feet.get(int(body), -1) for body in contacts.body_B]
    on_A = [feet.get(int(body), -1) for body in contacts.body_A]
    add_contacts(
        np.array(contacts.tick) - first,
        np.array(on_A),
        np.array(on_B),
        np.concatenate(contacts.force),
        np.concatenate(contacts.point),
        np.array(contacts.slip_speed),
        rows["contact_points"],
        *(rows[name] for name in _CONTACTS),
    )


def write_pushes(pushes: Sequence[Array | None], rows: Rows) -> None:
    """Write the force on the torso."""
    _put(rows["push"], [_NOTHING if push is None else push for push in pushes])


def write_estimates(estimates: Sequence[ContactEstimate], rows: Rows) -> None:
    """Write what the contact estimator says."""
    _put(rows["contact_wrench"], [e.wrench for e in estimates])
    rows["contact_flag"][:] = [e.contact for e in estimates]


def write_targets(targets: Sequence[GaitTargets], rows: Rows) -> None:
    """Write what the gait wants."""
    rows["mode"][:] = [MODES.index(t.mode) for t in targets]
    rows["planned_contact"][:] = [t.contact for t in targets]
    _put(rows["reference_command"], [t.command for t in targets])
    rows["reference_yaw"][:] = [t.yaw for t in targets]
    swings = [t.swing for t in targets]
    _put(rows["swing_position"], [_NOWHERE if s is None else s.p_WC for s in swings])
    _put(rows["foothold"], [t.foothold for t in targets])
    rows["gait_steps"][:] = [t.steps for t in targets]
    rows["moved_footholds"][:] = [t.moved_footholds for t in targets]
    rows["clipped_commands"][:] = [t.clipped_commands for t in targets]


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
    k = np.array([plan.interval(time) for time in rows["time"].tolist()])
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


def write_reports(reports: Sequence[WholeBodyReport], rows: Rows) -> None:
    """Write what the whole-body controller did."""
    _put(rows["wbc_wrench"], [r.wrench for r in reports])
    _put(rows["wrench_error"], [r.wrench_error for r in reports])
    _put(rows["acceleration_error"], [r.acceleration_error for r in reports])
    rows["wbc_success"][:] = [r.success for r in reports]
    rows["dropped_rows"][:] = [r.dropped_rows for r in reports]
    rows["clipped_torques"][:] = [r.clipped for r in reports]
    rows["wbc_ms"][:] = [r.milliseconds for r in reports]


def _put(rows: Array, values: Sequence[Array]) -> None:
    """Write one array to each row; many times as fast as from a list of arrays."""
    np.concatenate(values, out=rows.reshape(-1, *rows.shape[2:]))
