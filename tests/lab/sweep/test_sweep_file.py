"""Sweep files: what they may say, and how they are refused."""

from dataclasses import replace
from pathlib import Path

import pytest

from drake_linefoot.errors import ScenarioError
from drake_linefoot.lab.scenario import PlantParameters, paths
from drake_linefoot.lab.scenario.load import parse_scenario
from drake_linefoot.lab.sweep import file as file_module
from drake_linefoot.lab.sweep.file import Distribution, load_sweep
from drake_linefoot.lab.sweep.jobs import fingerprint, jobs
from tests.helpers.tiny_sweeps import TINY, write_sweep

EXAMPLES = sorted((Path(__file__).parents[3] / "examples" / "sweeps").glob("*.yaml"))


def test_file_gives_groups_with_what_they_share(tmp_path):
    sweep = load_sweep(write_sweep(tmp_path))
    assert (sweep.name, sweep.scenario, {*sweep.runs.values()}, sweep.seed) == (
        "tiny",
        "stand",
        {4},
        1,
    )
    low, high = sweep.groups
    assert (low.base["gait"]["com_height"], high.base["gait"]["com_height"]) == (0.62, 0.642)
    for group in sweep.groups:
        assert group.base["segments"][0]["duration"] == 0.05
        assert group.sample["perturbation.joint_velocity"] == Distribution("uniform", (0.0, 0.5))
        assert group.sample["seed"].kind == "integer"  # sampled without being asked for


def test_in_another_simulator_it_is_a_sweep_of_its_own_with_the_same_draws(tmp_path):
    file = write_sweep(tmp_path)
    usual, other = load_sweep(file), load_sweep(file, "mujoco")
    assert (usual.name, other.name) == ("tiny", "tiny-mujoco")
    assert fingerprint(other) != fingerprint(usual)
    for job, again in zip(jobs(usual), jobs(other), strict=True):
        assert (again.key, again.sampled) == (job.key, job.sampled)
        scenario, plant = parse_scenario(again.scenario), PlantParameters(simulator="mujoco")
        assert scenario == replace(parse_scenario(job.scenario), plant=plant)
    with pytest.raises(ScenarioError, match=r"--simulator: plant\.simulator = 'bullet'"):
        load_sweep(file, "bullet")


def test_sweep_without_groups_is_a_group_of_its_own_name(tmp_path):
    text = "name: one\nscenario: stand\nruns: 2\nset: {seed: 7}\n"
    (group,) = load_sweep(write_sweep(tmp_path, text)).groups
    assert (group.name, group.base["seed"], dict(group.sample)) == ("one", 7, {})


def test_group_says_more_or_otherwise(tmp_path):
    text = """
name: cases
scenario: walk
set: {gait.swing_height: 0.05}
sample: {gait.step_width: {uniform: [0.15, 0.2]}, seed: {integer: [0, 9]}}
groups:
  - {name: a, sample: {gait.step_width: {choice: [0.16, 0.18]}}}
  - {name: b, set: {gait.step_width: 0.17, gait.swing_height: 0.07}}
"""
    a, b = load_sweep(write_sweep(tmp_path, text)).groups
    assert a.sample["gait.step_width"] == Distribution("choice", (0.16, 0.18))
    assert set(b.sample) == {"seed"}  # what a group sets is not sampled in it
    assert b.base["gait"]["step_width"] == 0.17
    assert (a.base["gait"]["swing_height"], b.base["gait"]["swing_height"]) == (0.05, 0.07)


def test_changes_come_one_after_the_other(tmp_path):
    text = """
name: order
scenario: stand
set:
  segments: [{duration: 0.1}, {duration: 0.2, walk: true}]
  segments[1].velocity[0]: 0.3
sample: {"segments[1].velocity[1]": {uniform: [-0.1, 0.1]}}
"""
    (group,) = load_sweep(write_sweep(tmp_path, text)).groups
    assert group.base["segments"][1]["velocity"] == [0.3, 0.0]
    assert group.base["segments"][0]["name"] == "stand"  # the rest has its defaults


@pytest.mark.parametrize("file", EXAMPLES, ids=lambda file: file.stem)
def test_shipped_sweeps_can_be_used(file):
    assert load_sweep(file).name == file.stem


