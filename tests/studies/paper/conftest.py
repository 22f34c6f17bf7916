"""States of a walk for the tests of the two-point controller."""

import pytest

from drake_linefoot.robot.dynamics import robot_dynamics
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
