"""Walking on the estimate: the loop with `estimation: true`, and what it says when it is lost."""

from dataclasses import replace

import numpy as np
import pytest

from drake_linefoot.errors import EstimateError, InputError, ScenarioError
from drake_linefoot.lab.results.plots import estimation
from drake_linefoot.lab.scenario import Scenario, Segment
from drake_linefoot.lab.scenario.load import load_scenario
from drake_linefoot.lab.simulation.recording import CHANNELS, WALL_TIMES
from drake_linefoot.lab.simulation.run import fall_of, simulate
from drake_linefoot.lab.wiring.closed_loop import build_closed_loop
from tests.helpers.recorded_runs import SHORT, Limp, short_run

WALK = Scenario(
    estimation=True,
    segments=[Segment("stand", 0.8), Segment("walk", 2.2, True, [0.4, 0.0], 0.3)],
)
ESTIMATE = [name for name, channel in CHANNELS.items() if channel.signal == "estimate"]


@pytest.fixture(scope="module")
def run():
    return simulate(build_closed_loop(WALK))


def test_it_walks_and_the_estimate_is_near_the_truth(run):
    assert not run.fell
    settled = run.time > 0.5
    tilt, _, velocity, _, nis = estimation(run).panels
    (sigma, error), late = tilt.lines, settled
    assert error.values[late].max() < np.radians(0.5)
    assert (error.values < sigma.values)[late].mean() > 0.95
    speed = velocity.lines[1].values[late]
    assert np.sqrt(np.mean(speed**2)) < 0.02
    way = np.linalg.norm(run.q[-1, 4:6] - run.q[0, 4:6])
    assert way > 0.4  # as the crow flies
    off = np.linalg.norm(run.estimate_pose[-1, 4:6] - run.q[-1, 4:6])
    assert off < 0.02 * way
    assert abs(run.estimate_pose[-1, 6] - run.q[-1, 6]) < 0.01
    assert np.nanmean(nis.lines[0].values) < 9.0


@pytest.mark.slow
def test_with_an_imu_5_ms_late_it_walks():
    """Taken as the state of now, the estimate of then makes a standing robot shake from 2 ms on."""
    onboard = replace(WALK.onboard, imu_delay=0.005)
    late = simulate(build_closed_loop(replace(WALK, onboard=onboard)))
    assert not late.fell, late.fall_reason
    error = (late.estimate_velocity - late.v[:, :6])[late.time > 0.5, 3:]
    assert np.sqrt(np.mean(np.sum(error**2, axis=1))) < 0.02
    standing = (late.time > 0.3) & (late.time < 0.8)
    assert np.abs(late.v[standing, :3]).max() < 0.1


def test_what_is_recorded_of_the_robot_is_the_truth(run):
    """The estimate is beside it: noise of the gyroscope is in one and not in the other."""
    rough, smooth = run.estimate_velocity[1:, :3], run.v[1:, :3]
    assert np.abs(np.diff(rough, 2, axis=0)).mean() > np.abs(np.diff(smooth, 2, axis=0)).mean()
    assert not np.array_equal(rough, smooth)


def test_the_same_seed_gives_the_same_bits_and_another_one_others():
    short = replace(WALK, segments=[Segment("stand", 0.05)])
    first, again = (simulate(build_closed_loop(short)) for _ in range(2))
    other = simulate(build_closed_loop(replace(short, seed=1)))
    for name in CHANNELS:
        if name not in WALL_TIMES:
            np.testing.assert_array_equal(getattr(first, name), getattr(again, name), err_msg=name)
    assert not np.array_equal(first.estimate_pose, other.estimate_pose)


def test_off_nothing_of_it_is_in_the_loop_or_the_recording():
    loop = build_closed_loop(SHORT)
    assert loop.estimator is None and loop.onboard is None
    names = {system.get_name() for system in loop.GetSystems()}
    assert not names & {"state_estimator", "onboard", "noise", "true_dynamics"}
    for name in ESTIMATE:
        assert np.isnan(getattr(short_run(), name)).all()


def test_a_sensor_that_breaks_ends_the_run_and_is_named():
    loop = build_closed_loop(WALK)

    def cut(root):
        if root.get_time() > 0.1:
            context = loop.onboard.GetMyMutableContextFromRoot(root)
            state = context.get_discrete_state_vector().value().copy()
            state[3] = np.nan  # bias of the accelerometer
            context.SetDiscreteState(state)

    broken = simulate(loop, look=cut)
    assert broken.fell and broken.fall_time < 0.2
    assert "state_estimator.imu: element 3 is nan" in broken.fall_reason


@pytest.mark.parametrize(
    ("height", "reason"),
    [
        (0.1, r"did not rest in the first 0\.5 s"),  # it lands after 0.14 s, [m]
        (0.4, r"did not rest in the first 0\.5 s"),  # after 0.29 s
        (1.0, r"no contact has agreed with the IMU for 0\.3 s"),  # after 0.45 s
    ],
)
def test_a_robot_that_begins_in_the_air_is_said_to_be_lost(height, reason):
    loop = build_closed_loop(WALK)
    simulator = loop.make_simulator()
    root = simulator.get_mutable_context()
    x = loop.plant.state(root)
    x[6] += height
    loop.plant.place(root, x)
    with pytest.raises(EstimateError, match=reason) as error:
        simulator.AdvanceTo(0.5)
    assert fall_of(error.value).startswith("state estimate lost: ")


def test_noise_of_the_other_sensors_is_refused():
    with pytest.raises(ScenarioError, match=r"estimation = True: must be false"):
        load_scenario("walk", {"estimation": True, "sensors.gyro": 0.1})


def test_a_controller_that_knows_no_contact_is_refused():
    with pytest.raises(InputError, match="lacks the output port contact"):
        build_closed_loop(WALK, controller=Limp())


@pytest.mark.parametrize("entries", [{"imu_delay": 0.001}, {"imu_rate": 500.0}])
def test_it_stands_with_a_late_or_slow_imu(entries):
    onboard = replace(WALK.onboard, **entries)
    stand = replace(WALK, onboard=onboard, segments=[Segment("stand", 0.7)])
    assert not simulate(build_closed_loop(stand)).fell
