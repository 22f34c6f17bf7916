"""The grid: model variants, pooling, picture and claims on made-up runs."""

import json
from itertools import product

import numpy as np
import pytest

from drake_linefoot.errors import InputError
from drake_linefoot.lab.results.provenance import made_with
from drake_linefoot.lab.scenario.load import dump_scenario, validate
from drake_linefoot.robot.humanoid import load_humanoid
from studies import tuning
from studies.common import trials as kept_trials
from studies.common.models import com_height, leg_mass_variant, leg_share, with_robot
from studies.common.runs import paper_scenario
from studies.common.trial import tried, walk
from studies.common.trials import FRESH
from studies.paper import grid
from studies.paper.grid import (
    COMMANDS,
    CONTESTANTS,
    MEASURED,
    MODELS,
    PAIRS,
    SEEDS,
    WEIGHTS,
    Point,
    assemble,
    claims,
    contestant,
    draw,
    over_seeds,
    table,
)
from studies.paper.grid_picture import shade


@pytest.fixture(scope="module")
def heavy(tmp_path_factory):
    return leg_mass_variant("mit_humanoid", 1.4, tmp_path_factory.mktemp("robots"))


# --- the variants ----------------------------------------------------------------------------


def mass_of(humanoid, names):
    context = humanoid.plant.CreateDefaultContext()
    return sum(humanoid.plant.GetBodyByName(name).get_mass(context) for name in names)


def inertia_of(humanoid, name):
    context = humanoid.plant.CreateDefaultContext()
    body = humanoid.plant.GetBodyByName(name)
    return body.CalcSpatialInertiaInBodyFrame(context).CopyToFullMatrix6()


def test_a_variant_has_heavier_legs_and_the_same_mass(heavy, humanoid):
    variant = load_humanoid(heavy)
    assert variant.mass == pytest.approx(humanoid.mass, abs=1e-9)
    assert leg_share(variant) == pytest.approx(1.4 * leg_share(humanoid))
    links = ["left_thigh_link", "right_foot_link"]
    assert mass_of(variant, links) == pytest.approx(1.4 * mass_of(humanoid, links))
    arms = ["left_forearm_link", "right_upper_arm_link"]
    assert mass_of(variant, arms) == pytest.approx(mass_of(humanoid, arms))


def test_inertias_are_scaled_as_the_masses(heavy, humanoid):
    variant = load_humanoid(heavy)
    np.testing.assert_allclose(
        inertia_of(variant, "left_shank_link"), 1.4 * inertia_of(humanoid, "left_shank_link")
    )
    share = mass_of(variant, ["torso"]) / mass_of(humanoid, ["torso"])
    assert 0.0 < share < 1.0
    np.testing.assert_allclose(inertia_of(variant, "torso"), share * inertia_of(humanoid, "torso"))


