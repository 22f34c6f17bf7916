"""Put a block of your own in place of one of ours: an MPC that is no MPC.

`EcdMpc` is replaced by a LeafSystem that holds CoM and torso with springs and dampers.
Its ports have the same names and carry the same signals, so nothing else changes.
Good enough to stand; try `walk=True` in the segment to see why a walk needs a preview.

    python examples/05_own_block.py
"""

import argparse

import numpy as np
from pydrake.systems.framework import LeafSystem
from scipy.spatial.transform import Rotation

from drake_linefoot import (
    Scenario,
    Segment,
    build_closed_loop,
    build_controller,
    load_humanoid,
    simulate,
)
from drake_linefoot.centroidal import resultants
from drake_linefoot.constants import GRAVITY
from drake_linefoot.lab.results.metrics import compute_metrics
from drake_linefoot.layout import flat
from drake_linefoot.leaf_system import read_signal, weak
from drake_linefoot.math.rotation import skew
from drake_linefoot.mpc.ecd_mpc import standing_plan
from drake_linefoot.robot.dynamics import dynamics_layout


class SpringBalance(LeafSystem):
    """Springs and dampers on CoM and torso, f = m (g + k (r_d - r) - d r'), shared by both feet.

    The ten numbers of the two contact wrenches are the smallest that add up to the force and
    the moment about the CoM.
    """

    def __init__(self, humanoid, scenario):
        super().__init__()
        self.set_name("spring_balance")
        self.model = model = standing_plan(humanoid, scenario.mpc)
        # `dynamics` is what StateDynamics computes of the state: CoM, velocities, feet, ...
        self.layout = dynamics_layout(humanoid)
        self.dynamics = self.DeclareVectorInputPort("dynamics", self.layout.size)
        self.DeclareVectorOutputPort(
            "plan",
            len(flat(model)),
            weak(self, self.calc_plan),
            prerequisites_of_calc={self.dynamics.ticket(), self.time_ticket()},
        )

    def calc_plan(self, context, output):
        d, model = read_signal(self, self.dynamics, context, self.layout), self.model
        r, v, omega = d.p_WG, d.v_WG, d.v[:3]
        tilt = Rotation.from_matrix(d.R_WB).as_rotvec()
        acceleration = 20.0 * (model.states[0, :3] - r) - 8.0 * v
        moment = -60.0 * tilt - 12.0 * omega
        force = model.mass * (acceleration - GRAVITY)
        grasp = np.zeros((6, 10))  # from the two wrenches to moment and force
        for foot, p in enumerate(model.p_WC[0]):
            grasp[:3, 5 * foot : 5 * foot + 3] = skew(p - r)
            grasp[1:3, 5 * foot + 3 : 5 * foot + 5] = np.eye(2)
            grasp[3:, 5 * foot : 5 * foot + 3] = np.eye(3)
        shared = np.linalg.lstsq(grasp, np.concatenate([moment, force]), rcond=None)[0]
        wrench = np.tile(shared.reshape(2, 5), (len(model.wrench), 1, 1))
        states = np.tile([*r, *v, *np.zeros(6)], (len(wrench) + 1, 1))
        times = context.get_time() + model.times
        force, turning = resultants(wrench, model.p_WC, model.R_WC, r)
        plan = model._replace(times=times, wrench=wrench, states=states, r_G=r)
        output.SetFromVector(flat(plan._replace(force=force, moment=turning)))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--duration", type=float, default=2.0, help="[s]")
    arguments = parser.parse_args()
    scenario = Scenario(segments=[Segment("stand", arguments.duration)])
    humanoid = load_humanoid(scenario.robot)
    controller = build_controller(humanoid, scenario, mpc=SpringBalance(humanoid, scenario))
    run = simulate(build_closed_loop(scenario, controller=controller))
    metrics = compute_metrics(run)
    drift = np.ptp(run.com, axis=0)
    print(f"fell: {metrics['fell']}; the CoM moved within {1e3 * drift.round(4)} mm")


if __name__ == "__main__":
    main()
