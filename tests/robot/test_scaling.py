"""Defaults in the size of a robot: a similar robot does the same, a second of it being another."""

from copy import copy
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator

from drake_linefoot.fields import ScaledDefault
from drake_linefoot.gait.parameters import GaitParameters
from drake_linefoot.lab.scenario import PlantParameters, Scenario
from drake_linefoot.robot.dynamics import robot_dynamics
from drake_linefoot.robot.humanoid import load_humanoid
from drake_linefoot.robot.scaling import (
    ratios,
    round_number,
    scaled,
    swing_momentum,
    torso_inertia,
    unit_value,
    units_of,
)
from drake_linefoot.wiring.controller import build_controller
from tests.helpers.ports import look
from tests.helpers.similar import LENGTH, MASS, TIME, similar_robot
from tests.helpers.walking import robot


@pytest.fixture(scope="module")
def small(tmp_path_factory):
    return load_humanoid(similar_robot(tmp_path_factory.mktemp("small")))


def first_tick(humanoid, x, tick):
    """Return what the controller does after a tick with a state: plan, report, torque."""
    plant = PlantParameters(time_step=tick)
    scenario = Scenario(robot=str(humanoid.description.file), plant=plant)
    mpc = replace(scenario.mpc, solver="active_set", model="ecd")  # its knots go by no period
    scenario = replace(scenario, mpc=mpc)
    controller = build_controller(humanoid, scenario)
    context = controller.CreateDefaultContext()
    zero = np.zeros(humanoid.na)
    for name, value in (("state", x), ("command", np.zeros(4)), ("applied_torque", zero)):
        controller.GetInputPort(name).FixValue(context, value)
    simulator = Simulator(controller, context)
    simulator.AdvanceTo(tick)
    said = [look(controller.GetOutputPort(name), context, humanoid) for name in ("plan", "report")]
    return [*said, controller.GetOutputPort("torque").Eval(context)]


def test_a_similar_robot_is_controlled_alike(small):
    """Wrenches and torques of a moving robot differ by what a newton and a metre are to it."""
    h, rng = robot(), np.random.default_rng(5)
    x = np.array(h.x_nominal)
    x[h.nq :] = 0.05 * rng.normal(size=h.nv)
    y = x.copy()
    y[4:7] *= LENGTH
    y[h.nq :] /= TIME
    y[h.nq + 3 : h.nq + 6] *= LENGTH
    assert small.mass == pytest.approx(MASS * h.mass)
    assert small.com_height == pytest.approx(LENGTH * h.com_height)
    plan, report, torque = first_tick(h, x, 0.002)
    plan_s, report_s, torque_s = first_tick(small, y, 0.001)
    assert report.success
    assert report_s.success
    assert np.abs(plan.wrench[0, :, :2]).max() > 1.0  # it has something to do
    units = MASS * np.array([1.0, 1.0, 1.0, LENGTH, LENGTH])
    np.testing.assert_allclose(plan_s.times, plan.times * TIME, atol=1e-12)
    np.testing.assert_allclose(plan_s.wrench / units, plan.wrench, rtol=1e-6, atol=1e-5)
    np.testing.assert_allclose(report_s.wrench / units, report.wrench, rtol=1e-6, atol=1e-5)
    np.testing.assert_allclose(torque_s / (MASS * LENGTH), torque, rtol=1e-6, atol=1e-5)


def test_the_mit_humanoid_has_the_defaults_as_they_are():
    scenario = scaled(Scenario(), robot())
    assert scenario == Scenario()
    assert type(scenario.gait.swing_height) is float
    assert type(scenario.mpc.weights.velocity[1]) is float


def test_a_number_that_is_given_stays(small):
    gait = scaled(GaitParameters(swing_height=0.06), small)
    assert gait.swing_height == 0.06
    assert isinstance(GaitParameters().step_width, ScaledDefault)
    assert gait.step_width == pytest.approx(LENGTH * 0.16)
    assert gait.speed_learning == GaitParameters().speed_learning
    assert gait.single_support == pytest.approx(0.1)  # a multiple of 2 ms


