"""The grid: model variants, pooling, picture and claims on made-up runs; the search for weights."""

import json

import numpy as np
import pytest

from drake_linefoot.errors import InputError
from drake_linefoot.evaluation import tuning
from drake_linefoot.evaluation.grid import (
    CONTESTANTS,
    MODELS,
    PAIRS,
    QUANTITIES,
    Point,
    assemble,
    claims,
    contestant,
    draw,
    table,
)
from drake_linefoot.evaluation.grid_picture import shade
from drake_linefoot.evaluation.runs import paper_scenario
from drake_linefoot.evaluation.trial import Job, carry_out, walk
from drake_linefoot.evaluation.tuning import GROUPS, cost_of, scaled, search
from drake_linefoot.evaluation.variants import (
    com_height,
    leg_mass_variant,
    leg_share,
    with_robot,
)
from drake_linefoot.mpc.parameters import MpcWeights
from drake_linefoot.robot.humanoid import load_humanoid
from drake_linefoot.scenario_io import dump_scenario, validate


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
    return {**row, **dict.fromkeys(QUANTITIES, size)}


def data_of(sizes):
    """Data of points whose (ECD, single body) have these errors; None is a fall."""
    points = [Point((0.4 + 0.4 * i, 0.0, 0.0), (0.2, 0.03), 1.0) for i in range(len(sizes))]
    rows = [
        made_up([i, weights, model], size or 0.9, fell=size is None)
        for i, pair in enumerate(sizes)
        for weights, model in CONTESTANTS
        for size in [pair[MODELS.index(model)]]
    ]
    return assemble(points, rows, paper_scenario(False), {"1": 0.43}, 4.5)


def test_ratios_are_pooled_where_both_stand():
    data = data_of([(0.01, 0.02), (0.03, 0.04), (0.02, None), (None, None)])
    expected = np.sqrt((0.01**2 + 0.03**2) / (0.02**2 + 0.04**2))
    assert data["roll_rms_ecd_over_srbm"] == pytest.approx(expected)
    assert data["pooled"]["tuned"]["speed_error"] == pytest.approx(expected)
    assert data["falls"]["equal"] == {"ecd": 1, "srbm": 2}
    assert data["fell"]
    json.dumps(data, allow_nan=False)


def test_claims_follow_the_numbers():
    good = claims(data_of([(0.01, 0.02), (0.02, None)]))
    assert all(claim.holds for claim in good)
    bad = claims(data_of([(0.02, 0.02), (None, 0.02)]))
    assert not any(claim.holds for claim in bad)
    nothing = claims(data_of([(None, None)]))
    assert not any(claim.holds for claim in nothing)


def test_table_and_picture_show_every_point():
    data = data_of([(0.01, 0.02), (0.02, None), (None, 0.02), (None, None)])
    rows = table(data)
    assert all(len(row) == len(rows[0]) for row in rows)
    assert len(rows) == 1 + 4 * len(CONTESTANTS) + len(PAIRS)
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
    one, other = (contestant(base, point, {1.4: heavy}, "equal", model) for model in MODELS)
    assert (one.mpc.model, other.mpc.model) == MODELS
    other.mpc.model = one.mpc.model
    assert dump_scenario(one) == dump_scenario(other)
    assert one.gait.single_support == 0.3
    best = contestant(base, point, {1.4: heavy}, "tuned", "srbm")
    assert best.mpc.weights == tuning.tuned("srbm") != one.mpc.weights


@pytest.mark.slow
def test_a_walk_of_the_grid(heavy):
    scenario = walk(with_robot(paper_scenario(False), heavy), (0.4, 0.0, 0.0), 2.0)
    row = carry_out(Job([0], dump_scenario(scenario)))
    assert not row["fell"]
    assert row["roll_rms"] < row["roll_max"] < 0.1
    assert row["speed_error"] < 0.2


# --- the search for weights ----------------------------------------------------------------------


def test_weights_are_scaled_by_group():
    found = scaled(MpcWeights(), np.array([1.0, 0.0, 0.0, -1.0, 0.0]))
    assert found.position == [0.0, 0.0, 20000.0]
    assert found.orientation == pytest.approx([30.0] * 3)
    assert found.velocity == MpcWeights().velocity


def test_falling_costs_more_the_earlier():
    upright = {"fell": False, "roll_rms": 0.03, "pitch_rms": 0.04, "speed_error": 0.1}
    assert cost_of(upright, 4.0) == pytest.approx(2.5 + 1.0)
    early, late = ({"fell": True, "fall_time": t} for t in (1.0, 3.0))
    assert cost_of(early, 4.0) > cost_of(late, 4.0) > cost_of(upright, 4.0)


def test_the_search_finds_a_known_minimum_and_repeats_itself():
    best = np.array([0.5, -0.5, 0.3, 0.0, -0.8])

    def cost(candidates):
        def decades(w):
            d = MpcWeights()
            pairs = [
                (w.position[2], d.position[2]),
                (w.velocity[0], d.velocity[0]),
                (w.angular_momentum[0], d.angular_momentum[0]),
                (w.orientation[0], d.orientation[0]),
                (w.force, d.force),
            ]
            return np.array([np.log10(a / b) for a, b in pairs])

        return [float(np.sum((decades(w) - best) ** 2)) for w in candidates]

    found = search(cost, rounds=150, candidates=2, seed=1)
    assert found.first == pytest.approx(np.sum(best**2))
    assert found.cost < 1e-3
    assert search(cost, rounds=5, candidates=2, seed=1) == search(cost, 5, 2, 1)
    assert len(best) == len(GROUPS)
    scanned = search(cost, rounds=0, candidates=2, seed=1, scan=True)
    assert scanned.cost == pytest.approx(np.sum((best - [0, 0, 0, 0, -1]) ** 2))
    assert scanned.weights.force == pytest.approx(0.1 * MpcWeights().force)


def test_what_is_found_is_stored_beside_the_rest(tmp_path, monkeypatch):
    file = tmp_path / "weights.yaml"
    monkeypatch.setattr(tuning, "FILE", file)
    for model, force in (("ecd", 2e-5), ("srbm", 3e-5)):
        weights = MpcWeights(force=force)
        tuning.store(model, tuning.Found(weights, 1.0, 2.0), f"tune {model}", file)
    assert tuning.tuned("ecd").force == 2e-5
    assert tuning.tuned("srbm").force == 3e-5
    assert "command: tune srbm" in file.read_text()


def test_the_shipped_weights_say_how_they_were_found():
    assert tuning.tuned("srbm").force > 0.0
    assert "drake_linefoot.evaluation.tuning --model srbm" in tuning.FILE.read_text()
