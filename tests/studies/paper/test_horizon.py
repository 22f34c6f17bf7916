"""The torso along one plan: what is asked of the full body, medians, claims."""

import json

import numpy as np
import pytest

from drake_linefoot.mpc.parameters import MpcParameters
from drake_linefoot.robot.humanoid import load_humanoid
from studies.paper import horizon
from studies.paper.plan_error import MODELS, TIMES, Planners, stages
from studies.zoo.robots import make
from tests.helpers.walking import dynamics_of, recorded_walk, robot


@pytest.fixture(scope="module")
def planners():
    return Planners(robot(), MpcParameters())


def test_steps_end_at_the_knots():
    times, at = stages(np.array([1.0, 1.04, 1.05, 1.075]), 0.02)
    np.testing.assert_allclose(
        times, [1.0, 1.01, 1.02, 1.03, 1.04, 1.045, 1.05, 1.05625, 1.0625, 1.06875, 1.075]
    )
    np.testing.assert_allclose(times[::2][at], [1.0, 1.04, 1.05, 1.075])


def test_what_is_asked_of_the_full_body_is_one_motion(planners):
    """Velocities are rates of places; arms swing by how far the right foot is ahead."""
    one = recorded_walk().mpc[60]
    times = np.linspace(one.plan.times[0], one.plan.times[-1], 1001)
    horizon = one.horizon._replace(arm_swing=0.5)
    motion = planners.motion(dynamics_of(one.x), horizon, one.plan, times)

    def rate(values):
        return np.gradient(values, times, axis=-2)[..., 1:-1, :]

    np.testing.assert_allclose(rate(motion.r), motion.v[1:-1], atol=2e-3)
    np.testing.assert_allclose(rate(motion.p), motion.p_dot[:, 1:-1], atol=0.02)
    turning = np.cross(motion.w, motion.x)[:, 1:-1]
    np.testing.assert_allclose(rate(motion.x), turning, atol=0.02)
    assert np.abs(motion.p_dot).max() > 0.5
    swing = horizon.arm_swing * np.ptp(motion.p[1, :, 0] - motion.p[0, :, 0])
    assert swing > 0.05
    assert np.ptp(motion.angles, axis=0).max() == pytest.approx(swing, rel=0.2)  # it turns
    np.testing.assert_allclose(rate(motion.angles), motion.rates[1:-1], atol=0.05)


def test_the_contact_consistent_model_is_nearest_and_the_single_body_farthest(planners):
    records = recorded_walk().mpc[35:90:9]
    errors = [planners.errors(one.x, one.horizon) for one in records]
    consistent, ecd, single = (
        np.median([one[model] for one in errors], axis=0)[1:] for model in MODELS
    )
    assert np.isfinite(single).all()
    assert (consistent < ecd).all()
    assert (ecd < single).all()
    assert consistent.max() < 5e-3


def test_medians_leave_out_what_is_not_known():
    rng = np.random.default_rng(0)
    values = rng.normal(size=(3, 7, 4))
    values[0, 2], values[1, 1:, 0], values[2, :3, 1] = np.nan, np.nan, np.nan
    np.testing.assert_allclose(horizon.medians(values), np.nanmedian(values, axis=1))
    assert np.isnan(horizon.medians(np.full((2, 3), np.nan))).all()


def test_states_count_where_every_model_has_a_number():
    rows = [row(horizon.MIT, GOOD), row(horizon.MIT, (0.003, 0.005, 0.03))]
    for found in rows[1]["errors"]["srbm"]:
        found[-1] = None
    summary = horizon.summary_of(rows)
    assert (summary["plans"], summary["compared"]) == (6, 3)
    assert list(summary["missing"].values()) == [0, 0, 3]
    assert summary["median"]["ecd"] == pytest.approx([0.0045] * 3 + [0.004])
    assert summary["interval"]["ecd"][-1] == pytest.approx([0.004, 0.004])


