"""Inertia and angular momentum of the robot for many configurations of its legs at once, (23).

Drake says once what every link weighs, and for the arms as they are held now; the legs are
moved here.
"""

from typing import NamedTuple

import numpy as np
from pydrake.multibody.tree import BodyIndex

from drake_linefoot.math.compiled import compiled
from drake_linefoot.math.rotation import cross
from drake_linefoot.robot.chains import JOINTS, foot_in_link
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.robot.legs import Legs, chain, new_links
from drake_linefoot.robot.tree import add_inertia
from drake_linefoot.robot.tree_model import rigid_body
from drake_linefoot.types import Array


class Masses(NamedTuple):
    """What is in the torso's frame and in those of the legs' links: 1 + n 5 rigid bodies.

    The torso is first, then the links leg by leg; arms count where they hang, as they are held.

    Attributes:
        mass: [kg], shape (1 + n 5,).
        com: CoM in the body's own frame [m], shape (1 + n 5, 3).
        inertia: about the CoM, in the body's own frame [kg m^2], shape (1 + n 5, 3, 3).
    """

    mass: Array
    com: Array
    inertia: Array


class MomentumMaps(NamedTuple):
    """What turning and the joints of the legs give of momentum, in the torso frame B.

    ``L = I_B Omega + sum angular qdot``, about the CoM, and ``m (v - v_P) = sum linear qdot``
    with P, the point of the torso that is where the CoM is.

    Attributes:
        I_B: locked inertia about the CoM [kg m^2], shape (K, 3, 3).
        com: from the torso's origin [m], shape (K, 3).
        angular: about the CoM, of each joint [kg m^2], shape (n, K, 3, 5).
        linear: of each joint [kg m], shape (n, K, 3, 5).
    """

    I_B: Array
    com: Array
    angular: Array
    linear: Array

    def momentum(self, rates: Array, Omega: Array) -> Array:
        """Return the angular momentum about the CoM, (23) [kg m^2/s], shape (K, 3).

        Args:
            rates: of the joints [rad/s], shape (n, K, 5).
            Omega: angular velocity of the torso in B [rad/s], shape (K, 3).
        """
        of_joints = np.matvec(self.angular, rates).sum(axis=0)
        return np.matvec(self.I_B, Omega) + of_joints


class LegInertia:
    """The robot as a torso and two moving legs, with arms that hold still."""

    def __init__(self, humanoid: Humanoid, legs: Legs) -> None:
        """Read from the model what hangs on the torso and on each link of the legs."""
        self._humanoid, self._legs = humanoid, legs
        self._context = humanoid.plant.CreateDefaultContext()
        plant, description = humanoid.plant, humanoid.description
        legs_joints = [name for foot in description.feet for name in foot.leg_joints]
        joints = [humanoid.names.joint(name) for name in legs_joints]
        roots = [humanoid.base, *(joint.child_body() for joint in joints)]
        self._frames = [humanoid.base.body_frame(), *(j.frame_on_child() for j in joints)]
        self._origins = np.zeros((len(self._frames), 3))  # of the links in these frames
        for side, last in enumerate((JOINTS, 2 * JOINTS)):  # a last link has the axes of the foot
            X_FL = foot_in_link(humanoid, side).inverse()
            self._frames[last], self._origins[last] = humanoid.foot_frames[side], X_FL.translation()
        self._groups = _hanging_on(humanoid, [body.index() for body in roots])
        plant.SetPositions(self._context, humanoid.q_nominal)
        rows = [self._rigid_body(i) for i in range(len(roots))]
        self._masses = Masses(*(np.array(values) for values in zip(*rows, strict=True)))
        arms = {humanoid.names.joint(name).child_body().index() for name in description.arm_joints}
        self._with_arms = [i for i, group in enumerate(self._groups) if arms & set(group)]

    def _rigid_body(self, i: int) -> tuple[float, Array, Array]:
        """Return mass, CoM and inertia of group `i`, with the joints as they are in the context."""
        plant, frame, bodies = self._humanoid.plant, self._frames[i], self._groups[i]
        mass, com, inertia = rigid_body(plant, self._context, frame, bodies)
        return mass, com - self._origins[i], inertia

    def __call__(self, q: Array, angles: Array) -> MomentumMaps:
        """Return what turning and every joint of the legs give of momentum.

        Args:
            q: present positions, of which the arms' count, shape (nq,).
            angles: of the legs [rad], shape (2, K, 5).
        """
        masses = self._masses
        if self._with_arms:
            self._humanoid.plant.SetPositions(self._context, q)
        for i in self._with_arms:
            masses.mass[i], masses.com[i], masses.inertia[i] = self._rigid_body(i)
        return momentum_maps(self._legs, masses, angles)


