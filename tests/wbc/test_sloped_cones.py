"""The programs of the whole-body controller and the MPC on ground that rises across the feet."""

import numpy as np
import pytest

from drake_linefoot.contact.contacts import LineContact
from drake_linefoot.mpc.condensed_qp import scaled_cones
from drake_linefoot.wbc.parameters import WbcParameters
from tests.helpers.feet import feet_of
from tests.helpers.walking import ground_cone, mirror_wrench, robot
from tests.helpers.whole_body import solve_wrenches

SLOPES = [[0.0, 0.17], [0.12, -0.2], [-0.17, 0.0]]
MU, X = WbcParameters().friction, robot().half_length


@pytest.fixture(scope="module", params=SLOPES, ids=str)
def slope(request):
    return np.array(request.param)


@pytest.fixture(scope="module")
def some(records, dynamics_of):
    """States with their standing feet, and wrenches that friction cannot give."""
    out = []
    for seed, r in enumerate(records[40::15]):
        rng = np.random.default_rng(seed)
        sides = np.flatnonzero(r.targets.contact).tolist()
        desired = rng.normal(size=(len(sides), 5)) * [150.0, 150.0, 20.0, 4.0, 4.0]
        desired[:, 2] += 150.0
        vdot = rng.normal(size=robot().nv)
        out.append((dynamics_of(r.x), vdot, sides, desired))
    return out


def excess(d, sides, wrench, slope):
    cones = [ground_cone(MU, X, feet_of(d)[i].R_WC, slope) for i in sides]
    return max(float((W @ w).max()) for W, w in zip(cones, wrench, strict=True))


def test_its_wrenches_are_inside_the_cone_of_the_ground(some, slope):
    level = 0
    for d, vdot, sides, desired in some:
        solution = solve_wrenches(d, vdot, sides, desired, slope)
        assert solution.success
        assert excess(d, sides, solution.wrench, slope) < 1e-3
        level += excess(d, sides, solution.wrench, np.zeros(2)) > 1.0
    assert level > 0 or slope[1] == 0.0  # the feet point along x: it is another cone


def test_a_wrench_after_a_failure_is_inside_as_well(some, slope, solver_only):
    failures = 0
    for d, vdot, sides, desired in some:
        solution = solve_wrenches(d, vdot, sides, desired, slope, max_iterations=1)
        if not solution.success:
            failures += 1
            assert excess(d, sides, solution.wrench, slope) < 1e-9
    assert failures > 3


def test_a_mirrored_slope_gives_the_mirrored_wrench(records, dynamics_of, slope):
    h, exact = robot(), {"solver": "clarabel", "tolerance": 1e-10}
    desired = np.array([[100.0, 120.0, 110.0, 2.0, 3.0], [-40.0, 150.0, 130.0, -3.0, 1.0]])
    x = next(r.x for r in records[40:] if r.targets.contact.all())
    d, other_d, vdot = dynamics_of(x), dynamics_of(h.mirror_state(x)), np.zeros(h.nv)
    one = solve_wrenches(d, vdot, [0, 1], desired, slope, **exact)
    mirrored = mirror_wrench(desired)
    other = solve_wrenches(other_d, vdot, [0, 1], mirrored, slope * [1, -1], **exact)
    np.testing.assert_allclose(other.wrench, mirror_wrench(one.wrench), atol=1e-3)


def test_the_cones_of_the_mpc_are_those_of_the_ground(some, slope):
    """Row by row, in units of m g and, for torques, of m g X."""
    units = robot().contact.units(robot().mass)
    for d, _, sides, desired in some:
        for side, w in zip(sides, desired, strict=True):
            R = feet_of(d)[side].R_WC
            slack = ground_cone(MU, X, R, slope) @ w / units[0]
            slack[2:] /= X
            mine = LineContact(1.0)
            rows = scaled_cones(mine.cone(1.0), mine.ends, MU, R[None], slope[None])[0]
            found = rows @ (w / units)
            np.testing.assert_allclose(found, slack, atol=1e-12)
