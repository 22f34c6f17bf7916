"""Centroidal quantities of the full plant, summed over its bodies.

Nothing here uses the project's Jacobians or momentum matrices: accelerations come from the
plant's inverse dynamics.
"""

import numpy as np
from pydrake.multibody.math import SpatialForce
from pydrake.multibody.tree import MultibodyForces

from drake_linefoot.math.rotation import from_quaternion, skew
from drake_linefoot.mpc.ecd import Linearisation


def inertias(humanoid, context):
    """Mass, CoM in W, rotational inertia about it in W, pose: of every body."""
    out = []
    plant = humanoid.plant
    for index in plant.GetBodyIndices(humanoid.base.model_instance()):
        body = plant.get_body(index)
        M = body.CalcSpatialInertiaInBodyFrame(context)
        X = body.EvalPoseInWorld(context)
        R = X.rotation().matrix()
        central = M.Shift(M.get_com()).CalcRotationalInertia().CopyToFullMatrix3()
        out.append((body, M.get_mass(), R @ M.get_com(), X.translation(), R @ central @ R.T))
    return out


def momentum_about(humanoid, context, point):
    """Angular momentum about a point [kg m^2/s], summed over the bodies."""
    total = np.zeros(3)
    for body, m, p, origin, J in inertias(humanoid, context):
        V = body.EvalSpatialVelocityInWorld(context)
        w, v = V.rotational(), V.translational() + np.cross(V.rotational(), p)
        total += np.cross(origin + p - point, m * v) + J @ w
    return total


def momentum_rates(humanoid, context, vdot, point):
    """Rates of linear momentum and of angular momentum about a resting point."""
    A = humanoid.plant.CalcSpatialAccelerationsFromVdot(context, vdot)
    linear, angular = np.zeros(3), np.zeros(3)
    for body, m, p, origin, J in inertias(humanoid, context):
        w = body.EvalSpatialVelocityInWorld(context).rotational()
        alpha, a_o = A[body.index()].rotational(), A[body.index()].translational()
        a = a_o + np.cross(alpha, p) + np.cross(w, np.cross(w, p))
        linear += m * a
        angular += np.cross(origin + p - point, m * a) + J @ alpha + np.cross(w, J @ w)
    return linear, angular


def contact_lines(humanoid, context):
    """Points and frames of both lines: x along the foot, y level."""
    p, R = [], []
    for frame, p_FC in zip(humanoid.foot_frames, humanoid.p_FC, strict=True):
        X = frame.CalcPoseInWorld(context)
        x = X.rotation().col(0)
        y = np.cross([0.0, 0.0, 1.0], x)
        y /= np.linalg.norm(y)
        p.append(X @ p_FC)
        R.append(np.column_stack([x, y, np.cross(x, y)]))
    return np.array(p), np.array(R)


def accelerations(humanoid, context, torque, u, external=None):
    """vdot of the full dynamics under joint torques, two line wrenches and one on the torso.

    The last is a moment about the CoM over a force, in W.
    """
    plant = humanoid.plant
    forces = MultibodyForces(plant)
    plant.CalcForceElementsContribution(context, forces)
    p, R = contact_lines(humanoid, context)
    for side, frame in enumerate(humanoid.foot_frames):
        f, tau = u[5 * side : 5 * side + 3], R[side][:, 1:] @ u[5 * side + 3 : 5 * side + 5]
        body = frame.body()
        R_WB = body.EvalPoseInWorld(context).rotation().matrix()
        # Force at the body origin with the moment of its line of action.
        moment = tau + np.cross(p[side] - body.EvalPoseInWorld(context).translation(), f)
        F_B = SpatialForce(R_WB.T @ moment, R_WB.T @ f)
        body.AddInForce(context, np.zeros(3), F_B, body.body_frame(), forces)
    if external is not None:
        R_WB = humanoid.base.EvalPoseInWorld(context).rotation().matrix()
        lever = plant.CalcCenterOfMassPositionInWorld(context)
        lever = lever - humanoid.base.EvalPoseInWorld(context).translation()
        moment = external[:3] + np.cross(lever, external[3:])
        F_B = SpatialForce(R_WB.T @ moment, R_WB.T @ external[3:])
        humanoid.base.AddInForce(context, np.zeros(3), F_B, humanoid.base.body_frame(), forces)
    M = plant.CalcMassMatrix(context)
    missing = -plant.CalcInverseDynamics(context, np.zeros(humanoid.nv), forces)
    missing[humanoid.actuated_v] += torque
    return np.linalg.solve(M, missing)


def put(humanoid, context, x):
    humanoid.plant.SetPositionsAndVelocities(context, x)
    return (
        humanoid.plant.CalcCenterOfMassPositionInWorld(context),
        humanoid.plant.CalcCenterOfMassTranslationalVelocityInWorld(context),
    )


def linearisation(humanoid, context, x):
    """The reference that a state is, as the model wants it: one interval."""
    r, v = put(humanoid, context, x)
    R = from_quaternion(x[:4])
    L = momentum_about(humanoid, context, r)
    total = np.zeros((3, 3))
    for _, m, p, origin, J in inertias(humanoid, context):
        S = skew(origin + p - r)
        total += J - m * S @ S
    w = x[humanoid.nq : humanoid.nq + 3]
    rows = (R.T @ total @ R, R, R.T @ w, L, r, v)
    return Linearisation(*(a[None] for a in rows))


def composite_inertia(humanoid, context, q):
    """Inertia of all bodies about their common CoM, in the torso frame, by the plant."""
    humanoid.plant.SetPositions(context, q)
    bodies = humanoid.plant.GetBodyIndices(humanoid.base.model_instance())
    spatial = humanoid.plant.CalcSpatialInertia(context, humanoid.base.body_frame(), bodies)
    return spatial.Shift(spatial.get_com()).CalcRotationalInertia().CopyToFullMatrix3()
