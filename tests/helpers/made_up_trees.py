"""Robots for the tests of rigid-body dynamics: random trees of links, in random states."""

from functools import cached_property

import numpy as np
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import (
    FixedOffsetFrame,
    PrismaticJoint,
    RevoluteJoint,
    RotationalInertia,
    ScrewJoint,
    SpatialInertia,
    UniversalJoint,
    WeldJoint,
)

from drake_linefoot.contact.contacts import LineContact
from drake_linefoot.robot.tree_model import read_tree


def random_state(robot, rng, speed=1.0):
    """Any attitude, joints anywhere, everything moving."""
    q = np.concatenate([rng.normal(size=4), rng.uniform(-3.0, 3.0, robot.nq - 4)])
    q[:4] /= np.linalg.norm(q[:4])
    return np.concatenate([q, speed * rng.normal(size=robot.nv)])


class MadeUp:
    """What `robot_dynamics` wants of a robot: a random tree of links in a plant.

    Joints turn or slide about any axis, between frames that are anywhere; links have branches,
    bodies without mass and bodies that are welded to them; some joints have motors.
    """

    def __init__(self, seed, links=9, kinds=(RevoluteJoint, PrismaticJoint), beside=False):
        self.rng, self.plant = np.random.default_rng(seed), MultibodyPlant(0.0)
        self.robot = self.plant.AddModelInstance("robot")
        self.base = self.body("base", 5.0)
        ends = [self.base]
        for i in range(links):
            on, body = ends[self.rng.integers(len(ends))], self.body(f"link{i}", 1.0)
            self.join(f"joint{i}", kinds[self.rng.integers(len(kinds))], on, body)
            ends.append(body)
            if self.rng.random() < 0.5:
                ends.append(self.body(f"welded{i}", float(self.rng.random() < 0.7)))
                weld = WeldJoint(f"weld{i}", *self.frames(body, ends[-1]), self.pose())
                self.plant.AddJoint(weld)
        self.world, self.contact = self.plant.world_frame(), LineContact(0.1)
        feet = [ends[self.rng.integers(len(ends))] for _ in range(2)]
        self.foot_frames = [self.frames(foot, foot)[0] for foot in feet]
        self.p_FC = self.rng.normal(size=(2, 3))
        if beside:
            self.add_what_is_beside()
        self.plant.Finalize()
        self.nq, self.nv = self.plant.num_positions(), self.plant.num_velocities()

    def body(self, name, mass):
        """Add a body with any centre of mass and inertia, or one without mass."""
        if mass == 0.0:
            return self.plant.AddRigidBody(name, self.robot, SpatialInertia.Zero())
        mass *= self.rng.uniform(0.2, 2.0)
        A = self.rng.normal(size=(3, 3))
        I = mass * (A @ A.T)  # noqa: E741
        I = 0.5 * np.trace(I) * np.eye(3) - 0.5 * I  # noqa: E741  # physical
        about = RotationalInertia(*np.diag(I), I[0, 1], I[0, 2], I[1, 2])
        com = self.rng.normal(size=3)
        inertia = SpatialInertia.MakeFromCentralInertia(mass, com, about)
        return self.plant.AddRigidBody(name, self.robot, inertia)

    def pose(self):
        return RigidTransform(RollPitchYaw(self.rng.uniform(-3, 3, 3)), self.rng.normal(size=3))

    def frames(self, *bodies):
        """Add a frame somewhere in each body."""
        names = [f"frame{self.plant.num_frames() + i}" for i in range(len(bodies))]
        pairs = zip(names, bodies, strict=True)
        return [
            self.plant.AddFrame(FixedOffsetFrame(name, body.body_frame(), self.pose()))
            for name, body in pairs
        ]

    def join(self, name, kind, parent, child):
        frames, axis = self.frames(parent, child), self.rng.normal(size=3)
        axis /= np.linalg.norm(axis)
        if kind is UniversalJoint:
            return self.plant.AddJoint(UniversalJoint(name, *frames))
        if kind is ScrewJoint:
            return self.plant.AddJoint(ScrewJoint(name, *frames, axis, 0.3, 0.0))
        joint = self.plant.AddJoint(kind(name, *frames, axis))
        if self.rng.random() < 0.7:
            motor = self.plant.AddJointActuator(f"{name}_motor", joint, 10.0)
            motor.set_default_rotor_inertia(self.rng.uniform(0.0, 0.01))
            motor.set_default_gear_ratio(self.rng.uniform(1.0, 20.0))
        return joint

    def add_what_is_beside(self):
        """Put heavy bodies to the world that are no part of the robot."""
        for instance in (self.robot, self.plant.AddModelInstance("furniture")):
            inertia = SpatialInertia.SolidSphereWithMass(1e3, 1.0)
            body = self.plant.AddRigidBody(f"rock{int(instance)}", instance, inertia)
            self.plant.WeldFrames(self.world, body.body_frame(), self.pose())

    @cached_property
    def _tree(self):
        context = self.plant.CreateDefaultContext()
        return read_tree(self.plant, context, self.base, self.foot_frames, self.p_FC)

    def tree(self, context):
        return self._tree
