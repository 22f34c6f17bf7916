"""Channels of a run as columns with names: a table of pandas, lines of matplotlib."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache
from itertools import product
from math import prod
from typing import TYPE_CHECKING, ClassVar, NamedTuple

from drake_linefoot.axes import WRENCH, points_of_foot
from drake_linefoot.errors import InputError, LinefootError
from drake_linefoot.facts import WithFacts
from drake_linefoot.lab.scenario import Scenario
from drake_linefoot.lab.simulation.channels import Channel
from drake_linefoot.late import late
from drake_linefoot.page import HEIGHT, Page
from drake_linefoot.robot.humanoid import Humanoid, load_humanoid
from drake_linefoot.types import Array

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from pandas import DataFrame

BASE_Q = ("q_w", "q_x", "q_y", "q_z", "x", "y", "z")  # R_WB, p_WB
SIZED = {"nq": "q", "nv": "v", "na": "torque", "nw": "contact_wrench", "nc": "true_normal"}
BASE_V = ("w_x", "w_y", "w_z", "v_x", "v_y", "v_z")  # in W


class Column(NamedTuple):
    """One number of a channel over time."""

    unit: str
    values: Array  # shape (n,)


humanoid_named = cache(load_humanoid)


def robot_of(run: RunView) -> Humanoid:
    """Return the robot of a run.

    Raises:
        InputError: it is not the one that was recorded any more.
        ModelError: it cannot be read.
    """
    humanoid = humanoid_named(run.scenario.robot)
    found = {name: vars(run)[channel].shape[-1] for name, channel in SIZED.items()}
    if found != humanoid.sizes:
        allowed = f"has {humanoid.sizes}, not the {found} of the recording"
        raise InputError("run", "robot", run.scenario.robot, allowed)
    return humanoid


def axis_names(run: RunView) -> dict[str, tuple[str, ...]]:
    """Return the names of the entries of axes that are as long as the robot of a run has them.

    Raises:
        InputError, ModelError: see `robot_of`.
    """
    humanoid = robot_of(run)
    plant, joints = humanoid.plant, run.joint_names
    return {
        "nq": (*BASE_Q, *plant.GetPositionNames(False, False)[len(BASE_Q) :]),
        "nv": (*BASE_V, *plant.GetVelocityNames(False, False)[len(BASE_V) :]),
        "na": joints,
        "nw": WRENCH[: humanoid.contact.size],
        "nc": points_of_foot(humanoid.sizes["nc"]),
    }


def columns(
    channels: Mapping[str, tuple[Channel, Array]], sized: Mapping[str, tuple[str, ...]]
) -> dict[str, Column]:
    """Return every number of channels with their values, n rows, under its name: `com.x`.

    `scaled` is what `axis_names` returns.
    """
    found = {}
    for name, (channel, values) in channels.items():
        axes = channel.names(sized)
        units = channel.entry_units(len(axes[-1]) if axes else 1)
        flat = flattened(values)
        for i, entries in enumerate(product(*axes)):
            found[".".join([name, *entries])] = Column(units[i % len(units)], flat[:, i])
    return found


def flattened(values: Array) -> Array:
    """Return all numbers of each sample in a row, shape (n, m), also of none."""
    return values.reshape(len(values), prod(values.shape[1:]))


def how_it_ended(run: RunView) -> str:
    """Return how a run ended, in words."""
    if not run.ended:
        return "no: it was killed, broke off or goes on"
    return f"FELL: {run.fall_reason}" if run.fell else "upright"


class RunView(WithFacts):
    """What a recorded run shows of itself, which has the attributes below.

    Attributes:
        channels: what every array is, by its name; with `rpy`.
    """

    channels: ClassVar[dict[str, Channel]]
    scenario: Scenario
    version: str
    joint_names: tuple[str, ...]
    fell: bool
    fall_reason: str
    ended: bool
    wall_seconds: float
    time: Array

    @property
    def realtime_rate(self) -> float:
        """Simulated seconds per second of wall time; 0 without a sample or a wall time."""
        known = len(self.time) > 0 and self.wall_seconds > 0.0
        return float(self.time[-1]) / self.wall_seconds if known else 0.0

    def __getitem__(self, name: str) -> Array:
        """Return a channel by its name, or by signal and part: ``run["report.wrench"]``.

        Raises:
            InputError: there is no such channel.
        """
        values: Array = getattr(self, self._name(name))
        return values

    def unit(self, name: str) -> str:
        """Return the unit of a channel, or of `rpy`.

        Raises:
            InputError: there is no such channel.
        """
        return self._channel(name).unit

    def to_pandas(self, *names: str) -> DataFrame:
        """Return channels as a table over time [s], a column for each number.

        A column is named after its channel and entry, `com.x` or `torque.left_knee`; the units
        of all are in the table's `attrs["units"]`.

        Args:
            names: of channels, or signal and part as of ``run[...]``, or `rpy`; without, of all.

        Raises:
            InputError: there is no such channel.
            LinefootError: pandas is not installed, which is the extra `pandas`.
            ModelError: the robot of the run, which names the joints, cannot be read.
        """
        every = [name for name in self.channels if name not in {"time", "rpy"}]
        found = self._columns(names or every)
        try:
            import pandas as pd
        except ImportError as error:
            needs = "to_pandas needs pandas: pip install drake_linefoot[pandas]"
            raise LinefootError(needs) from error
        index = pd.Index(self.time, name="time")
        frame = pd.DataFrame({name: c.values for name, c in found.items()}, index)
        frame.attrs["units"] = {name: column.unit for name, column in found.items()}
        return frame

    def plot(self, *names: str, axes: Axes | None = None) -> Axes:
        """Draw channels over time with matplotlib; raises as `to_pandas` does.

        Args:
            names: of channels, or `rpy`.
            axes: to draw into; None makes a new figure.

        Returns:
            The axes; its `figure.savefig("com.png")` writes a picture.
        """
        found = self._columns(names)
        if axes is None:
            import matplotlib.pyplot as plt

            axes = plt.subplots(layout="constrained")[1]
        for name, column in found.items():
            axes.plot(self.time, column.values, lw=1.0, label=name)
        axes.set_xlabel("time [s]")
        axes.set_ylabel(", ".join(dict.fromkeys(f"[{column.unit}]" for column in found.values())))
        axes.legend(fontsize="small")
        axes.grid(color="0.8", lw=0.5)
        return axes

    def show(self, height: int = HEIGHT) -> Page:
        """Show it again: a replay in a cell of a notebook, in a script in a browser.

        Args:
            height: in a notebook [px].

        Returns:
            The page; its `save("replay.html")` writes it.

        Raises:
            LinefootError: it cannot be drawn.
        """
        page: Page = late("lab.visualization.replay", "show_run")(self, height)
        return page

    def report(self, height: int = HEIGHT) -> Page:
        """Return what `linefoot walk` writes as report.html, to be seen as the replay is."""
        page: Page = late("lab.results.report", "show_report")(self, height)
        return page

    def _name(self, name: str) -> str:
        """Return the name of a channel that is given by its name, or by signal and part."""
        sources = {f"{c.signal}.{c.attribute}": n for n, c in self.channels.items() if c.attribute}
        if (found := sources.get(name, name)) in self.channels:
            return found
        allowed = f"must be one of {list(self.channels)}, or of {list(sources)}"
        raise InputError("run", "channel", name, allowed)

    def _channel(self, name: str) -> Channel:
        return self.channels[self._name(name)]

    def _columns(self, names: Sequence[str]) -> dict[str, Column]:
        named = dict.fromkeys(map(self._name, names))
        chosen = {name: (self.channels[name], getattr(self, name)) for name in named}
        return columns(chosen, axis_names(self))

    def _title(self) -> str:
        return f"Run of {self.scenario.name!r}, {len(self.time)} samples"

    def _facts(self) -> dict[str, object]:
        end = self.time[-1] if len(self.time) else 0.0
        return {
            "robot": self.scenario.robot,
            "simulated": f"{end:.3f} s, {self.realtime_rate:.2f} x real time, "
            f"drake_linefoot {self.version}",
            "ended": how_it_ended(self),
            "channels": f"{len(self.channels)} arrays: {', '.join(list(self.channels)[:6])}, ...",
            "look": 'run.show(), run.report(), run.plot("com"), run.to_pandas("com")',
        }
