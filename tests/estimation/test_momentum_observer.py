"""The momentum observer (19)-(21) against AutoDiff, forward dynamics and a simulated robot."""

from types import SimpleNamespace

import numpy as np
import pytest
from pydrake.autodiffutils import ExtractGradient, InitializeAutoDiff
from pydrake.common.value import AbstractValue
from pydrake.multibody.math import SpatialForce
from pydrake.multibody.plant import (
    AddMultibodyPlant,
    ExternallyAppliedSpatialForce,
    MultibodyPlantConfig,
)
from pydrake.multibody.tree import JacobianWrtVariable, PdControllerGains
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantValueSource, ConstantVectorSource

from drake_linefoot.estimation.contact_estimator import ContactEstimator
from drake_linefoot.estimation.contact_parameters import EstimatorParameters
from drake_linefoot.estimation.momentum_observer import momentum_terms, update_residual
from drake_linefoot.lab.plants.scene import add_ground
from drake_linefoot.lab.scenario.scene import load_scene
from drake_linefoot.robot.dynamics import robot_dynamics
from drake_linefoot.robot.state_dynamics import StateDynamics
from tests.helpers.feet import feet_of
from tests.helpers.ports import look

SEEDS = range(4)


def contexts(robot):
    return robot.plant.CreateDefaultContext(), robot.plant.CreateDefaultContext()


# --- the terms of (20) ----------------------------------------------------------------------


@pytest.mark.parametrize("seed", SEEDS)
def test_coriolis_transpose_is_that_of_autodiff(robot, walking_state, seed):
    """C'v = Mdot v - C v, with Mdot the exact derivative of M along the motion."""
    x = walking_state(robot, seed)
    q, v = x[: robot.nq], x[robot.nq :]
    context = robot.plant.CreateDefaultContext()
    robot.plant.SetPositionsAndVelocities(context, x)
    Cv, qdot = robot.plant.CalcBiasTerm(context), robot.plant.MapVelocityToQDot(context, v)
    found = robot_dynamics(robot, context, x).CTv

    exact = robot.plant.ToAutoDiffXd()
    exact_context = exact.CreateDefaultContext()
    exact.SetPositions(exact_context, InitializeAutoDiff(q, gradient=qdot[:, None]))
    M = exact.CalcMassMatrix(exact_context)
    Mdot = ExtractGradient(M).reshape(robot.nv, robot.nv)  # symmetric: its order is no matter
    expected = Mdot @ v - Cv
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12 * np.abs(expected).max())


@pytest.mark.parametrize("seed", SEEDS)
def test_coriolis_transpose_does_the_same_work(robot, walking_state, seed):
    """v' C' v = v' C v, and it is quadratic in the velocities."""
    x = walking_state(robot, seed)
    context, faster = robot.plant.CreateDefaultContext(), x.copy()
    faster[robot.nq :] *= -2.0
    d, e = (robot_dynamics(robot, context, y) for y in (x, faster))
    assert d.v @ d.CTv == pytest.approx(d.v @ d.Cv, abs=1e-11)
    np.testing.assert_allclose(e.CTv, 4.0 * d.CTv, rtol=0, atol=1e-11)


@pytest.mark.parametrize("seed", SEEDS)
def test_momentum_changes_as_the_equation_of_motion_says(robot, walking_state, advance, seed):
    """(20): dp/dt less the known terms and the torques is the force of the contacts."""
    x = walking_state(robot, seed)
    context, scratch = contexts(robot)
    robot.plant.SetPositionsAndVelocities(context, x)
    d = robot_dynamics(robot, context, x)
    rng = np.random.default_rng(seed)
    nw = robot.contact.size
    wrenches = rng.normal(size=(2, nw)) * [40, 40, 120, 8, 4, 4][:nw]
    contact = sum(foot.J.T @ w for foot, w in zip(feet_of(d), wrenches, strict=True))
    actuation = np.zeros(robot.nv)
    actuation[robot.actuated_v] = 20.0 * rng.normal(size=robot.na)
    gravity = robot.plant.CalcGravityGeneralizedForces(context)
    Cv = robot.plant.CalcBiasTerm(context)
    vdot = np.linalg.solve(d.M, actuation + gravity + contact - Cv)

    def momentum(t):
        """Momentum on the true motion, with an error of order t^3."""
        mean = np.concatenate([d.q, d.v + 0.5 * t * vdot])
        moved = advance(robot, mean, t)
        robot.plant.SetPositions(scratch, moved[: robot.nq])
        return robot.plant.CalcMassMatrix(scratch) @ (d.v + t * vdot)

    p, terms_known = momentum_terms(d, d.v)
    np.testing.assert_allclose(p, momentum(0.0), rtol=0, atol=1e-12)
    h = 1e-6
    rate = (momentum(h) - momentum(-h)) / (2 * h)
    scale = np.abs(rate).max()
    np.testing.assert_allclose(terms_known, rate - actuation - contact, rtol=0, atol=1e-7 * scale)