def _hanging_on(humanoid: Humanoid, roots: list[BodyIndex]) -> list[list[BodyIndex]]:
    """Return for each of some bodies itself and what hangs on it and on none further out."""
    plant = humanoid.plant
    parents = {}
    for index in plant.GetJointIndices():
        joint = plant.get_joint(index)
        parents[joint.child_body().index()] = joint.parent_body().index()
    groups: list[list[BodyIndex]] = [[] for _ in roots]
    for body in (plant.get_body(BodyIndex(i)) for i in range(1, plant.num_bodies())):
        at = body.index()
        while at not in roots and at in parents:
            at = parents[at]
        if at in roots:  # else it is fixed to the world
            groups[roots.index(at)].append(body.index())
    return groups


@compiled
def turned(R: Array, a: Array, out: Array) -> None:
    """Write ``R a``, shapes (3, 3) and (3,)."""
    for i in range(3):
        out[i] = R[i, 0] * a[0] + R[i, 1] * a[1] + R[i, 2] * a[2]


@compiled
def momentum_maps(legs: Legs, masses: Masses, q: Array) -> MomentumMaps:
    """Return what turning and every joint give of momentum, (23); a joint moves all beyond it.

    Args:
        legs: n legs.
        masses: of torso and links.
        q: joint angles [rad], shape (n, K, 5).
    """
    n, K, _ = q.shape
    I_B, com = np.zeros((K, 3, 3)), np.zeros((K, 3))
    angular, linear = np.zeros((n, K, 3, JOINTS)), np.zeros((n, K, 3, JOINTS))
    links, upright, total = new_links(), np.eye(3), masses.mass.sum()
    beyond, moment = np.empty((3, 3)), np.empty(3)  # inertia and first moment about B's origin
    c, arm, h = np.empty(3), np.empty(3), np.empty(3)
    for k in range(K):
        com[k] = masses.mass[0] * masses.com[0]
        add_inertia(masses.mass[0], masses.com[0], upright, masses.inertia[0], I_B[k])
        for leg in range(n):
            chain(legs, leg, q[leg, k], links)
            beyond[:], moment[:], mass = 0.0, 0.0, 0.0
            for i in range(JOINTS - 1, -1, -1):
                body, R, axis = 1 + leg * JOINTS + i, links.R[i + 1], links.axes[i]
                origin, m = links.origins[i + 1], masses.mass[body]
                turned(R, masses.com[body], c)
                mass += m
                for r in range(3):
                    c[r] += origin[r]
                    moment[r] += m * c[r]
                    arm[r] = moment[r] - mass * origin[r]
                add_inertia(m, c, R, masses.inertia[body], beyond)
                turned(beyond, axis, h)
                P, lever = cross(axis, arm), cross(moment, cross(axis, origin))
                for r in range(3):
                    linear[leg, k, r, i], angular[leg, k, r, i] = P[r], h[r] - lever[r]
            I_B[k] += beyond
            com[k] += moment
        com[k] /= total
        add_inertia(-total, com[k], upright, np.zeros((3, 3)), I_B[k])
        for leg in range(n):
            for i in range(JOINTS):
                shift = cross(com[k], linear[leg, k, :, i])
                for r in range(3):
                    angular[leg, k, r, i] -= shift[r]
    return MomentumMaps(I_B, com, angular, linear)
