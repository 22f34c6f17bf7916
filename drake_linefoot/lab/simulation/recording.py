"""A recorded run: arrays with one row per sample, and what is needed to read them."""

import os
from dataclasses import dataclass, fields
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Self, get_type_hints

import numpy as np

from drake_linefoot.axes import (
    COMMAND,
    COMMAND_UNITS,
    ENDS_OF_FEET,
    FEET,
    PLACE,
    PLACE_UNITS,
    RPY,
    XYZ,
)
from drake_linefoot.errors import InputError, legible
from drake_linefoot.lab.scenario import Scenario
from drake_linefoot.lab.scenario.load import make_scenario, scenario_data
from drake_linefoot.lab.simulation.channels import (
    FORESEEN,
    HORIZON,
    Channel,
    com_ahead,
    first_places,
    foothold,
    mean_velocity,
    mode,
    nis,
    part,
    success,
    swing_position,
)
from drake_linefoot.lab.simulation.checked_log import Facts, checked
from drake_linefoot.lab.simulation.log import WHAT, LogFile, Reader, read_log
from drake_linefoot.lab.simulation.run_view import RunView
from drake_linefoot.math.rotation import roll_pitch_yaw
from drake_linefoot.types import Array

LOG = "log.arrow"  # the file, in the folder of a run, also of one that goes on
OLD = ".npz"  # of older versions
UNFINISHED = ".part"  # behind the name of the folder of a run that goes on
BLOCK = 2**16  # samples that are written together


