"""A simulated robot that differs from the model its controller has."""

import numpy as np
from numpy.typing import NDArray
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import RigidBody, SpatialInertia
from pydrake.systems.framework import Context

from drake_linefoot.errors import ScenarioError
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.scenario.disturbances import ErrorParameters


def check_error(plant: MultibodyPlant, humanoid: Humanoid, error: ErrorParameters) -> None:
    """Check that the torso keeps a mass.

    Raises:
        ScenarioError: it does not.
    """
    mass = plant.GetBodyByName(humanoid.torso.name()).default_mass()
    if mass + error.torso_mass <= 0.0:
        allowed = f"must be above -{mass:g} kg, the mass of the torso"
        raise ScenarioError("scenario", "error.torso_mass", error.torso_mass, allowed)


def apply_error(
    plant: MultibodyPlant, context: Context, humanoid: Humanoid, error: ErrorParameters
) -> None:
    """Give a plant's context masses, inertias and damping that differ from the model's.

    A body's inertia about its centre of mass grows with its mass; a centre of mass that is
    moved takes it along.

    Args:
        plant: that is simulated.
        context: of the plant.
        humanoid: the robot.
        error: how it differs. Its Coulomb friction is the business of the actuators.
    """
    torso = plant.GetBodyByName(humanoid.torso.name())
    share = 1.0 + error.torso_mass / torso.default_mass()
    X_TB = humanoid.base.body_frame().CalcPose(humanoid.scratch, humanoid.torso.body_frame())
    R_TB = X_TB.rotation()
    _set_inertia(torso, context, share, R_TB @ np.array(error.torso_com))
    for body in leg_bodies(plant, humanoid):
        _set_inertia(body, context, error.leg_mass_scale, np.zeros(3))
    for name in humanoid.description.actuated_joints:
        joint = plant.GetJointByName(name)
        joint.SetDampingVector(context, joint.default_damping_vector() + error.joint_damping)


def leg_bodies(plant: MultibodyPlant, humanoid: Humanoid) -> list[RigidBody]:
    """Return the bodies that the leg joints of the description move, both legs."""
    names = [name for foot in humanoid.description.feet for name in foot.leg_joints]
    joints = [plant.GetJointByName(name).index() for name in names]
    return [plant.get_body(index) for index in plant.GetBodiesKinematicallyAffectedBy(joints)]


def _set_inertia(
    body: RigidBody, context: Context, share: float, offset: NDArray[np.float64]
) -> None:
    """Scale the mass of a body about its centre of mass, and move that by `offset` [m]."""
    nominal = body.default_spatial_inertia()
    if nominal.get_mass() == 0.0:
        return
    p, mass = nominal.get_com(), nominal.get_mass()
    about_com = nominal.CalcRotationalInertia().ShiftToCenterOfMass(mass, p)
    inertia = SpatialInertia.MakeFromCentralInertia(share * mass, p + offset, share * about_com)
    body.SetSpatialInertiaInBodyFrame(context, inertia)
