"""Contacts of many ticks against one contact after the other."""

from dataclasses import dataclass

import numpy as np

from drake_linefoot.lab.simulation.contact_forces import write_contacts
from drake_linefoot.lab.simulation.recorder import dtype_of
from drake_linefoot.lab.simulation.recording import CHANNELS
from tests.helpers.recorded_runs import SIZES

TICKS = 5
FEET = {7: 0, 9: 1}  # sides by the index of the body


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
    return [*results, Contacts()], rng.normal(size=(TICKS, 2, 2, 3))


def written(results, ends, feet):
    rows = np.full(TICKS, np.nan, dtype_of(CHANNELS, SIZES))
    rows["contact_points"] = ends
    write_contacts(results, rows, feet)
    return rows["true_force"], rows["true_normal"], rows["slip_speed"]


def test_contacts_are_added_to_the_foot_and_to_the_nearer_end():
    results, ends = random_contacts(0)
    total, normal = np.zeros((TICKS, 2, 3)), np.zeros((TICKS, 2, 2))
    slip = np.zeros((TICKS, 2))
    counted = 0
    for i, contacts in enumerate(results):
        for one in contacts:
            side, f = FEET.get(one.B), one.force
            if side is None:
                side, f = FEET.get(one.A), -one.force
            if side is None:
                continue
            counted += 1
            distances = np.linalg.norm(ends[i, side] - one.point, axis=1)
            total[i, side] += f
            normal[i, side, np.argmin(distances)] += f[2]
            slip[i, side] = max(slip[i, side], one.speed)
    assert 30 < counted < 48
    for found, wanted in zip(written(results, ends, FEET), (total, normal, slip), strict=True):
        np.testing.assert_allclose(found, wanted, atol=1e-14)


def test_other_feet_have_the_same_contacts():
    """Sides exchanged: nothing depends on which foot is the left one."""
    results, ends = random_contacts(1)
    exchanged = {body: 1 - side for body, side in FEET.items()}
    pairs = written(results, ends, FEET), written(results, ends[:, ::-1], exchanged)
    for one, two in zip(*pairs, strict=True):
        np.testing.assert_array_equal(two, one[:, ::-1])


def test_without_contacts_there_is_no_force():
    nothing = [Contacts() for _ in range(TICKS)]
    for found in written(nothing, np.zeros((TICKS, 2, 2, 3)), FEET):
        assert (found == 0.0).all()
