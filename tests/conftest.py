"""What every test shares."""

import drake_linefoot  # noqa: F401  before numpy: one BLAS thread in every test process

# isort: split
import logging
import os
import signal

import numpy as np
import pytest
from hypothesis import settings
from scipy.spatial.transform import Rotation

from drake_linefoot.lab.wiring.closed_loop import warm_up
from drake_linefoot.mpc.models import registry
from drake_linefoot.robot.humanoid import load_humanoid
from tests.helpers.small_biped import write_small_biped
from tests.helpers.sole_biped import write_turned_biped

settings.register_profile("linefoot", derandomize=True, deadline=None)
settings.load_profile("linefoot")


# A shell that starts the tests in the background lets them, and their processes, ignore Ctrl-C.
signal.signal(signal.SIGINT, signal.default_int_handler)

DRAKES_LEVEL = logging.getLogger("drake").level  # once pydrake has set it


@pytest.hookimpl(tryfirst=True)
def pytest_sessionstart(session):
    """Compile before the workers start, each of which would do it: tests have time limits."""
    if "PYTEST_XDIST_WORKER" not in os.environ:
        warm_up()


@pytest.fixture(autouse=True)
def _drakes_log_level():
    """Let every test hear what Drake says; commands and studies silence it."""
    logging.getLogger("drake").setLevel(DRAKES_LEVEL)


@pytest.fixture
def own_models():
    """`register` of the MPC's models; those that a test registers are forgotten after it."""
    known = dict(registry.MODELS.own)
    yield registry.register
    registry.MODELS.own.clear()
    registry.MODELS.own.update(known)


@pytest.fixture(scope="session")
def humanoid():
    """The MIT Humanoid; nothing in it changes."""
    return load_humanoid("mit_humanoid")


@pytest.fixture(scope="session")
def walking_state():
    """Make random plausible states: knees bent, torso almost upright, everything moving."""

    def make(humanoid, seed, speed=1.0, tilt=0.15):
        """Return [q, v]; `speed` scales the velocities, `tilt` is the largest roll and pitch."""
        rng = np.random.default_rng(seed)
        q = humanoid.q_nominal.copy()
        heading, pitch, roll = rng.uniform(-1, 1, 3) * [3.0, tilt, tilt]
        xyzw = Rotation.from_euler("ZYX", [heading, pitch, roll]).as_quat()
        q[:4] = np.roll(xyzw, 1)
        q[4:7] += [*rng.uniform(-2, 2, 2), rng.uniform(-0.1, 0.1)]
        wanted = q[humanoid.actuated_q] + rng.uniform(-0.3, 0.3, humanoid.na)
        lower, upper = humanoid.position_lower, humanoid.position_upper
        q[humanoid.actuated_q] = np.clip(wanted, lower + 0.02, upper - 0.02)
        v = speed * rng.normal(size=humanoid.nv)
        return np.concatenate([q, v])

    return make


@pytest.fixture(scope="session")
def advance():
    """Move a configuration on at constant velocity, exactly: no generalized acceleration."""

    def move(humanoid, x, t):
        """Return the state `t` seconds later, the torso turning about a fixed axis."""
        q, v = np.array(x[: humanoid.nq]), x[humanoid.nq :]
        R = Rotation.from_rotvec(t * v[:3]) * Rotation.from_quat(np.roll(q[:4], -1))
        q[:4] = np.roll(R.as_quat(), 1)
        q[4:7] += t * v[3:6]
        q[humanoid.actuated_q] += t * v[humanoid.actuated_v]
        return np.concatenate([q, v])

    return move


@pytest.fixture(scope="session")
def contact_wrenches():
    """Add up what a simulated plant says of its contacts."""

    def add(humanoid, plant, context, dynamics):
        """Sum the simulator's own point contacts to the wrench of each line, shape (2, 5)."""
        results = plant.get_contact_results_output_port().Eval(context)
        bodies = [plant.GetBodyByName(foot.frame).index() for foot in humanoid.description.feet]
        out = np.zeros((2, 5))
        for i in range(results.num_point_pair_contacts()):
            info = results.point_pair_contact_info(i)
            on_B = info.bodyB_index() in bodies
            side = bodies.index(info.bodyB_index() if on_B else info.bodyA_index())
            force = info.contact_force() if on_B else -info.contact_force()
            moment = np.cross(info.contact_point() - dynamics.p_WC[side], force)
            out[side] += [*force, *(dynamics.R_WC[side, :, 1:].T @ moment)]
        return out

    return add


# --- a second robot, described without touching code ---------------------------------------

SMALL_BIPEDS = ("small biped", "small biped with arms")
SOLE_BIPED = "sole biped"


@pytest.fixture(scope="session")
def small_biped_files(tmp_path_factory):
    """Descriptions of a second robot, without and with arms, by name."""
    return {
        name: write_small_biped(tmp_path_factory.mktemp("small"), name.endswith("arms"))
        for name in SMALL_BIPEDS
    }


@pytest.fixture(scope="session", params=SMALL_BIPEDS)
def small_biped(request, small_biped_files):
    return load_humanoid(small_biped_files[request.param])


@pytest.fixture(scope="session")
def sole_biped(tmp_path_factory):
    """A robot with legs of six joints that stands on the surface of its soles."""
    return load_humanoid(write_turned_biped(tmp_path_factory.mktemp("soles")))


@pytest.fixture(scope="session", params=["mit_humanoid", *SMALL_BIPEDS, SOLE_BIPED])
def robot(request, small_biped_files):
    """Every robot there is."""
    if request.param == SOLE_BIPED:
        return request.getfixturevalue("sole_biped")
    return load_humanoid(small_biped_files.get(request.param, request.param))
