"""A recorded run: arrays with one row per sample, and what is needed to read them."""

import weakref
import zipfile
from contextlib import ExitStack
from dataclasses import dataclass, fields
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Self, get_type_hints

import numpy as np

from drake_linefoot.axes import (
    COMMAND,
    COMMAND_UNITS,
    ENDS,
    ENDS_OF_FEET,
    FEET,
    PLACE,
    PLACE_UNITS,
    RPY,
    WRENCH,
    XYZ,
)
from drake_linefoot.errors import InputError
from drake_linefoot.math.rotation import roll_pitch_yaw
from drake_linefoot.scenario import Scenario
from drake_linefoot.scenario.load import dump_scenario, parse_scenario
from drake_linefoot.simulation.channels import (
    FORESEEN,
    HORIZON,
    Channel,
    com_ahead,
    first_places,
    foothold,
    mean_velocity,
    nis,
    part,
    success,
    swing_position,
)
from drake_linefoot.simulation.growing import SUFFIX, StoredArray
from drake_linefoot.simulation.look import Looked
from drake_linefoot.simulation.stored import WHAT, check_run, read_folder, read_npz
from drake_linefoot.types import Array

LOG = "log.npz"  # the file, in the folder of a run
SAMPLES = "log"  # the folder of the same arrays while it goes on, in a folder beside that one
UNFINISHED = ".part"  # behind the name of that one
LARGEST = 2**30  # bytes of channels that are read into memory


