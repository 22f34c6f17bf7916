"""The LeafSystem that records a run."""

import math
import sys
from array import array
from collections.abc import Mapping
from types import EllipsisType
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydrake.systems.framework import Context, InputPort

from drake_linefoot.errors import SignalError
from drake_linefoot.lab.simulation.channels import RECORDED, Channel
from drake_linefoot.lab.simulation.log import LogFile, Reader, read_log
from drake_linefoot.lab.simulation.plan_samples import sample_plans
from drake_linefoot.lab.simulation.recording import CHANNELS
from drake_linefoot.layout import Layout, Sizes
from drake_linefoot.leaf_system import Block, weak
from drake_linefoot.parts import KNOTS
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.types import Array

_BATCH = 128  # samples that are written together
_TO_DISK = 0.5  # [s] of samples that go to the disk together
_IN_MEMORY = 1024  # samples that stay in memory at least, when all go to the disk
_VECTORS = ("command", "torque", "applied_torque", "push")
_SIGNALS = ("dynamics", "contact", "targets", "report", "plan", "estimate", "foot_contacts")


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
        - foot_contacts

    What a controller has no output port for may stay unconnected: its channels are NaN.
    Samples are taken in a publish event, so they show the values the next plant step uses,
    and reading them computes nothing twice. Samples are kept in this object, not in the
    Context, or on the disk (`keep_in`); going back in time drops those that are not past any more.
    A state that is not finite is not recorded.
    """

    def __init__(self, humanoid: Humanoid, period: float = 0.001, knots: int = KNOTS) -> None:
        """Declare ports and the event.

        Args:
            humanoid: the robot.
            period: of the samples [s].
            knots: intervals of the plans.
        """
        super().__init__()
        self.set_name("recorder")
        self._period = period
        self._dtype = dtype_of(CHANNELS, humanoid.sizes)
        self._parts: list[NDArray[np.void]] = []  # samples, in pieces that stay where they are
        self._file: LogFile | None = None  # where they go
        self._new = 0  # number of the last samples that are not there yet
        self._tick: np.dtype[np.void] | None = None  # type of a tick that is pending
        self._pending: list[bytes] = []  # ticks
        self._last = -math.inf  # time of the last of them
        self._plan_before: Array | None = None  # the last plan that was written
        for name in _VECTORS:
            self.DeclareVectorInputPort(name, *CHANNELS[name].shape(humanoid.sizes))
        for name in _SIGNALS:
            self.signal_input(name, Layout(RECORDED[name], {**humanoid.sizes, "knots": knots}))
        self._connected: list[InputPort] = []  # ports that have a value
        self.DeclareInitializationPublishEvent(weak(self, self._forget_layout))
        self.DeclarePeriodicPublishEvent(period, 0.0, weak(self, self._sample))

    @property
    def count(self) -> int:
        """Number of samples."""
        self._flush()
        if self._file is not None:
            return self._file.count + self._new
        return sum(map(len, self._parts))

    @property
    def dtype(self) -> np.dtype[np.void]:
        """Type of a sample: a place for every channel."""
        return self._dtype

    def keep_in(self, file: LogFile) -> None:
        """Let the samples go to the disk as they come; memory keeps the last second."""
        self._flush()
        self._file, self._new = file, sum(map(len, self._parts))

    def end(self, facts: Mapping[str, Any]) -> None:
        """Say on the disk how the run ended, see `Run.facts`; nothing more goes there."""
        self._flush()
        if self._file is not None:
            self._store()
            self._file.end(facts)

    def samples(self, name: str | EllipsisType, n: int = sys.maxsize) -> NDArray[Any]:
        """Return a copy of the last `n` samples, or all, of a channel; `...` takes whole rows.

        They are those in memory, see `keep_in`.
        """
        self._flush()
        return self._held(name, n)

    def last(self, name: str) -> Array:
        """Return the last sample of a channel; NaN before there is one."""
        samples = self.samples(name, 1)
        return samples[-1] if len(samples) else np.full(samples.shape[1:], np.nan)

    def _held(self, name: str | EllipsisType, n: int) -> NDArray[Any]:
        """Return `samples` of what has been written."""
        found = [np.empty(0, self._dtype)[name]]
        for rows in reversed(self._parts):
            if n <= 0:
                break
            found.append(rows[-n:][name])
            n -= len(rows)
        return np.concatenate(found[::-1])

    def arrays(self) -> Mapping[str, Array | Reader]:
        """Return all channels, as `Run` takes them; quaternions have unit norm, see `_unit`.

        Raises:
            OutputError: what is not on the disk yet cannot be written.
        """
        self._flush()
        if self._file is not None:
            self._store()
            return read_log(self._file.path).readers(CHANNELS)
        channels = {name: self.samples(name) for name in CHANNELS}
        return channels | {"q": _unit(channels["q"])}

    def go_on_from(self, other: "Recorder") -> None:
        """Take over the samples of another recorder of the same robot, and go on where it was."""
        other._flush()
        self._tick, self._plan_before, self._last = None, None, -math.inf
        self._pending.clear()
        self._parts, self._file, self._new = other._parts, other._file, other._new
        other._parts, other._file, other._new = [], None, 0

    def keep_last(self, n: int) -> None:
        """Forget all but the last `n` samples."""
        self._parts = [rows] if len(rows := self.samples(..., n)) else []

    def _sample(self, context: Context) -> None:
        time = context.get_time()
        try:
            if self._tick is None:
                self._lay_out(context)
            signals = [port.Eval(context) for port in self._connected]
        except SignalError:  # of a state that is not finite
            return
        if self._pending and time <= self._last:
            self._flush()
        self._last = time
        self._pending.append(b"".join([array("d", (time,)), *signals]))
        if len(self._pending) >= _BATCH:
            self._flush()

    def _lay_out(self, context: Context) -> None:
        """Find out which ports have a value, and lay out a tick: a record of each."""
        ports = [self.GetInputPort(name) for name in (*_VECTORS, *_SIGNALS)]
        self._connected = [port for port in ports if port.HasValue(context)]
        kinds: list[tuple[Any, ...]] = [("time", np.float64)]
        for port in self._connected:
            layout = self.layouts.get(port.get_name())
            kind = (np.float64, (port.size(),)) if layout is None else (layout.dtype,)
            kinds.append((port.get_name(), *kind))
        self._tick = np.dtype(kinds)

    def _forget_layout(self, context: Context) -> None:
        """Ask anew which signals there are."""
        self._flush()  # a batch has the same signals in each tick
        self._tick = None

    def _flush(self) -> None:
        """Write what is pending."""
        if self._tick is None or not self._pending:
            return
        ticks = np.frombuffer(b"".join(self._pending), self._tick)
        self._pending.clear()
        if self._parts and self._parts[-1]["time"][-1] >= (first := ticks["time"][0]):
            self._go_back(first)
            self._plan_before = None
        signals = {name: ticks[name] for name in ticks.dtype.names or ()}
        if (plans := signals.get("plan")) is not None:
            before, layout = self._plan_before, self.layouts["plan"]
            signals["plan_sample"] = sample_plans(plans, ticks["time"], layout, before)
            self._plan_before = np.frombuffer(plans[-1].tobytes())
        rows = rows_of(signals, self._dtype)
        self._parts.append(rows)
        if self._file is not None:
            self._new += len(rows)
            if self._new * self._period >= _TO_DISK:
                self._store()
                held = sum(map(len, self._parts))
                while held - len(self._parts[0]) >= _IN_MEMORY:
                    held -= len(self._parts.pop(0))

    def _store(self) -> None:
        """Write to the disk what is not there yet."""
        if self._file is None or not self._new:
            return
        rows = self._held(..., self._new)
        rows["q"] = _unit(rows["q"])
        self._file.append(rows)
        self._new = 0

    def _go_back(self, time: float) -> None:
        """Drop the samples that are not before a time [s]."""
        past = (rows[: np.searchsorted(rows["time"], time)] for rows in self._parts)
        if self._file is not None:
            self._store()
            there = read_log(self._file.path).channel("time")
            self._file.cut(int(np.searchsorted(there, time)))
        self._parts = [rows for rows in past if len(rows)]


def dtype_of(channels: Mapping[str, Channel], sizes: Sizes) -> np.dtype[np.void]:
    """Return the type of a row with a place for every channel."""
    return np.dtype([(name, np.float64, c.shape(sizes)) for name, c in channels.items()])


def rows_of(signals: Mapping[str, NDArray[Any]], dtype: np.dtype[np.void]) -> NDArray[np.void]:
    """Return what is recorded of n ticks: a place for every channel, NaN without its signal.

    Args:
        signals: by the names of their ports, as records of their layouts, shape (n,); with `time`.
        dtype: of a row.
    """
    nothing = np.full((len(signals["time"]), dtype.itemsize // 8), np.nan)
    rows: NDArray[np.void] = nothing.view(dtype)[:, 0]
    rows["push"] = 0.0
    for name, channel in CHANNELS.items():
        if channel.signal in signals:
            rows[name] = channel.read(signals[channel.signal])
    return rows


def _unit(q: Array) -> Array:
    """Return positions with quaternions of unit norm, shape (n, nq).

    The plant's, integrated step by step, drift from it by 5e-5 a second, and normalising those
    would change the bits of every run.
    """
    q = q.copy()
    q[:, :4] /= np.linalg.norm(q[:, :4], axis=1, keepdims=True)
    return q