def test_factor_one_is_the_robot_itself(tmp_path, humanoid):
    variant = load_humanoid(leg_mass_variant("mit_humanoid", 1.0, tmp_path))
    matrices = []
    for robot in (variant, humanoid):
        context = robot.plant.CreateDefaultContext()
        robot.plant.SetPositions(context, humanoid.q_nominal)
        matrices.append(robot.plant.CalcMassMatrix(context))
    np.testing.assert_allclose(*matrices, rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("factor", [0.0, -1.0, 2.0])
def test_an_impossible_variant_is_refused(tmp_path, factor):
    with pytest.raises(InputError, match="leave the torso some"):
        leg_mass_variant("mit_humanoid", factor, tmp_path)


def test_the_posture_is_kept(heavy, humanoid):
    base = paper_scenario(False)
    scenario = walk(with_robot(base, heavy), (0.8, 0.0, 0.0), 3.0)
    validate(scenario)
    variant = load_humanoid(heavy)
    moved = com_height(variant) - com_height(humanoid)
    assert moved < -0.01
    assert scenario.gait.com_height == pytest.approx(base.gait.com_height + moved)
    np.testing.assert_allclose(variant.q_nominal, humanoid.q_nominal, atol=1e-12)


# --- what the grid makes of its runs -----------------------------------------------------------


def made_up(label, size, fell=False):
    row = {"label": label, "fell": fell, "fall_time": 2.0 if fell else None, "measured": None}
    row["fall_reason"] = "torso low" if fell else ""
    return {**row, **dict.fromkeys(MEASURED, size)}


def beyond(ecd, srbm):
    """As many times below the ECD's error as that is below the single body's."""
    return None if ecd is None else ecd**2 / (srbm or 2.0 * ecd)


def data_of(sizes):
    """Data of points whose (ECD, single body) have these errors; None is a fall.

    The contact-consistent model's follow from both, see `beyond`; the other single body does as
    the one.
    """
    points = [Point((0.4 + 0.4 * i, 0.0, 0.0), (0.2, 0.03), 1.0) for i in range(len(sizes))]
    rows = [
        made_up([i, weights, model], size or 0.9, fell=size is None)
        for i, pair in enumerate(sizes)
        for weights, model in CONTESTANTS
        for size in [(*pair, pair[1], beyond(*pair))[MODELS.index(model)]]
    ]
    return assemble(points, rows, paper_scenario(False), {"1": 0.43}, 4.5)


def test_ratios_are_compared_where_both_stand():
    data = data_of([(0.01, 0.02), (0.03, 0.04), (0.02, None), (None, None)])
    expected, pooled = np.sqrt(0.5 * 0.75), np.sqrt((0.01**2 + 0.03**2) / (0.02**2 + 0.04**2))
    assert data["roll_rms_ecd_over_srbm"] == pytest.approx(expected)
    assert data["roll_rms_ecd_over_srbm_pooled"] == pytest.approx(pooled)
    assert data["roll_rms_ecd_over_srbm_interval"] == pytest.approx([0.5, 0.75])
    speed = data["over_points"]["tuned"]["ecd_over_srbm"]["speed_error"]
    assert speed["ratio"] == pytest.approx(expected)
    assert "where neither falls, 4 at most, of the ratio" in data["statistic"]
    falls = {"ecd": 1, "srbm": 2, "srbm_momentum": 2, "contact_consistent": 1}
    assert data["falls"] == {"equal": falls, "tuned": falls}
    assert data["falls_cc"] == 1
    assert data["roll_rms_cc_over_ecd"] == pytest.approx((0.5 * 0.75 * 0.5) ** (1.0 / 3.0))
    assert data["fell"]
    json.dumps(data, allow_nan=False)


def test_a_command_is_a_cluster():
    """Both points of a command have 0.5 and 0.8: whatever is drawn, the mean is the same."""
    points = [
        Point((speed, 0.0, 0.0), (0.2, 0.03), legs) for speed in (0.4, 0.7) for legs in (0.5, 1)
    ]
    rows = [
        made_up([i, weights, model], size)
        for i, (weights, model) in product(range(4), CONTESTANTS)
        for size in [0.01 * (0.5, 0.8)[i % 2] if model == "ecd" else 0.01]
    ]
    data = assemble(points, rows, paper_scenario(False), {"0.5": 0.3, "1": 0.43}, 4.5)
    assert data["roll_rms_ecd_over_srbm_interval"] == pytest.approx([np.sqrt(0.4)] * 2)
    assert "2 only" in data["statistic"]


def test_nothing_of_the_grid_was_tuned_on():
    assert not {command for command, _ in tuning.COURSE} & set(COMMANDS)
    assert min(SEEDS) >= FRESH
    assert len(set(SEEDS)) == 10


def test_claims_follow_the_numbers():
    good = claims(data_of([(0.01, 0.02)] * 2 + [(0.02, None)] * 8))
    assert all(claim.holds for claim in good[:-1])
    bad = claims(data_of([(0.02, 0.02)] * 2 + [(None, 0.02)] * 8))
    assert not any(claim.holds for claim in bad[:-1])
    assert bad[4].holds is False  # the ECD falls where the single body walks
    few = claims(data_of([(0.01, 0.02), (0.02, None), (0.02, None)]))
    assert few[4].holds is None
    for found in (good, bad, few):
        assert found[-1].holds is None  # the last two fall alike
    nothing = claims(data_of([(None, None)]))
    assert not any(claim.holds for claim in nothing)


def test_a_claim_says_where_torques_are_at_their_limits():
    """The contact-consistent model is worse at the second point only."""
    data = data_of([(0.01, 0.02), (0.03, 0.02), (None, 0.02)])
    for point, share in zip(data["points"], (0.0, 0.08, 0.9), strict=True):
        for row in point["runs"]["equal"].values():
            row["torque_limited"] = share
    assert all("torque_limited" not in pair for pair in data["over_points"]["equal"].values())
    assert {len(row) for row in table(data)} == {len(table(data)[0])}
    note = next(c.note for c in claims(data) if "contact-consistent" in c.claim)
    assert "at a limit in 8.0 % of the ticks (8.0 % with the ECD) where it is higher" in note
    assert "at a limit in 0.0 % of the ticks (0.0 % with the ECD) where it is lower" in note


def test_seeds_of_a_point_are_taken_together():
    rows = [made_up([0, "equal", "ecd"], size) for size in (0.03, 0.04)]
    found = over_seeds(rows)
    assert found["roll_rms"] == pytest.approx(np.sqrt(0.00125))
    assert (found["roll_max"], found["fell"], found["fall_time"]) == (0.04, False, None)
    assert over_seeds([*rows, made_up(None, 0.9, fell=True)])["fall_time"] == 2.0


def test_table_and_picture_show_every_point():
    data = data_of([(0.01, 0.02), (0.02, None), (None, 0.02), (None, None)])
    rows = table(data)
    assert all(len(row) == len(rows[0]) for row in rows)
    assert len(rows) == 1 + 4 * len(CONTESTANTS) + 2 * len(PAIRS) * len(WEIGHTS)
    texts = [text.get_text() for text in draw(data).axes[0].texts]
    assert [text.split("\n")[0] for text in texts] == [
        "0.50",
        "single body falls",
        "ECD falls",
        "both fall",
    ]


def test_colours_tell_better_from_worse():
    assert shade(0.5)[1] > shade(0.5)[0]
    assert shade(1.0) == (1.0, 1.0, 1.0)
    assert shade(2.0)[0] > shade(2.0)[1]


def test_contestants_differ_in_model_and_weights_only(heavy):
    base = paper_scenario(False)
    point = Point((0.8, 0.0, 0.0), (0.3, 0.05), 1.4)
    one, *others = (contestant(base, point, {1.4: heavy}, "equal", model) for model in MODELS)
    assert (one.mpc.model, *(other.mpc.model for other in others)) == MODELS
    for other in others:
        other.mpc.model = one.mpc.model
        assert dump_scenario(one) == dump_scenario(other)
    assert one.gait.single_support == 0.3
    best = contestant(base, point, {1.4: heavy}, "tuned", "srbm")
    assert best.mpc.weights == tuning.tuned("srbm") != one.mpc.weights


@pytest.mark.slow
def test_a_walk_of_the_grid(heavy):
    scenario = walk(with_robot(paper_scenario(False), heavy), (0.4, 0.0, 0.0), 2.0)
    row = tried(([0], dump_scenario(scenario)))
    assert not row["fell"]
    assert row["roll_rms"] < row["roll_max"] < 0.1
    assert row["speed_error"] < 0.2


def test_a_grid_that_was_broken_off_goes_on_with_what_it_has(tmp_path, monkeypatch):
    """Of what was kept nothing is walked again; what another code kept is."""
    asked = []

    def carried_out(trials, jobs, rows):
        asked.append(sorted({job.key for job in jobs} - set(rows)))
        for job in jobs:
            row = made_up(list(job.label), 0.02) | {"key": job.key, "seconds": 3.0}
            rows.setdefault(job.key, row)
        lines = [json.dumps(made_with()), *map(json.dumps, rows.values())]
        trials.file.write_text("\n".join(lines[:5]) + "\n")  # it was broken off
        return iter(())

    monkeypatch.setattr(kept_trials.Trials, "carried_out", carried_out)
    monkeypatch.setattr(grid, "DONE", tmp_path / "grid.jsonl")
    for name in ("COMMANDS", "STEPS", "LEGS"):
        monkeypatch.setattr(grid, name, getattr(grid, f"QUICK_{name}"))
    monkeypatch.setattr(grid, "SEEDS", (0,))
    for _ in range(2):
        data = grid.compute(quick=False)
    assert len(asked[1]) == len(asked[0]) - 4 > 0
    assert len(data["points"]) == 2
    assert data["seconds"] == 3.0 * len(asked[0])
    monkeypatch.setattr(kept_trials, "made_with", lambda: {"controller": "another"})
    monkeypatch.setattr(kept_trials, "hold", lambda *_: False)
    grid.compute(quick=False)
    assert asked[2] == asked[0]
