"""Dynamic feasibility: the residual of the MPC's plan in the equations of the full body.

At every tick the plan asks for wrenches f of the feet, for a CoM acceleration and for a rate
of angular momentum. The full body can do that when there is an acceleration vdot that keeps
the standing feet where they are and for which the six rows of the floating base, on which no
motor acts, balance::

    M vdot + C v = tau_g + J' f    (rows of the base)

So vdot is taken as the one that meets the contact task and below it the momentum task (52),
(53), as in the whole-body controller and in that order; the swing foot and the arms come
after these and can change nothing about the balance, because the base rows are the rate of
momentum, which the tasks above them have fixed. What is left of the balance is given as a
force and a moment about the present CoM. Wrenches of feet that do not stand are not counted:
they cannot act.

The rows hold for any model of the MPC that has the exact dynamics of linear and angular
momentum, the single rigid body's included: what ECD adds is the orientation, see figure 4.
Torque limits are no part of these six rows; the torques that were cut are counted beside them.
"""

import numpy as np
from matplotlib.figure import Figure

from drake_linefoot.centroidal import PlanSample
from drake_linefoot.lab.simulation.recording import Run
from drake_linefoot.robot.dynamics import robot_dynamics
from drake_linefoot.robot.humanoid import Humanoid, load_humanoid
from drake_linefoot.signals import RobotDynamics
from drake_linefoot.wbc.control import WholeBodyControl
from drake_linefoot.wbc.priorities import prioritised_acceleration
from drake_linefoot.wbc.tasks.contact import contact_task
from drake_linefoot.wbc.tasks.momentum import momentum_task
from drake_linefoot.wbc.tasks.task import Gains
from studies.common import runs
from studies.common.drawing import BLUE, GREY, array, legend, over
from studies.common.types import Array, Data
from studies.paper.figure import Claim, shown

TITLE = "Residual of the MPC's plan in the equations of the full body"
SMALL = 0.01  # [-] of the weight (force), of the weight times ARM (moment)
ARM = 0.1  # [m] that turns a force into the moment it is compared with
FLOOR = 1e-6  # [N, N m] lower end of logarithmic axes


def plan_residual(
    dynamics: RobotDynamics, plan: PlanSample, sides: list[int], mass: float, gains: Gains
) -> tuple[Array, int]:
    """Return what the base rows lack under a plan, and how many task rows contradicted others.

    The former is a force in W and a moment about the CoM [N, N m], shape (6,); `sides` are the feet
    that stand.
    """
    d = dynamics
    tasks = [contact_task(d, side, gains) for side in sides]
    tasks.append(momentum_task(d, plan, mass, gains))
    J, b = (np.concatenate(part) for part in zip(*tasks, strict=True))
    vdot, dropped, _ = prioritised_acceleration(d.M, J, b)
    base = d.M[:6] @ vdot + d.Cv[:6] - d.tau_g[:6]
    for side in sides:
        base -= d.J[side, :, :6].T @ plan.wrench[side]
    moment = base[:3] - np.cross(d.p_WG - d.p_WB, base[3:])
    return np.concatenate([base[3:], moment]), dropped


def compute(quick: bool) -> Data:
    """Simulate the walk and put the plan of every tick through the full body's equations."""
    run = runs.simulated(runs.paper_scenario(quick))
    residual, dropped = residuals(run, load_humanoid(run.scenario.robot))
    return measure(run, residual, dropped)


def residuals(run: Run, humanoid: Humanoid) -> tuple[Array, Array]:
    """Return force and moment of every sample, shape (n, 6), and dropped rows, shape (n,)."""
    context = humanoid.plant.CreateDefaultContext()
    gains = WholeBodyControl(humanoid, run.scenario.wbc).constants.gains
    residual, dropped = np.zeros((len(run.time), 6)), np.zeros(len(run.time))
    motions = (
        run.mpc_com, run.mpc_velocity, run.mpc_acceleration,
        run.mpc_momentum, run.mpc_momentum_rate,
    )  # fmt: skip
    for i in range(len(run.time)):
        dynamics = robot_dynamics(humanoid, context, np.concatenate([run.q[i], run.v[i]]))
        plan = PlanSample(*(channel[i] for channel in (*motions, run.mpc_wrench)))
        sides = [s for s in (0, 1) if run.planned_contact[i, s] > 0.5]
        residual[i], dropped[i] = plan_residual(dynamics, plan, sides, humanoid.mass, gains)
    return residual, dropped


