"""The gait's state as a record: the vector that Drake keeps, with a name for every place."""

import numpy as np
import pytest

from drake_linefoot.gait.state import GAIT, Mode, contact_of, fields_of, gait_record
from tests.helpers.pendulum_robot import STAND_STILL, PendulumRobot, targets_of

SIZE = GAIT.itemsize // 8


def states():
    robot = PendulumRobot()
    ticks = robot.run([0.4, 0.1, -0.5, 1.0], 1.0) + robot.run(STAND_STILL, 2.5)
    return [t.state for t in ticks[::50]]


def test_a_walk_goes_through_every_mode_and_its_states_are_vectors_of_numbers():
    seen = set()
    for state in states():
        vector = np.array([state]).view(float)
        assert vector.shape == (SIZE,)
        back = gait_record(vector)
        for name in GAIT.names:
            a, b = getattr(state, name), getattr(back, name)
            np.testing.assert_array_equal(a, b, err_msg=name)
            assert np.shape(a) == np.shape(b)
        seen.add(Mode(back.mode))
    assert seen == set(Mode)


def test_every_number_of_the_vector_belongs_to_one_field():
    """Changing one number changes one field, and all of them count."""
    vector = np.arange(1.0, SIZE + 1.0)
    base = gait_record(vector.copy())
    for i in range(SIZE):
        changed = vector.copy()
        changed[i] += 1.0
        other = gait_record(changed)
        different = [
            name
            for name in GAIT.names
            if not np.array_equal(getattr(base, name), getattr(other, name))
        ]
        assert len(different) == 1


def test_a_record_is_the_vector_itself():
    vector = np.zeros(SIZE)
    record = gait_record(vector)
    record.time, record.com[:] = 3.0, [5.0, 6.0, 7.0]
    assert sorted(vector[vector > 0.0]) == [3.0, 5.0, 6.0, 7.0]
    vector[:] = 2.0
    assert record.yaw == 2.0
    assert fields_of(record).steps == 2.0
    np.testing.assert_array_equal(fields_of(record).feet, np.full((2, 4), 2.0))


@pytest.mark.parametrize(
    ("mode", "side", "contact"),
    [
        (Mode.STAND, 0, (True, True)),
        (Mode.SHIFT, 1, (True, True)),
        (Mode.DOUBLE, 0, (True, True)),
        (Mode.SWING, 0, (True, False)),
        (Mode.SWING, 1, (False, True)),
    ],
)
def test_contact_follows_from_mode_and_side(mode, side, contact):
    state = PendulumRobot().state
    state.mode, state.side = mode, side
    assert contact_of(state) == contact
    targets = targets_of(state)
    np.testing.assert_array_equal(targets.contact, contact)
    assert (targets.mode, targets.swings) == (mode, float(not all(contact)))
