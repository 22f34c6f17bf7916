"""Scenarios: the shipped ones load, and every wrong one is refused with one clear line."""

import dataclasses
import subprocess
import sys

import pytest
import yaml
from pydrake.multibody import plant

from drake_linefoot.checks import plain
from drake_linefoot.errors import ScenarioError
from drake_linefoot.fields import RENAMED, ScaledDefault
from drake_linefoot.gait.parameters import GaitParameters
from drake_linefoot.lab.scenario import Scenario, Segment, paths
from drake_linefoot.lab.scenario.disturbances import GroundParameters, PushParameters
from drake_linefoot.lab.scenario.load import (
    dump_scenario,
    load_scenario,
    make_scenario,
    parse_scenario,
    validate,
)
from drake_linefoot.resources import models_dir, scenario_files
from drake_linefoot.robot.scaling import scaled
from drake_linefoot.wbc.parameters import WbcParameters
from tests.helpers.walking import robot

BIG = "9" * 5000


def write(tmp_path, text):
    file = tmp_path / "a.yaml"
    file.write_text(text, encoding="utf-8")
    return file


def refuse(name, overrides=None):
    """Return the error of a scenario that must not load; its message is one line."""
    with pytest.raises(ScenarioError) as raised:
        load_scenario(name, overrides)
    message = str(raised.value)
    assert message == " ".join(message.splitlines())
    assert len(message) < 1200
    return raised.value


def test_shipped_scenarios_are_all_there():
    assert list(scenario_files()) == ["paper", "stand", "walk"]


@pytest.mark.parametrize("name", scenario_files())
def test_shipped_scenario_loads_under_its_own_name(name):
    assert load_scenario(name).name == name


def test_walk_shows_every_kind_of_motion_in_about_14_seconds():
    scenario = load_scenario("walk")
    assert 13.0 <= scenario.duration <= 15.0
    assert not scenario.segments[0].walk
    assert not scenario.segments[-1].walk
    walks = [s for s in scenario.segments if s.walk]
    assert any(s.velocity == [0.0, 0.0] and s.turn_rate == 0.0 for s in walks)
    assert max(s.velocity[0] for s in walks) >= 0.8
    assert any(s.velocity[0] > 0.0 and s.turn_rate != 0.0 for s in walks)
    assert any(s.velocity[1] != 0.0 for s in walks)
    assert scenario.perturbation.joint_velocity > 0.0


def test_defaults_are_valid():
    validate(Scenario())


@pytest.mark.parametrize("name", scenario_files())
def test_dump_and_parse_give_the_same_scenario(name):
    overrides = {"mpc.tolerance": 1e-7 / 3, "seed": 7, "name": "a: 'b' #1.5"}
    pushes = [PushParameters(time=1.0), PushParameters(time=1.5, impulse=10.0, direction=-2.0)]
    scenario = load_scenario(name, {**overrides, "pushes": pushes, "ground.slope": 0.1})
    text = dump_scenario(scenario)
    assert parse_scenario(text) == scenario
    assert dump_scenario(parse_scenario(text)) == text


def test_dump_names_every_field():
    data = yaml.safe_load(dump_scenario(scaled(Scenario(), robot())))
    assert list(data) == [f.name for f in dataclasses.fields(Scenario)]
    assert data == plain(parse_scenario(yaml.safe_dump(data))) == plain(Scenario())
    assert list(data["ground"]) == [f.name for f in dataclasses.fields(Scenario().ground)]
    assert set(data["gait"]) == {f.name for f in dataclasses.fields(Scenario().gait)}


def test_dump_leaves_the_size_of_the_robot_open():
    """Read again, the defaults still take the size of whatever robot is built then."""
    scenario = Scenario(gait=GaitParameters(swing_height=0.06))
    again = parse_scenario(dump_scenario(scenario))
    assert again == scenario
    assert isinstance(again.gait.step_width, ScaledDefault)
    assert isinstance(again.mpc.weights.position[0], ScaledDefault)
    assert type(again.gait.swing_height) is float


def test_path_and_overrides(tmp_path):
    file = write(tmp_path, "seed: 3\n_anchors: {a: &width 0.2}\ngait: {step_width: *width}\n")
    scenario = load_scenario(file, {"mpc.model": "srbm"})
    assert (scenario.seed, scenario.gait.step_width, scenario.mpc.model) == (3, 0.2, "srbm")
    assert scenario.wbc == Scenario().wbc


