"""Dataclasses of parameters: mappings for their parts, tuples and arrays, help that can be read."""

import inspect

import numpy as np
import pytest

from drake_linefoot import ControllerParameters, Scenario, Segment, build_controller
from drake_linefoot.errors import ScenarioError
from drake_linefoot.gait.parameters import GaitParameters
from drake_linefoot.lab.scenario.disturbances import PushParameters
from drake_linefoot.lab.scenario.load import validate
from drake_linefoot.mpc.parameters import MpcParameters, MpcWeights


def test_parts_may_be_mappings_and_lists_of_mappings():
    weights = {"force": 2e-5}
    made = Scenario(
        mpc={"model": "srbm", "weights": weights},
        segments=[{"name": "walk", "walk": True}, Segment("stop")],
        pushes=({"time": 1.0, "impulse": 8.0},),
    )
    assert made == Scenario(
        mpc=MpcParameters(model="srbm", weights=MpcWeights(force=2e-5)),
        segments=[Segment("walk", walk=True), Segment("stop")],
        pushes=[PushParameters(1.0, impulse=8.0)],
    )
    assert MpcParameters(weights=weights).weights.force == 2e-5
    assert "walk 1.0 s" in repr(made)


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"mpc": {"modle": "srbm"}}, "mpc.modle = 'srbm': unknown field; must be one of"),
        ({"pushes": [{"force": 1.0}]}, r"pushes\[0\].force = 1.0: unknown field; must be one of"),
        ({"segments": [Segment(), {"duration": "long"}]}, r"segments\[1\].duration = 'long': must"),
    ],
)
def test_what_is_wrong_in_a_mapping_is_named(fields, message):
    with pytest.raises(ScenarioError, match=message):
        Scenario(**fields)


@pytest.mark.parametrize("pair", [(0.5, 0.1), np.array([0.5, 0.1]), [np.float64(0.5), 0.1]])
def test_tuples_and_arrays_are_lists(pair):
    scenario = Scenario(segments=(Segment("walk", 2.0, walk=True, velocity=pair),))
    assert validate(scenario).segments[0].velocity == [0.5, 0.1]
    small = Scenario(segments=[Segment(duration=np.float32(0.5), velocity=np.zeros(2, np.float32))])
    assert validate(small).segments == [Segment(duration=0.5)]
    with pytest.raises(ScenarioError, match="at most 2 items"):
        validate(Scenario(segments=[Segment("walk", walk=True, velocity=np.ones(3))]))


def test_a_controller_takes_them_too(humanoid):
    parameters = ControllerParameters(mpc={"weights": {"position": np.array([0.0, 0.0, 1e3])}})
    parameters.gait.speed_scale = (1.1, 1.2)  # set afterwards
    assert build_controller(humanoid, parameters).get_name() == "controller"
    parameters.gait.speed_scale = (1.1, "fast")
    with pytest.raises(ScenarioError, match="speed_scale"):
        build_controller(humanoid, parameters)


def test_signatures_have_plain_types():
    assert str(inspect.signature(Segment)) == (
        "(name: str = 'stand', duration: float = 1.0, walk: bool = False, "
        "velocity: list[float] = [0.0, 0.0], turn_rate: float = 0.0)"
    )
    shown = str(inspect.signature(Scenario))
    assert "segments: list[Segment]" in shown and "mpc: MpcParameters = MpcParameters()" in shown
    assert "Annotated" not in shown


def test_docstrings_say_of_every_field_what_it_means():
    lines = inspect.getdoc(GaitParameters).splitlines()
    assert lines[0].startswith("How the robot steps")
    assert "    swing_height [m] = 0.06: Apex of the swing foot." in lines
    assert "    lateral_max [m/s] = 0.5" in lines
    names = [*GaitParameters.__dataclass_fields__]
    assert [line.split()[0] for line in lines[lines.index("Fields:") + 1 :]] == names