# --- the update (21) ------------------------------------------------------------------------


def test_update_with_numbers_by_hand():
    """Momentum from 1 to 3 in 0.5 s is a force of 4; 1.5 is known and 0.5 the motor's."""
    rate, known = (np.array([3.0, 0.0]) - np.array([1.0, 0.0])) / 0.5, np.array([1.5, 0.0])
    actuation, held = np.array([0.5, -1.0]), np.array([10.0, 10.0])
    found = update_residual(held, rate, known, actuation, 0.0)
    np.testing.assert_array_equal(found, [2.0, 1.0])
    found = update_residual(held, rate, known, actuation, 0.75)
    np.testing.assert_array_equal(found, [8.0, 7.75])


def test_the_filter_has_the_gain_one_and_forgets():
    nothing, known = np.zeros(3), np.array([-7.0, 0.0, 2.0])
    residual = np.array([100.0, 100.0, -100.0])
    for count in range(1, 60):
        residual = update_residual(residual, nothing, known, nothing, 0.7)
        expected = np.array([7.0, 0.0, -2.0]) + 0.7**count * np.array([93.0, 100.0, -98.0])
        np.testing.assert_allclose(residual, expected, rtol=0, atol=1e-11)


# --- a simulated robot ----------------------------------------------------------------------


def held_robot(humanoid, contact_wrenches, push, ground=True, **parameters):
    """The robot with stiff joints on the ground, pushed at the torso's origin; the estimator.

    Drake's own implicit joint controllers hold the posture.
    """
    builder = DiagramBuilder()
    config = MultibodyPlantConfig(time_step=1e-3, contact_model="point")
    config.discrete_contact_approximation = "lagged"
    plant, _ = AddMultibodyPlant(config, builder)
    humanoid.add_to(plant)
    if ground:
        add_ground(plant, load_scene("flat_ground"))
    for index in plant.GetJointActuatorIndices():
        plant.get_joint_actuator(index).set_controller_gains(PdControllerGains(p=800, d=20))
    plant.Finalize()
    estimator = builder.AddSystem(
        ContactEstimator(humanoid, EstimatorParameters(filter_constant=0.0, **parameters))
    )
    posture = np.concatenate([humanoid.q_nominal[humanoid.actuated_q], np.zeros(humanoid.na)])
    hold = builder.AddSystem(ConstantVectorSource(posture))
    applied = ExternallyAppliedSpatialForce()
    torso = plant.GetBodyByName(humanoid.description.floating_base)
    applied.body_index, applied.p_BoBq_B = torso.index(), np.zeros(3)
    applied.F_Bq_W = SpatialForce(np.zeros(3), np.array(push, dtype=float))
    hand = builder.AddSystem(ConstantValueSource(AbstractValue.Make([applied])))
    builder.Connect(
        hold.get_output_port(), plant.get_desired_state_input_port(torso.model_instance())
    )
    builder.Connect(hand.get_output_port(), plant.get_applied_spatial_force_input_port())
    state = builder.AddSystem(StateDynamics(humanoid))
    builder.Connect(plant.get_state_output_port(), state.get_state_input_port())
    builder.Connect(state.get_dynamics_output_port(), estimator.get_dynamics_input_port())
    builder.Connect(
        plant.get_net_actuation_output_port(), estimator.get_applied_torque_input_port()
    )
    diagram = builder.Build()
    simulator = Simulator(diagram)
    root = simulator.get_mutable_context()
    context = plant.GetMyMutableContextFromRoot(root)
    plant.SetPositionsAndVelocities(context, humanoid.x_nominal)
    own = estimator.GetMyContextFromRoot(root)
    scratch = humanoid.plant.CreateDefaultContext()

    def until(time):
        """Advance and return what is estimated and what is."""
        simulator.AdvanceTo(time)
        x = plant.get_state_output_port().Eval(context)
        dynamics = robot_dynamics(humanoid, scratch, x)
        return SimpleNamespace(
            estimate=look(estimator.get_contact_output_port(), own, humanoid),
            wrench=contact_wrenches(humanoid, plant, context, dynamics),
            dynamics=dynamics,
        )

    until.diagram = diagram  # or it is collected before the simulator
    return until


