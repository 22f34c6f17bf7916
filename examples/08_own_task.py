"""A task of your own in the whole-body controller: arms that swing against the legs.

A task is rows ``J vdot = b`` with a priority; `build_controller` takes a list of them.

    python examples/08_own_task.py
"""

import argparse

import numpy as np

from drake_linefoot import (
    Scenario,
    Segment,
    build_closed_loop,
    build_controller,
    load_humanoid,
    simulate,
)
from drake_linefoot.wbc.tasks.task import POSTURE, Task, TaskRows

SWING, STIFFNESS, DAMPING = 2.0, 100.0, 20.0  # [rad/m] of how far a foot is ahead, [1/s^2], [1/s]


class SwingArms(Task):
    """Shoulders follow the feet: the left arm goes ahead with the right leg."""

    name = "swing arms"
    priority = POSTURE - 1.0  # after the feet and the momentum
    joints = ("left_shoulder_pitch", "right_shoulder_pitch")

    def __init__(self, humanoid):
        names = humanoid.description.actuated_joints
        places = [names.index(name) for name in self.joints]
        self.q, self.v = humanoid.actuated_q[places], humanoid.actuated_v[places]
        self.q_0, self.J = humanoid.q_nominal[self.q], np.eye(humanoid.nv)[self.v]

    def rows(self, d, targets):
        ahead = (d.p_WC[1] - d.p_WC[0]) @ d.R_WB[:, 0]  # of the right foot from the left one
        wanted = self.q_0 + SWING * ahead * np.array([-1.0, 1.0])  # a shoulder turns back about +y
        return TaskRows(self.J, STIFFNESS * (wanted - d.q[self.q]) - DAMPING * d.v[self.v])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=float, default=4.0, help="of walking")
    seconds = parser.parse_args().seconds
    scenario = Scenario(segments=[Segment("ahead", seconds, walk=True, velocity=[0.5, 0.0])])
    humanoid = load_humanoid(scenario.robot)
    arms = SwingArms(humanoid)
    for tasks in ([], [arms]):
        controller = build_controller(humanoid, scenario, tasks=tasks)
        run = simulate(build_closed_loop(scenario, controller=controller))
        steady = run.time > 0.5 * seconds
        shoulder, yaw = np.ptp(run.q[steady][:, arms.q[0]]), np.ptp(run.rpy[steady, 2])
        print(f"fell: {run.fell}; the left shoulder swings {shoulder:.2f}, the torso {yaw:.3f} rad")


if __name__ == "__main__":
    main()
