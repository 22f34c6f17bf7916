"""Tasks and wrench program of the whole-body controller, as its tests take them."""

from dataclasses import dataclass, replace

import numpy as np

from drake_linefoot.centroidal import NO_WRENCH
from drake_linefoot.contact.wrench_cone import LEVEL
from drake_linefoot.layout import flat
from drake_linefoot.statuses import Solved
from drake_linefoot.wbc.control import WholeBodyControl
from drake_linefoot.wbc.parameters import WbcParameters
from drake_linefoot.wbc.priorities import prioritised_acceleration
from drake_linefoot.wbc.tasks.contact import contact_task
from drake_linefoot.wbc.tasks.stack import stacked_tasks
from drake_linefoot.wbc.tasks.task import TaskRows
from drake_linefoot.wbc.wrench_qp import solve_program, wrench_program
from tests.helpers.walking import robot

EVERYWHERE = np.ones((2, 2))  # heel and toe of both feet have all friction


def controller_of(**parameters):
    """The whole-body control of the robot with some parameters changed."""
    return WholeBodyControl(robot(), replace(WbcParameters(), **parameters))


def gains_of(**parameters):
    """The gains of the tasks with some parameters changed."""
    return controller_of(**parameters).constants.gains


def computed(control, d, targets, plan):
    """The report of a tick of a `WholeBodyControl`, signals opened."""
    return control.report.open(control.compute(flat(d), flat(targets), flat(plan)))


def standing(targets):
    """Whether the left and the right foot stand, as the functions of a tick take it."""
    left, right = targets.contact > 0.5
    return bool(left), bool(right)


def swinging_feet(targets):
    """Whether the left and the right foot have a target, likewise."""
    left, right = targets.swings > 0.5
    return bool(left), bool(right)


def foot_in_the_air(targets):
    """The foot that swings in single support, 0 left, 1 right."""
    return standing(targets).index(False)


def stack_of(control, d, targets, plan, own=None):
    """The stack of a tick, whose rows are whose, and the feet as `stacked_tasks` takes them."""
    c, feet = (
        control.constants,
        (standing(targets), swinging_feet(targets), targets.swing, targets.slope),
    )
    own = np.empty((0, len(d.v) + 2)) if own is None else own
    return *stacked_tasks(d, feet, plan, c.mass, c.gains, (c.arms, targets.arms), own), feet


def stacked(tasks):
    """Rows of several tasks, one below the other."""
    return TaskRows(np.concatenate([t.J for t in tasks]), np.concatenate([t.b for t in tasks]))


def contact_tasks(d, sides, damping):
    """The task of several standing feet, with damping [1/s]."""
    gains = gains_of(contact_velocity_gain=damping)
    none = TaskRows(np.zeros((0, len(d.v))), np.zeros(0))
    return stacked([none, *(contact_task(d, side, gains) for side in sides)])


def prioritised(M, tasks):
    """Acceleration that meets tasks in strict order, and the number of dropped rows."""
    rows = stacked(tasks)
    vdot, dropped, positive = prioritised_acceleration(M, rows.J, rows.b)
    assert positive
    return vdot, dropped


@dataclass(frozen=True)
class WrenchSolution:
    """What (49) came to: of the standing feet, with how it was solved."""

    wrench: np.ndarray
    delta_fr: np.ndarray
    delta_f: np.ndarray
    status: Solved

    @property
    def success(self):
        return self.status.success


def solve_wrenches(d, vdot, sides, wrench_mpc, slope=LEVEL, external=NO_WRENCH, **parameters):
    """Solve (49) for standing feet as `WholeBodyControl.compute` does.

    By few active rows, else by the solver, and where that fails by the MPC's wrench, moved into
    its cone. `wrench_mpc` is of these feet, shape (n, 5).
    """
    control = controller_of(**parameters)
    weights, contact = control.constants.weights, (0 in sides, 1 in sides)
    of_both = np.zeros((2, 5))
    of_both[sides] = wrench_mpc
    slopes = np.tile(slope, (2, 1))
    ground = slopes, 1.0, EVERYWHERE
    program = wrench_program(d, vdot, contact, of_both, ground, external, weights)
    delta, active, found = solve_program(program, weights.weight)
    status = Solved.ACTIVE_SET if active else Solved.UNCONSTRAINED if sides else Solved.NO_CONTACT
    if not found:
        delta, status = control.solver.solve(program)
    delta_fr = delta.reshape(len(sides), 5)
    if not status.success:
        ground = d.R_WC[sides], slopes[sides], weights.friction, EVERYWHERE[sides]
        delta_fr = control.solver.inside_cones(program.u, *ground) - program.u
    delta_f = program.G @ delta_fr.ravel() + program.c
    return WrenchSolution(program.u + delta_fr, delta_fr, delta_f, status)
