"""Balance on both feet while the torso is pushed, and print how it swayed.

python examples/02_balance.py --push 40
"""

import argparse

import numpy as np
from pydrake.common.value import AbstractValue
from pydrake.multibody.math import SpatialForce
from pydrake.multibody.plant import ExternallyAppliedSpatialForce

from drake_linefoot.scenario import Scenario, Segment
from drake_linefoot.wiring.closed_loop import build_closed_loop


def push_on_torso(loop, force: float) -> AbstractValue:
    """A forward push [N] on the torso, at its origin."""
    applied = ExternallyAppliedSpatialForce()
    applied.body_index = loop.plant.GetBodyByName("torso").index()
    applied.F_Bq_W = SpatialForce(np.zeros(3), np.array([force, 0.0, 0.0]))
    return AbstractValue.Make([applied])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--push", type=float, default=40.0, help="force for 0.1 s [N]")
    parser.add_argument("--duration", type=float, default=3.0, help="[s]")
    arguments = parser.parse_args()

    loop = build_closed_loop(Scenario(segments=[Segment(duration=arguments.duration)]))
    simulator = loop.make_simulator()
    context = loop.plant.GetMyMutableContextFromRoot(simulator.get_mutable_context())
    port = loop.plant.get_applied_spatial_force_input_port()
    forces = {0.5: arguments.push, 0.6: 0.0, arguments.duration: 0.0}

    port.FixValue(context, push_on_torso(loop, 0.0))
    sway = []
    for time in np.arange(0.05, arguments.duration + 1e-9, 0.05):
        simulator.AdvanceTo(time)
        for start, force in forces.items():
            if abs(time - start) < 1e-6:
                port.FixValue(context, push_on_torso(loop, force))
        com = loop.plant.CalcCenterOfMassPositionInWorld(context)
        sway.append(com[0])
        print(f"{time:5.2f} s   CoM x {1e3 * com[0]:7.1f} mm   height {com[2]:.3f} m")
    print(
        f"largest sway {1e3 * (max(sway) - sway[0]):.1f} mm, "
        f"left at the end {1e3 * (sway[-1] - sway[0]):.1f} mm"
    )


if __name__ == "__main__":
    main()
