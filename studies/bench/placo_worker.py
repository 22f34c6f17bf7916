"""Times PlaCo's whole-body controller; run by an interpreter that has PlaCo and numpy.

A process of its own, because the wheels of PlaCo 0.10 ask for another numpy than this project.
It imports nothing of this package. Reads a JSON object per line on stdin and answers with one on
stdout: first {"urdf", "joints", "arms", "half_length", "friction", "states"}, then {"batch": [i]}.
"""

import json
import sys
from importlib.metadata import version
from time import perf_counter
from typing import Any

SIDES = ("left", "right")


class Controller:
    """PlaCo's solver for one set of standing feet: lines hard, everything else soft."""

    def __init__(self, robot: Any, setup: dict[str, Any], standing: list[bool]) -> None:
        """Declare contacts and tasks."""
        import numpy as np
        import placo

        self.robot, eye = robot, np.eye(4)
        self.solver = placo.DynamicsSolver(robot)
        self.feet, self.contacts, self.swing = [], [], None
        for side, stands in zip(SIDES, standing, strict=True):
            task = self.solver.add_frame_task(f"{side}_line", eye)
            task.orientation().mask.set_axises("yz", "local")  # free about the line
            task.configure(f"{side}_line", "hard" if stands else "soft", 10.0, 1.0)
            if stands:
                contact = self.solver.add_unilateral_line_contact(task)
                contact.length, contact.mu = 2.0 * setup["half_length"], setup["friction"]
                self.contacts.append(contact)
                self.feet.append((side, task))
            else:
                self.swing = task
        self.com = self.solver.add_com_task(np.zeros(3))
        self.com.configure("com", "soft", 10.0)
        self.com.kp = self.com.kd = 0.0  # the plan's acceleration, as the paper's controller
        self.torso = self.solver.add_orientation_task(setup["base"], np.eye(3))
        self.torso.configure("torso", "soft", 1.0)
        arms = self.solver.add_joints_task()
        arms.set_joints({name: setup["arms"][name] for name in setup["arms"]})
        arms.configure("arms", "soft", 1.0)

    def tick(self, state: dict[str, Any]) -> Any:
        """Set the state, update the kinematics, set the targets, solve."""
        robot = self.robot
        robot.state.q, robot.state.qd = state["q"], state["v"]
        robot.update_kinematics()
        for side, task in self.feet:
            task.T_world_frame = robot.get_T_world_frame(f"{side}_line")
        self.com.target_world = state["com"]
        self.com.ddtarget_world = state["com_acceleration"]
        self.torso.R_world_frame = state["R_torso"]
        if self.swing is not None:
            position = self.swing.position()
            self.swing.T_world_frame = state["T_swing"]
            position.dtarget_world = state["v_swing"]
            position.ddtarget_world = state["a_swing"]
        return self.solver.solve(False)


def prepared(state: dict[str, Any], columns: list[int]) -> dict[str, Any]:
    """Return a state with its arrays, its joints in PlaCo's order."""
    import numpy as np

    done: dict[str, Any] = {name: np.array(value) for name, value in state.items()}
    done["standing"] = tuple(state["standing"])
    for name, base in (("q", 7), ("v", 6)):
        joints = done[name][base:].copy()
        done[name][base:][columns] = joints
    return done


def main() -> None:
    """Answer until stdin ends."""
    import placo

    setup = json.loads(sys.stdin.readline())
    robot = placo.RobotWrapper(setup["urdf"], placo.Flags.ignore_collisions)
    columns = [robot.get_joint_v_offset(name) - 6 for name in setup["joints"]]
    states = [prepared(state, columns) for state in setup["states"]]
    controllers = {s: Controller(robot, setup, list(s)) for s in {s["standing"] for s in states}}
    loads = []
    for state in states:
        controller = controllers[state["standing"]]
        if not controller.tick(state).success:
            raise RuntimeError("PlaCo did not solve a state")
        loads.append(sum(float(contact.wrench[2]) for contact in controller.contacts))
    print(json.dumps({"version": version("placo"), "vertical_force": loads}), flush=True)
    for line in sys.stdin:
        times, batch = [], json.loads(line)["batch"]
        controllers[states[batch[0]]["standing"]].tick(states[batch[0]])  # wakes the caches
        for i in batch:
            state = states[i]
            start = perf_counter()
            controllers[state["standing"]].tick(state)
            times.append(perf_counter() - start)
        print(json.dumps({"times": times}), flush=True)


if __name__ == "__main__":
    main()
