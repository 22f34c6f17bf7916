"""A model of the MPC of one's own: the ECD with its inertia frozen at the present.

The momentum of the planned legs counts as with "ecd"; how the robot's inertia changes while they
move does not.

python examples/09_own_model.py [--seconds 4]
"""

import argparse

import numpy as np

from drake_linefoot import Scenario, Segment, build_closed_loop, simulate
from drake_linefoot.mpc.models.ecd import ECD
from drake_linefoot.mpc.models.model import Model
from drake_linefoot.mpc.models.registry import register
from drake_linefoot.mpc.parameters import MpcParameters
from drake_linefoot.signals import open_dynamics, open_reference


def frozen_inertia(reference, lines, dynamics, robot):
    """Write the momentum of the planned legs, and the present inertia in every interval."""
    reach = ECD.write_reference(reference, lines, dynamics, robot)
    planned = open_reference(reference, lines.p.shape[1])
    now = open_dynamics(dynamics, robot.nv, robot.nw)
    planned.I_B[:] = now.R_WB.T @ now.A[:3, :3] @ now.R_WB
    return reach


FROZEN = Model("frozen_inertia", "ECD with a frozen inertia", frozen_inertia)


def walk(model: str, seconds: float) -> None:
    """Walk forward and turn; print how far the robot came, and its tilt."""
    forward = Segment("walk", seconds, walk=True, velocity=[0.8, 0.0], turn_rate=0.3)
    scenario = Scenario(segments=[Segment("stand", 0.5), forward], mpc=MpcParameters(model=model))
    run = simulate(build_closed_loop(scenario))
    way = np.linalg.norm(np.diff(run.com[:, :2], axis=0), axis=1).sum()
    roll, pitch, _ = 1e3 * np.sqrt(np.mean(run.rpy**2, axis=0))
    print(f"{model:14} walked {way:.2f} m, roll {roll:.2f}, pitch {pitch:.2f} mrad RMS")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=float, default=4.0)
    seconds = parser.parse_args().seconds
    register(FROZEN)  # from now on also `mpc: {model: frozen_inertia}` in a scenario
    for model in (ECD, FROZEN):
        walk(model.name, seconds)


if __name__ == "__main__":
    main()
