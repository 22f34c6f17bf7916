"""A robot in a user's own MJCF, on a ground of its own, to be walked by the controller."""

from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from pydrake.math import RigidTransform

from drake_linefoot.errors import ScenarioError
from drake_linefoot.lab.plants.mujoco_model import add_motors, forgive
from drake_linefoot.lab.scenario import Scenario
from drake_linefoot.robot.humanoid import Humanoid

ENTRY = "plant.mujoco.mjcf"


def spec_of_file(humanoid: Humanoid, scenario: Scenario) -> Any:
    """Return an MjSpec of the file that a scenario names, with what the controller needs changed.

    Contacts, solver, joints and ground are the file's. Its actuators make way for a motor of each
    joint of the description, in the order of torques; joints that the description locks are welded;
    the time step is the scenario's.

    Raises:
        ScenarioError: the file cannot be read, or a joint of the description is not in it; the
            scenario has a ground or a model error of its own, which the file cannot take.
    """
    file = Path(str(scenario.plant.mujoco.mjcf))
    if scenario.error.changes_the_model:
        raise ScenarioError("scenario", "error", scenario.error, f"must change nothing of {file}")
    try:
        spec = mujoco.MjSpec.from_file(str(file))
        model = spec.compile()
    except (ValueError, FileNotFoundError) as error:
        allowed = f"MuJoCo refuses it: {' '.join(str(error).split())}"
        raise ScenarioError("scenario", ENTRY, str(file), allowed) from error
    for key in (*spec.keys, *spec.actuators):
        spec.delete(key)
    for name in (*humanoid.description.actuated_joints, *map(str, humanoid.description.lock)):
        if mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_JOINT, name) < 0:
            raise ScenarioError("scenario", ENTRY, str(file), f"must have the joint {name}")
    for name, angle in humanoid.description.lock.items():
        _weld(spec, model, str(name), float(angle))
    add_motors(spec, humanoid)
    spec.option.timestep = scenario.period
    forgive(spec)
    return spec


def pose_of_base(humanoid: Humanoid, model: Any) -> RigidTransform:
    """Return the pose of B in the body of a model that floats, which Drake knows by its name.

    Raises:
        ModelError: nothing floats, or the controller's model has no body of its name.
    """
    d, free = humanoid.description, np.flatnonzero(model.jnt_type == mujoco.mjtJoint.mjJNT_FREE)
    name = model.body(int(model.jnt_bodyid[free[0]])).name if len(free) else ""
    if not humanoid.names.has_body(name):
        raise d.refuse("model", name, "floats in MuJoCo: must be a body of the controller's model")
    frame = humanoid.names.body(name).body_frame()
    return humanoid.base.body_frame().CalcPose(humanoid.scratch, frame)


def _weld(spec: Any, model: Any, name: str, angle: float) -> None:
    """Hold a joint at an angle for good: turn, or shift, its body and take the joint away."""
    joint, known = spec.joint(name), model.joint(name)
    at = int(known.bodyid[0])
    body, axis, anchor = joint.parent, known.axis, known.pos
    quaternion, turn, after = np.array(model.body_quat[at]), np.zeros(4), np.zeros(4)
    before, moved = np.zeros(3), np.zeros(3)
    if known.type[0] == mujoco.mjtJoint.mjJNT_SLIDE:
        mujoco.mju_rotVecQuat(moved, angle * axis, quaternion)
        body.pos = model.body_pos[at] + moved
    else:
        mujoco.mju_axisAngle2Quat(turn, axis, angle)
        mujoco.mju_mulQuat(after, quaternion, turn)
        mujoco.mju_rotVecQuat(before, anchor, quaternion)
        mujoco.mju_rotVecQuat(moved, anchor, after)
        body.pos, body.quat = model.body_pos[at] + before - moved, after
        body.alt.type = mujoco.mjtOrientation.mjORIENTATION_QUAT
    spec.delete(joint)
