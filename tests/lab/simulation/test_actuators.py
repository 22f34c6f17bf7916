from itertools import product

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import LeafSystem

from drake_linefoot.lab.scenario import Scenario, Segment
from drake_linefoot.lab.scenario.disturbances import ActuatorParameters, ErrorParameters
from drake_linefoot.lab.simulation.actuators import Actuators, coulomb_friction, torque_bounds
from drake_linefoot.lab.simulation.run import simulate
from drake_linefoot.lab.wiring.closed_loop import build_closed_loop
from tests.helpers.recorded_runs import SHORT, short_run


def test_the_curve_is_flat_then_falls_to_nothing_at_the_velocity_limit():
    effort, fastest = np.array([40.0]), np.array([20.0])
    for speed, upper in ((0.0, 40.0), (10.0, 40.0), (15.0, 20.0), (20.0, 0.0), (25.0, 0.0)):
        found = torque_bounds(effort, fastest, 0.5, np.array([speed]))
        np.testing.assert_allclose(np.ravel(found), [-40.0, upper])  # it brakes with all it has
        mirrored = torque_bounds(effort, fastest, 0.5, np.array([-speed]))
        np.testing.assert_allclose(np.ravel(mirrored), [-upper, 40.0])
    power = np.linspace(0.0, 20.0, 50) * torque_bounds(40.0, 20.0, 0.5, np.linspace(0, 20, 50))[1]
    assert power.max() == pytest.approx(400.0, rel=1e-3)


def test_friction_opposes_motion_and_has_its_size():
    speed = np.array([-5.0, -0.1, 0.0, 0.1, 5.0])
    friction = coulomb_friction(0.6, speed)
    np.testing.assert_allclose(friction, -friction[::-1])
    np.testing.assert_allclose(friction[3:], [0.6 * np.tanh(1.0), 0.6], rtol=1e-6)
    assert friction[2] == 0.0


@pytest.mark.parametrize(("curve", "friction"), list(product((False, True), (0.0, 0.5))))
def test_alone_at_a_speed(humanoid, curve, friction):
    actuators = Actuators(humanoid, ActuatorParameters(curve, 0.4), friction)
    context = actuators.CreateDefaultContext()
    rng = np.random.default_rng(1)
    torque = rng.uniform(-1, 1, 18) * humanoid.effort_limits
    speed = rng.uniform(-1.2, 1.2, 18) * humanoid.velocity_limits
    x = humanoid.x_nominal.copy()
    x[humanoid.nq + humanoid.actuated_v] = speed
    actuators.GetInputPort("torque").FixValue(context, torque)
    actuators.GetInputPort("state").FixValue(context, x)
    wanted = torque
    if curve:
        limits = torque_bounds(humanoid.effort_limits, humanoid.velocity_limits, 0.4, speed)
        wanted = np.clip(torque, *limits)
        assert (wanted != torque).any()
    wanted = wanted - friction * np.tanh(speed / 0.1)
    np.testing.assert_allclose(actuators.GetOutputPort("actuation").Eval(context), wanted)


@pytest.mark.parametrize("steps", [1, 3, 6])
def test_a_delay_shifts_the_samples_by_whole_steps(humanoid, steps):
    """Alone: the torque of step k is applied in step k + n, and the first ones at once."""
    actuators = Actuators(humanoid, ActuatorParameters(delay=1e-3 * steps))
    simulator = Simulator(actuators)
    context = simulator.get_mutable_context()
    actuators.GetInputPort("state").FixValue(context, humanoid.x_nominal)
    simulator.Initialize()
    applied = []
    for k in range(12):
        actuators.GetInputPort("torque").FixValue(context, np.full(18, float(k)))
        applied.append(actuators.GetOutputPort("actuation").Eval(context)[0])
        simulator.AdvanceTo((k + 1) * 1e-3)
    assert applied == [float(k if k < steps else k - steps) for k in range(12)]


class Counting(LeafSystem):
    """A controller whose torque counts the ticks, seen in its state's time."""

    def __init__(self):
        super().__init__()
        self.set_name("counting")
        self.DeclareVectorInputPort("state", 49)
        self.DeclareVectorOutputPort(
            "torque",
            18,
            lambda context, output: output.SetFromVector(np.full(18, 10.0 * context.get_time())),
            prerequisites_of_calc={self.time_ticket()},
        )


@pytest.mark.parametrize("step", [0.001, 0.002])
def test_in_the_loop_a_delay_shifts_what_the_plant_applies(step):
    """And nothing else: what the estimator gets is what the plant got."""
    scenario = Scenario(actuators=ActuatorParameters(delay=0.004))
    scenario.plant.time_step = step
    loop = build_closed_loop(scenario, controller=Counting())
    simulator = loop.make_simulator()
    simulator.Initialize()
    simulator.AdvanceTo(0.04)
    torque, applied = (loop.recorder.samples(name)[:, 0] for name in ("torque", "applied_torque"))
    n = round(0.004 / step)
    np.testing.assert_allclose(applied[1 + n :], torque[: -1 - n], atol=1e-12)
    np.testing.assert_allclose(applied[1 : 1 + n], torque[:n], atol=1e-12)


def test_in_the_walk_a_delay_costs_no_second_tick_of_the_controller(wbc_ticks):
    delayed = Scenario(segments=SHORT.segments, actuators=ActuatorParameters(delay=0.003))
    run = simulate(build_closed_loop(delayed))
    assert not run.fell
    assert len(wbc_ticks) == len(run.time)
    np.testing.assert_allclose(run.applied_torque[4:], run.torque[:-4], atol=1e-12)


def test_perfect_actuators_are_no_system():
    assert build_closed_loop(SHORT).actuators is None
    idle = Scenario(segments=SHORT.segments, actuators=ActuatorParameters(True, 0.99))
    loop = build_closed_loop(idle)
    assert loop.actuators is not None
    np.testing.assert_array_equal(simulate(loop).q, short_run().q)


@pytest.mark.slow
@pytest.mark.parametrize(
    "scenario",
    [
        Scenario(actuators=ActuatorParameters(torque_speed=True)),
        Scenario(actuators=ActuatorParameters(delay=0.003)),
        Scenario(error=ErrorParameters(joint_friction=0.5)),
    ],
    ids=["curve", "delay", "friction"],
)
def test_it_walks_with_real_actuators(scenario):
    scenario.segments = [Segment("stand", 0.3), Segment("walk", 2.0, True, [0.4, 0.0])]
    run = simulate(build_closed_loop(scenario))
    assert not run.fell, run.fall_reason
    assert run.com[-1, 0] > 0.4
