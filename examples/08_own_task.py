"""A task of your own in the whole-body controller: a robot that waves while it walks.

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

RAISED, WAVES, RATE = -2.6, 0.4, 8.0  # [rad] of the arm and the elbow, [rad/s]
STIFFNESS, DAMPING = 100.0, 20.0  # [1/s^2], [1/s]


class Wave(Task):
    """The right arm goes up and waves; the other one swings with the feet."""

    name = "wave"
    priority = POSTURE - 1.0  # after the feet and the momentum
    joints = ("right_shoulder_pitch", "right_elbow")

    def __init__(self, humanoid):
        names = humanoid.description.actuated_joints
        places = [names.index(name) for name in self.joints]
        self.q, self.v = humanoid.actuated_q[places], humanoid.actuated_v[places]
        self.q_0, self.J = humanoid.q_nominal[self.q], np.eye(humanoid.nv)[self.v]

    def rows(self, d, targets):
        wanted = np.array([RAISED, self.q_0[1] + WAVES * np.sin(RATE * targets.time)])
        return TaskRows(self.J, STIFFNESS * (wanted - d.q[self.q]) - DAMPING * d.v[self.v])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=float, default=4.0)
    seconds = parser.parse_args().seconds
    scenario = Scenario(segments=[Segment("ahead", seconds, walk=True, velocity=[0.5, 0.0])])
    wave = Wave(humanoid := load_humanoid(scenario.robot))
    for tasks in ([], [wave]):
        controller = build_controller(humanoid, scenario, tasks=tasks)
        run = simulate(build_closed_loop(scenario, controller=controller))
        shoulder, elbow = run.q[run.time > 0.5 * seconds][:, wave.q].T
        print(
            f"fell: {run.fell}; arm at {shoulder.mean():.2f}, elbow moves {np.ptp(elbow):.2f} rad"
        )


if __name__ == "__main__":
    main()
