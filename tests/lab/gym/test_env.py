"""The Gymnasium environment: what its checker says, names, determinism, falls, rewards."""

import subprocess
import sys

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from drake_linefoot.errors import InputError
from drake_linefoot.lab.gym import NAME
from drake_linefoot.lab.gym.reward import Moment, tracking
from drake_linefoot.lab.simulation.recording import CHANNELS, WALL_TIMES
from drake_linefoot.lab.visualization.live import Link
from drake_linefoot.math.rotation import from_quaternion


@pytest.fixture(scope="module")
def env():
    return gymnasium.make(NAME)


@pytest.fixture(scope="module")
def helping():
    return gymnasium.make(
        NAME, residual=0.5, goal=[0.3, 0.0, 0.0], reward=lambda moment: moment.tilt
    )


def test_gymnasiums_own_checker_is_content(env):
    check_env(env.unwrapped, skip_render_check=True)


def test_every_number_has_a_name_a_unit_and_a_value_that_is_the_robots(env):
    observation, _ = env.reset(seed=3)
    robot, loop = env.unwrapped, env.unwrapped.loop
    seen = dict(zip([entry.name for entry in robot.entries], observation, strict=True))
    assert len(seen) == len(observation) == 15 + 2 * loop.humanoid.na
    assert {entry.unit for entry in robot.entries} == {"m", "m/s", "rad", "rad/s", "-"}
    run = robot.run()
    q, v = run.q[-1], run.v[-1]
    assert seen["height"] == pytest.approx(q[6])
    R_WB = from_quaternion(q[:4])
    up = [seen[f"up_{axis}"] for axis in "xyz"]
    np.testing.assert_allclose(R_WB @ up, [0.0, 0.0, 1.0], atol=1e-9)
    velocity = [seen[f"velocity_{axis}"] for axis in "xyz"]
    np.testing.assert_allclose(R_WB @ velocity, v[3:6], atol=1e-9)
    knee = loop.humanoid.description.actuated_joints.index("left_knee")
    assert seen["left_knee"] == pytest.approx(q[loop.humanoid.actuated_q[knee]])
    assert seen["left_knee_rate"] == pytest.approx(v[loop.humanoid.actuated_v[knee]])
    assert (seen["left_stands"], seen["right_stands"]) == (1.0, 1.0)
    assert robot.actions == ["forward", "left", "turn_rate"]


def test_an_action_is_a_command_in_shares_of_the_limits(env):
    env.reset(seed=0)
    env.step(np.array([0.5, -1.0, 0.25]))
    command = env.unwrapped.run().command[-1]
    np.testing.assert_allclose(command, [1.3, -0.5, 0.5, 1.0])


def test_episodes_of_one_seed_are_the_same_and_of_another_are_not(env):
    def first_steps(seed):
        env.reset(seed=seed)
        for _ in range(5):
            env.step(np.array([0.2, 0.0, 0.1]))
        run = env.unwrapped.run()
        return {name: getattr(run, name) for name in CHANNELS if name not in WALL_TIMES}

    once, other, again = first_steps(1), first_steps(2), first_steps(1)
    for name, values in once.items():
        np.testing.assert_array_equal(again[name], values, err_msg=name)
    assert len(once["time"]) == 101
    assert (once["q"] != other["q"]).any()


def test_residual_torques_are_added_and_a_robot_that_is_thrown_falls(helping):
    env, robot = helping, helping.unwrapped
    assert len(robot.actions) == 21
    observation, _ = env.reset(seed=0)
    np.testing.assert_array_equal(observation[-3:], [0.3, 0.0, 0.0])
    action = np.zeros(21)
    limits = robot.loop.humanoid.effort_limits
    calm = env.step(action)
    assert not calm[2] and 0.0 <= calm[1] < 0.1  # the reward that was given: the tilt
    action[3:] = 1.0
    env.step(action)
    reports = robot.loop.controller.GetOutputPort("torque")
    context = robot.simulator.get_context()
    total = reports.Eval(robot.loop.controller.GetMyContextFromRoot(context))
    assert (total > 0.4 * limits - limits).all() and (total - 0.5 * limits).std() > 0.0
    for _ in range(200):
        observation, _, terminated, truncated, info = env.step(action)
        if terminated:
            break
    assert terminated and not truncated and info["fall"]
    assert env.observation_space.contains(observation)
    env.reset(seed=0)
    assert not env.step(np.zeros(21))[2]