@dataclass(frozen=True, repr=False)
class Run(RunView):
    """A simulated run; `Run.load("out/walk")` reads one that was written.

    Every channel has one row per sample, n rows in all; below stand the unit and the shape of
    one row, which `unit` gives too. Row i holds what was true at `time[i]`: contact forces,
    applied torque and contact estimate belong to the plant step that ended there, torque,
    plan and push to the one that began. Feet are left before right, contact points heel before toe,
    of a sole left before right. Flags are 0 or 1. What a controller has no output port for is NaN.

    Attributes:
        scenario: what was run.
        version: of the package that ran it.
        joint_names: the actuated joints, na of them.
        effort_limits: torque limits [N m], shape (na,).
        fell: whether the robot fell, which ended the run.
        fall_time: when [s]; None without a fall.
        fall_reason: why; empty without a fall.
        wall_seconds: how long the simulation took [s].
        ended: whether it came to its end, by time or by a fall, or was stopped: not when it was
            killed, broke off or goes on.
    """

    scenario: Scenario
    version: str
    joint_names: tuple[str, ...]
    effort_limits: Array
    fell: bool
    fall_time: float | None
    fall_reason: str
    wall_seconds: float
    ended: bool

    time: Annotated[Array, Channel("time", "s")]
    # the robot
    # quaternion w x y z of R_WB, p_WB, joints; w_WB_W, v_WB_W, joints
    q: Annotated[Array, Channel("dynamics.q", ("-", "m", "rad"), "nq", groups=(4, 3, 0))]
    v: Annotated[Array, Channel("dynamics.v", ("rad/s", "m/s", "rad/s"), "nv", groups=(3, 3, 0))]
    com: Annotated[Array, Channel("dynamics.p_WG", "m", XYZ)]
    contact_points: Annotated[Array, part("foot_contacts.points")]  # foot, point, in W
    # v_x, v_y, turn rate, walk
    command: Annotated[Array, Channel("command", (*COMMAND_UNITS, "-"), (*COMMAND, "walk"))]
    torque: Annotated[Array, Channel("torque", "N m", "na")]  # what the controller asks for
    applied_torque: Annotated[Array, Channel("applied_torque", "N m", "na")]  # of the actuators
    push: Annotated[Array, Channel("push", "N", XYZ)]  # on the torso, in W; zero without
    # contact as the simulator has it
    true_force: Annotated[Array, part("foot_contacts.force")]  # on each foot, in W
    true_normal: Annotated[Array, part("foot_contacts.normal")]  # foot, point
    slip_speed: Annotated[Array, part("foot_contacts.slip")]  # fastest contact point of the foot
    # the gait
    # which feet stand and whether steps are queued, in a word: index in MODES
    mode: Annotated[Array, Channel("targets", "-", is_whole=True, convert=mode)]
    planned_contact: Annotated[Array, part("targets.contact")]
    reference_command: Annotated[Array, part("targets.command")]  # after limits
    reference_yaw: Annotated[Array, part("targets.yaw")]
    reference_friction: Annotated[Array, part("targets.friction")]  # at most
    reference_friction_share: Annotated[Array, part("targets.friction_share")]  # share of it
    # what else than the ground acts on the robot: moment about the centre of mass over force, in W
    reference_external: Annotated[Array, part("targets.external")]
    # why the command is not the one that was given: a `Limit`
    reference_limited: Annotated[Array, part("targets.limited")]
    # where a foot that swings should be, and where it will land: x, y, z, yaw
    swing_position: Annotated[Array, Channel("targets", "m", FEET, XYZ, convert=swing_position)]
    foothold: Annotated[Array, Channel("targets", PLACE_UNITS, FEET, PLACE, convert=foothold)]
    gait_steps: Annotated[Array, part("targets.steps")]
    # ticks, counted from the beginning
    moved_footholds: Annotated[Array, part("targets.moved_footholds")]
    clipped_commands: Annotated[Array, part("targets.clipped_commands")]
    # the MPC: what it planned for this time, as the rest here
    mpc_wrench: Annotated[Array, part("plan_sample.wrench")]
    mpc_com: Annotated[Array, part("plan_sample.r")]
    mpc_velocity: Annotated[Array, part("plan_sample.v")]  # of the centre of mass
    mpc_acceleration: Annotated[Array, part("plan_sample.a")]
    # angular, about the centre of mass
    mpc_momentum: Annotated[Array, part("plan_sample.L")]
    mpc_momentum_rate: Annotated[Array, part("plan_sample.L_dot")]
    # eta, of the torso from the desired one
    mpc_orientation: Annotated[Array, part("plan_sample.eta")]
    # over the horizon of the plan: mean, coming footholds, centre of mass even in time
    mpc_mean_velocity: Annotated[Array, Channel("plan", "m/s", XYZ, convert=mean_velocity)]
    mpc_footholds: Annotated[
        Array, Channel("plan", PLACE_UNITS, FORESEEN, PLACE, convert=first_places)
    ]
    mpc_horizon: Annotated[Array, Channel("plan", "m", HORIZON, XYZ, convert=com_ahead)]
    mpc_success: Annotated[Array, part("plan.status", success)]
    mpc_failures: Annotated[Array, part("plan.failures")]  # counted from the beginning
    mpc_ms: Annotated[
        Array, part("plan_sample.milliseconds")
    ]  # wall time, where a plan is new; else NaN
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
            return value.read() if isinstance(value, Reader) else value  # at each use

    @cached_property
    def rpy(self) -> Array:
        """Roll, pitch and yaw of the torso, yaw without jumps [rad], shape (n, 3)."""
        angles = roll_pitch_yaw(self.q[:, :4])
        angles[:, 2] = np.unwrap(angles[:, 2])
        return angles

    def sample(self, i: int) -> dict[str, Array]:
        """Return row `i` of every channel, by its name."""
        return {name: getattr(self, name)[i] for name in CHANNELS}

    def facts(self) -> tuple[dict[str, Any], dict[str, Any]]:
        """Return what is known of it at its beginning and at its end, as JSON takes it."""
        begin = {
            "version": self.version,
            "scenario": scenario_data(self.scenario),
            "joint_names": list(self.joint_names),
            "effort_limits": self.effort_limits.tolist(),
        }
        names = [field.name for field in fields(Facts) if field.name not in begin]
        end = {name: getattr(self, name) for name in names}
        return begin, {**end, "fall_reason": legible(self.fall_reason)}

    def save(self, path: str | Path, step: int = 1) -> None:
        """Write each so many samples as a log.

        Raises:
            OutputError: it cannot be written.
        """
        begin, end = self.facts()
        arrays = {name: getattr(self, name) for name in CHANNELS}
        dtype = np.dtype([(name, np.float64, a.shape[1:]) for name, a in arrays.items()])
        log, taken = LogFile(Path(path), dtype, CHANNELS, begin), np.arange(0, len(self.time), step)
        for block in np.array_split(taken, max(1, -(-len(taken) // BLOCK))):
            rows = np.empty(len(block), dtype)
            for name, values in arrays.items():
                rows[name] = values[block]
            log.append(rows)
        log.end(end)

    @classmethod
    def load(cls, path: str | Path) -> Self:
        """Read what `save` wrote, or what a run has recorded that was killed or goes on.

        Its channels stay on the disk, mapped; each is read when it is used.

        Args:
            path: the folder `linefoot walk` wrote, or the log itself. Where there is no
                folder yet, it is that of the run that has not ended, with `.part` behind its name.

        Raises:
            InputError: the file cannot be read, or is no recorded run.
            ScenarioError: its scenario is of another version.
        """
        log = read_log(log_of(path))
        said = checked(log, CHANNELS)
        said["scenario"] = make_scenario(said["scenario"], log.file)
        said["joint_names"] = tuple(said["joint_names"])
        said["effort_limits"] = np.array(said["effort_limits"], dtype=np.float64)
        return cls(**said)


def log_of(path: str | Path) -> Path:
    """Return the log that `Run.load` reads.

    Raises:
        InputError: there is only one that an older version wrote.
    """
    whole = Path(path)
    if whole.suffix == Path(LOG).suffix or (os.path.isfile(whole) and whole.suffix != OLD):
        return whole
    for folder in (whole, whole.with_name(whole.name + UNFINISHED)) if whole.name else (whole,):
        if os.path.exists(folder / LOG):  # False for a path that is none, as one too long
            return folder / LOG
        if os.path.isfile(old := folder if folder.suffix == OLD else folder / f"log{OLD}"):
            raise InputError(old, "", WHAT, "is of version 0.2.0 or older, which reads it")
    return whole / LOG


CHANNELS: dict[str, Channel] = {
    name: hint.__metadata__[0]
    for name, hint in get_type_hints(Run, include_extras=True).items()
    if hasattr(hint, "__metadata__")
}

DERIVED = {"rpy": Channel("", "rad", RPY)}  # computed from channels
WALL_TIMES = ("mpc_ms", "wbc_ms")  # the only channels that differ from run to run
Run.channels = CHANNELS | DERIVED
