"""The runs of a sweep: what is sampled depends on nothing but seed, path and index."""

import numpy as np
import pytest

from drake_linefoot.lab.scenario.load import parse_scenario, validate
from drake_linefoot.lab.sweep.file import Distribution, load_sweep
from drake_linefoot.lab.sweep.jobs import fingerprint, job, jobs, sampled_paths, sampled_values
from tests.helpers.tiny_sweeps import TINY, write_sweep

VELOCITY = "perturbation.joint_velocity"


@pytest.fixture
def sweep(tmp_path):
    return load_sweep(write_sweep(tmp_path))


def test_every_run_is_there_once_and_can_be_simulated(sweep):
    made = list(jobs(sweep))
    assert [one.key for one in made] == [(g, i) for i in range(4) for g in ("low", "high")]
    for one in made:
        scenario = parse_scenario(one.scenario)
        validate(scenario)
        assert scenario.seed == one.seed == one.sampled["seed"]
        assert scenario.perturbation.joint_velocity == one.sampled[VELOCITY]  # to the last bit
        assert scenario.gait.first_swing == one.sampled["gait.first_swing"]
        assert scenario.gait.com_height == (0.62 if one.group == "low" else 0.642)


def test_a_group_may_have_more_runs_or_fewer(tmp_path):
    """And its draws stay those of the same index."""
    few, many = ("name: cases\nscenario: stand\nruns: 2\ngroups:\n"
                 f"- {{name: a}}\n- {{name: b{more}}}\n" for more in ("", ", runs: 4"))  # fmt: skip
    short, long = (load_sweep(write_sweep(tmp_path, text)) for text in (few, many))
    keys = [one.key for one in jobs(long)]
    assert keys == [("a", 0), ("b", 0), ("a", 1), ("b", 1), ("b", 2), ("b", 3)]
    assert list(jobs(long))[:4] == list(jobs(short)) == list(jobs(long.at_most(2)))
    assert long.at_most(3).runs == {"a": 2, "b": 3}
    assert fingerprint(short) == fingerprint(long)


def test_draws_do_not_depend_on_order_length_or_other_parameters(sweep, tmp_path):
    text = TINY.replace("sample:\n", "sample:\n  gait.step_width: {uniform: [0.15, 0.2]}\n")
    more = load_sweep(write_sweep(tmp_path, text, runs=9))
    for i in (3, 0):
        here, there = (sampled_values(s, s.groups[1], i) for s in (sweep, more))
        assert {path: there[path] for path in here} == here
    assert sampled_values(sweep, sweep.groups[0], 2) == sampled_values(sweep, sweep.groups[1], 2)


def test_runs_and_seeds_differ(sweep, tmp_path):
    other = load_sweep(write_sweep(tmp_path, seed=2))
    values = {sampled_values(s, s.groups[0], i)[VELOCITY] for s in (sweep, other) for i in range(4)}
    assert len(values) == 8
    assert sampled_paths(sweep) == ["seed", VELOCITY, "gait.first_swing"]


def test_draws_are_what_they_were(sweep):
    """A change here makes every sweep that was carried out before another one."""
    values = job(sweep, sweep.groups[0], 0).sampled
    assert values == {"seed": 1461758234, VELOCITY: 0.47676871346427513, "gait.first_swing": "left"}


def test_fingerprint_is_of_what_decides_a_run(sweep, tmp_path):
    assert fingerprint(sweep) == fingerprint(load_sweep(write_sweep(tmp_path, runs=9)))
    changed = [
        load_sweep(write_sweep(tmp_path, seed=2)),
        load_sweep(write_sweep(tmp_path, TINY.replace("0.5]", "0.6]"))),
        load_sweep(write_sweep(tmp_path, TINY.replace("0.62", "0.63"))),
    ]
    assert len({fingerprint(one) for one in [sweep, *changed]}) == 4


@pytest.mark.parametrize(
    ("distribution", "mean", "deviation"),
    [
        (Distribution("uniform", (-1.0, 3.0)), 1.0, 4.0 / 12.0**0.5),
        (Distribution("normal", (2.0, 0.5)), 2.0, 0.5),
        (Distribution("integer", (0, 3)), 1.5, 1.25**0.5),
        (Distribution("choice", (1.0, 5.0)), 3.0, 2.0),
    ],
)
def test_distributions_have_their_moments(distribution, mean, deviation):
    rng = np.random.default_rng(3)
    values = np.array([distribution.sample(rng) for _ in range(4000)])
    assert values.mean() == pytest.approx(mean, abs=5.0 * deviation / 4000**0.5)
    assert values.std() == pytest.approx(deviation, rel=0.05)


def test_bounds_hold():
    rng = np.random.default_rng(4)
    logarithmic = Distribution("log_uniform", (0.01, 1.0))
    values = np.array([logarithmic.sample(rng) for _ in range(2000)])
    assert (values.min() >= 0.01, values.max() <= 1.0) == (True, True)
    assert np.median(values) == pytest.approx(0.1, rel=0.15)  # the middle of the logarithms
    clipped = Distribution("normal", (0.0, 1.0), (-0.5, 0.5))
    values = np.array([clipped.sample(rng) for _ in range(500)])
    assert (values.min(), values.max()) == (-0.5, 0.5)
    whole = [Distribution("integer", (1, 3)).sample(rng) for _ in range(100)]
    assert set(whole) == {1, 2, 3}
