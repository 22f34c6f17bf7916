"""What progress and pages say of a robot that does otherwise than it was told."""

import numpy as np
import pytest

from drake_linefoot.lab.simulation.channels import LIMITS
from drake_linefoot.lab.simulation.warnings import warnings_of
from drake_linefoot.robot.humanoid import load_humanoid

N = 1500
STEP = 1e-3  # [s]


class Samples:
    """A recorder that holds what it was given."""

    def __init__(self, **channels):
        """Hold samples of a robot that walks ahead at 0.5 m/s, as it was told."""
        time, robot = STEP * np.arange(N), load_humanoid("mit_humanoid")
        self._channels = {
            "time": time,
            "q": np.tile(robot.q_nominal, (N, 1)),
            "com": np.outer(time, [0.5, 0.0, 0.0]),
            "command": np.tile([0.5, 0.0, 0.0, 1.0], (N, 1)),
            "planned_contact": np.ones((N, 2)),
            "reference_limited": np.zeros(N),
        } | channels

    def samples(self, name, n):
        return self._channels[name][-n:]


def bent_to_its_stop(joint, share):
    """Positions of which a share of the last half second is at a joint's upper stop."""
    robot = load_humanoid("mit_humanoid")
    q, k = np.tile(robot.q_nominal, (N, 1)), robot.description.actuated_joints.index(joint)
    last = int(share * 0.5 / STEP)
    q[N - last :, robot.actuated_q[k]] = robot.position_upper[k] - 0.005
    return q


def said(**channels):
    return warnings_of(Samples(**channels), load_humanoid("mit_humanoid"))


def test_nothing_is_said_of_a_walk_as_told_nor_before_the_first_sample():
    assert said() == []
    nothing = {name: values[:0] for name, values in Samples()._channels.items()}
    assert said(**nothing) == []


@pytest.mark.parametrize("why", LIMITS[1:])
def test_it_says_why_the_command_is_limited(why):
    limited = np.zeros(N)
    limited[-1] = LIMITS.index(why)
    assert said(reference_limited=limited) == [f"command limited: {why}"]


def test_it_says_which_joint_is_at_its_stop():
    assert said(q=bent_to_its_stop("left_knee", 0.6)) == ["left_knee at its stop"]
    assert said(q=bent_to_its_stop("left_knee", 0.4)) == []


def test_an_ankle_counts_while_its_foot_stands():
    q, stands = bent_to_its_stop("right_ankle", 1.0), np.ones((N, 2))
    assert said(q=q) == ["right_ankle at its stop"]
    stands[:, 1] = 0.0
    assert said(q=q, planned_contact=stands) == []


def test_it_says_that_it_walks_the_other_way_unless_the_command_is_new():
    back = np.outer(STEP * np.arange(N), [-0.1, 0.0, 0.0])
    assert said(com=back) == ["walks against its command"]
    command = Samples()._channels["command"].copy()
    command[: N - 600, 0] = -0.1
    assert said(com=back, command=command) == []
    still = np.outer(STEP * np.arange(N), [-0.01, 0.0, 0.0])
    assert said(com=still) == []
