"""The frozen dataclasses that travel on abstract ports, with shapes and units.

Conventions, stated here once: world frame W with z up, torso B, contact frame C (origin in
the middle of a foot's contact line, x from heel to toe, y level). Left before right. A
contact wrench is ``[f_x, f_y, f_z]`` in W and ``[tau_y, tau_z]`` in C, acting on the robot
at C. Centroidal states are ``[r, r', L_G, eta]`` of (36). SI units, radians.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple, Self

import numpy as np

from drake_linefoot.centroidal import TIME_EPSILON, PlanSample, Trajectory, resultants, sample_plan
from drake_linefoot.types import Array, Flags, Indices


class Signal:
    """Base of all signals: never changed after it was made, so copies are the same object."""

    def __deepcopy__(self, memo: dict[int, object]) -> Self:
        """Return self; Drake copies abstract values on every update."""
        return self


class SwingTarget(NamedTuple):
    """Where the contact line of the swing foot should be now.

    Attributes:
        p_WC, v_WC, a_WC: middle of the line, velocity, acceleration [m, s], shape (3,).
        d_W: direction of the line, heel to toe, unit vector, shape (3,).
        w_W, alpha_W: angular velocity and acceleration of the line [rad, s], shape (3,).
    """

    p_WC: Array
    v_WC: Array
    a_WC: Array
    d_W: Array
    w_W: Array
    alpha_W: Array


@dataclass(frozen=True)
class GaitTargets(Signal):
    """What the whole-body controller needs of the gait, every tick.

    Attributes:
        time: when it holds [s].
        mode: "stand", "shift", "swing" or "double".
        contact: whether the left and the right foot stand.
        swing: target of the swing foot; None when both feet stand.
        foothold: where the swing foot will land, [x, y, z, yaw], shape (4,); NaN without.
        command: commanded velocity after rate limits, [v_x, v_y, turn rate], shape (3,).
        yaw: desired heading [rad].
        slope: of the ground, rise per metre along x and y of the world, shape (2,).
        friction: of the ground, at most: what feet that slid have told of it, 1 before [-].
        grip: share of it that heel and toe of each foot have, little at an end that bears nothing
            [-], shape (2, 2).
        external: what else than the ground acts on the robot, moment about the CoM over force in W,
            as far as it lasts [N m, N], shape (6,).
        limited: why the command is not the one that was given, a `Limit`.
        steps: steps taken.
        moved_footholds: ticks in which a limit moved the foothold.
        clipped_commands: ticks in which the command was outside its limits.
    """

    time: float
    mode: str
    contact: tuple[bool, bool]
    swing: SwingTarget | None
    foothold: Array
    command: Array
    yaw: float
    slope: Array
    friction: float
    grip: Array
    external: Array
    limited: int
    steps: int
    moved_footholds: int
    clipped_commands: int


@dataclass(frozen=True)
class ContactEstimate(Signal):
    """What the contact estimator says.

    Attributes:
        wrench: estimated wrench of each foot [N, N m], shape (2, 5).
        contact: whether each foot is on the ground.
        residual: tau_d of (21), generalized force of all contacts, shape (nv,).
        external: what else acts on the robot and lasts, moment about the CoM over force in W
            [N m, N], shape (6,).
    """

    wrench: Array
    contact: tuple[bool, bool]
    residual: Array
    external: Array


@dataclass(frozen=True)
class StateEstimate(Signal):
    """What the state estimator says of its estimate.

    Attributes:
        pose: quaternion w x y z of R_WB and p_WB [m], shape (7,).
        velocity: w_WB_W [rad/s], v_WB_W [m/s], shape (6,).
        sigma: standard deviations in W of rotation, velocity and position [rad, m/s, m], (9,).
        biases: of gyroscope and accelerometer [rad/s, m/s^2], shape (6,).
        innovation: of each heel and toe [m], NaN where none, shape (4, 3).
        nis: squared Mahalanobis distance of each innovation, NaN where none, shape (4,).
        holds: which heels and toes count as held, 0 or 1, shape (4,).
        refused: innovations outside the gate so far.
        slips: points that had to hold anew so far.
    """

    pose: Array
    velocity: Array
    sigma: Array
    biases: Array
    innovation: Array
    nis: Array
    holds: Array
    refused: float
    slips: float


LOCKED = np.empty((0, 3, 6))  # E of models in which the joints count as locked


@dataclass(frozen=True)
class Reference(Signal):
    """Reference of the MPC over K intervals between K + 1 knots.

    Attributes:
        times: knots [s], shape (K + 1,).
        r, v: CoM at the knots [m, m/s], shape (K + 1, 3).
        R: torso orientation at the knots, shape (K + 1, 3, 3).
        L: angular momentum about the CoM at the knots [kg m^2/s], shape (K + 1, 3).
        r_mid, v_mid: CoM in the middle of each interval, shape (K, 3).
        R_mid: torso orientation there, shape (K, 3, 3).
        Omega_mid: torso angular velocity there, in B [rad/s], shape (K, 3).
        L_mid: angular momentum there, shape (K, 3).
        I_B: locked inertia there, in B [kg m^2], shape (K, 3, 3).
        E: how the torso turns over feet that move as planned, of L and of m r' in B, see
            `torso_rates`, shape (K, 3, 6); of models with locked joints (0, 3, 6).
        contact: which feet stand in each interval, shape (K, 2).
        p_WC: contact lines [m], shape (K, 2, 3).
        R_WC: contact frames, shape (K, 2, 3, 3).
        slope: of the ground, rise per metre along x and y of the world, shape (2,).
        friction: of the ground, at most, as `GaitTargets` have it [-].
        external: what else acts on the robot, likewise, shape (6,).
        reach_error: largest inverse-kinematics residual over the horizon [m, rad].
        footholds: coming footholds [x, y, z, yaw], shape (n, 4).
    """

    times: Array
    r: Array
    v: Array
    R: Array
    L: Array
    r_mid: Array
    v_mid: Array
    R_mid: Array
    Omega_mid: Array
    L_mid: Array
    I_B: Array
    E: Array
    contact: Flags
    p_WC: Array
    R_WC: Array
    slope: Array
    friction: float
    external: Array
    reach_error: float
    footholds: Array

    @property
    def dt(self) -> Array:
        """Lengths of the intervals [s], shape (K,)."""
        return np.diff(self.times)


@dataclass(frozen=True)
class SolverReport:
    """How a quadratic program was solved.

    Attributes:
        success: whether the solution was used.
        status: the solver's own word.
        iterations: of the solver.
        milliseconds: wall time of the whole update.
    """

    success: bool
    status: str
    iterations: int
    milliseconds: float


@dataclass(frozen=True)
class CentroidalPlan(Signal):
    """What the MPC decided: wrenches that are constant in each interval, and the motion.

    Attributes:
        times: knots [s], shape (K + 1,).
        wrench: wrench of each foot in each interval [N, N m], shape (K, 2, 5).
        states: predicted ``[r, r', L_G, eta]`` at the knots, shape (K + 1, 12).
        r_G: the fixed point of L_G [m], shape (3,).
        mass: [kg].
        p_WC: contact lines, shape (K, 2, 3).
        R_WC: contact frames, shape (K, 2, 3, 3).
        footholds: coming footholds [x, y, z, yaw], shape (n, 4).
        external: what else than the ground it counts on, as of `GaitTargets`, shape (6,).
        report: how the program was solved.
        failures: failed solves so far.
    """

    times: Array
    wrench: Array
    states: Array
    r_G: Array
    mass: float
    p_WC: Array
    R_WC: Array
    footholds: Array
    external: Array
    report: SolverReport
    failures: int

    def intervals(self, times: Array) -> Indices:
        """Return the intervals that contain times [s], the first before, the last after, (n,)."""
        # The first knot bounds nothing, and the last neither.
        return self.times[1:-1].searchsorted(times + TIME_EPSILON, side="right")

    @cached_property
    def trajectory(self) -> Trajectory:
        """The plan as compiled code takes it."""
        force, moment = resultants(self.wrench, self.p_WC, self.R_WC, self.r_G)
        held = self.wrench, force, moment
        return Trajectory(self.times, self.states, *held, self.r_G, self.mass, self.external)

    def sample(self, t: float) -> PlanSample:
        """Return the plan at time `t` [s], held at its end."""
        return sample_plan(self.trajectory, t)


@dataclass(frozen=True)
class WholeBodyReport(Signal):
    """What the whole-body controller did in one tick.

    Attributes:
        torque: joint torques after limits [N m], shape (na,).
        wrench: wrench of each foot it counts on [N, N m], shape (2, 5).
        wrench_error: correction of the MPC's wrench, delta_fr of (49), shape (2, 5).
        acceleration_error: correction of the base acceleration, delta_f of (49), shape (6,).
        vdot: generalized acceleration it counts on, shape (nv,).
        success: whether the wrench program was solved.
        status: how.
        dropped_rows: task rows that were dropped because they contradict a higher task.
        clipped: torques that had to be limited.
        milliseconds: wall time of the tick.
    """

    torque: Array
    wrench: Array
    wrench_error: Array
    acceleration_error: Array
    vdot: Array
    success: bool
    status: str
    dropped_rows: int
    clipped: int
    milliseconds: float
