"""Show the MIT Humanoid in Meshcat, turning its joints one after the other.

Opens a page in the browser (the address is printed), or writes it to a file:

    python examples/01_show_robot.py
    python examples/01_show_robot.py --html robot.html
"""

import argparse
import time

import numpy as np
from pydrake.geometry import Meshcat, MeshcatVisualizer, SceneGraph
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import DiagramBuilder

from drake_linefoot import load_humanoid
from drake_linefoot.lab.visualization.live import live_page
from drake_linefoot.lab.visualization.replay import recording, write_replay
from drake_linefoot.lab.visualization.view import set_up_view

FRAMES = 24  # for each joint


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--html", help="write the animation to this file and end")
    arguments = parser.parse_args()
    with live_page() as page:
        turn_joints(page.meshcat)
        if arguments.html:
            write_replay(page.meshcat, arguments.html, "MIT Humanoid")
            print(f"wrote {arguments.html}")
            return
        print(f"open {page.url}; Ctrl-C ends")
        try:
            while True:
                time.sleep(1.0)
        except KeyboardInterrupt:
            pass


def turn_joints(meshcat: Meshcat) -> None:
    humanoid = load_humanoid("mit_humanoid")
    builder = DiagramBuilder()
    scene_graph = builder.AddSystem(SceneGraph())
    plant = builder.AddSystem(MultibodyPlant(0.0))
    plant.RegisterAsSourceForSceneGraph(scene_graph)
    humanoid.add_to(plant)
    plant.Finalize()
    builder.Connect(
        plant.get_geometry_pose_output_port(),
        scene_graph.get_source_pose_port(plant.get_source_id()),
    )
    set_up_view(meshcat, humanoid)
    MeshcatVisualizer.AddToBuilder(builder, scene_graph, meshcat)
    diagram = builder.Build()
    root = diagram.CreateDefaultContext()
    context = plant.GetMyMutableContextFromRoot(root)

    print(f"{humanoid.description.name}: {humanoid.mass:.2f} kg, {humanoid.na} joints")
    with recording(meshcat):
        for joint in range(humanoid.na):
            at = humanoid.actuated_q[joint]
            start = humanoid.q_nominal[at]
            room = min(0.4, humanoid.position_upper[joint] - start)
            for frame in range(FRAMES):
                q = humanoid.q_nominal.copy()
                q[at] = start + room * np.sin(np.pi * frame / FRAMES)
                plant.SetPositions(context, q)
                root.SetTime((joint * FRAMES + frame) / 32.0)
                diagram.ForcedPublish(root)


if __name__ == "__main__":
    main()