def numbers(data, at=""):
    """Yield the dotted path of every number in plain data."""
    if isinstance(data, dict):
        for name, value in data.items():
            yield from numbers(value, f"{at}.{name}" if at else name)
    elif isinstance(data, list):
        for i, value in enumerate(data):
            yield from numbers(value, f"{at}[{i}]")
    elif isinstance(data, float):
        yield at


FULL = Scenario(pushes=[PushParameters()], ground=GroundParameters(*[0.5] * 9))


@pytest.mark.parametrize("entry", list(numbers(plain(FULL))))
@pytest.mark.parametrize("value", [float("nan"), float("-inf"), "1.0", None])
def test_every_number_is_checked(entry, value):
    data = plain(FULL)
    paths.put(data, entry, value)
    if value is None and entry.startswith("ground."):
        assert make_scenario(data).ground != FULL.ground
        return
    with pytest.raises(ScenarioError) as raised:
        make_scenario(data)
    assert (raised.value.entry, str(raised.value.value)) == (entry, str(value))


# A YAML text, then what the message must hold besides the file's path.
WRONG = [
    ("gait: {step_width: .nan}", "gait.step_width = nan: must be a finite number"),
    ("gait: {swing_height: .inf}", "gait.swing_height = inf: must be a finite number"),
    (
        f"gait: {{com_height: 1{'0' * 400}}}",
        "gait.com_height = 'a whole number of 1329 bits': must be",
    ),
    ("gait: {step_width: 0.6}", "gait.step_width = 0.6: must lie in [0.1, 0.45]"),
    ("gait: {com_height: 0.8}", "gait.com_height = 0.8: must lie in [0.56, 0.68]"),
    ("gait: {single_support: 0.05}", "single_support = 0.05: must be above settle_time + fr"),
    (
        "gait: {double_support: 0.0}",
        "gait.double_support = 0.0: must be greater than or equal to 0.001 s",
    ),
    ("gait: {swing_height: 0}", "gait.swing_height = 0: must be greater than 0"),
    ("gait: {reach_speed: 0}", "gait.reach_speed = 0: must be greater than 0"),
    (
        "gait: {late_contact_max: -0.01}",
        "gait.late_contact_max = -0.01: must be greater than or equal to 0",
    ),
    ("gait: {contact_speed: 0}", "gait.contact_speed = 0: must be greater than 0"),
    ("gait: {reach_forward: 0}", "gait.reach_forward = 0: must be greater than 0"),
    ("gait: {reach_outward: -0.3}", "gait.reach_outward = -0.3: must be greater than 0"),
    (
        "gait: {slope_learning: -1.0}",
        "gait.slope_learning = -1.0: must be greater than or equal to 0",
    ),
    ("gait: {slope_max: 1.5}", "gait.slope_max = 1.5: must be less than or equal to 1"),
    ("gait: {contact_feedback: 1}", "gait.contact_feedback = 1: must be"),
    ("gait: {first_swing: up}", "gait.first_swing = 'up': must be one of ['left', 'right']"),
    (
        "gait: {step_widht: 0.2}",
        "gait.step_widht = 0.2: unknown field; must be one of ['step_width'], or",
    ),
    ("gait: {hurried_steps: 3}", "gait.hurried_steps = 3: unknown field; is called recovery_steps"),
    ("gait: {closing_tolerance: 0.1}", "unknown field; is called final_step_tolerance now"),
    ("wbc: {hurried_steps: 3}", "wbc.hurried_steps = 3: unknown field; must be one of ["),
    ("gait: {step_width: wide}", "gait.step_width = 'wide': must be a valid number"),
    (
        "gait: {step_width: 2e-1}",
        "gait.step_width = '2e-1': must be a valid number; YAML takes 1e-3",
    ),
    ("gait: {step_width: true}", "gait.step_width = True: must be a valid number"),
    ("gait: {step_width: null}", "gait.step_width = None: must be a valid number"),
    ("gait: {1: 2}", "gait.1 = 2: unknown field"),
    ("gait:", "gait = None: must be a dictionary or an instance of"),
    (
        "wbc: {swing_position_gain: -1.0}",
        "wbc.swing_position_gain = -1.0: must be greater than or equal to 0",
    ),
    ("wbc: {solver: mosek}", "wbc.solver = 'mosek': must be one of ['osqp', 'clarabel']"),
    (
        "mpc: {solver: mosek}",
        "mpc.solver = 'mosek': must be one of ['osqp', 'clarabel', 'active_set']",
    ),
    ("mpc: {model: lip}", "mpc.model = 'lip': must be one of ['ecd', 'contact_consistent', "),
    ("mpc: {knots: 0}", "mpc.knots = 0: must be greater than or equal to 1"),
    ("mpc: {knots: 1.5}", "mpc.knots = 1.5: must be a valid integer"),
    ("mpc: {period: 0.0205}", "mpc.period = 0.0205: must be a multiple of 0.001 s"),
    (
        "{mpc: {period: 0.021}, plant: {time_step: 0.002}}",
        "mpc.period = 0.021: must be a multiple of 0.002 s, plant.time_step",
    ),
    ("mpc: {friction: 0}", "mpc.friction = 0: must be greater than 0"),
    (
        "mpc: {weights: {position: [1, 2]}}",
        "mpc.weights.position = [1, 2]: must have at least 3 items",
    ),
    (
        "mpc: {weights: {position: [1, 2, -3]}}",
        "weights.position[2] = -3: must be greater than or equal to 0",
    ),
    ("mpc: {weights: {velocity: 3}}", "mpc.weights.velocity = 3: must be a valid list"),
    ("mpc: {weights: {force: 0}}", "mpc.weights.force = 0: must be greater than 0"),
    ("estimator: {method: kalman}", "estimator.method = 'kalman': must be one of ['pseudo"),
    ("estimator: {filter_constant: 1}", "estimator.filter_constant = 1: must be less than 1"),
    ("estimator: {release_force: 60}", "estimator.release_force = 60.0: must be below touch_force"),
    ("plant: {contact_approximation: soft}", "plant.contact_approximation = 'soft': must be one"),
    ("plant: {time_step: 0.1}", "plant.time_step = 0.1: must be 0.001 or 0.002 s"),
    (
        "perturbation: {base_velocity: -1}",
        "perturbation.base_velocity = -1: must be greater than or equal",
    ),
    ("segments: []", "segments = []: must have at least one segment"),
    ("segments: 3", "segments = 3: must be a valid list"),
    ("segments: &a [*a]", "segments[0] = 'a list of 1': must be a dictionary or an instance of"),
    ("segments: [{}, {duration: 0}]", "segments[1].duration = 0: must be greater than 0"),
    ("segments: [{velocity: [0.1]}]", "segments[0].velocity = [0.1]: must have at least 2 items"),
    ("segments: [{velocity: [a, 0]}]", "segments[0].velocity[0] = 'a': must be a valid number"),
    ("segments: [{turn_rate: .inf}]", "segments[0].turn_rate = inf: must be a finite number"),
    ("segments: [{turn_rate: 0.1}]", "segments[0].walk = False: must be true in a segment with"),
    ("segments: [{walk: 1}]", "segments[0].walk = 1: must be a valid boolean"),
    ("segments: [{name: ''}]", "segments[0].name = '': must be a name"),
    ("ground: {slope: steep}", "ground.slope = 'steep': must be a valid number"),
    ("ground: {slope: 0.9}", "ground.slope = 0.9: must be less than or equal to 0.8 rad"),
    ("ground: {slope: -0.1}", "ground.slope = -0.1: must be greater than or equal to 0 rad"),
    ("ground: {friction: 0}", "ground.friction = 0: must be greater than 0"),
    ("ground: {grip: 1.0}", "ground.grip = 1.0: unknown field; must be one of ['blocks'"),
    ("ground: {step_height: 0.03, tile: 0.1}", "ground.tile = 0.1: gives 12800 tiles, which"),
    ("error: {leg_mass_scale: 0}", "error.leg_mass_scale = 0: must be greater than 0"),
    (
        "error: {joint_friction: -1}",
        "error.joint_friction = -1: must be greater than or equal to 0",
    ),
    ("error: {torso_com: [0.1]}", "error.torso_com = [0.1]: must have at least 3 items"),
    ("actuators: {delay: 0.007}", "actuators.delay = 0.007: must be less than or equal to 0.006 s"),
    (
        "{mpc: {run_period: 0.005}, plant: {time_step: 0.002}}",
        "mpc.run_period = 0.005: must be a multiple of 0.002 s, plant.time_step",
    ),
    ("actuators: {delay: 0.0015}", "actuators.delay = 0.0015: must be a multiple of 0.001 s"),
    ("actuators: {base_speed_share: 1}", "actuators.base_speed_share = 1: must be less than 1"),
    ("sensors: {gyro: -0.1}", "sensors.gyro = -0.1: must be greater than or equal to 0"),
    ("sensors: {bias: 0.1}", "sensors.bias = 0.1: unknown field; must be one of ['encoder_res"),
    ("pushes: {time: 1.0}", "pushes = 'a dict of 1': must be a valid list"),
    ("pushes: [{force: 1.0}]", "pushes[0].force = 1.0: unknown field; must be one of ['direction'"),
    ("pushes: [{time: -0.1}]", "pushes[0].time = -0.1: must be greater than or equal to 0"),
    ("pushes: [{impulse: -1}]", "pushes[0].impulse = -1: must be greater than or equal to 0"),
    (
        "pushes: [{}, {duration: 0}]",
        "pushes[1].duration = 0: must be greater than or equal to 0.001 s",
    ),
    ("pushes: [{duration: 0.0125}]", "pushes[0].duration = 0.0125: must be a multiple of 0.001 s"),
    ("pushes: [{direction: .inf}]", "pushes[0].direction = inf: must be a finite number"),
    ("seed: -1", "seed = -1: must be greater than or equal to 0"),
    ("name: 2020-01-01", "name = datetime.date(2020, 1, 1): must be a valid string"),
    ('name: "two\\nlines"', r"name = 'two\nlines': must be a name, on one line"),
    ("robot: atlas", "robot = 'atlas': unknown robot; must be one of ['mit_humanoid']"),
    ("robot: nowhere.yaml", "robot = 'nowhere.yaml': not usable: nowhere.yaml"),
    ("scene: moon", "scene = 'moon': unknown scene; must be one of ['flat_ground', 'rough', 's"),
    ("scene: nowhere.yaml", "scene = 'nowhere.yaml': not usable: "),
    (f"scene: {'a' * 300}.yaml", "scene = 'aaa"),
    ("speed: 3", "speed = 3: unknown field; must be one of ['actuators', 'error', 'estimation',"),
    ("1: 2", "1 = 2: unknown field"),
    ("[]", " = []: must be a dictionary or an instance of"),
    ("", " = None: must be a dictionary or an instance of"),
    ("a: b: c", "line 1 = 'a: b: c': is no YAML: mapping values are not allowed here"),
    ("\nseed: [1,", "line 2 = 'seed: [1,': is no YAML: "),
    ("seed: 1\nseed: 2", "line 2 = 'seed: 2': is no YAML: 'seed' is given twice"),
    ("name: !!python/name:os.system x", "is no YAML: could not determine a constructor"),
    ("name: a\x00b", "is no YAML: "),
    ("seed: " + "[" * 5000, "is no YAML: "),
    (f"seed: {BIG}", "is no YAML: "),
    (
        f"mpc: {{knots: 0x{BIG}}}",
        "mpc.knots = 'a whole number of 20000 bits': must be less than or equal to 200",
    ),
    ("seed: !!int ''", "is no YAML: "),
]


