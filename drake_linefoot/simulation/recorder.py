"""The LeafSystem that records a run."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydrake.common.value import AbstractValue
from pydrake.multibody.plant import ContactResults, MultibodyPlant
from pydrake.systems.framework import Context, InputPort, LeafSystem

from drake_linefoot.robot.dynamics import SharedDynamics
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.signals import CentroidalPlan
from drake_linefoot.simulation import tick_batch
from drake_linefoot.simulation.recording import CHANNELS
from drake_linefoot.simulation.sample_store import SampleStore
from drake_linefoot.simulation.tick_batch import Contacts, Tick
from drake_linefoot.systems import weak

Array = NDArray[np.float64]

_BATCH = 64  # samples that are written together
_SIGNALS = ("contact", "targets", "plan", "report", "push")


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
        self._half_length = humanoid.half_length
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
        self._pending: list[Tick] = []
        self._contacts = Contacts([], [], [], [], [], [])
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
        self._signals: list[InputPort | None] | None = None  # None in it: has no value
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
        inputs, time = self._inputs, context.get_time()
        x = inputs["state"].Eval(context)
        if not math.isfinite(x.dot(x)) and not np.isfinite(x).all():
            return
        if self._signals is None:  # asking takes longer than reading
            ports = [inputs[name] for name in _SIGNALS]
            self._signals = [port if port.HasValue(context) else None for port in ports]
        if self._pending and time <= self._pending[-1].time:
            self._flush()
        self._read_contacts(inputs["contact_results"].Eval(context))
        d = self._dynamics(x)
        self._pending.append(
            Tick(
                time,
                d.q,
                d.v,
                d.p_WG,
                d.p_WC,
                d.R_WC,
                inputs["command"].Eval(context),
                inputs["torque"].Eval(context),
                inputs["applied_torque"].Eval(context),
                *(port and port.Eval(context) for port in self._signals),
            )
        )
        if len(self._pending) >= _BATCH:
            self._flush()

    def _read_contacts(self, results: ContactResults) -> None:
        """Append the contacts of the plant to those that are pending."""
        tick, body_A, body_B, force, point, slip_speed = self._contacts
        for k in range(results.num_point_pair_contacts()):
            info = results.point_pair_contact_info(k)
            tick.append(len(self._pending))
            body_A.append(info.bodyA_index())
            body_B.append(info.bodyB_index())
            force.append(info.contact_force())
            point.append(info.contact_point())
            slip_speed.append(info.slip_speed())

    def _forget_signals(self, context: Context) -> None:
        """Ask anew which signals there are."""
        self._flush()  # a batch has the same signals in each tick
        self._signals = None

    def _flush(self) -> None:
        """Write what is pending."""
        if not self._pending:
            return
        if self._store.drop_from(self._pending[0].time):
            self._plan_before = None
        done = 0
        while done < len(self._pending):
            rows = self._store.next_rows(len(self._pending) - done)
            count = len(rows["time"])
            self._write(self._pending[done : done + count], done, rows)
            self._store.count += count
            done += count
        self._pending.clear()
        for column in self._contacts:
            column.clear()

    def _write(self, ticks: list[Tick], first: int, rows: tick_batch.Rows) -> None:
        """Write pending ticks, of which the first has the number `first`."""
        tick_batch.write_robot(ticks, rows, self._half_length)
        tick_batch.write_contacts(self._contacts, first, rows, self._feet)
        signals: list[list[Any]] = [[getattr(tick, name) for tick in ticks] for name in _SIGNALS]
        contact, targets, plan, report, push = signals
        tick_batch.write_pushes(push, rows)
        if contact[0] is not None:
            tick_batch.write_estimates(contact, rows)
        if targets[0] is not None:
            tick_batch.write_targets(targets, rows)
        if plan[0] is not None:
            tick_batch.write_plans(plan, rows, self._plan_before)
        if report[0] is not None:
            tick_batch.write_reports(report, rows)
        self._plan_before = plan[-1]
