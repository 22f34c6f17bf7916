"""Feet with a width: when new-robot takes them for surfaces, and what it says of them."""

import numpy as np
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import ConvexHull, Delaunay

from drake_linefoot.errors import ModelError
from drake_linefoot.gait.constants import constants_of
from drake_linefoot.gait.parameters import GaitParameters
from drake_linefoot.lab.new_robot.analysis import analyse
from drake_linefoot.lab.new_robot.folder import write_folder
from drake_linefoot.lab.new_robot.posture import com_in_base, place_feet
from drake_linefoot.lab.new_robot.soles import inscribed
from drake_linefoot.lab.scenario import Scenario
from drake_linefoot.lab.scenario.load import check_limits, load_scenario
from drake_linefoot.robot.description import LINE, SIDES, SURFACE
from drake_linefoot.robot.humanoid import load_humanoid
from drake_linefoot.robot.scaling import scaled
from tests.helpers import made_up_robots as made_up
from tests.helpers.command_line import refuse
from tests.helpers.sole_biped import write_sole_biped

pytestmark = pytest.mark.slow  # together


def said(found):
    """The line on how feet touch."""
    (line,) = [line for line in found.lines if line.startswith("contact: ")]
    return line


# --- what is found --------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("length", "width", "mass"), [(0.17, 0.06, 33.0), (0.2, 0.05, 60.0), (0.08, 0.03, 2.0)]
)
def test_a_wide_sole_is_a_surface_with_an_ankle_roll(tmp_path, length, width, mass):
    found = analyse(write_sole_biped(tmp_path, length, width, mass))
    h, d = found.humanoid, found.humanoid.description
    assert d.contact == SURFACE and d.lock == {}
    assert h.mass == pytest.approx(mass)
    assert [len(foot.leg_joints) for foot in d.feet] == [6, 6]
    assert d.feet[0].leg_joints[-1] == "left_ankle_roll"
    assert (h.half_length, h.half_width) == pytest.approx((0.5 * length, 0.5 * width), abs=1e-5)
    assert d.contact_margin == pytest.approx(max(0.15 * 0.5 * width, 0.002), abs=5e-5)
    assert h.contact.half_width == pytest.approx(0.5 * width - d.contact_margin, abs=1e-5)
    assert f"{width:.3f} m wide" in said(found)
    x = 0.1 * length + 0.5 * length * np.array([-1.0, -1.0, 1.0, 1.0])
    np.testing.assert_allclose(h.contact_points[0, :, 0], x, atol=1e-5)
    y = 0.5 * width * np.array([1.0, -1.0, 1.0, -1.0])
    np.testing.assert_allclose(h.contact_points[1, :, 1], y, atol=1e-5)


def test_it_stands_on_all_corners_and_at_its_limits_with_flat_soles(tmp_path):
    """By the plant, from the description alone."""
    found = analyse(write_sole_biped(tmp_path))
    write_folder(tmp_path / "biped", found)
    h = load_humanoid(tmp_path / "biped" / "sole_biped.yaml")
    context = h.plant.CreateDefaultContext()
    h.plant.SetPositions(context, h.q_nominal)
    for frame, points in zip(h.foot_frames, h.contact_points, strict=True):
        corners = (frame.CalcPoseInWorld(context) @ points.T).T
        assert abs(corners[:, 2]).max() < 1e-4
    limits = found.data["limits"]
    width, height = limits["step_width_max"] - 1e-3, found.reach.walking
    p = np.array([[0.0, 0.5 * width, -height], [0.0, -0.5 * width, -height]])
    q, off = place_feet(h, found.reach.q, com_in_base(h, found.reach.q) + p)
    assert off < 2e-3
    h.plant.SetPositions(context, q)
    for frame in h.foot_frames:
        up = frame.CalcPose(context, h.base.body_frame()).rotation().matrix()[:, 2]
        np.testing.assert_allclose(up, [0.0, 0.0, 1.0], atol=5e-3)