@pytest.mark.parametrize(("text", "message"), WRONG, ids=lambda value: value[:40])
def test_wrong_text_is_refused_by_name(tmp_path, text, message):
    file = write(tmp_path, text)
    said = str(refuse(file))
    assert said.startswith(f"{file}")
    assert message in said


def test_missing_file():
    assert str(refuse("nowhere.yaml")).startswith("scenario = 'nowhere.yaml': no such file; must")
    assert "['paper', 'stand', 'walk']" in str(refuse("wlak"))
    assert "no such file" in str(refuse("a" * 5000))
    assert "no such file" in str(refuse("a\0b"))


def test_folder(tmp_path):
    assert "is a folder; must be a YAML file" in str(refuse(tmp_path))


def test_file_that_is_no_text(tmp_path):
    file = tmp_path / "a.yaml"
    file.write_bytes(b"\xff\xfe\x00\x80")
    assert "cannot be read: is not UTF-8 text" in str(refuse(file))


def test_error_carries_its_evidence():
    error = refuse("walk", {"gait.step_width": 2.0})
    assert error.where.endswith("walk.yaml")
    assert (error.entry, error.value) == ("gait.step_width", 2.0)
    assert "[0.1, 0.45]" in error.allowed


@pytest.mark.parametrize("entry", ["speed", "gait.speed", "gaits.step_width", "mpc.weights.x.y"])
def test_override_of_an_unknown_field(entry):
    assert f"{entry} = 1: no such field" in str(refuse("walk", {entry: 1}))


