"""One tick of the whole-body controller: (49)-(53)."""

import time
from typing import Any, NamedTuple

import numpy as np

from drake_linefoot.centroidal import Trajectory, sample_plan
from drake_linefoot.math.compiled import compiled
from drake_linefoot.robot.dynamics import RobotDynamics
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.robot.size import sized
from drake_linefoot.signals import CentroidalPlan, GaitTargets, SwingTarget, WholeBodyReport
from drake_linefoot.types import Array, Indices
from drake_linefoot.wbc.joint_stops import Stops, kept_off_stops
from drake_linefoot.wbc.parameters import WbcParameters
from drake_linefoot.wbc.tasks import NO_SWING, Gains, Joints, is_swing, stacked_tasks
from drake_linefoot.wbc.torque_limits import solve_by, solve_limited, torque_rows
from drake_linefoot.wbc.wrench_qp import (
    Weights,
    WrenchProgram,
    WrenchSolver,
    solve_program,
    wrench_program,
    wrench_weights,
)


class Constants(NamedTuple):
    """What does not change from tick to tick.

    Attributes:
        mass: [kg].
        gains: of the tasks.
        arms: the joints that the legs do not use.
        stops: of the legs.
        weights: of (49).
        actuated_v: index in v of each actuator, shape (na,).
        effort_limits: symmetric [N m], shape (na,).
    """

    mass: float
    gains: Gains
    arms: Joints
    stops: Stops
    weights: Weights
    actuated_v: Indices
    effort_limits: Array


class Effort(NamedTuple):
    """What the joints do.

    Attributes:
        torque: within the limits [N m], shape (na,).
        clipped: torques that were not.
        wrench: of both feet, zero in the air [N, N m], shape (2, 5).
        wrench_error: its difference from the MPC's, delta_fr of (49), shape (2, 5).
        acceleration_error: delta_f of (49), shape (6,).
        vdot: acceleration that comes of it, shape (nv,).
    """

    torque: Array
    clipped: int
    wrench: Array
    wrench_error: Array
    acceleration_error: Array
    vdot: Array


@compiled
def joint_effort(
    d: RobotDynamics,
    vdot: Array,
    program: WrenchProgram,
    delta: Array,
    contact: tuple[bool, bool],
    c: Constants,
) -> Effort:
    """Return what the joints must give, ``M vdot + Cv - tau_g - sum J_i' w_i``.

    Args:
        d: present quantities.
        vdot: commanded acceleration, shape (nv,).
        program: (49).
        delta: corrections that solve it, shape (5 n,).
        contact: whether the left and the right foot stand.
        c: constants.
    """
    wrench, error, at = np.zeros((2, 5)), np.zeros((2, 5)), 0
    for side in range(2):
        if contact[side]:
            error[side] = delta[5 * at : 5 * at + 5]
            wrench[side] = program.u[at] + error[side]
            at += 1
    delta_f, vdot = program.G @ delta + program.c, vdot.copy()
    vdot[:6] += delta_f
    J = d.J.reshape(10, len(vdot))
    needed = d.M @ vdot + d.Cv - d.tau_g - wrench.reshape(10) @ J
    torque, clipped = np.empty(len(c.actuated_v)), 0
    for k in range(len(torque)):
        tau, limit = needed[c.actuated_v[k]], c.effort_limits[k]
        torque[k] = min(max(tau, -limit), limit)
        clipped += int(torque[k] != tau)
    return Effort(torque, clipped, wrench, error, delta_f, vdot)


@compiled
def control_tick(
    state: tuple[Any, ...], targets: tuple[Any, ...], plan: tuple[Any, ...], c: tuple[Any, ...]
) -> tuple[tuple[Any, ...], tuple[int, int, bool, bool], tuple[Array, tuple[Array, ...]]]:
    """Return a tick as far as it goes without a solver.

    Takes and returns plain tuples: a NamedTuple costs 1 us each time it comes from Python or
    goes there, and with those inside the constants there would be twelve.

    Args:
        state: `RobotDynamics`.
        targets: time [s], which feet stand, `SwingTarget`; slope, friction and grip; external: of
            `GaitTargets`.
        plan: `Trajectory` of the MPC's plan.
        c: `Constants`, with those inside as tuples, too.

    Returns:
        (effort, (dropped, active, able, found), (vdot, program)): fields of `Effort`, task rows
        that were dropped, rows of the cones that the solution touches, whether the mass matrix is
        positive definite, whether the program (49) was solved; without that the effort is not one
        to apply. The acceleration that meets the tasks, shape (nv,), and fields of `WrenchProgram`.
    """
    now, contact, target, ground, external = targets
    d, swing = RobotDynamics(*state), SwingTarget(*target)
    sample = sample_plan(Trajectory(*plan), now)
    k = Constants(c[0], Gains(*c[1]), Joints(*c[2]), Stops(*c[3]), Weights(*c[4]), c[5], c[6])
    tasks = stacked_tasks(d, contact, sample, swing, k.mass, k.gains, k.arms)
    vdot, dropped, able = kept_off_stops(d, tasks, contact, is_swing(swing), k.stops)
    p = wrench_program(d, vdot, contact, sample.wrench, ground, external, k.weights)
    delta, active, found = solve_program(p, k.weights.weight)
    e = joint_effort(d, vdot, p, delta, contact, k)
    if found and e.clipped and len(delta):
        rows = torque_rows(d, vdot, p, contact, k.actuated_v)
        delta, active, found = solve_limited(
            p, rows, delta, k.effort_limits, k.weights.slack, k.weights.weight
        )
        e = joint_effort(d, vdot, p, delta, contact, k)
    effort = e.torque, e.clipped, e.wrench, e.wrench_error, e.acceleration_error, e.vdot
    return effort, (dropped, active, able, found), (vdot, (p.H, p.g, p.W, p.u, p.G, p.c))