@pytest.mark.parametrize("contact", [SURFACE, LINE])
def test_legs_with_wide_soles_stay_farther_apart(tmp_path, contact):
    """Whatever they touch with; soles that are narrow need no more than others."""
    for width, wide in ((0.10, True), (0.03, False)):
        found = analyse(write_sole_biped(tmp_path, width=width), contact=contact)
        gap = constants_of(GaitParameters(), found.humanoid)[0]["crossing_gap"]
        usual = scaled(GaitParameters(), found.humanoid).crossing_gap
        assert bool(gap > usual) is wide
        assert gap - width > 0.005


def test_its_walk_is_a_scenario(tmp_path):
    found = analyse(write_sole_biped(tmp_path))
    write_folder(tmp_path / "biped", found)
    scenario = load_scenario(str(tmp_path / "biped" / "walk.yaml"))
    assert scenario.duration == pytest.approx(10.0)
    gait = scaled(GaitParameters(), found.humanoid)
    check_limits(Scenario(gait=gait), found.humanoid.description)
    assert gait.step_width > 0.06  # feet side by side


def test_the_ground_under_four_corners_is_as_stiff_as_under_two_ends(tmp_path):
    write_sole_biped(tmp_path)
    stiff = []
    for contact in (SURFACE, LINE):
        found = analyse(tmp_path / "sole_biped.urdf", contact=contact)
        write_folder(tmp_path / contact, found)
        ground = load_scenario(str(tmp_path / contact / "walk.yaml")).ground
        points = found.humanoid.contact_points.shape[1]
        stiff.append(points * ground.point_contact_stiffness)
    assert stiff[0] == pytest.approx(stiff[1], rel=0.02)


def test_an_ankle_that_rolls_little_bounds_the_width_of_steps(tmp_path):
    """The sole stays flat while the leg leans out."""
    free, bound = (analyse(rolling(tmp_path, roll)).data["limits"] for roll in (0.5, 0.12))
    assert bound["step_width_max"] < free["step_width_max"] - 0.1


def rolling(folder, roll):
    file = write_sole_biped(folder)
    tree = made_up.read(file)
    made_up.bound(tree, "ankle_roll", -roll, roll)
    return made_up.write(tree, folder, f"roll_{roll}")


# --- when a foot is a line ------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("width", "contact"), [(0.002, LINE), (0.008, LINE), (0.012, LINE), (0.016, SURFACE)]
)
def test_a_sole_that_is_nearly_a_line_is_one(tmp_path, width, contact):
    """Of 170 mm: less than 5 % of it within the margin of 2 mm."""
    found = analyse(write_sole_biped(tmp_path, width=width))
    d = found.humanoid.description
    assert d.contact == contact
    if contact == LINE:
        assert d.lock == {"left_ankle_roll": 0.0, "right_ankle_roll": 0.0}
        assert f"soles are {1e3 * width:.0f} mm wide" in said(found)
        assert "contact_margin" not in found.data


@pytest.mark.parametrize(("effort", "contact"), [(1.0, LINE), (2.0, SURFACE)])
def test_an_ankle_roll_that_holds_next_to_nothing_is_locked(tmp_path, effort, contact):
    """33 kg held 5 % of 85 mm aside take 1.38 N m."""
    found = analyse(write_sole_biped(tmp_path, roll_effort=effort))
    assert found.humanoid.description.contact == contact
    weak = "left_ankle_roll has 1 N m, which holds the weight no 4.2 mm aside" in said(found)
    assert weak == (contact == LINE)


def test_five_joints_make_a_line(tmp_path):
    found = analyse(write_sole_biped(tmp_path, joints=5))
    assert found.humanoid.description.contact == LINE
    assert "a leg has 5 joints, a sole needs six" in said(found)


