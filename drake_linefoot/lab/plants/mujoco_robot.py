"""A robot in a model of MuJoCo: where its joints are there, and whether it weighs the same."""

from typing import Any, NamedTuple

import mujoco
import numpy as np
from pydrake.math import RigidTransform
from pydrake.systems.framework import Context

from drake_linefoot.errors import ModelError
from drake_linefoot.math.compiled import compiled
from drake_linefoot.math.rotation import cross, from_quaternion
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.types import Array

STATE = mujoco.mjtState.mjSTATE_FULLPHYSICS.value | mujoco.mjtState.mjSTATE_WARMSTART.value
UNLIKE = 1e-3  # [-] by which a mass or an inertia may differ from the controller's
POSTURES = 3  # at which mass matrices are compared


class Places(NamedTuple):
    """Where MuJoCo has what is in a state.

    Attributes:
        base_q, base_v: where the position of the body that floats and its velocity begin.
        joints_q, joints_v: where positions and velocities of the joints are, shape (na,).
        actuated_q, actuated_v: where they are in q and v, shape (na,).
        turn: from B to the body that floats, a quaternion.
        p_TB: from it to B, in its axes [m], shape (3,).
        nq, nv: sizes of a state.
    """

    base_q: int
    base_v: int
    joints_q: Array
    joints_v: Array
    actuated_q: Array
    actuated_v: Array
    turn: Array
    p_TB: Array
    nq: int
    nv: int


class MujocoRobot:
    """A humanoid in a compiled model.

    MuJoCo's free joint has the position before the quaternion, and an angular velocity in the axes
    of the body that floats.

    Attributes:
        model, data: MuJoCo's; `data` is scratch.
        size: of a state of MuJoCo with its warm start, `STATE`.
        base: which body floats.
        motors: which actuators drive the joints of the description, shape (na,).
        dofs: where those are among MuJoCo's velocities, shape (na,).
    """

    def __init__(self, humanoid: Humanoid, model: Any, X_TB: RigidTransform | None = None) -> None:
        """Find the joints of the description and their motors.

        Args:
            humanoid: the robot.
            model: MjModel with it.
            X_TB: pose of B in the body of the model that floats; None where that is B.

        Raises:
            ModelError: nothing floats, or a joint or its motor is missing.
        """
        self.humanoid, self.model, self.data = humanoid, model, mujoco.MjData(model)
        self.size = int(mujoco.mj_stateSize(model, STATE))
        X_TB = X_TB or RigidTransform()
        turn, p_TB = X_TB.rotation().ToQuaternion().wxyz(), X_TB.translation()
        refuse = humanoid.description.refuse
        free = np.flatnonzero(model.jnt_type == mujoco.mjtJoint.mjJNT_FREE)
        if len(free) != 1:
            raise refuse("model", f"{len(free)} free joints", "MuJoCo's model must have one")
        self.base = int(model.jnt_bodyid[free[0]])
        joints, motors = list[int](), list[int]()
        for name in humanoid.description.actuated_joints:
            joint = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_JOINT, name)
            drives = np.flatnonzero(
                (model.actuator_trnid[:, 0] == joint)
                & (model.actuator_trntype == mujoco.mjtTrn.mjTRN_JOINT)
            )
            if joint < 0 or len(drives) != 1:
                raise refuse("model", name, "MuJoCo's model must have a joint and a motor of it")
            joints.append(joint)
            motors.append(int(drives[0]))
        self.motors = np.array(motors)
        self.dofs = model.jnt_dofadr[joints]
        self._places = Places(
            int(model.jnt_qposadr[free[0]]),
            int(model.jnt_dofadr[free[0]]),
            model.jnt_qposadr[joints],
            self.dofs,
            humanoid.actuated_q,
            humanoid.actuated_v,
            turn,
            np.ascontiguousarray(p_TB),
            humanoid.nq,
            humanoid.nv,
        )

    def put(self, x: Array) -> None:
        """Put a state [q, v], shape (nq + nv,), into `data`; its quaternion becomes a unit one."""
        data, p = self.data, self._places
        q, v = x[: p.nq], x[p.nq :]
        at, moves = p.base_q, p.base_v
        turned = data.qpos[at + 3 : at + 7]
        mujoco.mju_mulQuat(turned, q[:4] / np.linalg.norm(q[:4]), p.turn * [1.0, -1.0, -1.0, -1.0])
        R_WT = from_quaternion(turned)
        p_BT_W = -R_WT @ p.p_TB
        data.qpos[at : at + 3] = q[4:7] + p_BT_W
        data.qvel[moves : moves + 3] = v[3:6] + cross(v[:3], p_BT_W)
        data.qvel[moves + 3 : moves + 6] = R_WT.T @ v[:3]
        data.qpos[p.joints_q], data.qvel[p.joints_v] = q[p.actuated_q], v[p.actuated_v]

    def taken(self) -> Array:
        """Return the state [q, v] that is in `data`, shape (nq + nv,)."""
        return state_of(self.data.qpos, self.data.qvel, self._places)

    def mass_matrix(self, x: Array) -> Array:
        """Return MuJoCo's mass matrix for Drake's velocities, shape (nv, nv).

        Args:
            x: state [q, v], shape (nq + nv,).
        """
        model, data, h = self.model, self.data, self.humanoid
        mujoco.mj_resetData(model, data)
        self.put(x)
        mujoco.mj_fwdPosition(model, data)
        M = np.zeros((model.nv, model.nv))
        mujoco.mj_fullM(model, data, M)
        T = np.zeros((model.nv, h.nv))  # of MuJoCo's velocities by Drake's
        for i in range(h.nv):
            self.put(np.concatenate([x[: h.nq], np.eye(h.nv)[i]]))
            T[:, i] = data.qvel
        product: Array = T.T @ M @ T
        return product


