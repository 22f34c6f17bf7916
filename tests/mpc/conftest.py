"""The programs of a recorded walk."""

from dataclasses import dataclass

import numpy as np
import pytest

from drake_linefoot.contact.cone_program import ConeProgram
from drake_linefoot.mpc.condensed_qp import CondensedQp
from drake_linefoot.mpc.models.model import CentroidalMeasurement
from drake_linefoot.mpc.parameters import MpcParameters
from drake_linefoot.mpc.solve import MpcSolver
from tests.helpers.walking import MpcRecord, measure, recorded_walk, robot


@dataclass(frozen=True)
class Problem:
    """One update: what it started from, and the program that was built of it."""

    record: MpcRecord
    measured: CentroidalMeasurement
    qp: CondensedQp

    @property
    def z(self):
        """What the closed loop decided, in the unknowns of the program."""
        wrench = self.record.plan.wrench[self.qp.active[:, 0], self.qp.active[:, 1]]
        return wrench.ravel() / self.qp.scale


def make_solver(**changes):
    """A solver of the robot's MPC with some parameters changed."""
    return MpcSolver(MpcParameters(**{"model": "ecd", **changes}), robot().mass, robot().contact)


@pytest.fixture(scope="session")
def solver_of():
    return make_solver


@pytest.fixture(scope="session")
def problems():
    """Every update of the recorded walk."""
    solver = make_solver()
    out = []
    for record in recorded_walk().mpc:
        measured = measure(record.x)
        out.append(Problem(record, measured, solver.build(record.reference, measured)))
    return out


@pytest.fixture(scope="session")
def accurate():
    """Solve a program by an interior-point method to 1e-10; returns scaled unknowns."""
    program = ConeProgram("clarabel", 1e-10, 200, 1e-5)

    def solve(qp):
        solution = program.solve(qp.H, qp.g, qp.W, np.zeros(qp.W.shape[:2]))
        assert solution.success, solution.status
        return solution.z

    return solve
