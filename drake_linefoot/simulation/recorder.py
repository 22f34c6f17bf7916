"""The LeafSystem that records a run."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydrake.common.value import AbstractValue
from pydrake.multibody.plant import ContactResults, MultibodyPlant
from pydrake.systems.framework import Context, InputPort, LeafSystem

from drake_linefoot.robot.dynamics import GRAVITY, RobotDynamics, SharedDynamics
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.signals import CentroidalPlan, ContactEstimate, GaitTargets, WholeBodyReport
from drake_linefoot.simulation.recording import CHANNELS, FORESEEN, MODES, com_ahead
from drake_linefoot.simulation.sample_store import SampleStore
from drake_linefoot.systems import weak

Array = NDArray[np.float64]

_BATCH = 64  # samples that are written together
_VECTORS = ("command", "torque", "applied_torque")
_SIGNALS = ("contact", "targets", "plan", "report", "push")

_Contact = tuple[int, int, Array, Array, float]  # bodies A and B, force on B, point, slip speed


class _Tick(NamedTuple):
    """What is kept of a tick until it is written."""

    time: float
    dynamics: RobotDynamics
    vectors: list[Array]
    contacts: list[_Contact]
    signals: list[Any]


def _contact(results: ContactResults, k: int) -> _Contact:
    """Return a contact of the plant."""
    info = results.point_pair_contact_info(k)
    bodies = int(info.bodyA_index()), int(info.bodyB_index())
    return *bodies, info.contact_force(), info.contact_point(), info.slip_speed()


class Recorder(LeafSystem):
    """Records everything a run shows, one sample per period.

    .. pydrake_system::

        name: Recorder
        input_ports:
        - state
        - command
        - torque
        - applied_torque
        - contact_results
        - contact
        - targets
        - plan
        - report
        - push

    | port | type | shape | unit |
    |---|---|---|---|
    | state | vector | nq + nv | Drake's order |
    | command | vector | 4 | v_x, v_y [m/s], turn rate [rad/s], walk (0 or 1) |
    | torque | vector | na | N m, of the controller |
    | applied_torque | vector | na | N m, net actuation of the plant |
    | contact_results | ContactResults | - | of the plant |
    | contact | ContactEstimate | - | optional |
    | targets | GaitTargets | - | optional |
    | plan | CentroidalPlan | - | optional |
    | report | WholeBodyReport | - | optional |
    | push | vector | 3 | N, in W; optional, zero without |

    Samples are taken in a publish event, so they show the values the next plant step uses,
    and reading them computes nothing twice. Samples are kept in this object, not in the
    Context; going back in time drops those that are not past any more. A state that is not
    finite is not recorded.
    """

    def __init__(
        self,
        humanoid: Humanoid,
        plant: MultibodyPlant,
        period: float = 0.001,
        dynamics: SharedDynamics | None = None,
    ) -> None:
        """Declare ports and the event.

        Args:
            humanoid: the robot.
            plant: the finalized plant that is simulated, to tell its bodies apart.
            period: of the samples [s].
            dynamics: shared with the controller; its own without.
        """
        super().__init__()
        self.set_name("recorder")
        self._dynamics = dynamics or SharedDynamics(humanoid)
        X = humanoid.half_length
        self._ends = np.array([[-X], [X]])  # heel and toe along the line
        self._feet = {
            int(plant.GetFrameByName(foot.frame).body().index()): side
            for side, foot in enumerate(humanoid.description.feet)
        }
        sizes = {"nq": humanoid.nq, "nv": humanoid.nv, "na": humanoid.na}
        self._store = SampleStore(
            {
                name: tuple(sizes[n] if isinstance(n, str) else n for n in channel.shape)
                for name, channel in CHANNELS.items()
            }
        )
        self._pending: list[_Tick] = []
        self._buffers = self._store.block  # that is written
        self._plan_before: CentroidalPlan | None = None
        for name, size in (
            ("state", humanoid.nq + humanoid.nv),
            ("command", 4),
            ("torque", humanoid.na),
            ("applied_torque", humanoid.na),
        ):
            self.DeclareVectorInputPort(name, size)
        self.DeclareAbstractInputPort("contact_results", AbstractValue.Make(ContactResults()))
        for name in ("contact", "targets", "plan", "report"):
            self.DeclareAbstractInputPort(name, AbstractValue.Make(object()))
        self.DeclareVectorInputPort("push", 3)
        self._inputs: dict[str, InputPort] = {
            port.get_name(): port
            for port in map(self.get_input_port, range(self.num_input_ports()))
        }
        self._signals: list[InputPort | None] | None = None  # those that have a value
        self.DeclareInitializationPublishEvent(weak(self, self._forget_signals))
        self.DeclarePeriodicPublishEvent(period, 0.0, weak(self, self._sample))

    @property
    def count(self) -> int:
        """Number of samples."""
        self._flush()
        return self._store.count

    def samples(self, name: str) -> Array:
        """Return the samples of one channel, shape (count, ...)."""
        return self.recent(name, self.count)

    def recent(self, name: str, n: int) -> Array:
        """Return the last `n` samples of one channel, or all when there are fewer."""
        self._flush()
        return self._store.recent(name, n)

    def arrays(self) -> dict[str, Array]:
        """Return all channels, as `Run` takes them."""
        return {name: self.samples(name).copy() for name in CHANNELS}

    def keep_last(self, n: int) -> None:
        """Forget all but the last `n` samples."""
        self._flush()
        self._store.keep_last(n)

    def _sample(self, context: Context) -> None:
        x = self._inputs["state"].Eval(context)
        if not np.isfinite(x).all():
            return
        if self._signals is None:  # asking takes longer than reading
            ports = [self._inputs[name] for name in _SIGNALS]
            self._signals = [port if port.HasValue(context) else None for port in ports]
        contacts = self._inputs["contact_results"].Eval(context)
        self._pending.append(
            _Tick(
                context.get_time(),
                self._dynamics(x),
                [self._inputs[name].Eval(context) for name in _VECTORS],
                [_contact(contacts, k) for k in range(contacts.num_point_pair_contacts())],
                [port and port.Eval(context) for port in self._signals],
            )
        )
        if len(self._pending) >= _BATCH:
            self._flush()

    def _forget_signals(self, context: Context) -> None:
        """Ask anew which signals there are."""
        self._signals = None

    def _flush(self) -> None:
        """Write what is pending; together, since each sample alone takes twice as long."""
        for tick in self._pending:
            if self._store.drop_from(tick.time):
                self._plan_before = None
            i = self._store.next_row()
            self._buffers = self._store.block
            self._buffers["time"][i] = tick.time
            for name, value in zip(_VECTORS, tick.vectors, strict=True):
                self._buffers[name][i] = value
            self._sample_robot(i, tick.dynamics)
            self._sample_contacts(i, tick.contacts)
            contact, targets, plan, report, push = tick.signals
            self._buffers["push"][i] = 0.0 if push is None else push
            if contact is not None:
                self._sample_estimate(i, contact)
            if targets is not None:
                self._sample_targets(i, targets)
            if plan is not None:
                self._sample_plan(i, plan)
            if report is not None:
                self._sample_report(i, report)
            self._store.count += 1
        self._pending.clear()

    def _sample_robot(self, i: int, d: RobotDynamics) -> None:
        b = self._buffers
        b["q"][i], b["v"][i], b["com"][i] = d.q, d.v, d.p_WG
        for side, foot in enumerate(d.feet):
            b["contact_points"][i, side] = foot.p_WC + self._ends * foot.R_WC[:, 0]

    def _sample_contacts(self, i: int, contacts: list[_Contact]) -> None:
        b = self._buffers
        force, normal, slip = b["true_force"][i], b["true_normal"][i], b["slip_speed"][i]
        force[:], normal[:], slip[:] = 0.0, 0.0, 0.0
        heel, toe = b["contact_points"][i].swapaxes(0, 1)
        line = toe - heel
        middle = 0.5 * np.sum(line * (toe + heel), axis=1)  # along the line
        for body_A, body_B, f_B, point, speed in contacts:
            side, f = self._feet.get(body_B), f_B
            if side is None:
                side, f = self._feet.get(body_A), -f_B
            if side is None:
                continue
            end = int(line[side] @ point > middle[side])
            force[side] += f
            normal[side, end] += f[2]
            slip[side] = max(slip[side], speed)

    def _sample_estimate(self, i: int, contact: ContactEstimate) -> None:
        self._buffers["contact_wrench"][i] = contact.wrench
        self._buffers["contact_flag"][i] = contact.contact

    def _sample_targets(self, i: int, targets: GaitTargets) -> None:
        b = self._buffers
        b["mode"][i] = MODES.index(targets.mode)
        b["planned_contact"][i] = targets.contact
        b["reference_command"][i] = targets.command
        b["reference_yaw"][i] = targets.yaw
        b["swing_position"][i] = np.nan if targets.swing is None else targets.swing.p_WC
        b["foothold"][i] = targets.foothold
        b["gait_steps"][i] = targets.steps
        b["moved_footholds"][i] = targets.moved_footholds
        b["clipped_commands"][i] = targets.clipped_commands

    def _sample_plan(self, i: int, plan: CentroidalPlan) -> None:
        b = self._buffers
        time = b["time"][i]
        sample, k = plan.sample(time, GRAVITY), plan.interval(time)
        b["mpc_wrench"][i] = sample.wrench
        b["mpc_com"][i], b["mpc_velocity"][i] = sample.r, sample.v
        b["mpc_acceleration"][i] = sample.a
        b["mpc_momentum"][i], b["mpc_momentum_rate"][i] = sample.L, sample.L_dot
        share = min((time - plan.times[k]) / (plan.times[k + 1] - plan.times[k]), 1.0)
        b["mpc_orientation"][i] = (1.0 - share) * plan.states[k, 9:] + share * plan.states[
            k + 1, 9:
        ]
        way, length = plan.states[-1, :3] - plan.states[0, :3], plan.times[-1] - plan.times[0]
        b["mpc_mean_velocity"][i] = way / length
        coming = plan.footholds[:FORESEEN]
        b["mpc_footholds"][i] = np.nan
        b["mpc_footholds"][i, : len(coming)] = coming
        if plan is not self._plan_before:
            self._ahead = com_ahead(plan)
        b["mpc_horizon"][i] = self._ahead
        b["mpc_success"][i] = plan.report.success
        b["mpc_failures"][i] = plan.failures
        new = plan is not self._plan_before and plan.report.milliseconds > 0.0
        b["mpc_ms"][i] = plan.report.milliseconds if new else np.nan  # one given took no time
        self._plan_before = plan

    def _sample_report(self, i: int, report: WholeBodyReport) -> None:
        b = self._buffers
        b["wbc_wrench"][i] = report.wrench
        b["wrench_error"][i] = report.wrench_error
        b["acceleration_error"][i] = report.acceleration_error
        b["wbc_success"][i] = report.success
        b["dropped_rows"][i] = report.dropped_rows
        b["clipped_torques"][i] = report.clipped
        b["wbc_ms"][i] = report.milliseconds
