"""Contacts of many ticks against one contact after the other, and the block that reads them."""

from dataclasses import dataclass

import numpy as np
import pytest
from pydrake.common.value import AbstractValue
from pydrake.multibody.plant import ContactResults
from scipy.spatial.transform import Rotation

from drake_linefoot.lab.plants.contact_forces import (
    ContactForces,
    FootContacts,
    contacts_of_feet,
    foot_contacts,
)
from drake_linefoot.layout import Layout, flat
from drake_linefoot.robot.dynamics import robot_dynamics

TICKS = 5
FEET = {7: 1, 9: 2}  # left and right by the index of the body
PLACES = {  # of the points from C, by the kind of foot
    "line": np.array([[-0.1, 0.0], [0.1, 0.0]]),
    "sole": np.array([[-0.1, 0.03], [-0.1, -0.03], [0.1, 0.03], [0.1, -0.03]]),
}


@dataclass(frozen=True)
class Contact:
    """What is asked of Drake's PointPairContactInfo."""

    A: int
    B: int
    force: np.ndarray
    point: np.ndarray
    speed: float

    def bodyA_index(self):
        return self.A

    def bodyB_index(self):
        return self.B

    def contact_force(self):
        return self.force

    def contact_point(self):
        return self.point

    def slip_speed(self):
        return self.speed


class Contacts(list):
    """What is asked of Drake's ContactResults."""

    def num_point_pair_contacts(self):
        return len(self)

    def point_pair_contact_info(self, k):
        return self[k]


def random_contacts(seed):
    """Contacts of feet with each other, the ground and between others; none in the last tick."""
    rng = np.random.default_rng(seed)

    def contact():
        bodies = rng.choice([0, 7, 9], 2)
        return Contact(*bodies, rng.normal(size=3), rng.normal(size=3), rng.uniform())

    results = [Contacts(contact() for _ in range(12)) for _ in range(TICKS - 1)]
    frames = Rotation.random(2 * TICKS, random_state=seed).as_matrix().reshape(TICKS, 2, 3, 3)
    return [*results, Contacts()], rng.normal(size=(TICKS, 2, 3)), frames


def found(dynamics, results, middles, frames, feet=FEET, places=PLACES["line"]):
    """Forces, normal forces and slip speeds of all ticks."""
    ticks, layout = [], Layout(FootContacts, {"nc": len(places)})
    for contacts, p_WC, R_WC in zip(results, middles, frames, strict=True):
        d = flat(dynamics._replace(p_WC=p_WC, R_WC=R_WC))
        vector = np.empty(layout.size)
        foot_contacts(vector, d, len(dynamics.v), 5, places, *contacts_of_feet(contacts, feet))
        ticks.append(layout.open(vector)[1:])
    return [np.stack(part) for part in zip(*ticks, strict=True)]


@pytest.fixture(scope="module")
def dynamics(humanoid, walking_state):
    scratch = humanoid.plant.CreateDefaultContext()
    return robot_dynamics(humanoid, scratch, walking_state(humanoid, 1))


@pytest.mark.parametrize("kind", PLACES)
def test_contacts_are_added_to_the_foot_and_to_the_nearest_point(dynamics, kind):
    results, middles, frames = random_contacts(0)
    places = PLACES[kind]
    ends = middles[:, :, None] + np.einsum("pk,tsik->tspi", places, frames[..., :2])
    total, normal = np.zeros((TICKS, 2, 3)), np.zeros((TICKS, 2, len(places)))
    slip = np.zeros((TICKS, 2))
    counted = 0
    for i, contacts in enumerate(results):
        for one in contacts:
            foot, f = FEET.get(one.B), one.force
            if foot is None:
                foot, f = FEET.get(one.A), -one.force
            if foot is None:
                continue
            counted, side = counted + 1, foot - 1
            distances = np.linalg.norm(ends[i, side] - one.point, axis=1)
            total[i, side] += f
            normal[i, side, np.argmin(distances)] += f[2]
            slip[i, side] = max(slip[i, side], one.speed)
    assert 30 < counted < 48
    sums = found(dynamics, results, middles, frames, places=places)
    for each, wanted in zip(sums, (total, normal, slip), strict=True):
        np.testing.assert_allclose(each, wanted, atol=1e-14)


def test_other_feet_have_the_same_contacts(dynamics):
    """Sides exchanged: nothing depends on which foot is the left one."""
    results, middles, frames = random_contacts(1)
    exchanged = {body: 3 - foot for body, foot in FEET.items()}
    one = found(dynamics, results, middles, frames)
    two = found(dynamics, results, middles[:, ::-1], frames[:, ::-1], exchanged)
    for each, other in zip(one, two, strict=True):
        np.testing.assert_array_equal(other, each[:, ::-1])


def test_without_contacts_there_is_no_force(dynamics):
    _, middles, frames = random_contacts(2)
    for each in found(dynamics, [Contacts()] * TICKS, middles, frames):
        assert (each == 0.0).all()


def test_heel_and_toe_are_at_the_ends_of_the_contact_line(humanoid, dynamics):
    block = ContactForces(humanoid, humanoid.plant)
    context = block.CreateDefaultContext()
    block.GetInputPort("dynamics").FixValue(context, flat(dynamics))
    results = AbstractValue.Make(ContactResults())
    block.GetInputPort("contact_results").FixValue(context, results)
    points = block.look("foot_contacts", context).points
    for side in (0, 1):
        for end, sign in enumerate((-1.0, 1.0)):
            along = sign * humanoid.half_length * dynamics.R_WC[side][:, 0]
            np.testing.assert_allclose(points[side, end], dynamics.p_WC[side] + along, atol=1e-15)
