import numpy as np
import pytest
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import LeafSystem
from scipy.spatial.transform import Rotation

from drake_linefoot.lab.scenario import Scenario, Segment
from drake_linefoot.lab.scenario.disturbances import SensorParameters
from drake_linefoot.lab.simulation.run import simulate
from drake_linefoot.lab.simulation.sensors import (
    Sensors,
    measured_state,
    noise_source,
    seed_noise,
    state_noise,
)
from drake_linefoot.lab.wiring.closed_loop import build_closed_loop
from tests.helpers.recorded_runs import SHORT, short_run

SIZES = SensorParameters(1e-3, 2e-2, 3e-3, 4e-2, 5e-3, 6e-2)


def rotation(q):
    return Rotation.from_quat(np.roll(q[:4], -1))


def test_without_noise_the_state_is_the_state(humanoid, walking_state):
    x = walking_state(humanoid, 0)
    noise = np.random.default_rng(0).normal(size=48)
    y = measured_state(humanoid, SensorParameters(), x, noise)
    np.testing.assert_allclose(y, x, rtol=0, atol=1e-15)
    assert SensorParameters().are_perfect and not SIZES.are_perfect


def test_the_noise_has_its_sizes(humanoid, walking_state):
    """To 5 %: four standard errors of 4000 samples are 4.5 %."""
    x = walking_state(humanoid, 1)
    source = noise_source(state_noise(humanoid), 0.001)
    sensors = Sensors(humanoid, SIZES)
    simulator = Simulator(source)
    context = simulator.get_mutable_context()
    seed_noise(source, context, 3)
    mine = sensors.CreateDefaultContext()
    sensors.GetInputPort("state").FixValue(mine, x)
    samples = []
    for k in range(4000):
        simulator.AdvanceTo(1e-3 * k)
        noise = source.get_output_port().Eval(context)
        sensors.GetInputPort("noise").FixValue(mine, noise)
        samples.append(sensors.GetOutputPort("measured").Eval(mine))
    samples = np.array(samples)
    change = samples - x
    q, v = change[:, :25], change[:, 25:]
    turns = (rotation(x).inv() * Rotation.from_quat(np.roll(samples[:, :4], -1, 1))).as_rotvec()
    for values, size in (
        (q[:, humanoid.actuated_q], 1e-3),
        (v[:, humanoid.actuated_v], 2e-2),
        (turns, 3e-3),
        (v[:, :3], 4e-2),
        (q[:, 4:7], 5e-3),
        (v[:, 3:6], 6e-2),
    ):
        np.testing.assert_allclose(values.std(axis=0), size, rtol=0.05)
        np.testing.assert_allclose(values.mean(axis=0), 0.0, atol=4.5 * size / np.sqrt(4000))
        follows = np.mean(values[1:] * values[:-1], axis=0) / size**2  # white
        np.testing.assert_allclose(follows, 0.0, atol=4.5 / np.sqrt(4000))
    np.testing.assert_allclose(np.linalg.norm(samples[:, :4], axis=1), 1.0, atol=1e-12)
    correlation = np.corrcoef(np.hstack([turns, q[:, 4:], v]).T)
    assert np.abs(correlation - np.eye(len(correlation))).max() < 0.08


def test_encoders_have_steps(humanoid, walking_state):
    x = walking_state(humanoid, 2)
    parameters = SensorParameters(joint_position=1e-3, encoder_resolution=0.01)
    noise = np.random.default_rng(1).normal(size=48)
    angles = measured_state(humanoid, parameters, x, noise)[humanoid.actuated_q]
    steps = angles / 0.01
    np.testing.assert_allclose(steps, np.round(steps), atol=1e-9)
    true = x[humanoid.actuated_q] + 1e-3 * noise[:18]
    assert np.abs(angles - true).max() <= 0.005 + 1e-12


def test_noise_follows_the_seed(humanoid):
    """Whatever other sources there were in this process."""

    def samples(seed):
        source = noise_source(state_noise(humanoid), 0.001)
        simulator = Simulator(source)
        seed_noise(source, simulator.get_mutable_context(), seed)
        simulator.AdvanceTo(0.01)
        return source.get_output_port().Eval(simulator.get_context())

    np.testing.assert_array_equal(samples(7), samples(7))
    assert (samples(7) != samples(8)).all()
    assert np.isfinite(samples(2**62)).all()


def test_sensors_are_a_direct_feedthrough_of_state_and_noise(humanoid):
    sensors = Sensors(humanoid, SIZES)
    assert sensors.HasDirectFeedthrough(0, 0) and sensors.HasDirectFeedthrough(1, 0)
    context = sensors.CreateDefaultContext()
    with pytest.raises(RuntimeError, match="state"):
        sensors.GetOutputPort("measured").Eval(context)


class Watching(LeafSystem):
    """A controller without torque that keeps what its updates and its output see."""

    def __init__(self):
        super().__init__()
        self.set_name("watching")
        self.updates, self.outputs = [], []
        state = self.DeclareVectorInputPort("state", 49)
        self.DeclareDiscreteState(1)

        def update(context, discrete):
            self.updates.append(state.Eval(context))

        def torque(context, output):
            self.outputs.append(state.Eval(context))
            output.SetFromVector(np.zeros(18))

        self.DeclarePeriodicDiscreteUpdateEvent(0.001, 0.0, update)
        self.DeclareVectorOutputPort("torque", 18, torque, prerequisites_of_calc={state.ticket()})


def test_an_update_measures_the_state_after_the_plants_step():
    """The same measurement that the output sees in the step that follows."""
    controller = Watching()
    scenario = Scenario(sensors=SIZES)
    loop = build_closed_loop(scenario, controller=controller)
    simulator = loop.make_simulator()
    simulator.Initialize()
    simulator.AdvanceTo(0.02)
    updates, outputs = np.array(controller.updates), np.array(controller.outputs)
    assert len(outputs) == 21 and len(updates) == 20
    np.testing.assert_array_equal(updates, outputs[1:])
    q = loop.recorder.samples("q")
    assert np.abs(outputs[:, :25] - q).max() > 1e-3  # the recorder has the true state
    np.testing.assert_allclose(q[0], loop.humanoid.q_nominal, atol=1e-15)


def test_it_walks_with_noise_and_the_run_is_repeatable():
    sensors = SensorParameters(1e-4, 0.02, 1e-3, 0.01, 1e-3, 0.01, 1e-4)
    scenario = Scenario(seed=2, segments=SHORT.segments, sensors=sensors)
    run, again = (simulate(build_closed_loop(scenario)) for _ in range(2))
    assert not run.fell
    np.testing.assert_array_equal(run.q, again.q)
    assert np.abs(run.q - short_run().q).max() > 1e-5


@pytest.mark.slow
def test_it_walks_at_speed_with_noise_on_all_but_the_linear_velocity():
    sensors = SensorParameters(1e-4, 0.05, 1e-3, 0.01, 1e-3, 0.0, 1e-4)
    segments = [Segment("stand", 0.3), Segment("walk", 2.0, True, [0.4, 0.0])]
    run = simulate(build_closed_loop(Scenario(segments=segments, sensors=sensors)))
    assert not run.fell, run.fall_reason
    assert run.com[-1, 0] > 0.4
