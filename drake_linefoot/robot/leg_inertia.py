"""Inertia and angular momentum of the robot for many configurations of its legs at once, (23).

Drake says once what every link weighs; torso and arms are what the legs leave of the whole robot as
it is now. The legs are moved here.
"""

from typing import NamedTuple

import numpy as np
from pydrake.multibody.tree import BodyIndex

from drake_linefoot.math.compiled import compiled, inlined
from drake_linefoot.math.linear import dot
from drake_linefoot.math.vectors import Vector, crossed, plus, times, vector, write
from drake_linefoot.robot.chains import foot_in_link
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.robot.legs import Legs, Links, chain, new_links
from drake_linefoot.robot.tree import add_inertia
from drake_linefoot.robot.tree_model import rigid_body
from drake_linefoot.signals import RobotDynamics
from drake_linefoot.types import Array


class Masses(NamedTuple):
    """What is in the torso's frame and in those of the legs' links: 1 + n 5 rigid bodies.

    The torso is first, then the links leg by leg; arms count where they hang, as they are held. Of
    the torso only the mass is constant, see `weigh_torso`.

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
        angular: about the CoM, of each joint [kg m^2], shape (n, K, 3, j).
        linear: of each joint [kg m], shape (n, K, 3, j).
    """

    I_B: Array
    com: Array
    angular: Array
    linear: Array

    def momentum(self, rates: Array, Omega: Array) -> Array:
        """Return the angular momentum about the CoM, (23) [kg m^2/s], shape (K, 3).

        Args:
            rates: of the joints [rad/s], shape (n, K, j).
            Omega: angular velocity of the torso in B [rad/s], shape (K, 3).
        """
        return momentum_of(self.I_B, self.angular, rates, Omega)


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
        n = humanoid.leg_joints.shape[1]
        for side, last in enumerate((n, 2 * n)):  # a last link has the axes of the foot
            X_FL = foot_in_link(humanoid, side).inverse()
            self._frames[last], self._origins[last] = humanoid.foot_frames[side], X_FL.translation()
        self._groups = _hanging_on(humanoid, [body.index() for body in roots])
        plant.SetPositions(self._context, humanoid.q_nominal)
        rows = [self._rigid_body(i) for i in range(len(roots))]
        self._masses = Masses(*(np.array(values) for values in zip(*rows, strict=True)))
        arms = {humanoid.names.joint(name).child_body().index() for name in description.arm_joints}
        links = range(1, len(self._groups))
        self._with_arms = [i for i in links if arms & set(self._groups[i])]

    def _rigid_body(self, i: int) -> tuple[float, Array, Array]:
        """Return mass, CoM and inertia of group `i`, with the joints as they are in the context."""
        plant, frame, bodies = self._humanoid.plant, self._frames[i], self._groups[i]
        mass, com, inertia = rigid_body(plant, self._context, frame, bodies)
        return mass, com - self._origins[i], inertia

    def masses(self, q: Array) -> Masses:
        """Return what there is, with what hangs on the legs as it is held at `q`, shape (nq,)."""
        masses = self._masses
        if self._with_arms:
            self._humanoid.plant.SetPositions(self._context, q)
        for i in self._with_arms:
            masses.mass[i], masses.com[i], masses.inertia[i] = self._rigid_body(i)
        return masses

    def __call__(self, d: RobotDynamics, angles: Array) -> MomentumMaps:
        """Return what turning and every joint of the legs give of momentum.

        Args:
            d: quantities of the present state: arms stay as they are.
            angles: of the legs [rad], shape (2, K, j).
        """
        masses = self.masses(d.q)
        com, inertia = whole_in_torso(d.q, d.p_WG, d.R_WB, d.A)
        weigh_torso(self._legs, masses, d.q[self._humanoid.leg_q], com, inertia)
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


@inlined
def whole_in_torso(q: Array, p_WG: Array, R_WB: Array, A: Array) -> tuple[Array, Array]:
    """Return CoM from the torso's origin and inertia about it of the robot as it is, in B.

    Args:
        q: positions, shape (nq,); see `RobotDynamics`, as for the others.
        p_WG: CoM [m], shape (3,).
        R_WB: torso orientation, shape (3, 3).
        A: centroidal momentum matrix, shape (6, nv).

    Returns:
        (com, I_B): [m] and [kg m^2], shapes (3,) and (3, 3).
    """
    com, inertia = np.zeros(3), np.zeros((3, 3))
    for i in range(3):
        for k in range(3):
            com[i] += R_WB[k, i] * (p_WG[k] - q[4 + k])
            turned_row = 0.0
            for n in range(3):
                turned_row += R_WB[n, i] * A[n, k]
            for j in range(3):
                inertia[i, j] += turned_row * R_WB[k, j]
    return com, inertia


