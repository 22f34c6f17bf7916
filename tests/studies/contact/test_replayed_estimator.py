"""The estimator over recorded walks: it says what it said in the loop, and is held to the truth."""

import numpy as np
import pytest

from drake_linefoot.errors import LinefootError
from drake_linefoot.lab.scenario import Scenario, Segment
from drake_linefoot.lab.simulation.run import simulate
from drake_linefoot.lab.wiring.closed_loop import build_closed_loop
from drake_linefoot.robot.humanoid import load_humanoid
from studies.common.command import SWEEPS
from studies.contact.constrained import COMPONENTS, compare, forms
from studies.contact.replayed import Score, estimate, figures, observe, score
from studies.contact.studied import lost, study
from studies.contact.thresholds import choice, choices, grid, is_fit, scored
from studies.contact.walks import Walk, recorded_walk, scenarios
from tests.helpers.recorded_runs import make_run

HUMANOID = load_humanoid("mit_humanoid")
STEPS = Scenario(segments=[Segment("stand", 0.1), Segment("step", 1.2, True, [0.2, 0.0])])


@pytest.fixture(scope="module")
def walk():
    return recorded_walk(STEPS, "nominal", 0)


@pytest.fixture(scope="module")
def seen(walk):
    return observe(HUMANOID, walk.run, walk.end)


def test_it_says_what_it_said_in_the_loop(walk, seen):
    _, wrench, flags = estimate(HUMANOID, seen, STEPS.estimator, 0.001)
    # The log's quaternions have unit norm, those in the loop drift from it by rounding.
    assert wrench == pytest.approx(walk.run.contact_wrench, abs=1e-7)
    assert (flags == (walk.run.contact_flag > 0.5)).all()
    assert not flags.all()  # a foot has swung


def test_the_monitor_changes_nothing_and_keeps_the_true_wrench(walk):
    alone = simulate(build_closed_loop(STEPS))
    assert (walk.run.q == alone.q).all()
    assert walk.end == len(walk.run.time)
    assert walk.wrench[..., :3] == pytest.approx(walk.run.true_force, abs=1e-9)
    # Flat feet: the torque about the line's middle is that of the forces on heel and toe.
    heel, toe = np.moveaxis(walk.run.true_normal, 2, 0)
    pitch = HUMANOID.half_length * (heel - toe)
    assert np.abs(pitch).max() > 2.0
    assert walk.wrench[..., 3] == pytest.approx(pitch, abs=0.35)


def test_score_adds_up_the_feet():
    time = np.arange(0.0, 1.0, 0.001)
    normal, flag = np.full((len(time), 2, 2), 60.0), np.ones((len(time), 2))
    normal[200:400, 0] = normal[600:800, 1] = 0.0
    flag[203:404, 0] = flag[600:806, 1] = 0.0
    flag[700:710, 1] = 1.0
    run = make_run(time, true_normal=normal)
    left, right = score(run, flag > 0.5)
    assert [*left.latencies, *right.latencies] == pytest.approx([0.004, 0.006])
    assert (left.swings, left.false_contacts, left.missed) == (1, 0, 0)
    assert (right.swings, right.false_contacts, right.missed) == (1, 1, 0)
    found = figures([left, right, Score(swings=2, missed=1)])
    assert found["latency_ms"] == pytest.approx(5.0)
    assert (found["false_contact_rate"], found["missed_contact_rate"]) == (0.25, 0.25)
    assert figures([Score()])["latency_ms"] is None


def test_a_higher_threshold_and_a_slower_filter_detect_later(walk, seen):
    tried = choices(STEPS.estimator, (0.0, 0.95), (15.0, 120.0))
    scores = scored(HUMANOID, walk, seen, tried)
    cells = grid(tried, STEPS.estimator, [("nominal", scores)])
    assert len(cells) == 5  # and the default
    late = {(c["filter_constant"], c["touch_force"]): c["kinds"]["nominal"] for c in cells}
    assert late[0.0, 15.0]["latency_ms"] <= late[0.0, 120.0]["latency_ms"]
    assert late[0.0, 120.0]["latency_ms"] < late[0.95, 120.0]["latency_ms"]
    assert [c["default"] for c in cells].count(True) == 1


def test_the_default_is_tried_once():
    assert len(choices(STEPS.estimator)) == 25


def kind(p95, false=0, missed=0, swings=2000):
    counts = {"false_contacts": false, "missed_contacts": missed, "swings": swings}
    rates = {"false_contact_rate": false / swings, "missed_contact_rate": missed / swings}
    return {"latency_p95_ms": p95, **counts, **rates}


