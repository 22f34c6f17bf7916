"""Our own rigid-body dynamics against Drake's calls, on robots and on trees of all kinds."""

import numpy as np
import pytest
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import (
    RevoluteJoint,
    ScrewJoint,
    SpatialInertia,
    UniversalJoint,
)

from drake_linefoot.contact.contacts import LineContact
from drake_linefoot.lab.plants.scene import apply_error
from drake_linefoot.lab.scenario.disturbances import ErrorParameters
from drake_linefoot.layout import Layout
from drake_linefoot.math.compiled import as_python
from drake_linefoot.robot import dynamics
from drake_linefoot.robot.dynamics import (
    dynamics_by_drake,
    dynamics_layout,
    dynamics_of_tree,
    robot_dynamics,
)
from drake_linefoot.robot.tree_model import read_tree
from drake_linefoot.signals import RobotDynamics, open_dynamics
from tests.helpers import made_up_robots
from tests.helpers.made_up_trees import MadeUp, random_state
from tests.lab.new_robot.test_analysis import ROBOTS as MADE_UP

SEEDS = range(6)
STATES = 40
NEAR = 1e-10  # [-] of the largest number of a quantity, or of 1
BY_DIFFERENCE = 1e-7  # likewise, where Drake's calls have a difference of M


def check_against_drake(robot, context=None, states=STATES, seed=0):
    """Compare every quantity over random states."""
    context = context or robot.plant.CreateDefaultContext()
    assert robot.tree(context) is not None
    rng = np.random.default_rng(seed)
    for _ in range(states):
        x = random_state(robot, rng, speed=3.0)
        own, drake = robot_dynamics(robot, context, x), dynamics_by_drake(robot, context, x)
        for name, found, expected in zip(RobotDynamics._fields, own, drake, strict=True):
            near = BY_DIFFERENCE if name == "CTv" else NEAR
            scale = max(1.0, np.abs(expected).max())
            np.testing.assert_allclose(found, expected, rtol=0, atol=near * scale, err_msg=name)


# --- made-up trees ------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(12))
def test_trees_of_all_kinds(seed):
    check_against_drake(MadeUp(seed, links=seed + 1), seed=seed)


def test_a_base_without_joints():
    check_against_drake(MadeUp(3, links=0))


def test_what_does_not_hang_on_the_base_does_not_count():
    check_against_drake(MadeUp(5, beside=True))
    alone, beside = (MadeUp(5, beside=beside) for beside in (False, True))
    x = random_state(alone, np.random.default_rng(1))
    for one, other in zip(*(robot_dynamics(r, None, x) for r in (alone, beside)), strict=True):
        np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize("seed", SEEDS)
def test_coriolis_transpose_is_what_is_left_of_the_rate_of_momentum(seed):
    """dp/dt = C'v where M vdot = -Cv: no force at all; by a difference along that motion."""
    robot = MadeUp(seed)
    x = random_state(robot, np.random.default_rng(seed))
    d, h = robot_dynamics(robot, None, x), 1e-5
    context = robot.plant.CreateDefaultContext()
    robot.plant.SetPositions(context, d.q)
    vdot = -np.linalg.solve(d.M, d.Cv)
    p = []
    for t in (h, -h):
        qdot = robot.plant.MapVelocityToQDot(context, d.v + 0.5 * t * vdot)
        x_t = np.concatenate([d.q + t * qdot, d.v + t * vdot])
        near = robot_dynamics(robot, None, x_t)
        p.append(near.M @ near.v)
    rate = (p[0] - p[1]) / (2.0 * h)
    np.testing.assert_allclose(d.CTv, rate, rtol=0, atol=2e-6 * np.abs(rate).max())


