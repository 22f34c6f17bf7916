"""What a log has to be to be that of a run: checked once, where it is read."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
from pydantic import InstanceOf

from drake_linefoot.axes import CORNERS, ENDS, WRENCH
from drake_linefoot.checks import check
from drake_linefoot.errors import InputError
from drake_linefoot.fields import (
    Flag,
    Line,
    Name,
    NameOrPath,
    NotNegative,
    Positive,
    Unit,
    misfit,
    together,
)
from drake_linefoot.lab.simulation.channels import Channel
from drake_linefoot.lab.simulation.log import MOST, WHAT, Log, Reader
from drake_linefoot.lab.simulation.run_view import SIZED
from drake_linefoot.types import Array, Flags

SHORTEST_GAP, LONGEST_GAP = 1e-6, 1.5  # [s] between two samples
KNOWN = {"time", "dynamics", "foot_contacts"}  # signals that every plant has: without NaN
OFF_UNIT = 1e-3  # of the norm of a quaternion
_CONTACTS = {3: len(ENDS), len(WRENCH) - 1: len(ENDS), len(WRENCH): len(CORNERS)}  # nw: nc
_Seconds = Unit("s", most=1e9)


def _ended(said: "Facts") -> None:
    if said.fell != (said.fall_time is not None):
        raise misfit("fall_time", said.fall_time, "must be there for a fall, and for nothing else")


@dataclass
class Facts:
    """What a log says of its run, up to `effort_limits` at its beginning, the rest at its end."""

    version: Name
    scenario: InstanceOf[dict[str, Any]]
    joint_names: list[NameOrPath]
    effort_limits: list[Annotated[Positive, Unit("N m", most=1e6)]]
    fell: Flag
    fall_time: Annotated[NotNegative, _Seconds] | None
    fall_reason: Line
    wall_seconds: Annotated[NotNegative, _Seconds]
    ended: Flag = True

    _fits = together(_ended)


def checked(log: Log, channels: Mapping[str, Channel]) -> dict[str, Any]:
    """Return what a log says of its run, and what reads each channel, which is checked then.

    Args:
        log: that was read.
        channels: that it has to have.

    Raises:
        InputError: it is not that of a run; the message names file and entry.
    """
    sizes = _checked_shapes(log, channels)
    _check_time(log, log.channel("time"))
    said = {**log.facts, **(log.ended or {})}
    if log.ended is None:  # as if it took as long as what it simulated
        end = max(float(log.channel("time")[-1:].sum()), 1e-3)
        said |= {"fell": False, "fall_time": None, "fall_reason": "", "wall_seconds": end}
        said["ended"] = False
    facts = check(said, Facts, log.file, error=InputError)
    for entry in ("joint_names", "effort_limits"):
        if (n := len(getattr(facts, entry))) != sizes["na"]:
            raise InputError(log.file, entry, f"{n} of them", f"must be {sizes['na']}")
    readers = {name: _Checked(log, name, channels[name].signal in KNOWN) for name in channels}
    return {**vars(facts), **readers}


def _checked_shapes(log: Log, channels: Mapping[str, Channel]) -> dict[str, int]:
    """Return the sizes of a robot whose channels have the shapes of a log."""
    file, shapes = log.file, log.shapes
    if missing := [name for name in channels if name not in shapes]:
        raise InputError(file, "", WHAT, f"lacks {', '.join(missing[:3])}")
    sizes = {size: (0, *shapes[name])[-1] for size, name in SIZED.items()}
    if not sizes["nq"] - 7 == sizes["nv"] - 6 == sizes["na"] > 0:
        raise InputError(file, "q, v, torque", str(sizes), "must have nq - 7 = nv - 6 = na")
    if _CONTACTS.get(sizes["nw"]) != sizes["nc"]:
        allowed = f"must be of a kind of contact, nw: nc as in {_CONTACTS}"
        raise InputError(file, "contact_wrench, true_normal", str(sizes), allowed)
    for name, channel in channels.items():
        if (shape := shapes[name]) != (wanted := channel.shape(sizes)):
            raise InputError(file, name, f"of shape {shape}", f"must have {wanted}")
    return sizes


def _check_time(log: Log, time: Array) -> None:
    """Raise InputError when samples do not follow each other as those of a run do."""
    steps = np.diff(time, prepend=0.0)
    fits = (steps >= SHORTEST_GAP) & (steps <= LONGEST_GAP)
    fits[:1] = (steps[:1] >= 0.0) & (steps[:1] <= LONGEST_GAP)
    for row in _first(~fits):
        allowed = f"must begin at 0 and go on in steps of {SHORTEST_GAP:g} to {LONGEST_GAP:g} s"
        raise InputError(log.file, f"time[{row}]", float(time[row]), allowed)


def _first(flags: Flags) -> Iterator[int]:
    """Yield the index of the first flag that is set, if there is one."""
    yield from np.flatnonzero(flags)[:1].tolist()


class _Checked(Reader):
    """A channel whose numbers are those of a run."""

    def __init__(self, log: Log, name: str, is_known: bool) -> None:
        """Read a channel of a log; of one that is known no number may be missing."""
        super().__init__(log, name)
        self._is_known, self._was_checked = is_known, False

    def read(self) -> Array:
        """Return its rows.

        Raises:
            InputError: they are damaged, or a number is none that a run can have.
        """
        rows = super().read()
        if not self._was_checked:
            self._check(rows)
        self._was_checked = True
        return rows

    def _check(self, rows: Array) -> None:
        flat = rows.reshape(len(rows), -1) if len(rows) else np.empty((0, 1))
        fits: Flags = np.abs(flat) <= MOST
        if not self._is_known:
            fits |= np.isnan(flat)
        allowed = f"must be a number of at most {MOST:g} in size"
        for row in _first(~np.asarray(fits.all(axis=1))):
            raise self._wrong(row, float(flat[row][~fits[row]][0]), allowed)
        if self.name == "q":
            norms = np.linalg.norm(flat[:, :4], axis=1)
            for row in _first(np.asarray(np.abs(norms - 1.0) > OFF_UNIT)):
                raise self._wrong(row, float(norms[row]), "must be a quaternion of norm 1 first")

    def _wrong(self, row: int, value: float, allowed: str) -> InputError:
        return InputError(self.log.file, f"{self.name}[{row}]", value, allowed)