def test_the_interval_draws_walks():
    """Plans of a walk that scatter leave no doubt; walks that differ do, of any length."""
    plans = np.outer([1.0, 2.0, 9.0], np.ones(4))
    np.testing.assert_allclose(horizon.intervals([plans] * 5), 2.0)
    ends = horizon.intervals([np.ones((3, 4)), 3.0 * np.ones((3, 4)), np.full((1, 4), 2.0)])
    np.testing.assert_allclose(ends, [[1.0, 3.0]] * 4)


def row(robot, sizes, walk="0.4 m/s", fell=False):
    """A walk with the same error of all plans of a model [rad]."""
    errors = {m: [[size] * len(TIMES)] * 3 for m, size in zip(MODELS, sizes, strict=True)}
    reason = "torso low" if fell else ""
    return {"robot": robot, "walk": walk, "seed": 0, "fell": fell, "fall_time": None,
            "fall_reason": reason, "errors": {} if fell else errors}  # fmt: skip


def data_of(rows):
    names = dict.fromkeys(row["robot"] for row in rows)
    of = {name: [row for row in rows if row["robot"] == name] for name in names}
    summary = {name: horizon.summary_of(own) for name, own in of.items()}
    return {"scenario": "", "seeds": [0], "fell": False, "times": list(TIMES), "rows": rows,
            "summary": summary}  # fmt: skip


GOOD, BAD = (0.001, 0.004, 0.02), (0.004, 0.002, 0.001)


def test_claims_are_of_the_nearest_model():
    robots = [row("a", BAD), row("b", BAD), row(horizon.ALIKE[0], GOOD)]  # the last is the first
    found = horizon.claims(data_of([row(horizon.MIT, GOOD)] * 2 + robots))
    assert [claim.holds for claim in found] == [True, False, True, False]
    assert found[0].ours.startswith("error 0.25 times the ECD's (0.25 to 0.25); lower in 8 of 8")
    assert found[3].ours.startswith("error 2.00 times the Base MPC's")
    mixed = [row(horizon.MIT, sizes) for sizes in (GOOD, BAD)]
    assert horizon.claims(data_of(mixed))[0].holds is None
    fallen = [row(horizon.MIT, GOOD, fell=True)]
    assert not any(claim.holds for claim in horizon.claims(data_of(fallen)))


def test_table_and_picture_tell_what_was_not_walked():
    lost = horizon.lost(horizon.Job("c", None, ("turn",), (0,), 1.0, 1), "not walked: no feet")
    rows = [row(horizon.MIT, GOOD), row("a", BAD), row("a", BAD, fell=True), *lost]
    data = json.loads(json.dumps(data_of(rows), allow_nan=False))
    table = horizon.table(data)
    assert {len(cells) for cells in table} == {len(table[0])}
    assert table[1][4:] == ["1"] * len(TIMES)
    twice = horizon.table(data_of([row(horizon.MIT, (0.001, 0.1336, 0.1336))] * 2))
    assert [cells[4] for cells in twice[1:]] == ["1 (1 to 1)", *["130 (130 to 130)"] * 2]
    assert ["1 of 2" in cells[2] for cells in table] == [False] * 4 + [True] * 3 + [False]
    assert table[-1][:4] == ["c", "-", "0 of 1", "not walked: no feet"]
    _, right = horizon.draw(data).axes
    assert [label.get_text() for label in right.get_yticklabels()] == ["a", "mit humanoid"]


def test_a_robot_of_others_is_described_from_its_file(tmp_path):
    described = horizon.scenario_of("theirs", make("no_arms", tmp_path), tmp_path)
    assert load_humanoid(described.robot).mass < robot().mass - 5.0  # without its arms
    points = make("point_feet", tmp_path)
    (found,) = horizon.tried(horizon.Job("theirs", points, ("turn",), (0,), 1.0, 1))
    assert (found["robot"], found["errors"]) == ("theirs", {})
    assert "the foot is a point" in found["fall_reason"]


@pytest.mark.slow
def test_quick_form():
    data = horizon.compute(quick=True)
    assert set(data["summary"]) == set(horizon.QUICK_ROBOTS)
    assert all(found["walks"] == found["tried"] for found in data["summary"].values())
    assert all(claim.holds for claim in horizon.claims(data))