@pytest.mark.parametrize("seed", SEEDS)
def test_passivity_energy_and_momentum(seed):
    """Coriolis forces do no work beside that of Mdot, and the whole robot obeys Newton."""
    robot = MadeUp(seed)
    d = robot_dynamics(robot, None, random_state(robot, np.random.default_rng(seed)))
    scale = np.abs(d.Cv).max()
    assert d.v @ d.CTv == pytest.approx(d.v @ d.Cv, abs=1e-12 * scale * np.abs(d.v).sum())
    vdot = np.linalg.solve(d.M, d.tau_g - d.Cv)  # falling
    rate = d.A @ vdot + d.Adot_v
    np.testing.assert_allclose(rate[:3], 0.0, rtol=0, atol=1e-10 * scale)
    mass = d.M[3, 3]
    np.testing.assert_allclose(rate[3:], [0, 0, -9.81 * mass], rtol=0, atol=1e-10 * scale)
    np.testing.assert_array_equal(d.M, d.M.T)
    np.linalg.cholesky(d.M)


# --- robots -------------------------------------------------------------------------------------


def test_every_robot_there_is(robot):
    check_against_drake(robot, states=200)


@pytest.mark.parametrize("name", MADE_UP)
def test_robots_of_the_zoo(name, tmp_path):
    """Parsed as they are, with every joint they have."""
    tree = made_up_robots.mit()
    MADE_UP[name](tree)
    check_against_drake(Parsed(made_up_robots.write(tree, tmp_path)))


class Parsed(MadeUp):
    """The tree of a URDF."""

    def __init__(self, file):
        self.plant = MultibodyPlant(0.0)
        Parser(self.plant).AddModels(str(file))
        self.plant.Finalize()
        self.world, self.contact = self.plant.world_frame(), LineContact(0.1)
        (index,) = self.plant.GetFloatingBaseBodies()
        self.base = self.plant.get_body(index)
        self.foot_frames = [
            self.plant.GetFrameByName(f"{side}_foot_link") for side in made_up_robots.SIDES
        ]
        self.p_FC = np.array([[0.03, 0.0, -0.04], [0.02, 0.01, -0.05]])
        self.nq, self.nv = self.plant.num_positions(), self.plant.num_velocities()


def test_masses_are_those_of_the_context(humanoid):
    """A context with model errors is another robot, and the nominal one stays as it is."""
    context = humanoid.plant.CreateDefaultContext()
    error = ErrorParameters(torso_mass=2.0, torso_com=[0.02, -0.01, 0.03], leg_mass_scale=1.2)
    apply_error(humanoid.plant, context, humanoid, error)
    motor = humanoid.plant.get_joint_actuator(humanoid.plant.GetJointActuatorIndices()[3])
    motor.SetRotorInertia(context, 2.0 * motor.default_rotor_inertia())
    check_against_drake(humanoid, context, states=100)
    nominal = robot_dynamics(humanoid, humanoid.scratch, humanoid.x_nominal)
    other = robot_dynamics(humanoid, context, humanoid.x_nominal)
    assert nominal.M[3, 3] == pytest.approx(humanoid.mass, rel=1e-14)
    assert other.M[3, 3] > humanoid.mass + 2.0
    check_against_drake(humanoid, states=5)


# --- how it is computed -------------------------------------------------------------------------


@pytest.mark.parametrize("kind", [ScrewJoint, UniversalJoint])
def test_other_joints_are_left_to_drake(kind):
    robot = MadeUp(2, kinds=(RevoluteJoint, kind))
    assert robot.tree(None) is None
    x = random_state(robot, np.random.default_rng(0))
    d = robot_dynamics(robot, robot.plant.CreateDefaultContext(), x)
    context = robot.plant.CreateDefaultContext()
    robot.plant.SetPositionsAndVelocities(context, x)
    np.testing.assert_array_equal(d.M, robot.plant.CalcMassMatrix(context).T)
    np.testing.assert_array_equal(d.Cv, robot.plant.CalcBiasTerm(context))
    com = robot.plant.CalcCenterOfMassPositionInWorld(context)
    np.testing.assert_allclose(d.p_WG, com, rtol=0, atol=1e-12)
    assert d.v @ d.CTv == pytest.approx(d.v @ d.Cv, abs=1e-6 * np.abs(d.Cv).max())


