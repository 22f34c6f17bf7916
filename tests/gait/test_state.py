"""The gait's state as a record: the vector that Drake keeps, in parts with names."""

import ast
import re
from dataclasses import fields
from pathlib import Path
from typing import get_type_hints

import numpy as np

from drake_linefoot.gait import state as state_module
from drake_linefoot.gait.state import (
    CONSTANTS,
    GAIT,
    GaitParameters,
    GaitState,
    gait_state,
    vector_of,
)
from drake_linefoot.layout import parts_of
from drake_linefoot.statuses import Mode
from tests.helpers.pendulum_robot import STAND_STILL, PendulumRobot
from tests.helpers.phases import mode_of, named, targets_of

SIZE = GAIT.itemsize // 8


def states():
    robot = PendulumRobot()
    ticks = robot.run([0.4, 0.1, -0.5, 1.0], 1.0) + robot.run(STAND_STILL, 2.5)
    return [t.state for t in ticks[::50]]


def numbers(state):
    """Every field of every part of a state."""
    return {
        f"{part}.{name}": np.array(getattr(getattr(state, part), name))
        for part in GAIT.names
        for name in GAIT[part].names
    }


def test_a_walk_goes_through_every_mode_and_its_states_are_vectors_of_numbers():
    seen = set()
    for state in states():
        vector = vector_of(state)
        assert vector.shape == (SIZE,)
        back = gait_state(vector)
        for (name, a), b in zip(numbers(state).items(), numbers(back).values(), strict=True):
            np.testing.assert_array_equal(a, b, err_msg=name)
            assert a.shape == b.shape
        assert mode_of(back) == named(targets_of(back))
        seen.add(mode_of(back))
    assert seen == set(Mode) - {Mode.FLIGHT}


def test_every_number_of_the_vector_belongs_to_one_field():
    """Changing one number changes one field, and all of them count."""
    vector = np.arange(1.0, SIZE + 1.0)
    base = numbers(gait_state(vector.copy()))
    for i in range(SIZE):
        changed = vector.copy()
        changed[i] += 1.0
        other = numbers(gait_state(changed))
        assert sum(not np.array_equal(base[name], other[name]) for name in base) == 1


def test_a_state_is_the_vector_itself():
    vector = np.zeros(SIZE)
    state = gait_state(vector)
    state.clock.time, state.robot.com[:] = 3.0, [5.0, 6.0, 7.0]
    assert sorted(vector[vector > 0.0]) == [3.0, 5.0, 6.0, 7.0]
    vector[:] = 2.0
    assert state.command.yaw == 2.0
    np.testing.assert_array_equal(state.robot.feet, np.full((2, 4), 2.0))


def test_no_part_has_many_fields_and_each_is_declared():
    """What the records hold is what their classes say, with units for the state."""
    for part in GAIT.names:
        declared = parts_of(get_type_hints(GaitState)[part])
        assert tuple(declared) == GAIT[part].names
        assert len(declared) <= 10
        assert all(p.meaning and p.unit for p in declared.values())
    given = [f.name for f in fields(GaitParameters) if f.name != "first_swing"]
    assert list(CONSTANTS.names[: len(given)]) == given


def test_each_part_is_written_by_one_module():
    """Its docstring names the module; `planner.begin` makes a state."""
    owners = {
        name: re.search(r"written by `(\w+)`", kind.__doc__)[1]
        for name, kind in get_type_hints(GaitState).items()
    }
    written = set()
    for file in Path(state_module.__file__).parent.glob("*.py"):
        for function in ast.walk(ast.parse(file.read_text())):
            if isinstance(function, ast.FunctionDef) and function.name != "begin":
                written |= {(part, file.stem) for part in parts_written(function)}
    assert written == set(owners.items())


def parts_written(function):
    """Parts of a state `s` to which a function assigns."""
    for node in ast.walk(function):
        targets = getattr(node, "targets", [getattr(node, "target", None)])
        for target in targets if isinstance(node, ast.Assign | ast.AugAssign) else ():
            for place in ast.walk(target):
                inner = isinstance(place, ast.Attribute) and isinstance(place.value, ast.Name)
                if inner and place.value.id == "s":
                    yield place.attr