@dataclass(frozen=True, repr=False)
class Run(Looked):
    """A simulated run; `Run.load("out/walk")` reads one that was written.

    Every channel has one row per sample, n rows in all; below stand the unit and the shape of
    one row, which `unit` gives too. Row i holds what was true at `time[i]`: contact forces,
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

    time: Annotated[Array, Channel("", "s")]
    # the robot
    # quaternion w x y z of R_WB, p_WB, joints; w_WB_W, v_WB_W, joints
    q: Annotated[Array, Channel("dynamics.q", ("-", "m", "rad"), "nq", groups=(4, 3, 0))]
    v: Annotated[Array, Channel("dynamics.v", ("rad/s", "m/s", "rad/s"), "nv", groups=(3, 3, 0))]
    com: Annotated[Array, Channel("dynamics.p_WG", "m", XYZ)]
    contact_points: Annotated[Array, Channel("", "m", FEET, ENDS, XYZ)]  # foot, heel or toe, in W
    # v_x, v_y, turn rate, walk
    command: Annotated[Array, Channel("command", (*COMMAND_UNITS, "-"), (*COMMAND, "walk"))]
    torque: Annotated[Array, Channel("torque", "N m", "na")]  # what the controller asks for
    applied_torque: Annotated[Array, Channel("applied_torque", "N m", "na")]  # of the actuators
    push: Annotated[Array, Channel("push", "N", XYZ)]  # on the torso, in W; zero without
    # contact as the simulator has it
    true_force: Annotated[Array, Channel("", "N", FEET, XYZ)]  # on each foot, in W
    true_normal: Annotated[Array, Channel("", "N", FEET, ENDS)]  # foot, heel or toe
    slip_speed: Annotated[Array, Channel("", "m/s", FEET)]  # fastest contact point of the foot
    # the gait
    mode: Annotated[Array, part("targets.mode")]  # index in MODES
    planned_contact: Annotated[Array, part("targets.contact")]
    reference_command: Annotated[Array, part("targets.command")]  # after limits
    reference_yaw: Annotated[Array, part("targets.yaw")]
    reference_friction: Annotated[Array, part("targets.friction")]  # at most
    reference_grip: Annotated[Array, part("targets.grip")]  # share of it
    # what else than the ground acts on the robot: moment about the centre of mass over force, in W
    reference_external: Annotated[Array, part("targets.external")]
    # why the command is not the one that was given: a `Limit`
    reference_limited: Annotated[Array, part("targets.limited")]
    # where the swing foot should be, and where it will land: x, y, z, yaw
    swing_position: Annotated[Array, Channel("targets", "m", XYZ, convert=swing_position)]
    foothold: Annotated[Array, Channel("targets", PLACE_UNITS, PLACE, convert=foothold)]
    gait_steps: Annotated[Array, part("targets.steps")]
    # ticks, counted from the beginning
    moved_footholds: Annotated[Array, part("targets.moved_footholds")]
    clipped_commands: Annotated[Array, part("targets.clipped_commands")]
    # the MPC: what it planned for this time, as the rest here
    mpc_wrench: Annotated[
        Array, Channel("plan_sample.wrench", ("N", "N m"), FEET, WRENCH, groups=(3, 2))
    ]
    mpc_com: Annotated[Array, Channel("plan_sample.r", "m", XYZ)]
    mpc_velocity: Annotated[Array, Channel("plan_sample.v", "m/s", XYZ)]  # of the centre of mass
    mpc_acceleration: Annotated[Array, Channel("plan_sample.a", "m/s^2", XYZ)]
    # angular, about the centre of mass
    mpc_momentum: Annotated[Array, Channel("plan_sample.L", "kg m^2/s", XYZ)]
    mpc_momentum_rate: Annotated[Array, Channel("plan_sample.L_dot", "N m", XYZ)]
    # eta, of the torso from the desired one
    mpc_orientation: Annotated[Array, Channel("", "rad", XYZ)]
    # over the horizon of the plan: mean, coming footholds, centre of mass even in time
    mpc_mean_velocity: Annotated[Array, Channel("plan", "m/s", XYZ, convert=mean_velocity)]
    mpc_footholds: Annotated[
        Array, Channel("plan", PLACE_UNITS, FORESEEN, PLACE, convert=first_places)
    ]
    mpc_horizon: Annotated[Array, Channel("plan", "m", HORIZON, XYZ, convert=com_ahead)]
    mpc_success: Annotated[Array, part("plan.status", success)]
    mpc_failures: Annotated[Array, part("plan.failures")]  # counted from the beginning
    mpc_ms: Annotated[Array, Channel("", "ms")]  # wall time, where a plan is new; else NaN
    # the whole-body controller
    wbc_wrench: Annotated[Array, part("report.wrench")]
    wrench_error: Annotated[Array, part("report.wrench_error")]
    acceleration_error: Annotated[Array, part("report.acceleration_error")]
    wbc_success: Annotated[Array, part("report.status", success)]
    dropped_rows: Annotated[Array, part("report.dropped_rows")]
    clipped_torques: Annotated[Array, part("report.clipped")]
    wbc_ms: Annotated[Array, part("report.milliseconds")]  # wall time
    # the contact estimator
    contact_wrench: Annotated[Array, part("contact.wrench")]
    contact_flag: Annotated[Array, part("contact.contact")]
    # the state estimator: R_WB and p_WB; w_WB_W, v_WB_W; standard deviations of rotation,
    # velocity, position in W; biases of gyroscope, accelerometer; NIS of each heel and toe
    estimate_pose: Annotated[Array, part("estimate.pose")]
    estimate_velocity: Annotated[Array, part("estimate.velocity")]
    estimate_sigma: Annotated[Array, part("estimate.sigma")]
    estimate_bias: Annotated[Array, part("estimate.biases")]
    estimate_nis: Annotated[
        Array, Channel("estimate", "-", ENDS_OF_FEET, convert=nis)
    ]  # NaN where none
    # counted from the beginning
    refused_contacts: Annotated[Array, part("estimate.refused")]  # outside the gate
    slipped_contacts: Annotated[Array, part("estimate.slips")]  # that hold anew

    if not TYPE_CHECKING:  # to which every name would be an attribute

        def __getattribute__(self, name: str) -> Any:
            value = super().__getattribute__(name)
            return value.read() if isinstance(value, StoredArray) else value  # at each use

    @cached_property
    def rpy(self) -> Array:
        """Roll, pitch and yaw of the torso, yaw without jumps [rad], shape (n, 3)."""
        angles = roll_pitch_yaw(self.q[:, :4])
        angles[:, 2] = np.unwrap(angles[:, 2])
        return angles

    def sample(self, i: int) -> dict[str, Array]:
        """Return row `i` of every channel, by its name."""
        return {name: getattr(self, name)[i] for name in CHANNELS}

    def facts(self) -> dict[str, Any]:
        """Return all but the channels as arrays; the scenario is YAML text."""
        names = [field.name for field in fields(self) if field.name not in CHANNELS]
        return {name: getattr(self, name) for name in names} | {
            "scenario": dump_scenario(self.scenario),
            "fall_time": np.nan if self.fall_time is None else self.fall_time,
        }

    def save(self, path: str | Path, step: int = 1) -> None:
        """Write each so many samples as `numpy.savez_compressed` does, array after array."""
        facts = self.facts()
        with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
            for name in (field.name for field in fields(self)):
                array = np.asanyarray(facts[name] if name in facts else getattr(self, name)[::step])
                with archive.open(f"{name}{SUFFIX}", "w", force_zip64=True) as file:
                    np.lib.format.write_array(file, array, allow_pickle=False)

    @classmethod
    def load(cls, path: str | Path) -> Self:
        """Read what `save` wrote, or what a run has recorded that was killed or goes on.

        Channels of more than `LARGEST` bytes together stay on the disk, unpacked; each is mapped
        when it is used.

        Args:
            path: the folder `linefoot walk` wrote, or the npz file itself. Where there is no
                folder yet, it is that of the run that has not ended, with `.part` behind its name.

        Raises:
            InputError: the file cannot be read, or is no recorded run.
            ScenarioError: its scenario is of another version.
        """
        file, names = log_of(path), [field.name for field in fields(cls)]
        with ExitStack() as stack:
            if file.suffix == ".npz":
                run = cls._of(file, *read_npz(file, names, LARGEST, stack))
            else:
                run = cls._of(file, read_folder(file, names), file)
            weakref.finalize(run, stack.pop_all().close)
        return run

    @classmethod
    def _of(cls, file: Path, stored: dict[str, Array], folder: Path | None) -> Self:
        """Return the run that arrays of a file are; channels stay in `folder` when given."""
        for name, otherwise in LATER.items():
            if "time" in stored:
                shape = len(np.atleast_1d(stored["time"])), *CHANNELS[name].shape({})
                stored.setdefault(name, np.full(shape, otherwise))
        missing = [f.name for f in fields(cls) if f.name not in stored]
        if missing:
            raise InputError(file, "", WHAT, f"lacks {', '.join(missing)}")
        if folder is not None:  # a process that was killed may have written some of the last rows
            n = min(len(np.atleast_1d(stored[name])) for name in CHANNELS)
            stored |= {name: stored[name][:n] for name in CHANNELS if stored[name].ndim}
        check_run(stored, file, CHANNELS)
        fall_time, wall = float(stored["fall_time"]), float(stored["wall_seconds"])
        end = float(stored["time"][-1:].sum())
        channels: dict[str, Any] = {name: stored[name] for name in CHANNELS}
        if folder is not None:
            files = {name: folder / f"{name}{SUFFIX}" for name in CHANNELS}
            there = {name: file for name, file in files.items() if file.exists()}
            channels |= {name: StoredArray(f, len(stored["time"])) for name, f in there.items()}
        return cls(
            scenario=parse_scenario(str(stored["scenario"]), file),
            version=str(stored["version"]),
            joint_names=tuple(str(name) for name in stored["joint_names"]),
            effort_limits=stored["effort_limits"],
            fell=bool(stored["fell"]),
            fall_time=None if np.isnan(fall_time) else fall_time,
            fall_reason=str(stored["fall_reason"]),
            wall_seconds=max(end, 1e-3) if np.isnan(wall) else wall,  # as if it were real time
            **channels,
        )


def log_of(path: str | Path) -> Path:
    """Return the log that `Run.load` reads: an npz file, or a folder of npy files."""
    whole = Path(path)
    if whole.suffix == ".npz":
        return whole
    if not (whole / LOG).exists() and whole.name:
        for folder in (whole, whole.with_name(whole.name + UNFINISHED)):
            if (folder / SAMPLES).is_dir():
                return folder / SAMPLES
    return whole / LOG


CHANNELS: dict[str, Channel] = {
    name: hint.__metadata__[0]
    for name, hint in get_type_hints(Run, include_extras=True).items()
    if hasattr(hint, "__metadata__")
}

DERIVED = {"rpy": Channel("", "rad", RPY)}  # computed from channels
LATER = {"mpc_horizon": np.nan, "push": 0.0}  # which logs of before lack, and what they hold then
LATER |= {name: np.nan for name, c in CHANNELS.items() if c.signal == "estimate"}
WALL_TIMES = ("mpc_ms", "wbc_ms")  # the only channels that differ from run to run
Run.channels = CHANNELS | DERIVED