def test_override_of_a_field_that_was_called_otherwise():
    refused = str(refuse("walk", {"gait.hurried_steps": 1}))
    assert "gait.hurried_steps = 1: no such field; it is called recovery_steps now" in refused


def test_every_new_name_of_a_field_is_one():
    kinds = GaitParameters, WbcParameters
    known = {field.name for kind in kinds for field in dataclasses.fields(kind)}
    assert set(RENAMED.values()) <= known and not set(RENAMED) & known


def test_override_of_an_item_of_a_list():
    scenario = load_scenario("walk", {"pushes": [PushParameters()], "pushes[0].impulse": 5.0})
    assert scenario.pushes == [PushParameters(impulse=5.0)]
    assert load_scenario("walk", {"segments[1].velocity[0]": 0.1}).segments[1].velocity == [0.1, 0]
    assert "pushes[0].time = 1: no such field" in str(refuse("walk", {"pushes[0].time": 1}))


def test_override_of_a_wrong_type():
    assert "mpc.weights = 3: must be a dictionary" in str(refuse("walk", {"mpc.weights": 3}))
    assert "segments[0] = 'x': must be a dictionary" in str(refuse("walk", {"segments": ["x"]}))


def test_scenario_made_in_python_is_checked_too():
    scenario = Scenario(segments=[Segment(), Segment(walk=True, velocity=[float("nan"), 0.0])])
    with pytest.raises(ScenarioError, match=r"segments\[1\]\.velocity\[0\] = nan"):
        validate(scenario)


