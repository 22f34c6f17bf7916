"""Ask the MPC for one plan, without any simulation, and draw it.

The robot stands in its nominal posture and is commanded to walk: the plan shifts the weight,
then steps.

    python examples/03_plan_only.py --out plan.png
"""

import argparse

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from drake_linefoot import Scenario, load_humanoid
from drake_linefoot.centroidal import NO_WRENCH
from drake_linefoot.estimation.wrench_estimate import half_the_weight
from drake_linefoot.gait.constants import constants_of
from drake_linefoot.gait.horizon import plan_horizon
from drake_linefoot.gait.measurement import measure_gait
from drake_linefoot.gait.planner import begin, update
from drake_linefoot.layout import flat
from drake_linefoot.mpc.models.model import measure_centroidal
from drake_linefoot.mpc.reference import ReferenceGenerator
from drake_linefoot.mpc.solve import MpcSolver
from drake_linefoot.robot.dynamics import robot_dynamics
from drake_linefoot.signals import ContactEstimate
from drake_linefoot.statuses import Solved
from drake_linefoot.terrain import felt_ground


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", default="plan.png", help="picture to write")
    arguments = parser.parse_args()

    humanoid, scenario = load_humanoid("mit_humanoid"), Scenario()
    scenario.mpc.knots = 24
    scratch = humanoid.plant.CreateDefaultContext()
    dynamics = robot_dynamics(humanoid, scratch, humanoid.x_nominal)

    constants = constants_of(scenario.gait, humanoid)
    standing = np.ones(2), np.zeros(humanoid.nv), NO_WRENCH  # both feet, and nothing else acts
    estimate = ContactEstimate(half_the_weight(humanoid.mass, humanoid.contact.size), *standing)
    measured = measure_gait(dynamics, estimate.contact, estimate.wrench, constants[0])
    gait = np.array([begin(measured, 0.0, constants[0])])
    walk = np.array([0.3, 0.0, 0.0, 1.0])  # v_x, v_y [m/s], turn rate [rad/s], walk
    seen = flat(dynamics), flat(estimate), humanoid.contact.size, felt_ground()
    update(gait, walk, *seen, 0.001, constants)
    horizon = plan_horizon(gait, constants, scenario.mpc.horizon, scenario.mpc.knots)

    reference = ReferenceGenerator(humanoid, scenario.mpc).generate(horizon, dynamics)
    solver = MpcSolver(scenario.mpc, humanoid.mass, humanoid.contact)
    start = measure_centroidal(dynamics)
    plan = solver.solve(reference, start)
    print(
        f"{Solved(int(plan.status)).words} in {plan.milliseconds:.1f} ms, "
        f"{plan.iterations:.0f} iterations"
    )

    figure, (top, bottom) = plt.subplots(2, 1, sharex=True, figsize=(8, 6), layout="constrained")
    top.plot(plan.times, plan.states[:, 1], label="CoM y, planned")
    top.plot(plan.times, reference.r[:, 1], "--", label="CoM y, reference")
    top.set_ylabel("y [m]")
    for side, name in enumerate(("left", "right")):
        bottom.stairs(plan.wrench[:, side, 2], plan.times, label=name, linewidth=2)
    bottom.set_ylabel("normal force [N]")
    bottom.set_xlabel("time [s]")
    for axes in (top, bottom):
        axes.legend()
        axes.grid(alpha=0.3)
    top.set_title("From standing to the first steps")
    figure.savefig(arguments.out, dpi=120)
    print(f"wrote {arguments.out}")


if __name__ == "__main__":
    main()