def test_another_tree_in_the_plant_is_left_to_drake():
    plant = MultibodyPlant(0.0)
    ball = SpatialInertia.SolidSphereWithMass(1.0, 0.1)
    base, _ = (plant.AddRigidBody(name, ball) for name in ("base", "ball"))
    plant.Finalize()
    context, frames = plant.CreateDefaultContext(), [base.body_frame()] * 2
    assert read_tree(plant, context, base, frames, np.zeros((2, 3))) is None


def test_the_same_state_gives_the_same_bits(robot):
    """Whatever was computed before, in whatever context, and whatever state that is in."""
    rng = np.random.default_rng(0)
    x, contexts = random_state(robot, rng), [robot.plant.CreateDefaultContext() for _ in range(2)]
    robot.plant.SetPositionsAndVelocities(contexts[1], random_state(robot, rng))
    first = robot_dynamics(robot, contexts[0], x)
    robot_dynamics(robot, contexts[0], random_state(robot, rng))
    for context in contexts:
        for one, other in zip(first, robot_dynamics(robot, context, x), strict=True):
            np.testing.assert_array_equal(one, other)


def test_what_was_given_and_what_was_returned_are_not_tied(humanoid):
    x = humanoid.x_nominal
    d, before = robot_dynamics(humanoid, humanoid.scratch, x), x.copy()
    for part in d:
        part[...] = 7.0
    np.testing.assert_array_equal(x, before)
    assert robot_dynamics(humanoid, humanoid.scratch, x).M[3, 3] != 7.0


@pytest.mark.parametrize(("nv", "nw"), [(6, 3), (7, 5), (24, 5), (31, 6)])
def test_the_layout_has_a_place_for_every_number(nv, nw):
    """Each once; Python's views are those of compiled code."""
    layout = Layout(RobotDynamics, {"nv": nv, "nw": nw})
    flat = np.arange(float(layout.size))
    views, opened = layout.open(flat), open_dynamics
    for parts in (views, opened(flat, nv, nw), as_python(opened)(flat, nv, nw)):
        assert type(parts) is RobotDynamics
        numbers = np.concatenate([part.ravel() for part in parts])
        np.testing.assert_array_equal(np.sort(numbers), flat)
        assert all(np.shares_memory(part, flat) for part in parts)
        for one, other in zip(parts, views, strict=True):
            np.testing.assert_array_equal(one, other)
    assert (len(parts.q), len(parts.v), parts.M.shape) == (nv + 1, nv, (nv, nv))


def test_views_keep_the_array_alive(humanoid):
    layout = dynamics_layout(humanoid)
    parts = [layout.open(np.full(layout.size, float(i))) for i in range(50)]
    assert [part.M.min() for part in parts] == list(range(50))


def test_robots_of_any_size_share_the_machine_code(robot):
    """Nothing is compiled anew for another number of velocities."""
    functions = dynamics_of_tree, dynamics.complete, open_dynamics
    before = None
    for made in (MadeUp(0, links=3), robot, MadeUp(1, links=8)):
        x = random_state(made, np.random.default_rng(0))
        context = made.plant.CreateDefaultContext()
        robot_dynamics(made, context, x)
        dynamics_by_drake(made, context, x)
        found = [len(getattr(function, "signatures", ())) for function in functions]
        assert before in (None, found)
        before = found


def test_an_upright_line_is_refused(humanoid):
    x = humanoid.x_nominal
    x[:4] = [np.sqrt(0.5), 0.0, np.sqrt(0.5), 0.0]  # nose down; soles are level in the posture
    with pytest.raises(ValueError, match="upright"):
        robot_dynamics(humanoid, humanoid.scratch, x)
