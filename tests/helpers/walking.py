"""Helpers of the controller's tests: mirrors, and a short walk that is simulated once.

`recorded_walk()` steps in place, walks forward in a left turn and then in a right turn; what
it keeps is what the blocks of the controller saw and said on the way.
"""

from dataclasses import dataclass
from functools import cache

import numpy as np
from pydrake.systems.framework import EventStatus

from drake_linefoot.contact.wrench_cone import line_cone
from drake_linefoot.estimation.contact_parameters import EstimatorParameters
from drake_linefoot.gait.parameters import GaitParameters
from drake_linefoot.lab.scenario import Scenario, Segment
from drake_linefoot.lab.wiring.closed_loop import build_closed_loop
from drake_linefoot.mpc.models.model import measure_centroidal
from drake_linefoot.mpc.parameters import MpcParameters
from drake_linefoot.robot.dynamics import robot_dynamics
from drake_linefoot.robot.humanoid import load_humanoid
from drake_linefoot.signals import (
    CentroidalPlan,
    GaitHorizon,
    GaitTargets,
    Reference,
    WholeBodyReport,
)
from tests.helpers.ports import look

MPC_TICKS = 20  # between two updates of the MPC
WBC_TICKS = 7  # between two recorded ticks of the whole-body controller

SCENARIO = Scenario(
    name="recorded walk",
    mpc=MpcParameters(model="ecd"),  # the paper's, whose equations the tests of its blocks check
    gait=GaitParameters(arm_swing=0.0),
    estimator=EstimatorParameters(external_time=0.0),  # nothing pulls at it
    segments=[
        Segment("in place", 0.6, True),
        Segment("forward, left turn", 0.7, True, [0.5, 0.0], 0.4),
        Segment("forward, right turn", 0.6, True, [0.5, 0.1], -0.6),
    ],
)


@dataclass(frozen=True)
class MpcRecord:
    """What one update of the MPC started from, and what it came to."""

    x: np.ndarray
    horizon: GaitHorizon
    reference: Reference
    previous: CentroidalPlan
    plan: CentroidalPlan


@dataclass(frozen=True)
class WbcRecord:
    """One tick of the whole-body controller."""

    x: np.ndarray
    targets: GaitTargets
    plan: CentroidalPlan
    report: WholeBodyReport
    torque: np.ndarray


@dataclass(frozen=True)
class Walk:
    """A recorded walk: every update of the MPC, some ticks of the whole-body controller."""

    mpc: tuple[MpcRecord, ...]
    wbc: tuple[WbcRecord, ...]

    @property
    def swinging(self):
        """The recorded ticks in single support."""
        return [r for r in self.wbc if r.targets.swings.any()]


@cache
def robot():
    """The robot of all helpers."""
    return load_humanoid("mit_humanoid")


class _Tape:
    """Monitor of a simulator that keeps what the controller's ports say."""

    def __init__(self, loop):
        self.loop, self.tick = loop, 0
        controller = loop.controller
        self.gait = controller.GetSubsystemByName("gait_planner")
        self.pending, self.mpc, self.wbc = None, [], []

    def __call__(self, root):
        if round(root.get_time() * 1000) != self.tick:
            raise AssertionError(f"tick {self.tick} at {root.get_time()} s")
        loop = self.loop
        context = loop.controller.GetMyContextFromRoot(root)
        x = loop.plant.state(root)

        def port(name):
            return look(loop.controller.GetOutputPort(name), context)

        plan = port("plan")
        if self.pending is not None:
            self.mpc.append(MpcRecord(*self.pending, plan))
            self.pending = None
        if self.tick % MPC_TICKS == 0:
            gait = self.gait.GetMyContextFromRoot(root)
            horizon = look(self.gait.get_horizon_output_port(), gait)
            self.pending = (x, horizon, port("reference"), plan)
        if self.tick % WBC_TICKS == 0:
            torque = loop.controller.GetOutputPort("torque").Eval(context)
            record = WbcRecord(x, port("targets"), plan, port("report"), torque)
            self.wbc.append(record)
        self.tick += 1
        return EventStatus.DidNothing()


@cache
def recorded_walk():
    """A walk of `SCENARIO`, simulated once."""
    loop = build_closed_loop(SCENARIO)
    simulator = loop.make_simulator()
    tape = _Tape(loop)
    simulator.set_monitor(tape)
    simulator.AdvanceTo(SCENARIO.duration)
    return Walk(tuple(tape.mpc), tuple(tape.wbc))


def dynamics_of(x):
    """Quantities of a state of the robot."""
    return robot_dynamics(robot(), robot().plant.CreateDefaultContext(), x)


def measure(x):
    """What the MPC measures of a state."""
    return measure_centroidal(dynamics_of(x))


# --- contact lines on ground that is not level ----------------------------------------------


def ground_frame(R_WC, slope):
    """Axes of the ground under a line: x along the line, z the normal as nearly as it can be."""
    x = R_WC[:, 0]
    normal = np.array([-slope[0], -slope[1], 1.0])
    z = normal - (normal @ x) * x
    z /= np.linalg.norm(z)
    return np.column_stack([x, np.cross(z, x), z])