def test_standing_it_sees_the_simulators_contact_forces(humanoid, contact_wrenches):
    """Within 0.05 N and N m, all ten numbers, while the robot still rocks a little."""
    until = held_robot(humanoid, contact_wrenches, [0.0, 0.0, 0.0])
    for time in (0.05, 0.1, 0.2, 0.3):
        seen = until(time)
        total = seen.wrench[:, 2].sum()
        assert total == pytest.approx(humanoid.mass * 9.81, rel=0.15)  # it rocks
        np.testing.assert_allclose(seen.estimate.wrench, seen.wrench, rtol=0, atol=0.05)
        np.testing.assert_array_equal(seen.estimate.contact, [1.0, 1.0])


def test_a_force_that_lasts_is_known_and_not_taken_for_one_of_the_feet(humanoid, contact_wrenches):
    """At the torso's origin; in 2 s within 0.3 N, 0.2 N m, and the feet within 1 N."""
    push = np.array([15.0, 8.0, -12.0])
    until = held_robot(humanoid, contact_wrenches, push)
    seen = until(2.0)
    d, external = seen.dynamics, seen.estimate.external
    np.testing.assert_allclose(external[3:], push, rtol=0, atol=0.3)
    np.testing.assert_allclose(external[:3], np.cross(d.p_WB - d.p_WG, push), rtol=0, atol=0.2)
    np.testing.assert_allclose(seen.estimate.wrench, seen.wrench, rtol=0, atol=1.0)


def test_a_push_is_taken_for_contact_forces_of_the_feet(humanoid, contact_wrenches):
    """The residual holds contacts and push; where it is not known the feet are blamed for it.

    Only two line contacts are looked for, so a push elsewhere shows up as the foot wrenches
    that come closest to its generalized force, on top of the true ones.
    """
    push = np.array([15.0, 8.0, -30.0])
    context = humanoid.plant.CreateDefaultContext()
    until = held_robot(humanoid, contact_wrenches, push, external_time=0.0)
    for time in (0.1, 0.2, 0.4):
        seen = until(time)
        d, residual = seen.dynamics, seen.estimate.residual
        moments = [
            np.cross(foot.p_WC - d.p_WB, w[:3]) + foot.R_WC @ [0.0, *w[3:]]
            for foot, w in zip(feet_of(d), seen.wrench, strict=True)
        ]
        # The push acts at the torso's origin: it has no moment about it.
        np.testing.assert_allclose(
            residual[3:6], seen.wrench[:, :3].sum(axis=0) + push, rtol=0, atol=0.2
        )
        np.testing.assert_allclose(residual[:3], np.sum(moments, axis=0), rtol=0, atol=0.2)
        # The joints see the true contacts alone.
        J = np.vstack([foot.J for foot in feet_of(d)])
        np.testing.assert_allclose(residual[6:], (J.T @ seen.wrench.ravel())[6:], rtol=0, atol=0.2)
        humanoid.plant.SetPositions(context, d.q)
        J_torso = humanoid.plant.CalcJacobianTranslationalVelocity(
            context,
            JacobianWrtVariable.kV,
            humanoid.base.body_frame(),
            np.zeros(3),
            humanoid.plant.world_frame(),
            humanoid.plant.world_frame(),
        )
        blamed = (np.linalg.pinv(J.T) @ J_torso.T @ push).reshape(2, 5)
        assert np.abs(blamed[:, 2]).max() > 3.0
        np.testing.assert_allclose(seen.estimate.wrench - seen.wrench, blamed, rtol=0, atol=0.2)


def test_in_free_fall_there_is_nothing(humanoid, contact_wrenches):
    until = held_robot(humanoid, contact_wrenches, [0.0, 0.0, 0.0], ground=False)
    seen = until(0.1)
    np.testing.assert_allclose(seen.estimate.residual, 0.0, rtol=0, atol=0.05)
    np.testing.assert_allclose(seen.estimate.wrench, 0.0, rtol=0, atol=0.1)
    np.testing.assert_array_equal(seen.estimate.contact, [0.0, 0.0])
