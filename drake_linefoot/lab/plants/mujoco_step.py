"""A step in MuJoCo as a LeafSystem."""

import math
import warnings
from collections.abc import Callable
from functools import partial

import mujoco
import numpy as np
from pydrake.systems.framework import BasicVector, Context, State

from drake_linefoot.constants import GRAVITY
from drake_linefoot.lab.plants.mujoco_robot import STATE, MujocoRobot
from drake_linefoot.leaf_system import Block, weak
from drake_linefoot.math.linear import all_finite
from drake_linefoot.math.rotation import cross, from_quaternion
from drake_linefoot.types import Array

CONTACTS = 32  # of feet that are seen at once; each sphere has one, or a few at edges of boxes
EACH = 8  # numbers of a contact: side, force, point, speed
_LOST = tuple(
    int(getattr(mujoco.mjtWarning, f"mjWARN_BAD{what}")) for what in ("QPOS", "QVEL", "QACC")
)  # after which MuJoCo puts the robot back to where its model has it


def _say(text: str) -> None:
    """Pass on what MuJoCo warns of, in one line."""
    warnings.warn(f"MuJoCo: {' '.join(text.split())}", RuntimeWarning, stacklevel=2)


class MujocoStep(Block):
    """Steps a robot in MuJoCo.

    .. pydrake_system::

        name: MujocoStep
        input_ports:
        - actuation
        - push
        output_ports:
        - state
        - net_actuation
        - angular_velocity
        - specific_force
        - contacts

    All is in the Context: MuJoCo's state with its warm start, and what the last step has led to.
    The step is an unrestricted update, as Drake's of a discrete plant, and so comes before the
    discrete updates of a tick; they see the state behind it. The accelerometer has the change of
    velocity over a step; `contacts` has those of the feet at the beginning of it.
    """

    def __init__(self, robot: MujocoRobot, start: Array) -> None:
        """Declare ports, state and event; nothing else may use `robot`'s data meanwhile.

        Args:
            robot: what is simulated.
            start: state [q, v] of a default context, shape (nq + nv,).
        """
        super().__init__()
        if mujoco.get_mju_user_warning() is None:  # which would write MUJOCO_LOG.TXT
            mujoco.set_mju_user_warning(_say)
        self.set_name("plant")
        self.robot, humanoid = robot, robot.humanoid
        model, na = robot.model, humanoid.na
        self._torso = self._torso_in_base()
        self._feet = _feet_of_geoms(robot)
        self._spans = np.cumsum([humanoid.nq + humanoid.nv, na, 3])
        torque = self.DeclareVectorInputPort("actuation", na)
        push = self.DeclareVectorInputPort("push", 3)
        self._in = torque, push
        for group in self._states_of(start):
            self.DeclareDiscreteState(group)
        sizes = np.diff([0, *self._spans, self._spans[-1] + CONTACTS * EACH])
        given = "state", "net_actuation", "specific_force", "contacts"
        calcs: dict[str, Callable[..., None]] = {}
        calcs |= {name: partial(weak(self, self._give), i) for i, name in enumerate(given)}
        calcs["angular_velocity"] = weak(self, self._calc_gyro)
        for (name, calc), size in zip(calcs.items(), [*sizes, 3], strict=True):
            tickets = {self.xd_ticket()}
            self.DeclareVectorOutputPort(name, int(size), calc, prerequisites_of_calc=tickets)
        self.DeclarePeriodicUnrestrictedUpdateEvent(
            float(model.opt.timestep), 0.0, weak(self, self._step)
        )

    def put(self, context: Context, x: Array) -> None:
        """Put the robot into the state [q, v] in a context; without a warm start."""
        groups = self._states_of(x)
        for i, group in enumerate(groups):
            context.SetDiscreteState(i, group)

    def _states_of(self, x: Array) -> tuple[Array, Array]:
        """Return MuJoCo's state of a robot in the state [q, v], and what a step says of one."""
        robot = self.robot
        mujoco.mj_resetData(robot.model, robot.data)
        robot.put(x)
        felt = -from_quaternion(x[:4] / np.linalg.norm(x[:4])).T @ GRAVITY
        rest = np.zeros(robot.humanoid.na), felt, np.zeros(CONTACTS * EACH)
        return self._state(), np.concatenate([robot.taken(), *rest])

    def _state(self) -> Array:
        state = np.empty(self.robot.size)
        mujoco.mj_getState(self.robot.model, self.robot.data, state, STATE)
        return state

    def _torso_in_base(self) -> Array:
        """Return the nominal centre of mass of the torso in B [m], shape (3,)."""
        humanoid = self.robot.humanoid
        frame = humanoid.torso.body_frame()
        X_BT = frame.CalcPose(humanoid.scratch, humanoid.base.body_frame())
        p: Array = X_BT @ humanoid.torso.default_com()
        return p

    def _step(self, context: Context, state: State) -> None:
        robot, (torque, push) = self.robot, self._in
        model, data = robot.model, robot.data
        ctrl = torque.Eval(context)
        if not all_finite(ctrl):
            raise RuntimeError("Detected NaN in the actuation")  # the words of Drake's plant
        mujoco.mj_setState(model, data, context.get_discrete_state(0).value(), STATE)
        data.ctrl[robot.motors] = ctrl
        x = self._part(context, 0)
        force = push.Eval(context) if push.HasValue(context) else np.zeros(3)
        data.xfrc_applied[robot.base] = self.wrench(x, force)
        mujoco.mj_step(model, data)
        self._check()
        after, h = robot.taken(), robot.humanoid
        v = slice(h.nq + 3, h.nq + 6)
        rate = (after[v] - x[v]) / float(model.opt.timestep) - GRAVITY
        felt = from_quaternion(after[:4]).T @ rate
        applied = data.qfrc_actuator[robot.dofs]
        state.get_mutable_discrete_state(0).SetFromVector(self._state())
        last = np.concatenate([after, applied, felt, self._contacts()])
        state.get_mutable_discrete_state(1).SetFromVector(last)

    def _check(self) -> None:
        """Raise RuntimeError when the step has led to numbers that MuJoCo does not go on from."""
        found = False
        for kind in _LOST:
            found |= self.robot.data.warning[kind].number > 0
            self.robot.data.warning[kind].number = 0
        if found:
            raise RuntimeError("MuJoCo's step did not converge: numbers beyond all bounds")

    def wrench(self, x: Array, force: Array) -> Array:
        """Return force and torque at the centre of mass of the base [N, N m], shape (6,).

        Args:
            x: state.
            force: on the torso in W [N], shape (3,).
        """
        robot = self.robot
        if not force.any():
            return np.zeros(6)
        mujoco.mj_kinematics(robot.model, robot.data)
        at = x[4:7] + from_quaternion(x[:4]) @ self._torso
        arm = at - robot.data.xipos[robot.base]
        return np.concatenate([force, cross(arm, force)])

    def _contacts(self) -> Array:
        """Return the contacts of feet in the last step, as they travel; side 0 is none."""
        model, data = self.robot.model, self.robot.data
        rows, force, n = np.zeros((CONTACTS, EACH)), np.empty(6), 0
        seen = data.contact
        geoms, places, axes, rows_of = seen.geom, seen.pos, seen.frame, seen.efc_address
        for k in range(data.ncon):
            first, second = self._feet[geoms[k]]
            if not (first or second) or rows_of[k] < 0 or n == CONTACTS:
                continue
            mujoco.mj_contactForce(model, data, k, force)
            # MuJoCo's force is that on the second; a contact of both feet counts for it.
            rows[n, 0] = second or -first
            rows[n, 1:4], rows[n, 4:7] = force[:3] @ axes[k].reshape(3, 3), places[k]
            rows[n, 7] = math.hypot(*self._slip(seen.friction[k], int(rows_of[k])))
            n += 1
        return rows.ravel()

    def _slip(self, friction: Array, row: int) -> tuple[float, float]:
        """Return the velocity along both tangents [m/s] of a contact whose rows begin at `row`."""
        velocity = self.robot.data.efc_vel
        if self.robot.model.opt.cone == mujoco.mjtCone.mjCONE_ELLIPTIC:
            return velocity[row + 1], velocity[row + 2]
        # An edge of the pyramid moves as the normal and its tangent times the friction do.
        first, back, second, right = velocity[row : row + 4]
        return 0.5 * (first - back) / friction[0], 0.5 * (second - right) / friction[1]

    def _part(self, context: Context, index: int) -> Array:
        """Return a part of what the last step has led to."""
        at = self._spans
        begin, end = (0, *at)[index], (*at, None)[index]
        part: Array = context.get_discrete_state(1).value()[begin:end]
        return part

    def _calc_gyro(self, context: Context, output: BasicVector) -> None:
        x, nq = self._part(context, 0), self.robot.humanoid.nq
        output.SetFromVector(from_quaternion(x[:4]).T @ x[nq : nq + 3])

    def _give(self, index: int, context: Context, output: BasicVector) -> None:
        output.SetFromVector(self._part(context, index))


def _feet_of_geoms(robot: MujocoRobot) -> Array:
    """Return 1 for what is of the left foot, 2 for the right one, 0 for others, by geometry."""
    model, feet, humanoid = robot.model, np.zeros(robot.model.ngeom), robot.humanoid
    for side, foot in enumerate(humanoid.description.feet):
        joint = model.joint(foot.leg_joints[-1])
        moved = model.body_weldid[model.geom_bodyid] == model.jnt_bodyid[joint.id]
        feet[moved] = 1.0 + side
    return feet