def ground_cone(mu, half_length, R_WC, slope):
    """Rows of (18) in the frame of the ground, for forces in W and torques in C."""
    W, R = line_cone(mu, half_length), ground_frame(R_WC, slope)
    return np.hstack([W[:, :3] @ R.T, W[:, 3:] @ (R.T @ R_WC)[1:, 1:]])


# --- mirrors in the plane y = 0 -------------------------------------------------------------

S = np.diag([1.0, -1.0, 1.0])
_WRENCH = np.array([1.0, -1.0, 1.0, 1.0, -1.0])  # tau_z turns round, tau_y does not


def polar(a):
    """Mirror positions, velocities, forces: shape (..., 3)."""
    return a @ S


def axial(a):
    """Mirror angular velocities and momenta, moments, rotation vectors: shape (..., 3)."""
    return -a @ S


def mirror_wrench(w):
    """Mirror the wrenches of both feet, shape (..., 2, 5)."""
    return w[..., ::-1, :] * _WRENCH


def mirror_external(w):
    """Mirror a moment over a force, shape (6,)."""
    return np.concatenate([axial(w[:3]), polar(w[3:])])


def mirror_rotation(R):
    """Mirror rotations and inertias, shape (..., 3, 3)."""
    return S @ R @ S


def mirror_places(feet):
    """Mirror [x, y, z, yaw] of any number of feet, without changing their order."""
    return feet * np.array([1.0, -1.0, 1.0, -1.0])


def mirror_reference(ref):
    """Mirror a `Reference`."""
    return ref._replace(
        r=polar(ref.r), v=polar(ref.v), R=mirror_rotation(ref.R), L=axial(ref.L),
        r_mid=polar(ref.r_mid), v_mid=polar(ref.v_mid), R_mid=mirror_rotation(ref.R_mid),
        Omega_mid=axial(ref.Omega_mid), L_mid=axial(ref.L_mid), I_B=mirror_rotation(ref.I_B),
        E=-S @ ref.E * np.append(-np.diag(S), np.diag(S)),  # of L, axial, and m r', polar
        contact=ref.contact[:, ::-1], p_WC=polar(ref.p_WC[:, ::-1]),
        R_WC=mirror_rotation(ref.R_WC[:, ::-1]), footholds=mirror_places(ref.footholds),
        slope=ref.slope[:, ::-1] * [1, -1], external=mirror_external(ref.external),
    )  # fmt: skip


def mirror_states(X):
    """Mirror centroidal states [r, r', L_G, eta], shape (..., 12)."""
    return X * np.array([1, -1, 1, 1, -1, 1, -1, 1, -1, -1, 1, -1.0])


def mirror_plan(plan):
    """Mirror a `CentroidalPlan`."""
    return plan._replace(
        wrench=mirror_wrench(plan.wrench), force=polar(plan.force), moment=axial(plan.moment),
        states=mirror_states(plan.states),
        r_G=polar(plan.r_G), p_WC=polar(plan.p_WC[:, ::-1]),
        R_WC=mirror_rotation(plan.R_WC[:, ::-1]), footholds=mirror_places(plan.footholds),
        external=mirror_external(plan.external),
    )  # fmt: skip


def mirror_targets(targets):
    """Mirror a `GaitTargets`."""
    swing = targets.swing[::-1]
    swing = np.concatenate([polar(swing[:, :4]), axial(swing[:, 4:])], axis=1)
    return targets._replace(
        contact=targets.contact[::-1], swings=targets.swings[::-1], swing=swing,
        foothold=mirror_places(targets.foothold[::-1]),
        command=targets.command * np.array([1.0, -1.0, -1.0]), yaw=-targets.yaw,
        slope=targets.slope[::-1] * [1, -1], friction_share=targets.friction_share[::-1],
        external=mirror_external(targets.external),
    )  # fmt: skip


def mirror_lines(a):
    """Mirror motions of lines, [x, y, z, pitch, yaw] or their rates, shape (..., 5)."""
    return a * np.array([1.0, -1.0, 1.0, 1.0, -1.0])


def mirror_horizon(horizon):
    """Mirror a `GaitHorizon`."""
    dcm = horizon.dcm * np.array([1.0, 1.0, 1.0, -1.0, 1.0, -1.0, 1.0, 1.0])
    return horizon._replace(
        contact=horizon.contact[:, ::-1], slopes=horizon.slopes[:, ::-1] * [1, -1],
        feet=mirror_places(horizon.feet[:, ::-1]),
        swing=horizon.swing[:, ::-1], reference=mirror_lines(horizon.reference[:, ::-1]),
        target=mirror_lines(horizon.target[:, ::-1]),
        dcm=dcm, footholds=mirror_places(horizon.footholds), slope=horizon.slope * [1, -1],
        yaw=-horizon.yaw, turn_rate=-horizon.turn_rate, ground=polar(horizon.ground),
        external=mirror_external(horizon.external), lean=horizon.lean * [1, -1],
    )  # fmt: skip
