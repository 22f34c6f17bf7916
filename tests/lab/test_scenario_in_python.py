"""Scenarios made in Python: a closed loop is built of what a file could say, and of no more."""

import pickle
from dataclasses import replace

import numpy as np
import pytest

from drake_linefoot.errors import ScenarioError
from drake_linefoot.gait.parameters import GaitParameters
from drake_linefoot.lab.scenario import Scenario, Segment, paths
from drake_linefoot.lab.scenario.disturbances import PushParameters
from drake_linefoot.lab.scenario.edit import warnings_of
from drake_linefoot.lab.scenario.load import dump_scenario, load_scenario, parse_scenario, validate
from drake_linefoot.lab.wiring.closed_loop import build_closed_loop
from drake_linefoot.mpc.parameters import MpcParameters, MpcWeights
from drake_linefoot.wbc.parameters import WbcParameters

NAN = float("nan")


def refuse(scenario):
    """Return the message of the error with which a closed loop is not built: one line."""
    with pytest.raises(ScenarioError) as raised:
        build_closed_loop(scenario)
    message = str(raised.value)
    assert len(message.splitlines()) == 1
    return message.removeprefix("scenario: ")


def weighted(**weights):
    return Scenario(mpc=MpcParameters(weights=MpcWeights(**weights)))


@pytest.mark.parametrize(
    ("scenario", "said"),
    [
        (weighted(force=NAN), "mpc.weights.force = nan: must be a finite number"),
        (
            weighted(velocity=[1.0, 2.0]),
            "mpc.weights.velocity = [1.0, 2.0]: must have at least 3 items",
        ),
        (weighted(position=[0.0, NAN, 1.0]), "mpc.weights.position[1] = nan: must be a finite"),
        (
            weighted(position=(1.0, "high", 1.0)),
            "mpc.weights.position[1] = 'high': must be a valid number",
        ),
        (
            weighted(position=np.ones(30)),
            "mpc.weights.position = 'a list of 30': must have at most 3 items",
        ),
        (Scenario(mpc=MpcParameters(knots=2.0)), "mpc.knots = 2.0: must be a valid integer"),
        (Scenario(mpc=MpcWeights()), "mpc.position = [0.0, 0.0, 2000.0]: unknown field"),
        (
            Scenario(gait=GaitParameters(step_width="0.2")),
            "gait.step_width = '0.2': must be a valid num",
        ),
        (Scenario(gait=GaitParameters(step_width=0.6)), "gait.step_width = 0.6: must lie in [0.1"),
        (Scenario(gait=None), "gait = None: must be a dictionary or an instance of"),
        (Scenario(wbc=WbcParameters(solver="mosek")), "wbc.solver = 'mosek': must be one of"),
        (Scenario(seed=-1), "seed = -1: must be greater than or equal to 0"),
        (Scenario(segments=[]), "segments = []: must have at least one segment"),
        (Scenario(segments=[Segment("turn", 1.0, turn_rate=0.1)]), "segments[0].walk = False: mus"),
        (Scenario(pushes=[PushParameters(duration=0.0105)]), "pushes[0].duration = 0.0105: must"),
        (Scenario(robot="atlas"), "robot = 'atlas': unknown robot; must be one of"),
        (None, "scenario = None: must be a dictionary or an instance of"),
    ],
    ids=lambda value: value[:40] if isinstance(value, str) else "",
)
def test_what_no_file_could_say_is_refused(scenario, said):
    assert refuse(scenario).startswith(said)


@pytest.mark.parametrize(
    ("entry", "value", "said"),
    [
        ("mpc.weights.torque", NAN, "mpc.weights.torque = nan: must be a finite number"),
        ("wbc.joint_limit_rate", "80", "wbc.joint_limit_rate = '80': must be a valid number"),
        (
            "gait.step_widht",
            0.2,
            "gait.step_widht = 0.2: unknown field; must be one of ['step_width'",
        ),
        ("mpc.weights.forces", 0.2, "mpc.weights.forces = 0.2: unknown field; must be one of"),
        ("estimator.release_force", 40.0, "estimator.release_force = 40.0: must be below touch_"),
        ("speed", 0.2, "speed = 0.2: unknown field; must be one of ['actuators', 'error'"),
    ],
)
def test_fields_that_are_set_later_are_checked_too(entry, value, said):
    scenario = Scenario()
    *parents, last = paths.parts_of(entry)
    part = scenario
    for name in parents:
        part = getattr(part, name)
    setattr(part, last, value)
    assert refuse(scenario).startswith(said)


def test_misspelt_arguments_are_refused_by_python():
    with pytest.raises(TypeError, match="step_widht"):
        GaitParameters(step_widht=0.2)


def test_numbers_of_numpy_are_numbers():
    scenario = Scenario(segments=[Segment("go", np.float64(2), True, [np.float64(0.5), 0])])
    validate(scenario)
    again = parse_scenario(dump_scenario(scenario))
    assert again == scenario
    assert type(again.segments[0].velocity[0]) is float


def test_scenarios_can_be_pickled_and_replaced():
    scenario = load_scenario("walk")
    assert pickle.loads(pickle.dumps(scenario)) == scenario
    changed = replace(scenario, gait=replace(scenario.gait, step_width=0.2))
    assert (changed.gait.step_width, scenario.gait.step_width) == (0.2, 0.16)
    assert scenario.gait is not load_scenario("walk").gait


@pytest.mark.parametrize(("flight", "most"), [(None, 2.6), (0.0, 1.5), (0.06, 2.6)])
def test_a_speed_beyond_what_may_be_run_is_said(flight, most):
    for speed, said in ((most, 0), (most + 0.01, 1)):
        gait = GaitParameters(flight=flight)
        scenario = Scenario(segments=[Segment("go", 3.0, True, [speed, 0.0])], gait=gait)
        found = warnings_of(scenario)
        assert len(found) == said
        assert all(f"the limit of {most:g} m/s" in text for text in found)
