"""States, commands and plant quantities for the tests of the whole-body controller."""

import numpy as np
import pytest
from pydrake.multibody.math import SpatialForce
from pydrake.multibody.tree import MultibodyForces

from drake_linefoot.robot.dynamics import robot_dynamics
from drake_linefoot.wbc import control, wrench_qp
from tests.helpers import whole_body
from tests.helpers.walking import recorded_walk


@pytest.fixture(scope="session")
def records():
    """Ticks of a walk: standing, both feet while walking, single support."""
    return recorded_walk().wbc


@pytest.fixture(scope="session")
def dynamics_of(humanoid):
    """Robot dynamics of a state."""
    context = humanoid.plant.CreateDefaultContext()
    return lambda x: robot_dynamics(humanoid, context, x)


class FullPlant:
    """The plant itself, asked without any of the project's Jacobians or matrices."""

    def __init__(self, humanoid):
        self.humanoid = humanoid
        self.plant = self.humanoid.plant
        self.context = self.plant.CreateDefaultContext()

    def put(self, x):
        self.plant.SetPositionsAndVelocities(self.context, x)
        return self

    def line(self, side):
        """Middle, axes (x along the foot, y level, z) of a contact line."""
        X = self.humanoid.foot_frames[side].CalcPoseInWorld(self.context)
        x = X.rotation().col(0)
        y = np.cross([0.0, 0.0, 1.0], x)
        y /= np.linalg.norm(y)
        return X @ self.humanoid.p_FC[side], np.column_stack([x, y, np.cross(x, y)])

    def line_velocity(self, side):
        """Velocity of the middle and angular velocity of the foot, in W."""
        frame = self.humanoid.foot_frames[side]
        V = frame.CalcSpatialVelocityInWorld(self.context)
        arm = self.line(side)[0] - frame.CalcPoseInWorld(self.context).translation()
        return V.translational() + np.cross(V.rotational(), arm), V.rotational()

    def line_acceleration(self, side, vdot):
        """Acceleration of the middle and angular acceleration of the foot, in W."""
        frame = self.humanoid.foot_frames[side]
        body = frame.body()
        A = self.plant.CalcSpatialAccelerationsFromVdot(self.context, vdot)[body.index()]
        arm = self.line(side)[0] - body.EvalPoseInWorld(self.context).translation()
        w = self.line_velocity(side)[1]
        alpha = A.rotational()
        a = A.translational() + np.cross(alpha, arm) + np.cross(w, np.cross(w, arm))
        return a, alpha

    def needed_forces(self, vdot, wrench):
        """Generalised forces that `vdot` still needs beside gravity and both lines' wrenches.

        The first six are 0 when the motion is possible, the others are the joint torques.
        """
        forces = MultibodyForces(self.plant)
        self.plant.CalcForceElementsContribution(self.context, forces)
        for side, (f, tau) in enumerate(zip(wrench[:, :3], wrench[:, 3:], strict=True)):
            body = self.humanoid.foot_frames[side].body()
            X = body.EvalPoseInWorld(self.context)
            p, R = self.line(side)
            moment = R[:, 1:] @ tau + np.cross(p - X.translation(), f)
            R_BW = X.rotation().matrix().T
            F = SpatialForce(R_BW @ moment, R_BW @ f)
            body.AddInForce(self.context, np.zeros(3), F, body.body_frame(), forces)
        return self.plant.CalcInverseDynamics(self.context, vdot, forces)


@pytest.fixture(scope="session")
def full_plant(humanoid):
    return FullPlant(humanoid)


@pytest.fixture
def solver_only(monkeypatch):
    """Leave programs with active rows to the solver."""
    tick, solve = control.control_tick, wrench_qp.solve_program

    def free_tick(*args):
        (dropped, active, able, found), program = tick(*args)
        return (dropped, active, able, found and not active), program

    def free_program(*args):
        delta, active, found = solve(*args)
        return delta, active, found and not active

    monkeypatch.setattr(control, "control_tick", free_tick)
    monkeypatch.setattr(whole_body, "solve_program", free_program)