def add_toes(tree, joint="ankle_roll"):
    """Let the foot bend at its toes, which carry the sole."""
    for side in SIDES:
        last = made_up.named(tree, "joint", f"{side}_{joint}")
        last.find("child").set("link", f"{side}_rear_link")
        made_up.add_link(tree, f"{side}_rear_link", 0.3)
        sole = f"{side}_{joint}_link"
        made_up.add_joint(tree, f"{side}_toe", f"{side}_rear_link", sole, "0 1 0")


@pytest.mark.parametrize(("joints", "contact"), [(6, SURFACE), (5, LINE)])
def test_a_toe_is_no_ankle_roll(tmp_path, joints, contact):
    tree = made_up.read(write_sole_biped(tmp_path, joints=joints))
    add_toes(tree, "ankle_roll" if joints == 6 else "ankle_pitch")
    found = analyse(made_up.write(tree, tmp_path, "toes"))
    assert found.humanoid.description.contact == contact
    assert found.data["lock"] == {"left_toe": 0.0, "right_toe": 0.0}
    if contact == LINE:
        assert "no six joints of a leg move a sole in all its ways" in said(found)


# --- what is asked for, and refused ---------------------------------------------------------------


def test_a_line_that_is_asked_for_is_that_of_the_robot_without_an_ankle_roll(tmp_path):
    asked = analyse(write_sole_biped(tmp_path), contact=LINE)
    tree = made_up.read(tmp_path / "sole_biped.urdf")
    for side in SIDES:
        made_up.named(tree, "joint", f"{side}_ankle_roll").set("type", "fixed")
    welded = analyse(made_up.write(tree, tmp_path, "welded"))
    assert "asked for" in said(asked)
    assert asked.data["limits"] == welded.data["limits"]
    assert asked.data["nominal_posture"] == pytest.approx(welded.data["nominal_posture"])
    assert asked.humanoid.p_FC == pytest.approx(welded.humanoid.p_FC)


