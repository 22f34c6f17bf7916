"""Walk forward, then turn, and write a replay that opens in any browser.

python examples/04_walk.py --out walk.html
"""

import argparse

import numpy as np

from drake_linefoot import Scenario, Segment, build_closed_loop, simulate
from drake_linefoot.lab.results.metrics import compute_metrics
from drake_linefoot.lab.visualization.replay import recording, write_replay
from drake_linefoot.lab.visualization.view import open_meshcat


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", default="walk.html", help="replay to write")
    parser.add_argument("--seconds", type=float, default=2.0, help="of each command")
    arguments = parser.parse_args()

    seconds = arguments.seconds
    scenario = Scenario(
        name="forward and turn",
        segments=[
            Segment("stand", 0.5),
            Segment("forward", seconds, walk=True, velocity=[0.6, 0.0]),
            Segment("turn", seconds, walk=True, velocity=[0.4, 0.0], turn_rate=0.8),
        ],
    )
    meshcat = open_meshcat()
    loop = build_closed_loop(scenario, meshcat)
    with recording(meshcat):
        run = simulate(loop)
    write_replay(meshcat, arguments.out, scenario.name)

    metrics = compute_metrics(run)
    for segment in metrics["segments"]:
        measured = np.round(segment["measured"], 2)  # forward, left [m/s], turn [rad/s]
        print(f"{segment['name']:8} commanded {segment['commanded']}, measured {measured}")
    print(
        f"fell: {metrics['fell']}, largest pitch {metrics['pitch_max_rad']:.3f} rad, "
        f"{metrics['steps']} steps; wrote {arguments.out}"
    )


if __name__ == "__main__":
    main()
