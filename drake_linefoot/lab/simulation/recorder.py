"""The LeafSystem that records a run."""

import math
import sys
from array import array
from collections.abc import Callable, Mapping
from types import EllipsisType
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydrake.common.value import AbstractValue
from pydrake.multibody.plant import ContactResults, MultibodyPlant
from pydrake.systems.framework import Context

from drake_linefoot.errors import SignalError
from drake_linefoot.lab.simulation.channels import Channel
from drake_linefoot.lab.simulation.contact_forces import write_contacts
from drake_linefoot.lab.simulation.log import LogFile, Stored, read_log
from drake_linefoot.lab.simulation.plan_samples import write_plans
from drake_linefoot.lab.simulation.recording import CHANNELS
from drake_linefoot.layout import Sizes
from drake_linefoot.leaf_system import Block, weak
from drake_linefoot.parts import KNOTS
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.signals import layouts
from drake_linefoot.types import Array

_BATCH = 128  # samples that are written together
_TO_DISK = 0.5  # [s] of samples that go to the disk together
_IN_MEMORY = 1024  # samples that stay in memory at least, when all go to the disk
_VECTORS = ("command", "torque", "applied_torque", "push")
_SIGNALS = ("dynamics", "contact", "targets", "report", "plan", "estimate")


class Recorder(Block):
    """Records everything a run shows, one sample per period.

    .. pydrake_system::

        name: Recorder
        input_ports:
        - command
        - torque
        - applied_torque
        - push
        - dynamics
        - contact
        - targets
        - report
        - plan
        - estimate
        - contact_results

    What a controller has no output port for may stay unconnected: its channels are NaN.
    Samples are taken in a publish event, so they show the values the next plant step uses,
    and reading them computes nothing twice. Samples are kept in this object, not in the
    Context, or on the disk (`keep_in`); going back in time drops those that are not past any more.
    A state that is not finite is not recorded.
    """

    def __init__(
        self,
        humanoid: Humanoid,
        plant: MultibodyPlant,
        period: float = 0.001,
        knots: int = KNOTS,
    ) -> None:
        """Declare ports and the event.

        Args:
            humanoid: the robot.
            plant: the finalized plant that is simulated, with the bodies of the feet.
            period: of the samples [s].
            knots: intervals of the plans.
        """
        super().__init__()
        self.set_name("recorder")
        self._half_length, self._period = humanoid.half_length, period
        self._feet = {
            int(humanoid.names_in(plant).frame(foot.frame).body().index()): side
            for side, foot in enumerate(humanoid.description.feet)
        }
        sizes, every = humanoid.sizes, layouts(humanoid.sizes, knots)
        self._layouts = {name: every[name] for name in _SIGNALS}
        self._shapes = {name: CHANNELS[name].shape(sizes) for name in _VECTORS}
        self._dtype = dtype_of(CHANNELS, sizes)
        self._parts: list[NDArray[np.void]] = []  # samples, in pieces that stay where they are
        self._files: LogFile | None = None  # where they go
        self._new = 0  # number of the last samples that are not there yet
        self._ticks: np.dtype[np.void] | None = None  # type of a tick that is pending
        self._pending: list[bytes] = []  # ticks, each with its plan and its contacts
        self._plans: list[bytes] = []
        self._results: list[ContactResults] = []
        self._last = -math.inf  # time of the last of them
        self._plan_last: bytes | None = None  # that was read
        self._plan_before: bytes | None = None  # that was written
        for name, shape in self._shapes.items():
            self.DeclareVectorInputPort(name, *shape)
        for name, layout in self._layouts.items():
            self.signal_input(name, layout)
        contacts = AbstractValue.Make(ContactResults())
        self._read_contacts = self.DeclareAbstractInputPort("contact_results", contacts).Eval
        self._readers: list[Callable[[Context], Array]] = []  # of ports that have a value
        self._read_plan: Callable[[Context], Array] | None = None
        self.DeclareInitializationPublishEvent(weak(self, self._forget_layout))
        self.DeclarePeriodicPublishEvent(period, 0.0, weak(self, self._sample))

    @property
    def count(self) -> int:
        """Number of samples."""
        self._flush()
        if self._files is not None:
            return self._files.count + self._new
        return sum(map(len, self._parts))

    @property
    def dtype(self) -> np.dtype[np.void]:
        """Type of a sample: a place for every channel."""
        return self._dtype

    def keep_in(self, files: LogFile) -> None:
        """Let the samples go to the disk as they come; memory keeps the last second."""
        self._flush()
        self._files, self._new = files, sum(map(len, self._parts))

    def samples(self, name: str | EllipsisType, n: int = sys.maxsize) -> NDArray[Any]:
        """Return a copy of the last `n` samples, or all, of a channel; `...` takes whole rows.

        They are those in memory, see `keep_in`.
        """
        self._flush()
        return self._held(name, n)

    def _held(self, name: str | EllipsisType, n: int) -> NDArray[Any]:
        """Return `samples` of what has been written."""
        found = [np.empty(0, self._dtype)[name]]
        for rows in reversed(self._parts):
            if n <= 0:
                break
            found.append(rows[-n:][name])
            n -= len(rows)
        return np.concatenate(found[::-1])

    def arrays(self) -> Mapping[str, Array | Stored]:
        """Return all channels, as `Run` takes them; quaternions have unit norm, see `_unit`.

        Raises:
            OutputError: what is not on the disk yet cannot be written.
        """
        self._flush()
        if self._files is not None:
            self._store()
            log = read_log(self._files.path)
            return {name: Stored(log, name) for name in CHANNELS}
        channels = {name: self.samples(name) for name in CHANNELS}
        return channels | {"q": _unit(channels["q"])}

    def go_on_from(self, other: "Recorder") -> None:
        """Begin with the samples of another recorder of the same robot, and go on where it did."""
        other._flush()
        self._parts, self._files, self._new = [*other._parts], other._files, other._new

    def keep_last(self, n: int) -> None:
        """Forget all but the last `n` samples."""
        self._parts = [rows] if len(rows := self.samples(..., n)) else []

    def _sample(self, context: Context) -> None:
        time = context.get_time()
        try:
            if self._ticks is None:
                self._lay_out(context)
            signals: list[Any] = [read(context) for read in self._readers]
        except SignalError:  # of a state that is not finite
            return
        if self._pending and time <= self._last:
            self._flush()
        self._last = time
        self._pending.append(b"".join([array("d", (time,)), *signals]))
        self._results.append(self._read_contacts(context).__copy__())
        if self._read_plan is not None:
            plan = self._read_plan(context).tobytes()
            if self._plan_last is None or plan != self._plan_last:
                self._plan_last = plan  # one that goes on is the same object
            self._plans.append(self._plan_last)
        if len(self._pending) >= _BATCH:
            self._flush()

    def _lay_out(self, context: Context) -> None:
        """Find out which ports have a value, and lay out a tick: a record of each."""
        ports = {name: self.GetInputPort(name) for name in (*_VECTORS, *_SIGNALS)}
        ports = {name: port for name, port in ports.items() if port.HasValue(context)}
        plan = ports.pop("plan", None)
        self._read_plan = None if plan is None else plan.Eval
        self._readers = [port.Eval for port in ports.values()]
        kinds: list[tuple[Any, ...]] = [("time", np.float64)]
        for name in ports:
            layout = self._layouts.get(name)
            of_port = (np.float64, self._shapes[name]) if layout is None else (layout.dtype,)
            kinds.append((name, *of_port))
        self._ticks = np.dtype(kinds)

    def _forget_layout(self, context: Context) -> None:
        """Ask anew which signals there are."""
        self._flush()  # a batch has the same signals in each tick
        self._ticks = None

    def _flush(self) -> None:
        """Write what is pending."""
        if self._ticks is None or not self._pending:
            return
        ticks = np.frombuffer(b"".join(self._pending), self._ticks)
        if self._parts and self._parts[-1]["time"][-1] >= (first := ticks["time"][0]):
            self._go_back(first)
            self._plan_before = None
        nothing = np.full((len(ticks), self._dtype.itemsize // 8), np.nan)
        rows = nothing.view(self._dtype)[:, 0]
        write_ticks(ticks, rows, self._half_length)
        write_contacts(self._results, rows, self._feet)
        if self._read_plan is not None:
            write_plans(self._plans, rows, self._plan_before, self._layouts["plan"])
            self._plan_before = self._plans[-1]
        self._parts.append(rows)
        for pending in (self._pending, self._plans, self._results):
            pending.clear()
        if self._files is not None:
            self._new += len(rows)
            if self._new * self._period >= _TO_DISK:
                self._store()
                held = sum(map(len, self._parts))
                while held - len(self._parts[0]) >= _IN_MEMORY:
                    held -= len(self._parts.pop(0))

    def _store(self) -> None:
        """Write to the disk what is not there yet."""
        if self._files is None or not self._new:
            return
        rows = self._held(..., self._new)
        rows["q"] = _unit(rows["q"])
        self._files.append(rows)
        self._new = 0

    def _go_back(self, time: float) -> None:
        """Drop the samples that are not before a time [s]."""
        past = (rows[: np.searchsorted(rows["time"], time)] for rows in self._parts)
        if self._files is not None:
            self._store()
            there = read_log(self._files.path).channel("time")
            self._files.cut(int(np.searchsorted(there, time)))
        self._parts = [rows for rows in past if len(rows)]


def dtype_of(channels: Mapping[str, Channel], sizes: Sizes) -> np.dtype[np.void]:
    """Return the type of a row with a place for every channel."""
    return np.dtype([(name, np.float64, c.shape(sizes)) for name, c in channels.items()])


def write_ticks(ticks: NDArray[np.void], rows: NDArray[np.void], half_length: float) -> None:
    """Write ticks into their channels.

    Args:
        ticks: records of the signals by the names of their ports, shape (n,).
        rows: of the channels, shape (n,).
        half_length: of the contact lines [m].
    """
    rows["time"], rows["push"] = ticks["time"], 0.0
    for name, channel in CHANNELS.items():
        if channel.signal in (ticks.dtype.names or ()):
            rows[name] = channel.read(ticks[channel.signal])
    ends, d = np.array([[-half_length], [half_length]]), ticks["dynamics"]
    middle, along = d["p_WC"][:, :, None], d["R_WC"][:, :, None, :, 0]
    rows["contact_points"] = middle + ends * along


def _unit(q: Array) -> Array:
    """Return positions with quaternions of unit norm, shape (n, nq).

    The plant's, integrated step by step, drift from it by 5e-5 a second, and normalising those
    would change the bits of every run.
    """
    q = q.copy()
    q[:, :4] /= np.linalg.norm(q[:, :4], axis=1, keepdims=True)
    return q
