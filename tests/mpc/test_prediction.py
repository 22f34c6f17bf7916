"""Prediction of the state in which a late plan begins to be used."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from drake_linefoot.lab.scenario import Scenario
from drake_linefoot.mpc.models.model import CentroidalMeasurement
from drake_linefoot.mpc.parameters import MpcParameters
from drake_linefoot.mpc.prediction import predict
from drake_linefoot.wiring.controller import build_controller
from tests.helpers.ports import look
from tests.helpers.walking import measure, recorded_walk

LEAD = 0.02  # [s]


@pytest.fixture(scope="module")
def records():
    return recorded_walk().mpc


def forces_of(plan, t):
    """Points and forces, and free moments, of both feet at a time."""
    k = int(np.searchsorted(plan.times, t + 1e-9, side="right")) - 1
    wrench = plan.wrench[k]
    moment = [
        plan.R_WC[k, i, :, 1] * wrench[i, 3] + plan.R_WC[k, i, :, 2] * wrench[i, 4] for i in (0, 1)
    ]
    return plan.p_WC[k], wrench[:, :3], moment


def test_it_agrees_with_an_integration_of_newton_and_euler(humanoid, records):
    """Moments about the moving CoM of a rigid set of forces, by a general integrator."""
    plan, m = records[5].plan, measure(records[5].x)
    now = float(plan.times[0])

    def rate(t, y):
        points, forces, moments = forces_of(plan, t)
        about = sum(
            np.cross(p - y[:3], f) + n for p, f, n in zip(points, forces, moments, strict=True)
        )
        return np.concatenate([y[3:6], sum(forces) / plan.mass + [0, 0, -9.81], about])

    y0 = np.concatenate([m.r, m.v, m.L])
    y = solve_ivp(rate, (now, now + LEAD), y0, rtol=1e-10, atol=1e-12, max_step=1e-3).y[:, -1]
    found = predict(m, np.array([0.3, -0.2, 0.5]), plan, now, now + LEAD)
    np.testing.assert_allclose(found.r, y[:3], atol=1e-9)
    np.testing.assert_allclose(found.v, y[3:6], atol=1e-9)
    np.testing.assert_allclose(found.L, y[6:9], atol=1e-6)
    turned = Rotation.from_rotvec(LEAD * np.array([0.3, -0.2, 0.5])) * Rotation.from_matrix(m.R_WB)
    np.testing.assert_allclose(found.R_WB, turned.as_matrix(), atol=1e-12)


def test_an_error_of_the_present_state_stays(humanoid, records):
    """The robot is where it is measured, not where the plan has it."""
    plan, m = records[5].plan, measure(records[5].x)
    now, push = float(plan.times[0]), np.array([0.3, -0.2, 0.1])
    moved = CentroidalMeasurement(r=m.r + 0.01, v=m.v + push, L=m.L + 1.0, R_WB=m.R_WB)
    a, b = (predict(s, np.zeros(3), plan, now, now + LEAD) for s in (m, moved))
    np.testing.assert_allclose(b.r - a.r, 0.01 + LEAD * push, atol=1e-12)
    np.testing.assert_allclose(b.v - a.v, push, atol=1e-12)
    np.testing.assert_allclose(b.L - a.L, 1.0, atol=1e-12)


def test_it_foresees_a_walk(humanoid, records):
    """Most of what changes between two updates, in every quantity."""
    missed, changed = [], []
    for record, after in pairwise(records):
        m, then = measure(record.x), measure(after.x)
        now = float(record.plan.times[0])
        w_WB = record.x[humanoid.nq : humanoid.nq + 3]
        found = predict(m, w_WB, record.plan, now, now + LEAD)
        missed.append(difference(found, then))
        changed.append(difference(m, then))
    missed, changed = np.median(missed, axis=0), np.median(changed, axis=0)
    np.testing.assert_array_less(missed, [0.1, 0.25, 0.6, 0.45] * changed)


def difference(a, b):
    """Distances of CoM, velocity, angular momentum and orientation."""
    turn = Rotation.from_matrix(a.R_WB.T @ b.R_WB).magnitude()
    parts = [np.linalg.norm(x - y) for x, y in ((a.r, b.r), (a.v, b.v), (a.L, b.L))]
    return np.array([*parts, turn])


def test_with_late_plans_the_first_knot_is_a_period_ahead(humanoid):
    """Of the reference, and so of the plan; without, it is now."""
    for late in (False, True):
        controller = build_controller(humanoid, Scenario(mpc=MpcParameters(late=late)))
        context = controller.CreateDefaultContext()
        for name, value in (("state", humanoid.x_nominal), ("command", np.zeros(4))):
            controller.GetInputPort(name).FixValue(context, value)
        controller.GetInputPort("applied_torque").FixValue(context, np.zeros(humanoid.na))
        reference = look(controller.GetOutputPort("reference"), context)
        assert reference.times[0] == pytest.approx(LEAD if late else 0.0)
