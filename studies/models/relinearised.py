"""The model of the MPC linearised about its own plan instead of about what the gait asks for.

A sequential program: plan, linearise about the plan, plan again. What it brings over one round is
what a nonlinear program could bring.
"""

from scipy.spatial.transform import Rotation

from drake_linefoot.centroidal import sample_plan
from drake_linefoot.mpc.models.motion import desired_motion
from drake_linefoot.mpc.models.registry import model_named
from drake_linefoot.mpc.parameters import MpcParameters
from drake_linefoot.mpc.reference import ReferenceGenerator
from drake_linefoot.mpc.solve import MpcSolver
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.signals import CentroidalPlan, Reference
from studies.common.types import Array


class Relinearised(ReferenceGenerator):
    """The reference with inertia and momentum about the plan of the round before.

    What is asked for at the knots stays. In the middles of the intervals it says where the plan is
    and how the torso would turn there as it is asked to, which is what the torso's rate is
    linearised about: L_mid is that momentum, so that w_d belongs to it.
    """

    def __init__(self, humanoid: Humanoid, parameters: MpcParameters, rounds: int) -> None:
        """Keep a solver; `rounds` of planning, that of the MPC among them."""
        super().__init__(humanoid, parameters)
        self._solver = MpcSolver(parameters, humanoid.mass, humanoid.contact)
        self._rounds, self._measure = rounds, model_named(parameters.model).measure

    def vector(self, horizon: Array, dynamics: Array) -> Array:
        """Return the vector of the reference about the last plan; see `ReferenceGenerator`."""
        flat = super().vector(horizon, dynamics)
        measured, asked = self._measure(self.dynamics.open(dynamics)), self.reference.open(flat)
        for _ in range(self._rounds - 1):
            plan = self._solver.solve(self.reference.open(flat), measured)
            if not plan.success:
                return flat
            flat = self._about(plan, asked, horizon, dynamics)
        return flat

    def _about(
        self, plan: CentroidalPlan, asked: Reference, horizon: Array, dynamics: Array
    ) -> Array:
        """Return the vector of a reference that is linearised about a plan."""
        flat, d = self.reference.vector(asked).copy(), self.dynamics.open(dynamics)
        lines = desired_motion(flat.copy(), horizon, asked.times, d.p_WG, self._robot.nw)
        ref = self.reference.open(flat)
        for k, time in enumerate(0.5 * (asked.times[1:] + asked.times[:-1])):
            sample = sample_plan(plan, float(time))
            tilt = 0.5 * (plan.states[k, 9:] + plan.states[k + 1, 9:])
            ref.r_mid[k], ref.v_mid[k] = sample.r, sample.v
            ref.R_mid[k] = asked.R_mid[k] @ Rotation.from_rotvec(tilt).as_matrix()
        self._model.write_reference(flat, lines, dynamics, self._robot_now(horizon, d))
        ref.L[:], ref.R_mid[:] = asked.L, asked.R_mid
        return flat