@compiled
def state_of(qpos: Array, qvel: Array, places: Places) -> Array:
    """Return the state [q, v] that is in MuJoCo's positions and velocities, shape (nq + nv,)."""
    at, moves, nq = places.base_q, places.base_v, places.nq
    x, a, b = np.empty(nq + places.nv), qpos[at + 3 : at + 7], places.turn
    R = from_quaternion(a)
    p, w = R @ places.p_TB, R @ qvel[moves + 3 : moves + 6]
    x[0] = a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3]
    x[1] = a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2]
    x[2] = a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1]
    x[3] = a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0]
    x[4:7] = qpos[at : at + 3] + p
    x[nq : nq + 3], x[nq + 3 : nq + 6] = w, qvel[moves : moves + 3] + cross(w, p)
    for k in range(len(places.joints_q)):
        x[places.actuated_q[k]] = qpos[places.joints_q[k]]
        x[nq + places.actuated_v[k]] = qvel[places.joints_v[k]]
    return x


def check_same_robot(robot: MujocoRobot, context: Context) -> None:
    """Check that MuJoCo's robot is the one of the controller.

    Their mass matrices are compared at random postures.

    Args:
        robot: in MuJoCo.
        context: of the humanoid's own plant, for masses and inertias.

    Raises:
        ModelError: mass, reflected inertia or a link differs; the message names it.
    """
    h, random = robot.humanoid, np.random.default_rng(0)
    for _ in range(POSTURES):
        x = h.x_nominal
        x[h.actuated_q] = random.uniform(h.position_lower, h.position_upper)
        h.plant.SetPositionsAndVelocities(context, x)
        theirs, ours = robot.mass_matrix(x), h.plant.CalcMassMatrix(context)
        wrong = difference(h, theirs, ours, robot.model.dof_armature[robot.dofs])
        if wrong is not None:
            raise wrong


def difference(
    humanoid: Humanoid, theirs: Array, ours: Array, armature: Array
) -> ModelError | None:
    """Return an error that names how a robot differs from the controller's; None when it does not.

    Args:
        humanoid: the robot.
        theirs: mass matrix in MuJoCo, shape (nv, nv).
        ours: mass matrix of the controller's model, shape (nv, nv).
        armature: reflected inertias in MuJoCo [kg m^2, kg], shape (na,).
    """
    d = humanoid.description
    size = np.sqrt(np.outer(np.diag(ours), np.diag(ours)))
    if (np.abs(theirs - ours) <= UNLIKE * size).all():
        return None
    if abs(theirs[3, 3] - ours[3, 3]) > UNLIKE * ours[3, 3]:
        mass = f"{theirs[3, 3]:.4g} kg in MuJoCo"
        return d.refuse("model", mass, f"the controller's robot weighs {ours[3, 3]:.4g} kg")
    # What a joint moves is all that hangs on it: the link that differs is at the last such joint.
    wrong = np.abs(np.diag(theirs - ours)) > UNLIKE * np.diag(ours)
    for name, at, rotor in reversed(
        [*zip(d.actuated_joints, humanoid.actuated_v, armature, strict=True)]
    ):
        if wrong[at]:
            values = f"{theirs[at, at]:.4g} in MuJoCo, {ours[at, at]:.4g} in the controller's model"
            if rotor == 0.0:
                allowed = f"joint has no reflected inertia (armature) in MuJoCo: it moves {values}"
            else:
                allowed = f"joint moves a link of another inertia: {values}"
            return d.refuse("model", name, allowed)
    return d.refuse("model", d.floating_base, "body of another inertia, or hinges in other places")