@pytest.mark.parametrize("given", [{"residual": 1.5}, {"goal": [1.0, 2.0]}])
def test_what_cannot_be_used_is_refused(given):
    with pytest.raises(InputError, match=r"Linefoot-v0: (residual|goal)"):
        gymnasium.make(NAME, **given)


def test_the_reward_is_largest_for_what_is_wanted():
    wanted = Moment(np.array([0.5, 0, 0]), np.array([0.5, 0, 0]), 0.0, np.zeros(18), False)
    assert tracking(wanted) == 1.0
    assert tracking(wanted._replace(velocity=np.zeros(3))) < 0.1
    assert tracking(wanted._replace(tilt=0.2)) == pytest.approx(0.9)
    assert tracking(wanted._replace(torque=np.ones(18))) == pytest.approx(0.9)
    assert tracking(wanted._replace(fell=True)) == 0.0


def test_its_name_with_the_module_needs_no_import():
    code = "import gymnasium; print(gymnasium.make('drake_linefoot.lab.gym:Linefoot-v0').spec.id)"
    run = [sys.executable, "-c", code]
    done = subprocess.run(run, capture_output=True, text=True, check=True)
    assert done.stdout == "Linefoot-v0\n"


def test_a_camera_takes_pictures_of_the_robot_wherever_it_is():
    env = gymnasium.make(NAME, render_mode="rgb_array", goal=[0.0, 0.0, 0.0])
    env.reset(seed=0)
    picture = env.render()
    assert picture.shape == (480, 640, 3) and picture.dtype == np.uint8
    robot = env.unwrapped
    context, loop = robot.simulator.get_mutable_context(), robot.loop
    x = loop.plant.state(context).copy()
    x[4] += 3.0
    loop.plant.place(context, x)
    torso = np.s_[120:360, 240:400]  # in the middle
    moved = env.render()[torso].astype(float)
    assert np.abs(moved - picture[torso]).mean() < 8.0
    assert picture[torso].std() > 20.0
    env.close()


def test_a_human_sees_it_on_a_page(capsys, monkeypatch):
    shown, show = [], Link.show

    def kept(link, kind, content):
        shown.append((kind, content))
        show(link, kind, content)

    monkeypatch.setattr(Link, "show", kept)
    env = gymnasium.make(NAME, render_mode="human")
    said = capsys.readouterr().err
    assert said.startswith("Live at http://localhost:") and said.endswith("/view/\n")
    assert env.unwrapped.loop.meshcat is not None
    assert env.unwrapped.simulator.get_target_realtime_rate() == 1.0
    env.reset(seed=0)
    for _ in range(5):
        env.step(np.array([0.5, 0.0, 0.0]))
    env.reset(seed=1)  # from which the page begins anew
    times = [content["time"] for kind, content in shown if kind == "state"]
    assert shown[0][0] == "setup" and times[0] == times[-1] == 0.0
    assert len(times) >= 4 and max(times) > 0.05
    assert env.render() is None
    env.close()


def test_without_a_mode_nothing_is_rendered(env):
    env.reset(seed=0)
    assert env.unwrapped.render() is None
    assert env.unwrapped.metadata == {"render_modes": ["human", "rgb_array"], "render_fps": 50}
    with pytest.raises(InputError, match="render_mode = 'film': must be one of"):
        type(env.unwrapped)(render_mode="film")