@pytest.mark.parametrize(
    ("unit", "value"),
    [
        ("-", 1.0), ("m", 3.0), ("m/s^2", 3.0 / 25.0), ("1/s", 0.2), ("N", 7.0),
        ("1/(kg m^2/s)^2", (2.0 * 9.0 / 5.0) ** -2), ("rad/s^2", 1.0 / 25.0),
        ("s^2/m^2", 25.0 / 9.0), ("1/(N m)^2", 21.0**-2),
    ],
)  # fmt: skip
def test_units_are_products_of_powers(unit, value):
    base = {"m": 3.0, "s": 5.0, "kg": 2.0, "N": 7.0, "rad": 1.0}
    assert unit_value(unit, base) == pytest.approx(value, rel=1e-14)


@pytest.mark.parametrize(
    ("value", "near"),
    [(0.5, 0.5), (0.17, 0.2), (0.66, 0.5), (0.8, 1.0), (3.1, 2.0), (3.2, 5.0), (0.0029, 0.002)],
)
def test_round_numbers(value, near):
    assert round_number(value) == near


def test_gravity_is_the_same_to_all():
    base = units_of(SimpleNamespace(mass=59.0, com_height=0.88))
    assert base["m"] / base["s"] ** 2 == pytest.approx(1.0)
    assert base["N"] == pytest.approx(base["kg"] * base["m"] / base["s"] ** 2)
    alike = SimpleNamespace(mass=24.86855, com_height=0.65225562)
    assert units_of(alike) == {"m": 1, "s": 1, "kg": 1, "N": 1, "rad": 1}


def test_defaults_keep_to_the_limits_of_the_robot(small):
    limits = small.description.limits
    narrow = replace(limits, step_width_max=0.03, com_height_min=0.165)
    humanoid = copy(small)
    humanoid.description = replace(small.description, limits=narrow)
    gait = scaled(GaitParameters(), humanoid)
    assert limits.step_width_min < gait.step_width < 0.03
    assert 0.165 < gait.com_height < limits.com_height_max
    assert scaled(GaitParameters(step_width=0.2), humanoid).step_width == 0.2


def test_heavy_legs_swing_slowly():
    """Twice the momentum of a leg for the weight takes sqrt(2) times as long."""
    h = robot()
    ratio = ratios(h)
    assert ratio["swing_time"] == 1.0
    np.testing.assert_array_equal(ratio["torso_inertia"], 1.0)
    short = copy(h)
    short.half_length = 0.5 * h.half_length
    assert ratios(short)["swing_time"] == pytest.approx(2.0**0.5)
    assert scaled(GaitParameters(), short).single_support == pytest.approx(0.282)
    assert scaled(GaitParameters(), short).double_support == GaitParameters().double_support


def test_momentum_of_a_swing_and_inertia_of_a_torso():
    """Against Drake's momentum of the motions that they are of."""
    h = robot()
    plant, context, d = (
        h.plant,
        h.plant.CreateDefaultContext(),
        robot_dynamics(h, h.scratch, h.x_nominal),
    )
    v = np.zeros(h.nv)
    leg = h.leg_v[0]
    v[leg] = np.linalg.solve(d.J[0][:, leg], [1.0, 0.0, 0.0, 0.0, 0.0])
    plant.SetPositionsAndVelocities(context, np.concatenate([h.q_nominal, v]))
    L = plant.CalcSpatialMomentumInWorldAboutPoint(context, d.p_WG).rotational()
    assert swing_momentum(h, d) == pytest.approx(abs(L[1]) / (h.mass * h.half_length))
    shares = torso_inertia(h, d)
    assert ((0.0 < shares) & (shares < 1.0)).all()
