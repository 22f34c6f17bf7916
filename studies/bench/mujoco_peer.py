"""MuJoCo's step of the same robot on the same states: what the plant itself costs elsewhere."""

import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from drake_linefoot.constants import GRAVITY
from drake_linefoot.lab.scenario import Scenario
from drake_linefoot.lab.scenario.scene import scene_of
from drake_linefoot.robot.humanoid import Humanoid
from studies.bench.loops import STEPS, time_of
from studies.common.models import read
from studies.common.recorder import Tick
from studies.common.types import Array


class MujocoStep:
    """Steps of the robot in MuJoCo, from its URDF, on a plane.

    Contacts are MuJoCo's: friction is the scene's, softness its default. Joints have the limits of
    the URDF and the reflected inertias of our plant.
    """

    def __init__(self, humanoid: Humanoid, scenario: Scenario) -> None:
        """Make the model.

        Raises:
            ImportError: there is no MuJoCo.
        """
        import mujoco

        self._mujoco, self._humanoid = mujoco, humanoid
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "robot.urdf"
            made = read(humanoid.description.model, "visual")
            for shape in made.iter("collision"):
                shape.attrib.pop("name", None)  # left and right have the same
            made.write(file, encoding="utf-8")
            spec = mujoco.MjSpec.from_file(str(file))
        spec.option.gravity, spec.option.timestep = GRAVITY, scenario.plant.time_step
        spec.body(humanoid.description.floating_base).add_freejoint()
        spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=[0.0, 0.0, 1.0])
        for geom in spec.geoms:
            geom.friction[0] = scene_of(scenario).friction
        plant, names = humanoid.plant, humanoid.description.actuated_joints
        for i in plant.GetJointActuatorIndices():
            motor = plant.get_joint_actuator(i)
            spec.joint(motor.joint().name()).armature = motor.default_reflected_inertia()
        self._model = spec.compile()
        self._data = mujoco.MjData(self._model)
        joints = [self._model.joint(name) for name in names]
        self._q, self._v = (
            np.array([int(address[0]) for address in addresses])
            for addresses in ([j.qposadr for j in joints], [j.dofadr for j in joints])
        )

    def about(self) -> dict[str, Any]:
        """Return version, what is measured, and by which share the mass matrices differ."""
        h = self._humanoid
        return {
            "version": self._mujoco.__version__,
            "how": "mj_step of the same URDF, its own contacts and integrator",
            "mass_matrix_difference": self.mass_matrix_difference(h.x_nominal),
        }

    def batch(self, ticks: Sequence[Tick]) -> list[float]:
        """Return the time of one step [s], from each state, its torque held for `STEPS` steps."""
        step, model, data = self._mujoco.mj_step, self._model, self._data
        times = []
        for tick in ticks:
            self._place(tick.before.x)
            data.qfrc_applied[self._v] = tick.torque
            times.append(time_of(lambda: step(model, data, STEPS)) / STEPS)
        return times

    def mass_matrix_difference(self, x: Array) -> float:
        """Return the largest difference of the mass matrices over the largest entry.

        `x` is the state in Drake's order, shape (nq + nv,).
        """
        h, mujoco = self._humanoid, self._mujoco
        self._place(x)
        mujoco.mj_forward(self._model, self._data)
        theirs = np.zeros((self._model.nv, self._model.nv))
        mujoco.mj_fullM(self._model, self._data, theirs)
        context = h.plant.CreateDefaultContext()
        h.plant.SetPositionsAndVelocities(context, x)
        R, T = Rotation.from_quat(x[:4], scalar_first=True).as_matrix(), np.zeros_like(theirs)
        T[:3, 3:6], T[3:6, :3] = R, np.eye(3)  # of Drake's velocities by MuJoCo's
        T[h.actuated_v, self._v] = 1.0
        ours = T.T @ h.plant.CalcMassMatrix(context) @ T
        return float(np.abs(theirs - ours).max() / np.abs(ours).max())

    def _place(self, x: Array) -> None:
        """Set the state, as MuJoCo has it: position before quaternion, Omega in B."""
        h, data = self._humanoid, self._data
        self._mujoco.mj_resetData(self._model, data)
        v = x[h.nq :]
        data.qpos[:7] = *x[4:7], *x[:4]
        R = Rotation.from_quat(x[:4], scalar_first=True)
        data.qvel[:6] = *v[3:6], *R.inv().apply(v[:3])
        data.qpos[self._q], data.qvel[self._v] = x[h.actuated_q], v[h.actuated_v]
