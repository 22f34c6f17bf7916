"""One update of the MPC as a plain function call: reference and state in, plan out."""

import time
from typing import Any

import numpy as np

from drake_linefoot.centroidal import intervals_at, resultants
from drake_linefoot.constants import STANDARD_GRAVITY
from drake_linefoot.contact.cone_program import ConeProgram, ConeSolution
from drake_linefoot.contact.contacts import Contact
from drake_linefoot.contact.surface import SurfaceContact
from drake_linefoot.errors import InputError
from drake_linefoot.math.active_set import solve_few_active
from drake_linefoot.math.linear import both_finite
from drake_linefoot.math.rotation import rotation_error
from drake_linefoot.mpc.condensed_qp import (
    CURVATURE,
    CondensedQp,
    Constants,
    build_qp,
    constants_of,
)
from drake_linefoot.mpc.ecd import centroidal_state
from drake_linefoot.mpc.models.model import CentroidalMeasurement
from drake_linefoot.mpc.models.registry import model_named
from drake_linefoot.mpc.parameters import ACTIVE_SET, MPC_SOLVERS, MpcParameters
from drake_linefoot.signals import CentroidalPlan, Reference
from drake_linefoot.statuses import Solved
from drake_linefoot.types import Array

RHO = 0.1 * CURVATURE  # [-] of OSQP: few iterations at any number of knots
RHO_SURFACE = 0.2 * CURVATURE  # [-] where tau_x is among the unknowns: a third fewer iterations


class MpcSolver:
    """The MPC of one robot: constants, and the programs it keeps between updates."""

    def __init__(self, parameters: MpcParameters, mass: float, contact: Contact) -> None:
        """Keep constants; `mass` [kg], `contact` of the feet.

        Raises:
            InputError: the parameters name an unknown solver or model.
        """
        self.parameters = parameters
        self.mass = mass
        p = parameters
        if p.solver not in MPC_SOLVERS:
            raise InputError("mpc.solver", "", p.solver, f"must be one of {MPC_SOLVERS}")
        self._constants = constants_of(p, mass, contact)
        self._model = model_named(p.model)
        self._guesses = p.solver == ACTIVE_SET
        solver = "osqp" if self._guesses else p.solver
        rho = RHO_SURFACE if isinstance(contact, SurfaceContact) else RHO
        self._program = ConeProgram(solver, p.tolerance, p.max_iterations, rho)

    def build(
        self,
        reference: Reference,
        measured: CentroidalMeasurement,
        constants: Constants | None = None,
    ) -> CondensedQp:
        """Return the program of an update; r_G is the present CoM; arguments as of `solve`."""
        r_G = measured.r
        eta = rotation_error(measured.R_WB, reference.R[0])
        x0 = centroidal_state(measured.r, measured.v, measured.L, eta, r_G, self.mass)
        about = self._model.linearise(reference)
        return build_qp(constants or self._constants, reference, about, x0, r_G)

    def solve(
        self,
        reference: Reference,
        measured: CentroidalMeasurement,
        previous: CentroidalPlan | None = None,
        constants: Constants | None = None,
    ) -> CentroidalPlan:
        """Return the plan; when the program is not solved, the previous one goes on.

        Args:
            reference: desired motion.
            measured: present state.
            previous: the last plan: start of the solver's iteration, when there is one, and
                what is used on failure.
            constants: weights and friction; those of the parameters without.

        Returns:
            The plan; `status` says whether it is new, `failures` counts.
        """
        started = time.perf_counter()
        qp = self.build(reference, measured, constants)
        solution = self._few_active(qp) if self._guesses else None
        if solution is None:
            guess = None if previous is None else _guess(previous, reference, qp)
            zero = np.zeros(qp.W.shape[:2])
            solution = self._program.solve(qp.H, qp.g, qp.W, zero, guess)
        U = solution.z * qp.scale
        failures = 0.0 if previous is None else previous.failures
        if not solution.success:
            failures += 1.0
            U = U if previous is not None else _share_weight(reference, qp, self.mass)
        says: dict[str, Any] = {
            "status": float(solution.status),
            "active": float(solution.active),
            "iterations": float(solution.iterations),
            "milliseconds": 1e3 * (time.perf_counter() - started),
            "failures": failures,
        }
        if not solution.success and previous is not None:
            return previous._replace(**says)
        wrench = qp.wrenches(U)
        force, moment = resultants(wrench, reference.p_WC, reference.R_WC, measured.r)
        return CentroidalPlan(
            times=reference.times,
            wrench=wrench,
            force=force,
            moment=moment,
            states=qp.states(U),
            r_G=measured.r,
            mass=self.mass,
            p_WC=reference.p_WC,
            R_WC=reference.R_WC,
            coming=reference.coming,
            footholds=reference.footholds,
            external=reference.external,
            **says,
        )

    def _few_active(self, qp: CondensedQp) -> ConeSolution | None:
        """Solve with few of the cones' rows active, exactly; None when a solver has to."""
        if len(qp.W) == 0 or not both_finite(qp.H.ravel(), qp.g):
            return None
        A = qp.rows()
        room = np.zeros(len(A))
        z, found = solve_few_active(qp.H, qp.g, A, room, self.parameters.tolerance)
        if not found:
            return None
        active = int(np.count_nonzero(A @ z >= -self.parameters.tolerance))
        status = Solved.ACTIVE_SET if active else Solved.UNCONSTRAINED
        return ConeSolution(z, status, active=active)


def _guess(previous: CentroidalPlan, reference: Reference, qp: CondensedQp) -> Array:
    """Return the previous plan, shifted to the new knots, in scaled variables."""
    middle = 0.5 * (reference.times[1:] + reference.times[:-1])
    intervals = intervals_at(previous.times, middle)
    return previous.wrench[intervals[qp.active[:, 0]], qp.active[:, 1]].ravel() / qp.scale


def _share_weight(reference: Reference, qp: CondensedQp, mass: float) -> Array:
    """Return wrenches that carry the weight on the standing feet, for a first failure."""
    standing = reference.contact.sum(axis=1)[qp.active[:, 0]]
    U = np.zeros((len(qp.active), qp.W.shape[2]))
    U[:, 2] = mass * STANDARD_GRAVITY / standing
    return U.ravel()