REFUSED = {
    "five joints": ({"joints": 5}, "surface", "a leg has 5 joints, a sole needs six"),
    "no width": ({"width": 0.002}, "surface", "soles are 2 mm wide"),
    "a weak roll": ({"roll_effort": 0.5}, "surface", "left_ankle_roll has 0.5 N m"),
    "points": ({}, "point", "'point' must be line or surface: on points a robot cannot stand"),
    "nonsense": ({}, "plane", "'plane' must be line or surface"),
    "feet that are points": ({"length": 0.01}, "surface", "the foot is a point"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_cannot_be_is_refused_in_a_line(tmp_path, monkeypatch, capsys, name):
    options, contact, why = REFUSED[name]
    monkeypatch.chdir(tmp_path)
    write_sole_biped(tmp_path, **options)
    line = refuse(capsys, "new-robot", "sole_biped.urdf", "--out", "out", "--contact", contact)
    assert why in line and len(line) < 300
    assert not (tmp_path / "out").exists()


def test_soles_that_differ_in_width_are_refused(tmp_path):
    tree = made_up.read(write_sole_biped(tmp_path))
    next(tree.iter("box")).set("size", "0.17 0.05 0.02")
    with pytest.raises(ModelError, match="feet differ in width"):
        analyse(made_up.write(tree, tmp_path, "unequal"))


def described(folder, work):
    """Load the description of a biped with soles, changed."""
    out = folder / "biped"
    write_folder(out, analyse(write_sole_biped(folder)))
    file = out / "sole_biped.yaml"
    data = yaml.safe_load(file.read_text())
    work(data)
    file.write_text(yaml.safe_dump(data))
    return load_humanoid(file)


def test_a_sole_that_is_wider_than_the_foot_is_refused(tmp_path):
    def wider(data):
        for foot in data["feet"]:
            foot["contact_width"] = 0.12

    with pytest.raises(ModelError, match=r"feet\[0\].contact_width = .*edge is 0.030 m off them"):
        described(tmp_path, wider)


def test_a_sole_that_stands_on_its_edge_is_refused(tmp_path):
    def tilted(data):
        data["nominal_posture"].update(left_ankle_roll=0.05, right_ankle_roll=-0.05)

    with pytest.raises(ModelError, match=r"soles must be flat: left is off by .* in roll"):
        described(tmp_path, tilted)


# --- the rectangle in a sole ----------------------------------------------------------------------


def size_of(points):
    low, high = inscribed(np.array(points, dtype=float))
    return high - low


def test_rectangles_in_shapes_with_known_ones():
    np.testing.assert_allclose(size_of([[0, 0], [4, 0], [4, 1], [0, 1]]), [4.0, 1.0])
    np.testing.assert_allclose(size_of([[0, -1], [4, -2], [4, 2], [0, 1]]), [4.0, 2.0])
    angle = np.linspace(0.0, 2.0 * np.pi, 400, endpoint=False)
    circle = np.column_stack([np.cos(angle), np.sin(angle)])
    np.testing.assert_allclose(size_of(circle), [np.sqrt(2.0)] * 2, rtol=0.02)
    np.testing.assert_allclose(size_of(circle * [3.0, 0.5]), [3 * 2**0.5, 0.5 * 2**0.5], rtol=0.02)
    np.testing.assert_allclose(size_of([[0, 1], [2, 1], [1, 1]]), [2.0, 0.0])
    np.testing.assert_allclose(size_of([[0, 1], [2, 1]]), [2.0, 0.0])
    low, high = inscribed(np.array([[0.0, 1.0], [2.0, 1.0]]))
    assert low[1] == high[1] == 1.0


@given(
    st.lists(
        st.tuples(st.floats(-1.0, 1.0), st.floats(-0.4, 0.4)), min_size=4, max_size=12, unique=True
    ),
    st.integers(0, 2**31),
)
@settings(deadline=None)
def test_the_rectangle_is_inside_and_none_that_is_tried_is_larger(points, seed):
    points = np.array(points)
    hull = None
    if np.linalg.svd(points - points.mean(axis=0), compute_uv=False)[1] > 0.1:
        hull = ConvexHull(points)
    if hull is None:
        return
    low, high = inscribed(points)
    inside = hull.equations[:, :2], hull.equations[:, 2]
    corners = np.array([[x, y] for x in (low[0], high[0]) for y in (low[1], high[1])])
    assert (inside[0] @ corners.T + inside[1][:, None]).max() < 1e-9
    random, within = np.random.default_rng(seed), Delaunay(points)
    ends = np.sort(random.uniform(points.min(axis=0), points.max(axis=0), (4000, 2, 2)), axis=1)
    tried = [[ends[:, i, 0], ends[:, j, 1]] for i in range(2) for j in range(2)]
    fits = np.all([within.find_simplex(np.array(p).T) >= 0 for p in tried], axis=0)
    areas = np.prod(ends[:, 1] - ends[:, 0], axis=1)[fits]
    assert areas.max(initial=0.0) < 1.03 * np.prod(high - low) + 1e-3


def test_a_sole_of_four_balls_has_the_rectangle_between_them(tmp_path):
    """As G1's: narrower at the heel."""
    tree = made_up.read(write_sole_biped(tmp_path))
    for side in SIDES:
        foot = made_up.named(tree, "link", f"{side}_ankle_roll_link")
        for collision in foot.findall("collision"):
            foot.remove(collision)
        for x, y in ((-0.05, 0.025), (-0.05, -0.025), (0.12, 0.03), (0.12, -0.03)):
            foot.append(made_up.ball((x, y, -0.03), 0.005))
    found = analyse(made_up.write(tree, tmp_path, "balls"))
    h = found.humanoid
    assert (2 * h.half_length, 2 * h.half_width) == pytest.approx((0.17, 0.05), abs=1e-5)
    assert "soles, from collision shapes: 0.170 m long, 0.060 m wide" in "\n".join(found.lines)