@compiled
def add_link(masses: Masses, body: int, links: Links, i: int, J: Array) -> tuple[float, Vector]:
    """Add a link's inertia about the torso's origin to J; return its mass and CoM [kg, m].

    Args:
        masses: of torso and links.
        body: which of them.
        links: where those of its leg are.
        i: which of these.
        J: [kg m^2], shape (3, 3).
    """
    R, origin, c = links.R[i + 1], links.origins[i + 1], masses.com[body]
    at = (
        origin[0] + R[0, 0] * c[0] + R[0, 1] * c[1] + R[0, 2] * c[2],
        origin[1] + R[1, 0] * c[0] + R[1, 1] * c[1] + R[1, 2] * c[2],
        origin[2] + R[2, 0] * c[0] + R[2, 1] * c[1] + R[2, 2] * c[2],
    )
    add_inertia(masses.mass[body], at, R, masses.inertia[body], J)
    return masses.mass[body], at


@compiled
def weigh_torso(legs: Legs, masses: Masses, q: Array, com: Array, inertia: Array) -> None:
    """Write CoM and inertia of the torso with its arms: what the legs leave of the whole robot.

    Args:
        legs: n legs of j joints.
        masses: of torso and links; row 0 is written.
        q: present joint angles [rad], shape (n, j).
        com: present CoM of the robot from the torso's origin, in B [m], shape (3,).
        inertia: of the robot about it [kg m^2], shape (3, 3).
    """
    links, upright, none = new_links(legs), np.eye(3), np.zeros((3, 3))
    total, m, J, first = 0.0, masses.mass[0], np.zeros((3, 3)), np.empty(3)
    for mass in masses.mass:
        total += mass
    for r in range(3):
        first[r] = total * com[r]
    for leg in range(len(q)):
        chain(legs, leg, q[leg], links)
        for i in range(len(legs.zeros)):
            mass, at = add_link(masses, 1 + leg * len(legs.zeros) + i, links, i, J)
            for r in range(3):
                first[r] -= mass * at[r]
    for r in range(3):
        masses.com[0, r] = first[r] / m if m > 0.0 else 0.0
        for s in range(3):
            masses.inertia[0, r, s] = inertia[r, s] - J[r, s]
    add_inertia(total, (com[0], com[1], com[2]), upright, none, masses.inertia[0])
    add_inertia(-m, vector(masses.com, 0, 0), upright, none, masses.inertia[0])


@compiled
def momentum_maps(legs: Legs, masses: Masses, q: Array) -> MomentumMaps:
    """Return what turning and every joint give of momentum, (23); a joint moves all beyond it.

    Args:
        legs: n legs of j joints.
        masses: of torso and links.
        q: joint angles [rad], shape (n, K, j).
    """
    (n, K, _), j = q.shape, len(legs.zeros)
    I_B, com = np.zeros((K, 3, 3)), np.zeros((K, 3))
    angular, linear = np.zeros((n, K, 3, j)), np.zeros((n, K, 3, j))
    links, upright, total = new_links(legs), np.eye(3), masses.mass.sum()
    none, beyond, h = np.zeros((3, 3)), np.empty((3, 3)), np.empty(3)  # about B's origin
    for k in range(K):
        write(com, k, 0, times(masses.mass[0], vector(masses.com, 0, 0)))
        add_inertia(masses.mass[0], vector(masses.com, 0, 0), upright, masses.inertia[0], I_B[k])
        for leg in range(n):
            chain(legs, leg, q[leg, k], links)
            beyond[:], mass, moment = 0.0, 0.0, (0.0, 0.0, 0.0)
            for i in range(j - 1, -1, -1):
                m, at = add_link(masses, 1 + leg * len(legs.zeros) + i, links, i, beyond)
                mass, moment = mass + m, plus(moment, times(m, at))
                axis, origin = vector(links.axes, i, 0), vector(links.origins, i + 1, 0)
                P = crossed(axis, plus(moment, times(-mass, origin)))
                lever = crossed(moment, crossed(axis, origin))
                turned(beyond, links.axes[i], h)
                for r in range(3):
                    linear[leg, k, r, i], angular[leg, k, r, i] = P[r], h[r] - lever[r]
            write(com, k, 0, plus(vector(com, k, 0), moment))
            for r in range(3):
                for s in range(3):
                    I_B[k, r, s] += beyond[r, s]
        c = times(1.0 / total, vector(com, k, 0))
        write(com, k, 0, c)
        add_inertia(-total, c, upright, none, I_B[k])
        for leg in range(n):
            for i in range(len(legs.zeros)):
                P = linear[leg, k, 0, i], linear[leg, k, 1, i], linear[leg, k, 2, i]
                shift = crossed(c, P)
                for r in range(3):
                    angular[leg, k, r, i] -= shift[r]
    return MomentumMaps(I_B, com, angular, linear)


@inlined
def momentum_of(I_B: Array, angular: Array, rates: Array, Omega: Array) -> Array:
    """Return `MomentumMaps.momentum`, of the maps that it takes."""
    n, K, _ = rates.shape
    L = np.empty((K, 3))
    for k in range(K):
        for r in range(3):
            L[k, r] = dot(I_B[k, r], Omega[k])
            for leg in range(n):
                L[k, r] += dot(angular[leg, k, r], rates[leg, k])
    return L
