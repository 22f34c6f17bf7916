"""The MIT Humanoid's description agrees with its model, and the generated files are current."""

import importlib.util
import sys
from pathlib import Path

import pytest
import yaml
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant

from drake_linefoot.resources import models_dir

ROBOT = models_dir() / "mit_humanoid"
URDF = ROBOT / "mit_humanoid.urdf"
TOOL = Path(__file__).resolve().parents[2] / "tools" / "make_mit_humanoid.py"
SIDES = ("left", "right")
LEG = ("hip_yaw", "hip_abad", "hip_pitch", "knee", "ankle")
ARM = ("shoulder_pitch", "shoulder_abad", "shoulder_yaw", "elbow")
ABOUT_Y = {"hip_pitch", "knee", "ankle", "shoulder_pitch", "elbow"}


def read(name):
    return yaml.safe_load((ROBOT / name).read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def description():
    return read("mit_humanoid.yaml")


@pytest.fixture(scope="module")
def plant():
    plant = MultibodyPlant(0.0)
    Parser(plant).AddModels(str(URDF))
    plant.Finalize()
    return plant


@pytest.fixture(scope="module")
def generator():
    """The generator script as a module."""
    sys.path.insert(0, str(TOOL.parent))
    try:
        spec = importlib.util.spec_from_file_location(TOOL.stem, TOOL)
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        yield module
    finally:
        sys.path.remove(str(TOOL.parent))


def test_description_has_exactly_its_entries(description):
    assert list(description) == [
        *("name", "model", "floating_base", "actuated_joints", "feet", "arm_joints"),
        *("mirror", "nominal_posture", "limits"),
    ]
    assert description["model"] == URDF.name
    assert description["floating_base"] == "torso"


def test_description_names_the_joints_of_the_model(description, plant):
    names = plant.GetActuatorNames(add_model_instance_prefix=False)
    assert description["actuated_joints"] == names
    assert description["arm_joints"] == [f"{side}_{name}" for side in SIDES for name in ARM]
    for foot, side in zip(description["feet"], SIDES, strict=True):
        assert (foot["name"], foot["frame"]) == (side, f"{side}_foot_link")
        assert plant.HasFrameNamed(foot["frame"])
        assert foot["leg_joints"] == [f"{side}_{name}" for name in LEG]


def test_contact_points_are_the_lowest_points_of_the_spheres(description):
    contact = read("parameters.yaml")["contact"]
    heel, toe = (contact["centres"][name] for name in ("heel", "toe"))
    expected = [[x, y, pytest.approx(z - contact["radius"])] for x, y, z in (heel, toe)]
    for foot in description["feet"]:
        assert foot["contact_points"] == expected


def test_only_axes_along_y_keep_their_sign_in_the_mirror(description):
    joints = read("parameters.yaml")["joints"]
    signs = {joint: 1 if joint in ABOUT_Y else -1 for joint in (*LEG, *ARM)}
    assert {joint["name"]: joint["mirror_sign"] for joint in joints} == {
        f"left_{name}": sign for name, sign in signs.items()
    }
    assert description["mirror"] == {
        f"left_{name}": [f"right_{name}", sign] for name, sign in signs.items()
    }


def upright(plant, hip_pitch, knee, ankle):
    """A context with both legs bent alike and the torso upright at the origin."""
    context = plant.CreateDefaultContext()
    angles = {"hip_pitch": hip_pitch, "knee": knee, "ankle": ankle}
    for side in SIDES:
        for name, angle in angles.items():
            plant.GetJointByName(f"{side}_{name}").set_angle(context, angle)
    return context


def com_above_sole(plant, context):
    """Vector from the middle of the left contact line to the CoM."""
    foot = plant.GetFrameByName("left_foot_link").CalcPoseInWorld(context)
    com = plant.CalcCenterOfMassPositionInWorld(context)
    return com - foot.translation() - foot.rotation().multiply([0.025, 0.0, -0.041])


def test_nominal_posture_stands_with_flat_soles_under_the_com(description, plant):
    posture = description["nominal_posture"]
    for name in LEG:
        assert posture.get(f"left_{name}") == posture.get(f"right_{name}")
    legs = [posture[f"left_{name}"] for name in ("hip_pitch", "knee", "ankle")]
    assert sum(legs) == pytest.approx(0.0, abs=1e-12)
    x, _, z = com_above_sole(plant, upright(plant, *legs))
    assert (x, z) == (pytest.approx(0.0, abs=1e-5), pytest.approx(0.6523, abs=6e-5))


def test_com_height_limits_leave_the_legs_room(description, plant):
    limits = description["limits"]
    deep = upright(plant, -0.766699, 1.55, -0.783301)  # flat soles, the ankle 1 deg from its stop
    x, _, lowest = com_above_sole(plant, deep)
    assert abs(x) < 1e-3
    assert limits["com_height_min"] == pytest.approx(lowest, abs=1e-3)
    highest = com_above_sole(plant, upright(plant, 0.0, 0.0, 0.0))[2]
    assert lowest < limits["com_height_max"] < highest - 0.02


@pytest.mark.parametrize(
    ("knee", "ankle", "ahead", "height"),
    [
        (1.405, -0.8, 0.033, 0.58),  # the ankle at its stop, the foot behind the CoM
        (1.229, -0.8, 0.068, 0.60),
        (0.814, -0.8, 0.162, 0.620),  # the highest CoM at which the stop is met
        (0.0, -0.535296, 0.228, 0.63),  # a straight leg, the foot behind
        (0.0, 0.547083, -0.288, 0.63),  # and before the CoM
        (0.0, 0.507024, -0.271, 0.64),
    ],
)
def test_stride_that_a_flat_foot_allows(plant, knee, ankle, ahead, height):
    x, _, z = com_above_sole(plant, upright(plant, -(knee + ankle), knee, ankle))
    assert (x, z) == (pytest.approx(ahead, abs=1e-3), pytest.approx(height, abs=1e-3))


def test_step_length_is_within_reach_somewhere(description, plant):
    ends = [upright(plant, -ankle, 0.0, ankle) for ankle in (-0.535296, 0.547083)]
    behind, before = (com_above_sole(plant, context)[0] for context in ends)
    assert description["limits"]["step_length"] < behind - before


def test_generated_files_are_current(generator):
    files = generator.generate(ROBOT)
    assert generator.stale_files(files) == []
    assert set(files) == {URDF, *(ROBOT / "meshes").iterdir()}


def test_check_finds_a_stale_file(generator, tmp_path, monkeypatch, capsys):
    target = tmp_path / "models" / "mit_humanoid"
    target.mkdir(parents=True)
    for name in ("parameters.yaml", "looks.yaml"):
        (target / name).write_bytes((ROBOT / name).read_bytes())
    monkeypatch.setattr(generator, "MODEL_DIR", target)
    assert generator.main(["--check"]) == 1
    assert generator.main([]) == 0
    assert generator.main(["--check"]) == 0
    capsys.readouterr()
    (target / "mit_humanoid.urdf").write_text("edited", encoding="utf-8")
    assert generator.main(["--check"]) == 1
    assert "mit_humanoid.urdf" in capsys.readouterr().out
