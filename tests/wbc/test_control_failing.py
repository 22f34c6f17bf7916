"""A tick of the whole-body controller at limits of torque, and where a solution is not found."""

import numpy as np
import pytest

from drake_linefoot.robot.humanoid import load_humanoid
from drake_linefoot.statuses import Solved
from drake_linefoot.wbc.control import WholeBodyControl
from drake_linefoot.wbc.parameters import WbcParameters
from tests.helpers.whole_body import computed

EXACT = WbcParameters(solver="clarabel", tolerance=1e-10)


@pytest.fixture(scope="module")
def control(humanoid):
    return WholeBodyControl(humanoid, WbcParameters())


def test_torques_at_their_limits_are_clipped_and_reported(humanoid, dynamics_of, records):
    """Of a leg that stands, against a robot of the same model whose limits are out of reach."""
    r = next(r for r in records[60:] if r.targets.swings.any())
    parameters, leg = WbcParameters(torque_limit_weight=0.0), int(np.argmin(r.targets.swings))
    strong, weak = load_humanoid("mit_humanoid"), load_humanoid("mit_humanoid")
    strong.effort_limits = weak.effort_limits = np.full(humanoid.na, 1e9)
    wanted = computed(WholeBodyControl(strong, parameters), dynamics_of(r.x), r.targets, r.plan)
    over = np.zeros(humanoid.na, dtype=bool)
    over[humanoid.leg_joints[leg]] = True
    weak.effort_limits = np.where(over, 0.5 * np.abs(wanted.torque), 1e9)
    report = computed(WholeBodyControl(weak, parameters), dynamics_of(r.x), r.targets, r.plan)
    assert (report.clipped, wanted.clipped) == (np.count_nonzero(over), 0) == (5, 0)
    np.testing.assert_array_equal(report.torque[~over], wanted.torque[~over])
    np.testing.assert_array_equal(report.torque[over], 0.5 * wanted.torque[over])


def test_a_failing_solver_is_reported_and_the_torques_still_fit_the_wrench(
    humanoid, dynamics_of, records, full_plant, solver_only
):
    poor = WholeBodyControl(humanoid, WbcParameters(max_iterations=1))
    failed = 0
    for r in [r for r in records if r.report.status == Solved.ACTIVE_SET][:10]:
        report = computed(poor, dynamics_of(r.x), r.targets, r.plan)
        failed += not report.success
        needed = full_plant.put(r.x).needed_forces(report.vdot, report.wrench)
        np.testing.assert_allclose(needed[:6], 0.0, atol=1e-8)
        if report.clipped == 0:
            np.testing.assert_allclose(needed[humanoid.actuated_v], report.torque, atol=1e-8)
    assert failed == 10


def test_a_tick_that_needs_a_solver_is_the_same_tick(
    humanoid, control, dynamics_of, records, solver_only
):
    """The program goes to the solver only when rows are active, and comes to the same torques."""
    exact, statuses, free = WholeBodyControl(humanoid, EXACT), set(), set()
    for r in records[::3]:
        d = dynamics_of(r.x)
        status = computed(control, d, r.targets, r.plan).status
        (statuses if r.report.status == Solved.ACTIVE_SET else free).add(status)
        torque = computed(exact, d, r.targets, r.plan).torque
        np.testing.assert_allclose(torque, r.torque, atol=0.02)
    assert statuses == {Solved.SOLVER}
    assert free == {Solved.UNCONSTRAINED}


def test_a_mass_matrix_that_is_not_positive_definite_is_refused(control, dynamics_of, records):
    d, r = dynamics_of(records[100].x), records[100]
    with pytest.raises(np.linalg.LinAlgError, match="not positive definite"):
        computed(control, d._replace(M=-d.M), r.targets, r.plan)