def cell(p95, default=False, **counts):
    return {"default": default, "kinds": {"nominal": kind(1.0), "noisy": kind(p95, **counts)}}


@pytest.mark.parametrize(
    ("counts", "fit"),
    [
        ({}, True),
        ({"swings": 500}, None),  # too few to know: up to 0.76 %
        ({"false": 10}, None),
        ({"false": 17}, False),  # 0.53 % at least
        ({"missed": 17}, False),
        ({"false": 9000}, False),  # several in a swing
    ],
)
def test_few_wrong_contacts_are_fit_as_far_as_their_interval_says(counts, fit):
    assert is_fit(cell(2.0, **counts)) is fit


@pytest.mark.parametrize(
    ("cells", "best", "stays"),
    [
        ([cell(2.5, default=True), cell(2.0)], 0, True),  # within a millisecond
        ([cell(4.0, default=True), cell(2.0)], 1, False),
        ([cell(4.0, default=True), cell(2.0, false=10)], 1, False),  # undecided
        ([cell(4.0, default=True), cell(2.0, false=100)], 0, True),
        ([cell(4.0, missed=100, default=True), cell(9.0)], 1, False),
        ([cell(4.0, missed=100, default=True), cell(9.0, false=400)], None, False),
        ([cell(None, default=True), cell(9.0)], 1, False),
    ],
)
def test_choice_is_the_fastest_of_those_that_are_not_unfit(cells, best, stays):
    found = choice(cells)
    assert (found["best"], found["stays"]) == (best, stays)


def test_what_a_push_makes_the_estimator_feel_does_not_decide():
    cells = [cell(4.0, default=True), cell(2.0, missed=1000)]
    for one in cells:
        one["kinds"]["pushed"] = one["kinds"].pop("noisy")
    assert [is_fit(one) for one in cells] == [True, True]
    assert choice(cells)["best"] == 0  # nominal walks are alike


def test_only_pushed_walks_are_pushed():
    walks = scenarios(SWEEPS, 1)
    assert [kind for scenario, kind, _ in walks if scenario.pushes] == ["pushed"]
    noisy = next(scenario for scenario, kind, _ in walks if kind == "noisy")
    assert noisy.sensors.gyro > 0.0


def test_a_walk_that_is_lost_ends_the_study():
    with pytest.raises(LinefootError, match="noisy 3: too slow"):
        lost((Scenario(name="noisy 3"), "noisy", 3), "too slow")


def test_a_walk_has_a_score_for_each_choice_and_what_both_forms_said():
    tried = choices(STEPS.estimator, (0.8,), (30.0, 80.0))
    found = study(tried, STEPS.estimator, (STEPS, "nominal", 2))
    assert (found.kind, found.number, len(found.scores)) == ("nominal", 2, 2)
    assert found.until == pytest.approx(1.3, abs=2e-3)
    assert found.scores[0][0].swings > 0
    assert len(found.compared.errors) == 260


def test_forms_are_held_against_the_true_wrench(walk, seen):
    _, wrench, _ = estimate(HUMANOID, seen, STEPS.estimator, 0.001)
    off = np.array([1.0, -2.0, 30.0, 0.5, 0.0])
    made_up = Walk("nominal", 0, walk.run, wrench + off, walk.end)
    found = compare(HUMANOID, made_up, seen, STEPS.estimator)
    both = forms([("nominal", found), ("nominal", found)])["nominal"]
    assert both["pseudoinverse"]["rms"] == pytest.approx(np.abs(off), abs=1e-6)
    assert len(both["constrained"]["rms"]) == len(COMPONENTS)
    assert both["unsolved"] == 0
    assert both["samples"] == 2 * len(range(1, walk.end, 5))
    true = forms([("nominal", compare(HUMANOID, walk, seen, STEPS.estimator))])["nominal"]
    for form in ("pseudoinverse", "constrained"):
        assert true[form]["rms_swing"][2] < 5.0  # [N] of a foot in the air
        assert 0.0 < true[form]["median_ms"] < 50.0


def test_a_sample_that_is_not_solved_is_left_out_and_counted(walk, seen):
    found = compare(HUMANOID, walk, seen, STEPS.estimator)
    broken = found._replace(errors=found.errors.copy())
    broken.errors[3] = np.nan
    told = forms([("nominal", broken)])["nominal"]
    assert (told["samples"], told["unsolved"]) == (len(found.errors), 1)
    assert np.isfinite(told["constrained"]["rms"]).all()
