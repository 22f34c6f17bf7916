"""The LeafSystem that records a run."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydrake.common.value import AbstractValue
from pydrake.multibody.plant import ContactResults, MultibodyPlant
from pydrake.systems.framework import Context, InputPort

from drake_linefoot.math.kernels import all_finite
from drake_linefoot.robot.dynamics import SharedDynamics
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.signals import CentroidalPlan
from drake_linefoot.simulation.recording import CHANNELS
from drake_linefoot.simulation.sample_store import SampleStore
from drake_linefoot.simulation.tick_batch import (
    Rows,
    check_arrays,
    tick_row,
    write_contacts,
    write_plans,
    write_ticks,
)
from drake_linefoot.systems import Block, weak

Array = NDArray[np.float64]

_BATCH = 64  # samples that are written together
_VECTORS = ("command", "torque", "applied_torque")
_SIGNALS = ("contact", "targets", "plan", "report", "push")


class Recorder(Block):
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
        self._pending: list[bytes] = []  # rows of ticks, each with its plan and its contacts
        self._plans: list[Any] = []
        self._results: list[ContactResults] = []
        self._last = -math.inf  # time of the last of them
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
        self._read = {name: port.Eval for name, port in self._inputs.items()}
        self._signals: list[str] | None = None  # that have values
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
        read, time = self._read, context.get_time()
        x = read["state"](context)
        if not self._dynamics.knows(x) and not all_finite(x):
            return
        if self._signals is None:  # asking takes longer than reading
            self._signals = [name for name in _SIGNALS if self._inputs[name].HasValue(context)]
            check_arrays((name, read[name](context)) for name in self._signals if name != "plan")
        if self._pending and time <= self._last:
            self._flush()
        self._last = time
        signals = {name: read[name](context) for name in self._signals}
        self._plans.append(signals.pop("plan", None))
        self._results.append(read["contact_results"](context).__copy__())
        inputs = [read[name](context) for name in _VECTORS]
        self._pending.append(tick_row(time, x, self._dynamics(x), inputs, signals.items()))
        if len(self._pending) >= _BATCH:
            self._flush()

    def _forget_signals(self, context: Context) -> None:
        """Ask anew which signals there are."""
        self._flush()  # a batch has the same signals in each tick
        self._signals = None

    def _flush(self) -> None:
        """Write what is pending."""
        if not self._pending:
            return
        ticks = np.frombuffer(b"".join(self._pending)).reshape(len(self._pending), -1)
        if self._store.drop_from(ticks[0, 0]):
            self._plan_before = None
        while len(ticks):
            rows = self._store.next_rows(len(ticks))
            count = len(rows["time"])
            self._write(ticks[:count], rows)
            self._store.count += count
            ticks = ticks[count:]
        self._pending.clear()

    def _write(self, ticks: Array, rows: Rows) -> None:
        """Write the first of the pending ticks, and forget their plans and contacts."""
        n = len(ticks)
        names = [name for name in self._signals or () if name != "plan"]
        write_ticks(ticks, rows, names, self._half_length)
        write_contacts(self._results[:n], rows, self._feet)
        if self._plans[0] is not None:
            write_plans(self._plans[:n], rows, self._plan_before)
        self._plan_before = self._plans[n - 1]
        del self._plans[:n], self._results[:n]
