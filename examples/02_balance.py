"""Balance on both feet while the torso is pushed, and print how it swayed.

python examples/02_balance.py --push 40
"""

import argparse

import numpy as np

from drake_linefoot import Scenario, Segment, build_closed_loop, simulate
from drake_linefoot.lab.scenario.disturbances import PushParameters

BEGIN, LASTS = 0.5, 0.1  # [s] of the push


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--push", type=float, default=40.0, help="forward force for 0.1 s [N]")
    parser.add_argument("--duration", type=float, default=3.0, help="[s]")
    arguments = parser.parse_args()

    push = PushParameters(time=BEGIN, duration=LASTS, impulse=LASTS * arguments.push)
    scenario = Scenario(segments=[Segment("stand", arguments.duration)], pushes=[push])
    run = simulate(build_closed_loop(scenario))

    for time in np.arange(0.05, run.time[-1], 0.05):
        x, _, height = run.com[np.searchsorted(run.time, time)]
        print(f"{time:5.2f} s   CoM x {1e3 * x:7.1f} mm   height {height:.3f} m")
    sway = 1e3 * (run.com[:, 0] - run.com[0, 0])
    print(f"largest sway {sway.max():.1f} mm, left at the end {sway[-1]:.1f} mm")


if __name__ == "__main__":
    main()
