"""One tick of the whole-body controller, slow and obvious: the paper's steps, line by line.

Every quantity comes from a call of Drake that has its name, tasks are met by the recursion of
null-space projections, and the program (49) is solved as it is printed, base rows included.
"""

import numpy as np
from pydrake.multibody.tree import JacobianWrtVariable
from pydrake.solvers import ClarabelSolver, MathematicalProgram

from drake_linefoot.wbc.tasks.task import TaskRows
from studies.paper.two_point import recursive_acceleration
from tests.helpers.walking import ground_cone

kV = JacobianWrtVariable.kV


def slow_torque(humanoid, p, x, targets, plan):
    """Torques before their limits, and whether a cone is active; `p` are the parameters."""
    plant, context = humanoid.plant, humanoid.plant.CreateDefaultContext()
    plant.SetPositionsAndVelocities(context, x)
    M, Cv = plant.CalcMassMatrix(context), plant.CalcBiasTerm(context)
    tau_g = plant.CalcGravityGeneralizedForces(context)
    feet = [line_rows(humanoid, context, side) for side in (0, 1)]
    sides = [side for side in (0, 1) if targets.contact[side]]
    k = interval_now(plan, targets.time)
    wrench_mpc = plan.wrench[k]
    J = np.vstack([feet[i].J for i in sides])
    damping = p.contact_velocity_gain * (J @ x[humanoid.nq :])
    tasks = [TaskRows(J, -damping - np.hstack([feet[i].b for i in sides]))]
    tasks.append(momentum_rows(humanoid, context, plan, targets.time, k))
    for side in np.flatnonzero(targets.swings):
        tasks.append(swing_rows(p, x[humanoid.nq :], feet[side], targets.swing_target(side)))
    rows = np.eye(humanoid.nv)[humanoid.arm_v]
    q_arm, v_arm = x[humanoid.arm_q], x[humanoid.nq + humanoid.arm_v]
    wanted = humanoid.q_nominal[humanoid.arm_q] - q_arm
    tasks.append(TaskRows(rows, p.arm_position_gain * wanted - p.arm_velocity_gain * v_arm))
    vdot = recursive_acceleration(M, tasks)
    delta_f, wrench, active = program(
        humanoid, p, M, Cv, tau_g, vdot, feet, sides, wrench_mpc, targets.slope
    )
    vdot[:6] += delta_f
    outer = sum(feet[i].J.T @ wrench[k] for k, i in enumerate(sides))
    return (M @ vdot + Cv - tau_g - outer)[humanoid.actuated_v], active


class line_rows:  # noqa: N801  a record
    """Jacobian (51), bias, place and motion of a contact line."""

    def __init__(self, humanoid, context, side):
        plant, frame, p_FC = humanoid.plant, humanoid.foot_frames[side], humanoid.p_FC[side]
        W = plant.world_frame()
        X_WF = frame.CalcPoseInWorld(context)
        along = X_WF.rotation().col(0)
        level = np.cross([0.0, 0.0, 1.0], along)
        level /= np.linalg.norm(level)
        self.R = np.column_stack([along, level, np.cross(along, level)])
        self.p = X_WF @ p_FC
        J = plant.CalcJacobianSpatialVelocity(context, kV, frame, p_FC, W, W)
        bias = plant.CalcBiasSpatialAcceleration(context, kV, frame, p_FC, W, W)
        self.J6 = J
        self.J = np.vstack([J[3:], self.R[:, 1:].T @ J[:3]])
        self.b = np.hstack([bias.translational(), self.R[:, 1:].T @ bias.rotational()])


def interval_now(plan, t):
    """The interval of the plan that contains `t`."""
    return max(i for i in range(len(plan.wrench)) if i == 0 or plan.times[i] <= t + 1e-9)