def test_robot_given_by_path_is_checked_by_its_own_limits(tmp_path):
    shipped = models_dir() / "mit_humanoid" / "mit_humanoid.yaml"
    wide = yaml.safe_load(shipped.read_text(encoding="utf-8"))
    wide["limits"]["step_width_max"] = 0.7
    robot = tmp_path / "wide.yaml"
    robot.write_text(yaml.safe_dump(wide), encoding="utf-8")
    scenario = load_scenario("walk", {"robot": str(robot), "gait.step_width": 0.6})
    assert scenario.gait.step_width == 0.6
    robot.write_text("limits: 3", encoding="utf-8")
    assert f"{robot}: name = None: Field required" in str(refuse("walk", {"robot": str(robot)}))


def test_validation_builds_no_plant():
    code = (
        "from pydrake.multibody import plant, parsing\n"
        "def refuse(*args): raise AssertionError('built a plant')\n"
        "plant.MultibodyPlant.__init__ = parsing.Parser.__init__ = refuse\n"
        "from drake_linefoot.lab.scenario.load import load_scenario\n"
        "assert load_scenario('walk').name == 'walk'\n"
    )
    subprocess.run([sys.executable, "-c", code], timeout=60, check=True)


def test_contact_approximations_are_those_that_drake_has(monkeypatch):
    """Drake 1.58 has no tamsi any more: a scenario with it is refused when it is read."""
    here = ("sap", "lagged", "similar")
    for name in here:
        make_scenario({"plant": {"contact_approximation": name}})
    newer = {f"k{name.capitalize()}": None for name in here}
    enum = type("DiscreteContactApproximation", (), {"__members__": newer})
    monkeypatch.setattr(plant, "DiscreteContactApproximation", enum)
    with pytest.raises(ScenarioError, match=r"contact_approximation = 'tamsi': must be one of"):
        make_scenario({"plant": {"contact_approximation": "tamsi"}})
