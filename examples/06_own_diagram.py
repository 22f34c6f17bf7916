"""The controller in a diagram of one's own, whose plant holds a box that the robot pushes along.

python examples/06_own_diagram.py [--seconds 5] [--show]

It needs the controller alone: neither a scenario nor anything else of the laboratory.
"""

import argparse

from pydrake.common import temp_directory
from pydrake.geometry import HalfSpace, StartMeshcat
from pydrake.math import RigidTransform
from pydrake.multibody.parsing import LoadModelDirectivesFromString, ProcessModelDirectives
from pydrake.multibody.plant import CoulombFriction
from pydrake.planning import RobotDiagramBuilder
from pydrake.systems.analysis import Simulator
from pydrake.systems.primitives import ConstantVectorSource, LogVectorOutput

from drake_linefoot import ControllerParameters, build_controller, load_humanoid
from drake_linefoot.wiring.controller import check_plant

BOX = """<sdf version="1.7"><model name="box"><link name="box">
  <inertial><mass>1</mass><inertia><ixx>0.03</ixx><iyy>0.03</iyy><izz>0.03</izz></inertia></inertial>
  <collision name="c"><geometry><box><size>0.2 0.6 0.3</size></box></geometry></collision>
  <visual name="v"><geometry><box><size>0.2 0.6 0.3</size></box></geometry></visual>
</link></model></sdf>"""
DIRECTIVES = """directives:
- add_model:
    name: box
    file: package://mine/box.sdf
    default_free_body_pose: {box: {translation: [0.6, 0, 0.15]}}"""


def build(parameters, meshcat=None):
    """Return a diagram, its plant, the robot and the log of its torque."""
    robot_builder = RobotDiagramBuilder(time_step=parameters.period)
    plant, builder = robot_builder.plant(), robot_builder.builder()
    folder = temp_directory()
    with open(f"{folder}/box.sdf", "w", encoding="utf-8") as file:
        file.write(BOX)
    parser = robot_builder.parser()
    parser.package_map().Add("mine", folder)
    ProcessModelDirectives(LoadModelDirectivesFromString(DIRECTIVES), parser)
    humanoid = load_humanoid("mit_humanoid")
    humanoid.add_to(plant)
    level, friction = RigidTransform(), CoulombFriction(0.8, 0.8)
    plant.RegisterCollisionGeometry(plant.world_body(), level, HalfSpace(), "ground", friction)
    plant.Finalize()
    check_plant(plant, parameters.period)

    robot = humanoid.names_in(plant).root
    controller = builder.AddSystem(build_controller(humanoid, parameters))
    command = builder.AddSystem(ConstantVectorSource([0.4, 0.0, 0.0, 1.0]))  # m/s, rad/s, walk
    for source, name in (
        (plant.get_state_output_port(robot), "state"),
        (plant.get_net_actuation_output_port(robot), "applied_torque"),
        (command.get_output_port(), "command"),
    ):
        builder.Connect(source, controller.GetInputPort(name))
    torque = controller.GetOutputPort("torque")
    builder.Connect(torque, plant.get_actuation_input_port(robot))
    log = LogVectorOutput(torque, builder, publish_period=0.01)
    if meshcat is not None:
        from pydrake.visualization import AddDefaultVisualization  # needs matplotlib

        AddDefaultVisualization(builder, meshcat)
    return robot_builder.Build(), plant, humanoid, log


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=3.0)
    parser.add_argument("--show", action="store_true", help="in a browser, in real time")
    options = parser.parse_args()
    meshcat = StartMeshcat() if options.show else None
    diagram, plant, humanoid, log = build(ControllerParameters(), meshcat)
    simulator = Simulator(diagram)
    simulator.set_target_realtime_rate(1.0 if options.show else 0.0)
    context = plant.GetMyMutableContextFromRoot(simulator.get_mutable_context())
    robot = humanoid.names_in(plant).root
    plant.SetPositionsAndVelocities(context, robot, humanoid.x_nominal)
    simulator.AdvanceTo(options.seconds)
    torso = plant.GetPositions(context, robot)[4:7]
    box = plant.EvalBodyPoseInWorld(context, plant.GetBodyByName("box")).translation()
    print(f"torso at {torso.round(2)} m, box at {box.round(2)} m")
    print(f"largest torque {abs(log.FindLog(simulator.get_context()).data()).max():.0f} N m")


if __name__ == "__main__":
    main()
