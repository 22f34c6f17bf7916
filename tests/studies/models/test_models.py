"""The study of models: the pendulum's plan, linearising anew, and what is said of trials."""

from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from drake_linefoot.constants import GRAVITY
from drake_linefoot.lab.results.page import render
from drake_linefoot.lab.scenario import Scenario, Segment
from drake_linefoot.lab.scenario.load import validate
from drake_linefoot.lab.simulation.run import simulate
from drake_linefoot.mpc.ecd_mpc import standing_plan
from drake_linefoot.mpc.parameters import MpcParameters
from drake_linefoot.mpc.reference import ReferenceGenerator
from drake_linefoot.robot.dynamics import robot_dynamics
from drake_linefoot.robot.scaling import scaled
from studies import models
from studies.models.__main__ import HEAD, cells_of
from studies.models.cases import BASE, FACTORS, MODELS, VARIANTS, Trial, level, scenario, trials
from studies.models.pendulum import nearest, pendulum_plan
from studies.models.relinearised import Relinearised
from studies.models.summary import draw, summed
from studies.models.trial import built
from tests.helpers.walking import recorded_walk, robot

HUMANOID = robot()
P = scaled(MpcParameters(), HUMANOID)
WALK = Scenario(segments=[Segment("stand", 0.3), Segment("walk", 1.5, True, [0.4, 0.0])])


@pytest.fixture(scope="module")
def generated():
    """A walking horizon, the present state, and the reference of both."""
    record = next(r for r in recorded_walk().mpc if r.horizon.coming > 1)
    d = robot_dynamics(HUMANOID, HUMANOID.plant.CreateDefaultContext(), record.x)
    return d, record.horizon, ReferenceGenerator(HUMANOID, P).generate(record.horizon, d)


def test_the_pendulum_stands_on_its_feet_and_carries_the_weight(generated):
    """Its plan is finite, presses within the feet, and is carried on by its own forces."""
    d, _, ref = generated
    plan = pendulum_plan(d, ref, standing_plan(HUMANOID, P), HUMANOID.half_length)
    assert np.isfinite(plan.states).all() and np.isfinite(plan.wrench).all()
    assert not plan.wrench[ref.contact == 0.0].any()
    weight = -HUMANOID.mass * GRAVITY[2]
    assert plan.force[:, 2].mean() == pytest.approx(weight, rel=0.1)
    moved = np.abs(plan.wrench[..., 3])
    assert np.all(moved <= HUMANOID.half_length * plan.wrench[..., 2] + 1e-9)
    dv = ref.dt[:, None] * (plan.force / HUMANOID.mass + GRAVITY)
    np.testing.assert_allclose(np.diff(plan.states[:, 3:6], axis=0), dv, atol=1e-9)
    np.testing.assert_array_equal(plan.states[:, 6:], 0.0)


def test_the_point_that_is_pressed_is_the_nearest_of_a_line(generated):
    """Against all points of the foot of an interval with one foot."""
    _, _, ref = generated
    k = int(np.flatnonzero(ref.contact.sum(axis=1) == 1.0)[0])
    foot = int(np.argmax(ref.contact[k]))
    middle, along = ref.p_WC[k, foot], ref.R_WC[k, foot, :, 0]
    for away in ([0.02, 0.3, 0.0], [0.5, -0.1, 0.0], [-0.5, 0.0, 0.0]):
        found = nearest(middle + away, ref, k, HUMANOID.half_length).p
        every = middle + np.linspace(-1.0, 1.0, 2001)[:, None] * HUMANOID.half_length * along
        best = every[np.argmin(np.linalg.norm(every - (middle + away), axis=1))]
        np.testing.assert_allclose(found, best, atol=1e-4)


def test_one_round_is_the_reference_as_it_was(generated):
    d, horizon, ref = generated
    once = Relinearised(HUMANOID, P, 1).generate(horizon, d)
    for name in ref._fields:
        np.testing.assert_array_equal(getattr(once, name), getattr(ref, name), err_msg=name)


def test_rounds_go_towards_a_reference_that_stays(generated):
    """Rounds change it less and less, and never what is asked for."""
    d, horizon, ref = generated
    found = [Relinearised(HUMANOID, P, rounds).generate(horizon, d) for rounds in (1, 2, 3, 4)]
    for name in ("times", "r", "v", "R", "L", "Omega_mid", "contact", "p_WC"):
        np.testing.assert_array_equal(getattr(found[-1], name), getattr(ref, name), err_msg=name)
    steps = [np.abs(after.E - before.E).max() for before, after in pairwise(found)]
    assert steps[0] > 0.0
    assert steps[2] < 0.3 * steps[0]


@pytest.mark.parametrize("name", ["pendulum", "twice"])
def test_blocks_of_the_study_walk(name):
    run = simulate(built(VARIANTS[name], WALK))
    assert not run.fell, run.fall_reason
    assert run.com[-1, 0] - run.com[0, 0] > 0.2


def test_every_variant_has_the_same_draw():
    """But for what it changes, and the impulse of the push."""
    base = scenario(Trial(BASE, 7))
    for name, variant in VARIANTS.items():
        made = validate(scenario(Trial(name, 7)))
        assert made.segments == base.segments and made.seed == base.seed
        assert made.pushes[0] == replace(base.pushes[0], impulse=variant.impulse)
        assert (made.mpc == base.mpc) == (not any("mpc" in entry for entry in variant.entries))
    keys = [one.key for one in trials(2, 500)]
    assert len(keys) == len(set(keys)) == 2 * len(VARIANTS)


def row(variant, index, upright, pitch=0.02):
    of = {"roll": 0.01, "pitch": pitch, "speed_error": 0.05} if upright else {}
    nothing = dict.fromkeys(("roll", "pitch", "speed_error"))
    return {"variant": variant, "index": index, "upright": upright, "reason": ""} | nothing | of


def test_variants_are_compared_run_by_run():
    rows = [row(BASE, i, i < 3) for i in range(4)] + [row("srbm", i, i > 0, 0.04) for i in range(4)]
    found = summed(rows)
    assert set(found) == {BASE, "srbm"}
    one = found["srbm"]
    assert (one["upright"], one["against"]["won"], one["against"]["lost"]) == (3, 1, 1)
    assert one["pitch_ratio"] == pytest.approx(2.0)
    cells = dict(zip(HEAD, cells_of("srbm", one), strict=True))
    assert (cells["upright"], cells["won, lost"]) == ("3 of 4", "1, 1")
    assert found[BASE]["low"] < 0.75 < found[BASE]["high"]


def test_the_picture_has_every_level_of_every_factor():
    names = [BASE, *(level(name, x) for name, one in FACTORS.items() for x in one.levels)]
    rows = [row(name, i, True) for name in dict.fromkeys([*names, *MODELS]) for i in range(2)]
    axes = draw(summed(rows)).axes
    assert [len(ax.lines[0].get_xdata()) for ax in axes[1:]] == [
        len(one.levels) for one in FACTORS.values()
    ]


def test_the_page_begins_with_what_was_found():
    found = summed([row(name, i, i > 0) for name in VARIANTS for i in range(3)])
    made = {"command": "python -m studies.models", "made_with": {}, "variants": found}
    made["impulses"] = {"models": 35, "errors": 20}
    rows = [cells_of(name, one) for name, one in found.items()]
    told = {"summary": made, "head": HEAD, "rows": rows, "picture": "curves.png"}
    page = render("index.md.j2", Path(models.__file__).parent, **told)
    assert page.splitlines()[2].startswith("**After a push of 35 N s 2 of 3 stay upright with the")
