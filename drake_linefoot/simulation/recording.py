"""A recorded run: arrays with one row per sample, and what is needed to read them."""

from __future__ import annotations

import io
import zipfile
from dataclasses import dataclass, fields
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Annotated, get_type_hints

import numpy as np
from numpy.typing import NDArray

from drake_linefoot.errors import InputError
from drake_linefoot.math import so3
from drake_linefoot.math.kernels import from_quaternion
from drake_linefoot.scenario import Scenario
from drake_linefoot.scenario_io import dump_scenario, parse_scenario
from drake_linefoot.signals import CentroidalPlan
from drake_linefoot.simulation.channels import (
    BASE,
    COMMAND,
    ENDS,
    FEET,
    PLACE,
    RPY,
    WRENCHES,
    XYZ,
    Channel,
)

Array = NDArray[np.float64]

LOG = "log.npz"  # the file, in the folder of a run
FORESEEN = 3  # footholds of the plan that are recorded
HORIZON = 8  # places of the centre of mass over the horizon of the plan that are recorded


@dataclass(frozen=True)
class Run:
    """A simulated run; `Run.load("out/walk")` reads one that was written.

    Every channel has one row per sample, n rows in all; below stand the unit and the shape of
    one row, which `units` has too. Row i holds what was true at `time[i]`: contact forces,
    applied torque and contact estimate belong to the plant step that ended there, torque,
    plan and push to the one that began. Feet are left before right, contact points heel before toe.
    Flags are 0 or 1. What a controller has no output port for is NaN.

    Attributes:
        scenario: what was run.
        version: of the package that ran it.
        joint_names: the actuated joints, na of them.
        effort_limits: torque limits [N m], shape (na,).
        fell: whether the robot fell, which ended the run.
        fall_time: when [s]; None without a fall.
        fall_reason: why; empty without a fall.
        wall_seconds: how long the simulation took [s].
    """

    scenario: Scenario
    version: str
    joint_names: tuple[str, ...]
    effort_limits: Array
    fell: bool
    fall_time: float | None
    fall_reason: str
    wall_seconds: float

    time: Annotated[Array, Channel("s")]
    # the robot
    # quaternion w x y z of R_WB, p_WB, joints; w_WB_W, v_WB_W, joints
    q: Annotated[Array, Channel("-, m, rad", "nq", groups=(4, 3, 0))]
    v: Annotated[Array, Channel("rad/s, m/s, rad/s", "nv", groups=(3, 3, 0))]
    com: Annotated[Array, Channel("m", XYZ)]
    contact_points: Annotated[Array, Channel("m", FEET, ENDS, XYZ)]  # foot, heel or toe, in W
    command: Annotated[Array, Channel("m/s, m/s, rad/s, -", COMMAND)]  # v_x, v_y, turn rate, walk
    torque: Annotated[Array, Channel("N m", "na")]  # what the controller asks for
    applied_torque: Annotated[Array, Channel("N m", "na")]  # what the actuators gave
    push: Annotated[Array, Channel("N", XYZ)]  # on the torso, in W; zero while nothing pushes
    # contact as the simulator has it
    true_force: Annotated[Array, Channel("N", FEET, XYZ)]  # on each foot, in W
    true_normal: Annotated[Array, Channel("N", FEET, ENDS)]  # foot, heel or toe
    slip_speed: Annotated[Array, Channel("m/s", FEET)]  # fastest contact point of the foot
    # the gait
    mode: Annotated[Array, Channel("-")]  # index in MODES
    planned_contact: Annotated[Array, Channel("-", FEET)]
    reference_command: Annotated[Array, Channel("m/s, m/s, rad/s", COMMAND[:3])]  # after limits
    reference_yaw: Annotated[Array, Channel("rad")]
    swing_position: Annotated[Array, Channel("m", XYZ)]  # where the swing foot should be
    foothold: Annotated[Array, Channel("m, m, m, rad", PLACE)]  # where it will land: x, y, z, yaw
    gait_steps: Annotated[Array, Channel("-")]
    moved_footholds: Annotated[Array, Channel("-")]  # ticks, counted from the beginning
    clipped_commands: Annotated[Array, Channel("-")]  # ticks, counted from the beginning
    # the MPC
    mpc_wrench: Annotated[Array, WRENCHES]
    mpc_com: Annotated[Array, Channel("m", XYZ)]  # planned for this time, as the rest here
    mpc_velocity: Annotated[Array, Channel("m/s", XYZ)]  # of the centre of mass
    mpc_acceleration: Annotated[Array, Channel("m/s^2", XYZ)]
    mpc_momentum: Annotated[Array, Channel("kg m^2/s", XYZ)]  # angular, about the centre of mass
    mpc_momentum_rate: Annotated[Array, Channel("N m", XYZ)]
    mpc_orientation: Annotated[Array, Channel("rad", XYZ)]  # eta, of the torso from the desired one
    mpc_mean_velocity: Annotated[Array, Channel("m/s", XYZ)]  # over the horizon of the plan
    mpc_footholds: Annotated[Array, Channel("m, m, m, rad", FORESEEN, PLACE)]
    mpc_horizon: Annotated[Array, Channel("m", HORIZON, XYZ)]  # centre of mass, even in time
    mpc_success: Annotated[Array, Channel("-")]
    mpc_failures: Annotated[Array, Channel("-")]  # counted from the beginning
    mpc_ms: Annotated[Array, Channel("ms")]  # wall time, where a plan is new; else NaN
    # the whole-body controller
    wbc_wrench: Annotated[Array, WRENCHES]
    wrench_error: Annotated[Array, WRENCHES]
    acceleration_error: Annotated[Array, Channel("rad/s^2, m/s^2", BASE, groups=(3, 3))]
    wbc_success: Annotated[Array, Channel("-")]
    dropped_rows: Annotated[Array, Channel("-")]
    clipped_torques: Annotated[Array, Channel("-")]
    wbc_ms: Annotated[Array, Channel("ms")]  # wall time
    # the contact estimator
    contact_wrench: Annotated[Array, WRENCHES]
    contact_flag: Annotated[Array, Channel("-", FEET)]

    @cached_property
    def rpy(self) -> Array:
        """Roll, pitch and yaw of the torso, yaw without jumps [rad], shape (n, 3)."""
        R = np.array([from_quaternion(q) for q in self.q[:, :4]])
        angles = so3.rpy(R)
        angles[:, 2] = np.unwrap(angles[:, 2])
        return angles

    @property
    def realtime_rate(self) -> float:
        """Simulated seconds per second of wall time."""
        return float(self.time[-1]) / self.wall_seconds

    @property
    def units(self) -> dict[str, str]:
        """The unit of every channel, and of `rpy`, by name."""
        return {name: channel.unit for name, channel in (CHANNELS | DERIVED).items()}

    def unit(self, name: str) -> str:
        """Return the unit of a channel.

        Raises:
            InputError: there is no such channel.
        """
        units = self.units
        if name not in units:
            raise InputError("run", "channel", name, f"must be one of {list(units)}")
        return units[name]

    def save(self, path: str | Path) -> None:
        """Write a compressed npz; the scenario goes in as YAML text."""
        arrays = {name: getattr(self, name) for name in CHANNELS}
        with Path(path).open("wb") as file:
            np.savez_compressed(
                file,
                scenario=np.array(dump_scenario(self.scenario)),
                version=np.array(self.version),
                joint_names=np.array(self.joint_names),
                effort_limits=self.effort_limits,
                fell=np.array(self.fell),
                fall_time=np.array(np.nan if self.fall_time is None else self.fall_time),
                fall_reason=np.array(self.fall_reason),
                wall_seconds=np.array(self.wall_seconds),
                **arrays,
            )

    @classmethod
    def load(cls, path: str | Path) -> Run:
        """Read what `save` wrote.

        Args:
            path: the folder `linefoot walk` wrote, or the npz file itself.

        Raises:
            InputError: the file cannot be read, or is no recorded run.
            ScenarioError: its scenario is of another version.
        """
        file = Path(path)
        file = file if file.suffix == ".npz" else file / LOG
        try:
            with np.load(io.BytesIO(file.read_bytes()), allow_pickle=False) as data:
                stored = {name: data[name] for name in data.files}
        except (OSError, ValueError, EOFError, zipfile.BadZipFile) as error:
            raise InputError(file, "", "recorded run", f"cannot be read: {error}") from error
        if "mpc_com" in stored:  # logs of before know no horizon
            nothing = np.full((len(stored["mpc_com"]), HORIZON, 3), np.nan)
            stored.setdefault("mpc_horizon", nothing)
        if "time" in stored:  # logs of before know no pushes
            stored.setdefault("push", np.zeros((len(stored["time"]), 3)))
        missing = [f.name for f in fields(cls) if f.name not in stored]
        if missing:
            raise InputError(file, "", "recorded run", f"lacks {', '.join(missing)}")
        fall_time = float(stored["fall_time"])
        return cls(
            scenario=parse_scenario(str(stored["scenario"]), file),
            version=str(stored["version"]),
            joint_names=tuple(str(name) for name in stored["joint_names"]),
            effort_limits=stored["effort_limits"],
            fell=bool(stored["fell"]),
            fall_time=None if np.isnan(fall_time) else fall_time,
            fall_reason=str(stored["fall_reason"]),
            wall_seconds=float(stored["wall_seconds"]),
            **{name: stored[name] for name in CHANNELS},
        )


def com_ahead(plan: CentroidalPlan) -> Array:
    """Return where a plan predicts the centre of mass, evenly over its horizon [m].

    Returns:
        From the first knot to the last, shape (HORIZON, 3).
    """
    places: Array = plan.states[_evenly(len(plan.times)), :3]
    return places


@lru_cache
def _evenly(count: int) -> NDArray[np.int64]:
    """Return which of `count` knots are shown, from the first to the last."""
    return np.round(np.linspace(0.0, count - 1.0, HORIZON)).astype(int)


def _channels() -> dict[str, Channel]:
    hints = get_type_hints(Run, include_extras=True)
    return {name: h.__metadata__[0] for name, h in hints.items() if hasattr(h, "__metadata__")}


CHANNELS = _channels()
DERIVED = {"rpy": Channel("rad", RPY)}  # computed from channels
WALL_TIMES = ("mpc_ms", "wbc_ms")  # the only channels that differ from run to run
MODES = ("stand", "shift", "swing", "double")