def measure(run: Run, residual: Array, dropped: Array) -> Data:
    """Return the size of the residual over time, and its spread while walking."""
    walking = runs.walking(run)
    force = np.linalg.norm(residual[:, :3], axis=1)
    moment = np.linalg.norm(residual[:, 3:], axis=1)
    rows = []
    for name, values in (("force [N]", force), ("moment about the CoM [N m]", moment)):
        chosen = values[walking]
        rows.append(
            {
                "name": name,
                **runs.quantiles(chosen, median=50, p95=95, p99=99, max=100),
                "rms": runs.jsonable(runs.rms(chosen)),
            }
        )
    weight = runs.weight(run)
    limits = [SMALL * weight, SMALL * weight * ARM]
    large = ((force > limits[0]) | (moment > limits[1])) & walking
    return {
        **runs.facts(run),
        "weight": weight,
        "limits": limits,
        "time": runs.decimated(run.time, 2),
        "force": runs.decimated(force, 2),
        "moment": runs.decimated(moment, 2),
        "rows": rows,
        "ticks": int(walking.sum()),
        "large": int(large.sum()),
        "dropped": int((dropped[walking] > 0).sum()),
        "clipped": int((run.clipped_torques[walking] > 0).sum()),
    }


def draw(data: Data) -> Figure:
    """Draw the size of the residual over time, on logarithmic axes."""
    figure, axes = over(TITLE, data, 2)
    time = array(data["time"])
    for ax, key, unit, limit in zip(
        axes, ("force", "moment"), ("N", "N m"), data["limits"], strict=True
    ):
        values = np.maximum(array(data[key]), FLOOR)
        ax.semilogy(time, values, color=BLUE, lw=0.6, label="residual")
        ax.axhline(limit, color=GREY, ls="--", label="counts as large")
        ax.set_ylabel(f"{key} [{unit}]")
    return legend(figure, axes[0])


def table(data: Data) -> list[list[str]]:
    """Return the spread of the residual."""
    keys = ("median", "rms", "p95", "p99", "max")
    rows = [["residual while walking", "median", "RMS", "95 %", "99 %", "largest"]]
    for row in data["rows"]:
        rows.append([row["name"], *(shown(row[key], ".3g") for key in keys)])
    return rows


def claims(data: Data) -> list[Claim]:
    """Return: the trajectories are dynamically feasible."""
    force, moment = data["rows"]
    known = force["p95"] is not None and data["ticks"] > 0
    share = data["large"] / max(data["ticks"], 1)
    ours = "no tick of walking"
    if known:
        ours = f"95th percentile {force['p95']:.3f} N, {moment['p95']:.3f} N m"
    return [
        Claim(
            "The MPC's trajectories are instantaneously dynamically feasible",
            "feasible (no number)",
            ours,
            known and force["p95"] <= data["limits"][0] and moment["p95"] <= data["limits"][1],
            "True by construction: the WBC and these rows use one mass matrix, so this checks the "
            f"code more than the paper. Base rows of the full body at each of {data['ticks']} "
            f"ticks of walking; holds when 95 % are below {data['limits'][0]:.1f} N and "
            f"{data['limits'][1]:.2f} N m (1 % of the "
            f"weight, at {ARM:g} m). {data['large']} ticks ({100 * share:.1f} %) are above, at "
            f"most {force['max'] or 0.0:.1f} N and {moment['max'] or 0.0:.1f} N m; torques were "
            f"cut in {data['clipped']} ticks, tasks contradicted contacts in {data['dropped']}.",
        )
    ]