# A change of TINY as (field, what follows it), or a whole text; then what is said.
WRONG = [
    ({"runs": "0"}, "runs = 0: must be greater than or equal to 1"),
    ({"runs": "1.5"}, "runs = 1.5: must be a valid integer"),
    ({"seed": "-1"}, "seed = -1: must be greater than or equal to 0"),
    ({"name": "../x"}, "name = '../x': must be a name of letters"),
    ({"name": "''"}, "name = '': must be a name"),
    ({"scenario": "nowhere"}, "scenario = 'nowhere': no such file; must be one of"),
    ("name: a\ngroups: 3", "groups = 3: must be a valid list"),
    ("name: a\nspeed: 3", "speed = 3: unknown field; must be one of ['groups', 'name'"),
    ("name: a\nset: [1]", "set = [1]: must be a valid dictionary"),
    ("name: a\nset: {gait.height: 1}", "set.gait.height = 1: no such entry in the scenario"),
    ("name: a\nset: {'segments[9].name': b}", "set.segments[9].name = 'b': no such entry"),
    ("name: a\nset: {1: 2}", "set.1 = 2: no such entry"),
    (
        "name: a\nset: {gait.step_width: wide}",
        "set: gait.step_width = 'wide': must be a valid number",
    ),
    ("name: a\nset: {gait.step_width: 9.0}", "sample: gait.step_width = 9.0: must lie in [0.1"),
    ("name: a\nset: {gait.step_width: .nan}", "gait.step_width = nan: must be a finite number"),
    ("name: a\nset: {gait: 3}", "set: gait = 3: must be a dictionary or an instance of"),
    ("name: a\nsample: {gait.x: {uniform: [0, 1]}}", "sample.gait.x = 'a dict of 1': no such"),
    ("name: a\nsample: {seed: 3}", "sample.seed = 3: must be one of {uniform: [low, high]}"),
    ("name: a\nsample: {seed: {poisson: [1]}}", "sample.seed = 'a dict of 1': must be one of"),
    ("name: a\nsample: {seed: {integer: [0, 1.5]}}", "seed.integer = [0, 1.5]: must be [low, hi"),
    (
        "name: a\nsample: {seed: {integer: [-2, 5]}}",
        "sample: seed = -2: must be greater than or equal to 0",
    ),
    ("name: a\nsample: {seed: {integer: [5, 2]}}", "integer = [5, 2]: must have the lower number"),
    ("name: a\nsample: {seed: {integer: 5}}", "sample.seed.integer = 5: must be [low, high]"),
    (
        "name: a\nsample: {gait.step_width: {uniform: [0.2, .inf]}}",
        "gait.step_width.uniform = [0.2, inf]: must be [low, high], finite numbers",
    ),
    (
        "name: a\nsample: {gait.step_width: {uniform: [0.2, 0.6]}}",
        "sample: gait.step_width = 0.6: must lie in [0.1, 0.45]",
    ),
    (
        "name: a\nsample: {gait.step_width: {log_uniform: [0, 0.2]}}",
        "log_uniform = [0, 0.2]: must be [low, high], both above 0",
    ),
    (
        "name: a\nsample: {gait.step_width: {normal: [0.2, -1]}}",
        "normal = [0.2, -1]: must have no negative deviation",
    ),
    (
        "name: a\nsample: {gait.step_width: {normal: [0.2, 0.1], clip: [0.3, 0.1]}}",
        "clip = [0.3, 0.1]: must have the lower number first",
    ),
    (
        "name: a\nsample: {gait.step_width: {uniform: [0.1, 0.2], clip: [0.1, 0.2]}}",
        "clip = [0.1, 0.2]: belongs to a normal distribution alone",
    ),
    ("name: a\nsample: {seed: {choice: []}}", "sample.seed.choice = []: must be a list of values"),
    (
        "name: a\nsample: {mpc.model: {choice: [ecd, lip]}}",
        "sample: mpc.model = 'lip': must be one of ['ecd', 'contact_consistent', ",
    ),
    ("name: a\ngroups: [{}]", "groups[0].name = '': must be a name"),
    ("name: a\ngroups: [{name: b}, {name: b}]", "groups[1].name = 'b': is the name of another"),
    ("name: a\ngroups: [{name: b, runs: 0}]", "groups[0].runs = 0: must be greater than or equal"),
    ("name: a\nname: b", "line 2 = 'name: b': is no YAML: 'name' is given twice"),
    ("[]", " = []: must be a dictionary or an instance of"),
]


@pytest.mark.parametrize(("change", "said"), WRONG, ids=lambda value: str(value)[:50])
def test_wrong_file_is_refused_by_name(tmp_path, change, said):
    text, fields = (change, {}) if isinstance(change, str) else (TINY, change)
    file = write_sweep(tmp_path, text, **fields)
    with pytest.raises(ScenarioError) as refused:
        load_sweep(file)
    assert said in str(refused.value)


def test_missing_file_is_refused():
    with pytest.raises(ScenarioError) as refused:
        load_sweep("nowhere.yaml")
    said = "nowhere.yaml: the sweep cannot be read: No such file or directory"
    assert str(refused.value) == said


@pytest.mark.parametrize("path", ["a.b[1].c", "a.b[0]", "a.d", "e"])
def test_entries_are_found_and_replaced(path):
    data = {"a": {"b": [1, {"c": 2}], "d": 3}, "e": 4}
    paths.put(data, path, "new")
    assert paths.get(data, path) == "new"
    assert str(data).count("new") == 1


@pytest.mark.parametrize("path", ["", ".a", "a.", "a..b", "a[b]", "a.b[2]", "a.b[-1]", "ab", "[0]"])
def test_odd_paths_lead_nowhere(path):
    with pytest.raises(KeyError):
        paths.get({"a": {"b": [1, 2]}}, path)


def test_thousands_of_groups_that_differ_in_name_are_checked_once(tmp_path, monkeypatch):
    calls = []
    real = file_module.validate
    monkeypatch.setattr(file_module, "validate", lambda *args: calls.append(1) or real(*args))
    names = "".join(f"  - {{name: g{i}}}\n" for i in range(3000))
    text = f"name: many\nscenario: stand\nruns: 1\ngroups:\n{names}"
    assert len(load_sweep(write_sweep(tmp_path, text)).groups) == 3000
    assert len(calls) <= 3  # both ends of the seed, and one more


@pytest.mark.parametrize(
    "text",
    [
        "sample: {seed: {choice: [" + ", ".join(map(str, range(2000))) + "]}}",
        "groups:\n" + "".join(f"  - {{name: g{i}, set: {{seed: {i}}}}}\n" for i in range(1001)),
    ],
)
def test_more_scenarios_than_can_be_checked_soon_are_refused(tmp_path, text):
    with pytest.raises(ScenarioError, match="must be at most 1000"):
        load_sweep(write_sweep(tmp_path, f"name: many\nscenario: stand\nruns: 1\n{text}\n"))