def momentum_rows(humanoid, context, plan, t, k):
    """(52), (53) with zero gains: the rate of momentum is what the plan's wrenches make."""
    plant, W = humanoid.plant, humanoid.plant.world_frame()
    A_l = humanoid.mass * plant.CalcJacobianCenterOfMassTranslationalVelocity(context, kV, W, W)
    bias_l = humanoid.mass * plant.CalcBiasCenterOfMassTranslationalAcceleration(context, kV, W, W)
    r = plant.CalcCenterOfMassPositionInWorld(context) - plant.GetPositions(context)[4:7]
    M, Cv = plant.CalcMassMatrix(context), plant.CalcBiasTerm(context)
    A_L = M[:3] - np.cross(r, M[3:6], axisb=0).T  # about the CoM
    bias_L = Cv[:3] - np.cross(r, Cv[3:6])
    force = plan.wrench[k, :, :3].sum(axis=0)
    tau = min(t, plan.times[-1]) - plan.times[k]
    gravity = np.array([0.0, 0.0, -9.81])
    com = plan.states[k, :3] + plan.states[k, 3:6] * tau
    com = com + 0.5 * tau**2 * (gravity + force / humanoid.mass)
    L_dot = np.zeros(3)
    for side in (0, 1):
        w, R = plan.wrench[k, side], plan.R_WC[k, side]
        L_dot += np.cross(plan.p_WC[k, side] - com, w[:3]) + R[:, 1] * w[3] + R[:, 2] * w[4]
    wanted = np.hstack([L_dot, humanoid.mass * gravity + force])
    return TaskRows(np.vstack([A_L, A_l]), wanted - np.hstack([bias_L, bias_l]))


def swing_rows(p, v, foot, target):
    """Position and direction of the swing foot's line, with gains."""
    V = foot.J6 @ v
    linear = target.a_WC + p.swing_velocity_gain * (target.v_WC - V[3:])
    linear += p.swing_position_gain * (target.p_WC - foot.p)
    angular = target.alpha_W + p.swing_velocity_gain * (target.w_W - V[:3])
    angular += p.swing_position_gain * np.cross(foot.R[:, 0], target.d_W)
    return TaskRows(foot.J, np.hstack([linear, foot.R[:, 1:].T @ angular]) - foot.b)


def program(humanoid, p, M, Cv, tau_g, vdot, feet, sides, wrench_mpc, slope):
    """(49): errors of base acceleration and wrenches, the base rows as equations.

    First without the cones, by its KKT system; only when that leaves one is a solver asked.
    """
    n = 6 + 5 * len(sides)
    missing = (M @ vdot + Cv - tau_g)[:6]
    rows = np.hstack([M[:6, :6], *(-feet[i].J[:, :6].T for i in sides)])
    for i in sides:
        missing = missing - feet[i].J[:, :6].T @ wrench_mpc[i]
    Q1 = [p.force_error_weight] * 3 + [p.torque_error_weight] * 2
    Q2 = [p.angular_acceleration_error_weight] * 3 + [p.acceleration_error_weight] * 3
    Q = 2.0 * np.diag(Q2 + Q1 * len(sides))
    KKT = np.block([[Q, rows.T], [rows, np.zeros((6, 6))]])
    z = np.linalg.solve(KKT, np.hstack([np.zeros(n), -missing]))[:n]
    desired = np.array([wrench_mpc[i] for i in sides])
    cones = [ground_cone(p.friction, humanoid.half_length, feet[i].R, slope[i]) for i in sides]
    wrench = desired + z[6:].reshape(-1, 5)
    if max(float((W @ w).max()) for W, w in zip(cones, wrench, strict=True)) <= 0.0:
        return z[:6], wrench, False
    prog = MathematicalProgram()
    f, d = prog.NewContinuousVariables(6), prog.NewContinuousVariables(len(sides), 5)
    unknowns = np.hstack([f, d.ravel()])
    prog.AddLinearEqualityConstraint(rows, -missing, unknowns)
    prog.AddQuadraticCost(Q, np.zeros(n), unknowns, True)
    for W, u, dk in zip(cones, desired, d, strict=True):
        prog.AddLinearConstraint(W, np.full(6, -np.inf), -W @ u, dk)
    result = ClarabelSolver().Solve(prog)
    return result.GetSolution(f), desired + result.GetSolution(d), True
