"""Every number of a scenario has bounds with a physical meaning, on both sides."""

import copy

import pytest
import yaml

from drake_linefoot.checks import plain
from drake_linefoot.errors import ScenarioError
from drake_linefoot.lab.scenario import Scenario, Segment
from drake_linefoot.lab.scenario.courses import (
    BlocksParameters,
    GapsParameters,
    PatchParameters,
    SpiralParameters,
    StairsParameters,
    StonesParameters,
)
from drake_linefoot.lab.scenario.disturbances import PushParameters
from drake_linefoot.lab.scenario.load import make_scenario, validate
from drake_linefoot.lab.scenario.paths import put
from drake_linefoot.lab.scenario.scene import Scene, load_scene

WHOLE = plain(Scenario(segments=[Segment("walk", 1.0, True)], pushes=[PushParameters()]))
COURSES = {
    "stairs": StairsParameters(),
    "gaps": GapsParameters(),
    "stones": StonesParameters(),
    "blocks": BlocksParameters(),
    "spiral": SpiralParameters(),
    "patches": [PatchParameters([[-1.0, -1.0], [1.0, -1.0], [0.0, 1.0]])],
}
WHOLE["ground"] = {name: 0.1 for name in WHOLE["ground"] if name not in COURSES}
WHOLE["ground"] |= {"point_contact_stiffness": 1e5}
WHOLE["ground"] |= {"slope": 0.0, "step_height": 0.0, "ledge_at": 1.0, "ledge_height": 0.0}
SEED = "seed"  # any whole number


def numbers(data, at=""):
    """Return the dotted path of every number in plain data, with its value."""
    entries = data.items() if isinstance(data, dict) else enumerate(data)
    for key, value in entries:
        path = f"{at}[{key}]" if isinstance(data, list) else f"{at}.{key}".removeprefix(".")
        if isinstance(value, dict | list):
            yield from numbers(value, path)
        elif isinstance(value, int | float) and not isinstance(value, bool):
            yield path, value


def on_course(name):
    """A scenario on a course, which is in place of slope, tiles and ledge."""
    return copy.deepcopy(WHOLE) | {"ground": {name: plain(COURSES[name])}}


PLACES = {path: value for path, value in numbers(WHOLE) if path != SEED}
for course in COURSES:
    PLACES |= dict(numbers(on_course(course)["ground"], "ground"))


def refusal(path, value):
    """Return the message with which a value is refused, "" when it is not."""
    entry = path.split(".")[1].partition("[")[0] if "." in path else ""
    data = on_course(entry) if entry in COURSES else copy.deepcopy(WHOLE)
    put(data, path, value)
    try:
        validate(make_scenario(data))
    except ScenarioError as error:
        return str(error)
    return ""


def test_the_places_are_all_that_a_scenario_has():
    for data in (copy.deepcopy(WHOLE), *map(on_course, COURSES)):
        validate(make_scenario(data))
    assert len(PLACES) > 100


@pytest.mark.parametrize("path", PLACES)
def test_no_number_may_be_huge(path):
    kind = type(PLACES[path]) if isinstance(PLACES[path], int) else float
    for value in (1e300, -1e300, 1.1e9, -1.1e9):
        assert path.split(".")[-1].partition("[")[0] in refusal(path, kind(value))


@pytest.mark.parametrize(
    "path, value",
    [
        ("ground.tile", 1e-300),
        ("mpc.knot_step", 1e4),
        ("gait.double_support", 1e9),
        ("segments[0].duration", 1e9),
        ("segments[0].duration", 1e-300),
        ("perturbation.joint_position", 1e300),
        ("ground.friction", 1e-300),
        ("mpc.max_iterations", 2**40),
        ("pushes[0].time", 1e9),
    ],
)
def test_what_has_crashed_or_hung_is_refused(path, value):
    message = refusal(path, value)
    assert path in message
    assert "\n" not in message


def test_segments_are_bounded_together():
    data = copy.deepcopy(WHOLE)
    data["segments"] = [{"duration": 9e3}] * 2
    with pytest.raises(ScenarioError, match=r"segments = '18000 s': must take at most 10000 s"):
        validate(make_scenario(data))


def test_knots_and_their_step_are_bounded_together():
    data = copy.deepcopy(WHOLE)
    data["mpc"] |= {"knots": 200, "knot_step": 0.06}
    with pytest.raises(ScenarioError, match=r"mpc.knot_step.*horizon of at most 10 s"):
        validate(make_scenario(data))


def test_the_numbers_of_a_scene_are_bounded_too(tmp_path):
    for path, _ in numbers(plain(Scene())):
        data = plain(Scene())
        put(data, path, 1e300)
        (tmp_path / "a.yaml").write_text(yaml.safe_dump(data))
        with pytest.raises(ScenarioError, match=path.partition("[")[0]):
            load_scene(str(tmp_path / "a.yaml"))
