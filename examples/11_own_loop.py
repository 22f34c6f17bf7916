"""MuJoCo's own loop, in its own viewer: the controller by itself, without a Drake diagram.

python examples/11_own_loop.py [--show]
"""

import sys
import time

import mujoco

from drake_linefoot import Controller, Scenario, load_humanoid
from drake_linefoot.lab.plants.mujoco_model import make_spec
from drake_linefoot.lab.plants.mujoco_robot import MujocoRobot


def walk(seconds, show=False):
    """Walk; return the state [q, v] at the end."""
    humanoid = load_humanoid("mit_humanoid")
    controller = Controller(humanoid)
    controller.warm_up()
    robot = MujocoRobot(humanoid, make_spec(humanoid, Scenario()).compile())
    model, data = robot.model, robot.data  # MjModel, MjData: do with them what you like
    robot.put(humanoid.x_nominal)
    torque = controller.begin(robot.taken())
    if show:
        from mujoco.viewer import launch_passive
    viewer, start = launch_passive(model, data) if show else None, time.perf_counter()
    while data.time < seconds and (viewer is None or viewer.is_running()):
        data.ctrl[robot.motors] = torque
        mujoco.mj_step(model, data)
        command = [0.4, 0.0, 0.2, 1.0] if data.time > 0.5 else [0.0, 0.0, 0.0, 0.0]
        torque = controller.tick(robot.taken(), data.qfrc_actuator[robot.dofs], command)
        if viewer is not None:
            viewer.sync()
            time.sleep(max(0.0, start + data.time - time.perf_counter()))
    return robot.taken()


if __name__ == "__main__":
    print(f"torso at {walk(3.0, '--show' in sys.argv)[4:7].round(2)} m")
