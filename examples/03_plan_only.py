"""Ask the MPC for one plan, without any simulation, and draw it.

The robot stands in its nominal posture and is told to walk: the plan shifts the weight,
then steps.

    python examples/03_plan_only.py --out plan.png
"""

import argparse

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from drake_linefoot.gait.horizon import plan_horizon
from drake_linefoot.gait.measure import measure_gait
from drake_linefoot.gait.planner import Gait
from drake_linefoot.gait.reference import Measured, ReferenceGenerator
from drake_linefoot.mpc.solve import CentroidalMeasurement, MpcSolver
from drake_linefoot.robot.dynamics import SharedDynamics
from drake_linefoot.robot.humanoid import load_humanoid
from drake_linefoot.scenario import Scenario


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", default="plan.png", help="picture to write")
    arguments = parser.parse_args()

    humanoid, scenario = load_humanoid("mit_humanoid"), Scenario()
    scenario.mpc.knots = 24
    dynamics = SharedDynamics(humanoid)(humanoid.x_nominal)
    measured = measure_gait(dynamics, (True, True), humanoid.half_length)

    gait = Gait(scenario.gait, humanoid.description.limits)
    state = gait.initial_state(0.0, measured)
    walk = np.array([0.3, 0.0, 0.0, 1.0])  # v_x, v_y [m/s], turn rate [rad/s], walk
    state = gait.update(state, walk, measured, 0.001)
    horizon = plan_horizon(gait, state, scenario.mpc.knots * scenario.mpc.knot_step)

    q = humanoid.q_nominal
    torso = humanoid.base_rotation(q)
    generator = ReferenceGenerator(humanoid, scenario.mpc)
    reference = generator.generate(horizon, Measured(q, measured.com, torso))
    solver = MpcSolver(scenario.mpc, humanoid.mass, humanoid.half_length)
    start = CentroidalMeasurement(measured.com, np.zeros(3), np.zeros(3), torso)
    plan = solver.solve(reference, start)
    print(
        f"{plan.report.status} in {plan.report.milliseconds:.1f} ms, "
        f"{plan.report.iterations} iterations"
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
