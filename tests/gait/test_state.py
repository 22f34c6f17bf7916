"""The gait's state as a vector: nothing is lost, nothing is shared."""

from dataclasses import fields

import numpy as np
import pytest

from drake_linefoot.gait import tick_kernels
from drake_linefoot.gait.state import GaitState, Mode
from tests.helpers.pendulum_robot import STAND_STILL, PendulumRobot


def states():
    robot = PendulumRobot()
    ticks = robot.run([0.4, 0.1, -0.5, 1.0], 1.0) + robot.run(STAND_STILL, 2.5)
    return [t.state for t in ticks[::50]]


def test_vector_and_state_say_the_same():
    seen = set()
    for state in states():
        vector = state.to_vector()
        assert vector.shape == (GaitState.size(),)
        back = GaitState.from_vector(vector)
        for field in fields(GaitState):
            a, b = getattr(state, field.name), getattr(back, field.name)
            np.testing.assert_array_equal(a, b, err_msg=field.name)
            assert np.shape(a) == np.shape(b)
        assert isinstance(back.mode, int)
        seen.add(Mode(back.mode))
    assert seen == set(Mode)


def test_every_number_of_the_vector_belongs_to_one_field():
    """Changing one number changes one field, and all of them count."""
    vector = np.arange(1.0, GaitState.size() + 1.0)
    base = GaitState.from_vector(vector)
    for i in range(len(vector)):
        changed = vector.copy()
        changed[i] += 1.0
        other = GaitState.from_vector(changed)
        different = [
            f.name
            for f in fields(GaitState)
            if not np.array_equal(getattr(base, f.name), getattr(other, f.name))
        ]
        assert len(different) == 1
        np.testing.assert_array_equal(other.to_vector(), changed)


NAMES = {
    "time": "TIME", "mode": "MODE", "side": "SIDE", "closing": "CLOSING", "due": "DUE",
    "phase_start": "PHASE_START", "phase_end": "PHASE_END", "yaw": "HEADING",
    "turn_rate": "TURN_RATE", "steps": "STEPS", "moved_footholds": "MOVED",
    "clipped_commands": "CLIPPED", "velocity": "VELOCITY", "speed_scale": "SCALE",
    "speed_offset": "OFFSET", "marks": "MARKS", "com": "COM", "com_velocity": "COM_VELOCITY",
    "feet": "FEET", "target": "TARGET", "reference": "REFERENCE", "slope": "SLOPE",
}  # fmt: skip


def test_the_kernels_find_every_field_where_it_is():
    """Each field filled with its own number shows where it begins, and where it ends."""
    assert NAMES.keys() == {f.name for f in fields(GaitState)}
    vector = np.arange(float(GaitState.size()))
    state = GaitState.from_vector(vector)
    for name, constant in NAMES.items():
        first = np.ravel(getattr(state, name))[0]
        assert getattr(tick_kernels, constant) == first, name
    assert GaitState.size() == tick_kernels.END


def test_a_state_does_not_share_memory_with_its_vector():
    vector = np.ones(GaitState.size())
    state = GaitState.from_vector(vector)
    vector[:] = 7.0
    np.testing.assert_array_equal(state.to_vector(), 1.0)


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
    state = PendulumRobot().state.changed(mode=mode, side=side)
    assert state.contact == contact
    assert state.swing_side == 1 - side
