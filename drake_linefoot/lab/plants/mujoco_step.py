"""A step in MuJoCo as a LeafSystem."""

import math
import warnings
from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import mujoco
import numpy as np
from pydrake.systems.framework import BasicVector, Context, State

from drake_linefoot.constants import GRAVITY
from drake_linefoot.lab.plants.mujoco_robot import STATE, MujocoRobot
from drake_linefoot.leaf_system import Block, weak
from drake_linefoot.math.compiled import compiled
from drake_linefoot.math.linear import all_finite
from drake_linefoot.math.rotation import cross, from_quaternion
from drake_linefoot.types import Array

CONTACTS = 32  # of feet that are seen at once; each sphere has one, or a few at edges of boxes
EACH = 8  # numbers of a contact: side, force, point, speed
_ELLIPTIC = int(mujoco.mjtCone.mjCONE_ELLIPTIC)
_LOST = np.array(
    [int(getattr(mujoco.mjtWarning, f"mjWARN_BAD{what}")) for what in ("QPOS", "QVEL", "QACC")]
)  # after which MuJoCo puts the robot back to where its model has it


class Contacts(NamedTuple):
    """The n contacts of a step, as MuJoCo has them.

    Attributes:
        geoms: which two, shape (n, 2).
        places: [m], shape (n, 3).
        axes: normal and tangents, shape (n, 9).
        friction: along the tangents first, shape (n, 5).
        begins: which row of the constraints is the first one; negative without any, shape (n,).
        dims: 1 without friction, else 3 or more, shape (n,).
        forces: of all rows [N].
        speeds: likewise [m/s].
    """

    geoms: Array
    places: Array
    axes: Array
    friction: Array
    begins: Array
    dims: Array
    forces: Array
    speeds: Array


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
        number = self.robot.data.warning.number
        if number[_LOST].any():
            number[_LOST] = 0
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
        if not data.ncon:
            return np.zeros(CONTACTS * EACH)
        c, rows = data.contact, (data.efc_force, data.efc_vel)
        parts = c.geom, c.pos, c.frame, c.friction, c.efc_address, c.dim, *rows
        seen = Contacts._make(map(np.ascontiguousarray, parts))
        return contacts_of_feet(seen, self._feet, model.opt.cone == _ELLIPTIC)

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


@compiled
def contacts_of_feet(seen: Contacts, feet: Array, elliptic: bool) -> Array:
    """Return the contacts of feet as they travel: side, force, point, speed; side 0 is none.

    Args:
        seen: all contacts of a step.
        feet: 1 for what is of the left foot, 2 for the right one, by geometry.
        elliptic: whether friction cones are, and no pyramids.
    """
    out, n, f, v = np.zeros((CONTACTS, EACH)), 0, np.zeros(3), np.zeros(2)
    for k in range(len(seen.begins)):
        first, second = feet[seen.geoms[k, 0]], feet[seen.geoms[k, 1]]
        row, dim = seen.begins[k], seen.dims[k]
        if (first == 0.0 and second == 0.0) or row < 0 or n == CONTACTS:
            continue
        forces, speeds = seen.forces[row:], seen.speeds[row:]
        if elliptic or dim == 1:
            f[0], f[1:], v[:] = forces[0], 0.0, 0.0
            if dim > 1:
                f[1:], v[:] = forces[1:3], speeds[1:3]
        else:  # an edge of the pyramid is the normal and friction times a tangent
            f[0] = forces[: 2 * (dim - 1)].sum()
            for i in range(2):
                mu = seen.friction[k, i]
                f[1 + i] = mu * (forces[2 * i] - forces[2 * i + 1])
                v[i] = 0.5 * (speeds[2 * i] - speeds[2 * i + 1]) / mu
        # MuJoCo's force is that on the second; a contact of both feet counts for it.
        out[n, 0] = second if second != 0.0 else -first
        for i in range(3):
            along = seen.axes[k, i], seen.axes[k, 3 + i], seen.axes[k, 6 + i]
            out[n, 1 + i] = f[0] * along[0] + f[1] * along[1] + f[2] * along[2]
        out[n, 4:7], out[n, 7] = seen.places[k], math.hypot(v[0], v[1])
        n += 1
    return out.ravel()


def _feet_of_geoms(robot: MujocoRobot) -> Array:
    """Return 1 for what is of the left foot, 2 for the right one, 0 for others, by geometry."""
    model, feet, humanoid = robot.model, np.zeros(robot.model.ngeom), robot.humanoid
    for side, foot in enumerate(humanoid.description.feet):
        joint = model.joint(foot.leg_joints[-1])
        moved = model.body_weldid[model.geom_bodyid] == model.jnt_bodyid[joint.id]
        feet[moved] = 1.0 + side
    return feet