class WholeBodyControl:
    """State and plans in, joint torques out: (49)-(53).

    Attributes:
        constants: what does not change from tick to tick.
        solver: of programs (49) that the active-set method leaves.
    """

    def __init__(self, humanoid: Humanoid, parameters: WbcParameters) -> None:
        """Keep the robot.

        Args:
            humanoid: the robot.
            parameters: gains and weights.

        Raises:
            InputError: the parameters name an unknown solver.
        """
        p, h = sized(parameters, humanoid), humanoid
        self.solver = WrenchSolver(p, h.mass, h.half_length)
        gains = Gains(
            p.com_position_gain, p.com_velocity_gain, p.angular_momentum_gain,
            p.swing_position_gain, p.swing_velocity_gain, p.arm_position_gain,
            p.arm_velocity_gain, p.contact_velocity_gain,
        )  # fmt: skip
        self.constants = Constants(
            mass=h.mass,
            gains=Gains(*map(float, gains)),
            arms=Joints(h.arm_q, h.arm_v, h.q_nominal[h.arm_q]),
            stops=leg_stops(h, p),
            weights=wrench_weights(p, h.mass, h.half_length),
            actuated_v=h.actuated_v,
            effort_limits=h.effort_limits,
        )
        self._packed = tuple(tuple(c) if isinstance(c, tuple) else c for c in self.constants)

    def compute(
        self, dynamics: RobotDynamics, targets: GaitTargets, plan: CentroidalPlan
    ) -> WholeBodyReport:
        """Return torques and how they came about.

        Args:
            dynamics: quantities of the present state.
            targets: which feet stand, and where the swing foot should be.
            plan: the MPC's plan.

        Raises:
            numpy.linalg.LinAlgError: the mass matrix is not positive definite.
        """
        started, t = time.perf_counter(), targets
        ground = t.slope, t.friction, t.grip
        wanted = t.time, t.contact, tuple(t.swing or NO_SWING), ground, t.external
        parts, (dropped, active, able, found), (vdot, program) = control_tick(
            tuple(dynamics), wanted, tuple(plan.trajectory), self._packed
        )
        effort = Effort(*parts)
        if not able:
            raise np.linalg.LinAlgError("the mass matrix is not positive definite")
        success, status = True, f"{active} active rows"
        if not active:
            status = "unconstrained" if any(t.contact) else "flight"
        if not found:
            effort, success, status = self._solved(dynamics, t, vdot, WrenchProgram(*program))
        return WholeBodyReport(
            **effort._asdict(),
            success=success,
            status=status,
            dropped_rows=dropped,
            milliseconds=1e3 * (time.perf_counter() - started),
        )

    def _solved(
        self, d: RobotDynamics, targets: GaitTargets, vdot: Array, program: WrenchProgram
    ) -> tuple[Effort, bool, str]:
        """Return what comes of the program by the solver, or of the MPC's wrench when it fails."""
        c, contact = self.constants, targets.contact
        rows = torque_rows(d, vdot, program, contact, c.actuated_v)
        delta, success, status = solve_by(
            self.solver, program, rows, c.effort_limits, c.weights.slack
        )
        if not success:
            t, stand = targets, np.array(contact)
            ground = d.R_WC[stand], t.slope, t.friction, t.grip[stand]
            moved = self.solver.inside_cones(program.u, *ground)
            delta = (moved - program.u).ravel()
        return joint_effort(d, vdot, program, delta, contact, c), success, status


def leg_stops(humanoid: Humanoid, parameters: WbcParameters) -> Stops:
    """Return the stops of both legs, with the margin and the rate of the parameters."""
    lower, upper = np.full(humanoid.nq, -np.inf), np.full(humanoid.nq, np.inf)
    lower[humanoid.actuated_q] = humanoid.position_lower + parameters.stop_margin
    upper[humanoid.actuated_q] = humanoid.position_upper - parameters.stop_margin
    legs, p = humanoid.leg_q, parameters
    rate, pitch_length = float(p.stop_rate), float(p.pitch_length)
    return Stops(legs, humanoid.leg_v, lower[legs], upper[legs], rate, pitch_length)
