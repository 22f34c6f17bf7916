import numpy as np
import pytest
from pydrake.geometry import Meshcat, MeshcatParams
from scipy.spatial import ConvexHull

from drake_linefoot.axes import CORNERS, ENDS
from drake_linefoot.lab.plants.ground import Ground
from drake_linefoot.lab.scenario import Scenario
from drake_linefoot.lab.scenario.scene import Scene
from drake_linefoot.lab.simulation.recording import CHANNELS
from drake_linefoot.lab.visualization.overlays import (
    NEWTONS_PER_METER,
    PUSH_NEWTONS_PER_METER,
    OverlayPainter,
)
from drake_linefoot.lab.visualization.view import (
    LINE_HEIGHT,
    LINE_SPACING,
    LINES_AHEAD,
    MOVED,
    _ground_lines,
    _lines_on,
)
from drake_linefoot.lab.wiring.closed_loop import build_closed_loop
from drake_linefoot.robot.humanoid import load_humanoid
from drake_linefoot.robot.scaling import units_of
from tests.helpers.recorded_runs import SIZES, short_run
from tests.helpers.similar import LENGTH as QUARTER
from tests.helpers.similar import similar_robot, similar_run
from tests.helpers.walk_on_soles import robot_on_soles, walk_on_soles

COM = np.array([0.0, 0.0, 0.6])
FEET = np.array([[[-0.05, 0.1, 0], [0.1, 0.1, 0]], [[-0.05, -0.1, 0], [0.1, -0.1, 0]]])
BOTH, LEFT, NONE = np.array([[1.0, 1.0], [1.0, 0.0], [0.0, 0.0]])
HUMANOID = load_humanoid("mit_humanoid")
LENGTH = 2.0 * HUMANOID.half_length


def sample_at(time, **changes):
    """Return a sample of the nominal posture at rest, of which little more is known."""
    known = {
        "q": HUMANOID.q_nominal,
        "v": np.zeros(HUMANOID.nv),
        "com": COM,
        "contact_points": FEET,
    }
    nothing = {name: np.full(channel.shape(SIZES), np.nan) for name, channel in CHANNELS.items()}
    return nothing | known | {"time": time, "planned_contact": BOTH} | changes


@pytest.fixture(scope="module")
def meshcat():
    return Meshcat(MeshcatParams(port=0))


@pytest.fixture
def draw(meshcat):
    meshcat.Delete("/overlays")
    painter = OverlayPainter(HUMANOID, meshcat, 0.6)
    return lambda time, **changes: painter.draw(sample_at(time, **changes))


def translation(meshcat, path):
    """Return the position at which an object is drawn."""
    return pose(meshcat, path)[3, :3]


def pose(meshcat, path):
    """Return the axes and the position of an object as rows (from MessagePack: 16 doubles)."""
    path = path if path.startswith("/") else f"/overlays/{path}"
    packed = meshcat._GetPackedTransform(path)
    at = packed.index(b"\xdc\x00\x10") + 3
    numbers = np.frombuffer(packed[at : at + 16 * 9], dtype=[("tag", "u1"), ("value", ">f8")])
    return numbers["value"].reshape(4, 4)


def numbers(meshcat, path, name):
    """Return a property of three numbers (from MessagePack: three doubles at its end)."""
    packed = meshcat._GetPackedProperty(f"/overlays/{path}", name)
    return np.frombuffer(packed[-27:], dtype=[("tag", "u1"), ("value", ">f8")])["value"]


def arrow(meshcat, path):
    """Return the force that an arrow shows [N]; zero when it is hidden."""
    if not is_visible(meshcat, path):
        return np.zeros(3)
    length = numbers(meshcat, f"{path}/shaft", "scale")[2]
    return NEWTONS_PER_METER * length * pose(meshcat, path)[2, :3]


def is_visible(meshcat, path):
    return meshcat._GetPackedProperty(f"/overlays/{path}", "visible").endswith(b"\xc3")


def test_each_touchdown_leaves_a_foothold(meshcat, draw):
    draw(0.0)
    assert meshcat.HasPath("/overlays/footholds/left/0")
    assert meshcat.HasPath("/overlays/footholds/right/0")
    draw(0.1, planned_contact=LEFT)
    assert not meshcat.HasPath("/overlays/footholds/right/1")
    draw(0.2)
    assert meshcat.HasPath("/overlays/footholds/right/1")
    assert not meshcat.HasPath("/overlays/footholds/left/1")


def test_going_back_in_time_starts_afresh(meshcat, draw):
    draw(0.0)
    draw(0.1, planned_contact=NONE)
    draw(0.2)
    draw(0.0)
    assert meshcat.HasPath("/overlays/footholds/left/0")
    assert not meshcat.HasPath("/overlays/footholds/left/1")


def test_what_is_not_known_is_not_drawn(meshcat, draw):
    draw(0.0, planned_contact=np.full(2, np.nan))
    assert not meshcat.HasPath("/overlays/footholds")
    assert is_visible(meshcat, "centre of mass/now")
    for path in (
        "predicted centre of mass/0",
        "planned footholds/0/line",
        "support/0",
        "friction cone/left",
        "true contact force/left heel",
        "estimated contact force/right toe",
        "swing path/left/0",
    ):
        assert not is_visible(meshcat, path), path


def test_a_trail_grows_only_when_the_robot_moves(meshcat, draw):
    for i in range(10):
        draw(0.125 * i)
    assert not meshcat.HasPath("/overlays/centre of mass/trail")
    for i in range(10, 13):
        draw(0.125 * i, com=np.array([0.05 * i, 0.0, 0.6]))
    assert meshcat.HasPath("/overlays/centre of mass/trail/2")
    assert not meshcat.HasPath("/overlays/centre of mass/trail/3")


def test_any_number_of_planned_footholds(meshcat, draw):
    planned = np.array([[0.1 * k, 0.1, 0.0, 0.2] for k in range(5)])
    for n in range(6):
        draw(0.1 * n, mpc_footholds=planned[:n])
    planned[1:] = np.nan
    draw(1.0, mpc_footholds=planned)
    assert not meshcat.HasPath("/overlays/planned footholds/3")
    shown = [is_visible(meshcat, f"planned footholds/{k}/line") for k in range(3)]
    assert shown == [True, False, False]
    np.testing.assert_allclose(translation(meshcat, "planned footholds/0/line"), [0.0, 0.1, 0.002])
    toe = [0.5 * LENGTH * np.cos(0.2), 0.1 + 0.5 * LENGTH * np.sin(0.2), 0.002]
    np.testing.assert_allclose(translation(meshcat, "planned footholds/0/toe"), toe)


def test_things_are_drawn_where_they_are(meshcat, draw):
    predicted = np.arange(24.0).reshape(8, 3)
    draw(0.0, com=np.array([0.3, 0.2, 0.6]), mpc_horizon=predicted)
    for path, place in {
        "footholds/left/0": [0.025, 0.1, 0.002],
        "footholds/right/0": [0.025, -0.1, 0.002],
        "centre of mass/now": [0.3, 0.2, 0.6],
        "centre of mass/on ground": [0.3, 0.2, 0.004],
        "capture point/point": [0.3, 0.2, 0.0],  # at rest
        "predicted centre of mass/7": [21.0, 22.0, 23.0],
        "friction cone/left": [0.025, 0.1, 0.0],
    }.items():
        np.testing.assert_allclose(translation(meshcat, path), place, err_msg=path)


def test_the_robot_is_kept_in_view(meshcat, draw):
    draw(0.0, com=np.array([3.0, -2.0, 0.6]))
    for path in MOVED:
        np.testing.assert_allclose(translation(meshcat, path), [-3.0, 2.0, 0.0])


def test_a_force_is_an_arrow_of_its_size_and_a_small_one_is_none(meshcat, draw):
    force = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 61.0]])
    draw(0.0, true_force=force, true_normal=np.array([[0.0, 0.0], [60.0, 1.0]]))
    np.testing.assert_allclose(translation(meshcat, "true contact force/right heel"), FEET[1, 0])
    assert is_visible(meshcat, "true contact force/right heel")
    length = 60.0 / NEWTONS_PER_METER
    scale = numbers(meshcat, "true contact force/right heel/shaft", "scale")
    np.testing.assert_allclose(scale, [1.0, 1.0, length])
    head = numbers(meshcat, "true contact force/right heel/head", "position")
    np.testing.assert_allclose(head, [0.0, 0.0, length])
    assert not is_visible(meshcat, "true contact force/right toe")
    assert not is_visible(meshcat, "true contact force/left heel")


def test_a_push_is_an_arrow_from_the_torso(meshcat, draw):
    draw(0.0)
    assert not is_visible(meshcat, "push/force")
    draw(0.1, push=np.array([0.0, 100.0, 0.0]))
    assert is_visible(meshcat, "push/force")
    torso = HUMANOID.q_nominal[4:7] + HUMANOID.base.default_com()  # upright
    np.testing.assert_allclose(translation(meshcat, "push/force"), torso)
    scale = numbers(meshcat, "push/force/shaft", "scale")
    np.testing.assert_allclose(scale, [1.0, 1.0, 100.0 / PUSH_NEWTONS_PER_METER])
    draw(0.2, push=np.zeros(3))
    assert not is_visible(meshcat, "push/force")


def test_the_support_is_a_line_on_one_foot_and_a_polygon_on_two(meshcat, draw):
    for time, standing, shown in (
        (0.0, BOTH, [True, True, True, True]),
        (0.1, LEFT, [True, False, False, False]),
        (0.2, NONE, [False, False, False, False]),
    ):
        draw(time, planned_contact=standing)
        assert [is_visible(meshcat, f"support/{edge}") for edge in range(4)] == shown
        assert is_visible(meshcat, "friction cone/right") == bool(standing[1])


def test_friction_cones_are_narrower_where_feet_have_slid(meshcat, draw):
    for time, known, share in ((0.0, np.nan, 1.0), (0.1, 1.0, 1.0), (0.2, 0.3, 0.5)):
        draw(time, reference_friction=known)
        scale = numbers(meshcat, "friction cone/left", "scale")
        np.testing.assert_allclose(scale, [share, share, 1.0])


def right_at(*place):
    """The right foot swings at a place, the left one stands."""
    return np.array([np.full(3, np.nan), place])


def test_the_path_of_a_swing_stays_until_the_next_of_that_foot(meshcat, draw):
    draw(0.0)
    for i in range(3):
        draw(0.1 + 0.03 * i, planned_contact=LEFT, swing_position=right_at(0.1 * i, -0.1, 0.05))
    draw(0.3)
    shown = [is_visible(meshcat, f"swing path/right/{k}") for k in range(10)]
    assert shown == [True] * 3 + [False] * 7
    draw(0.4, planned_contact=LEFT, swing_position=right_at(0.5, -0.1, 0.01))
    shown = [is_visible(meshcat, f"swing path/right/{k}") for k in range(10)]
    assert shown == [True] + [False] * 9
    assert not is_visible(meshcat, "swing path/left/0")


def test_the_capture_point_is_ahead_of_a_moving_robot(meshcat, draw):
    velocity = np.zeros(HUMANOID.nv)
    velocity[3] = 0.5  # m/s forward
    draw(0.0, v=velocity)
    ahead = translation(meshcat, "capture point/point")
    np.testing.assert_allclose(ahead, [0.5 * np.sqrt(0.6 / 9.81), 0.0, 0.0], atol=1e-9)


def test_the_capture_point_of_a_robot_in_flight_is_on_the_ground(meshcat, draw):
    velocity = np.zeros(HUMANOID.nv)
    velocity[3] = 2.0  # m/s forward
    flying = {"planned_contact": NONE, "contact_points": FEET + np.array([0.0, 0.0, 0.05])}
    draw(0.0, v=velocity, **flying)
    point = translation(meshcat, "capture point/point")
    np.testing.assert_allclose(point, [2.0 * np.sqrt(0.6 / 9.81), 0.0, 0.0], atol=1e-9)


def test_what_a_loop_does_is_drawn_while_it_does_it(meshcat):
    meshcat.Delete("/overlays")
    simulator = build_closed_loop(Scenario(), meshcat).make_simulator()
    simulator.AdvanceTo(0.1)
    for path in ("true contact force/left heel", "estimated contact force/right toe"):
        assert is_visible(meshcat, path)
    assert translation(meshcat, "predicted centre of mass/0")[2] == pytest.approx(0.6, abs=0.1)


def test_a_log_has_all_that_is_drawn_live(meshcat):
    meshcat.Delete("/overlays")
    run = short_run()
    i = int(np.argmin(np.abs(run.time - 0.3)))
    OverlayPainter(HUMANOID, meshcat, 0.6).draw(run.sample(i))
    np.testing.assert_allclose(translation(meshcat, "centre of mass/now"), run.com[i], atol=1e-9)
    for kind, force in (
        ("true", run.true_force[i]),
        ("estimated", run.contact_wrench[i, :, :3]),
    ):
        for side, foot in enumerate(("left", "right")):
            arrows = [arrow(meshcat, f"{kind} contact force/{foot} {e}") for e in ("heel", "toe")]
            np.testing.assert_allclose(sum(arrows), force[side], atol=1e-6)
            if kind == "true":
                normal = [up for *_, up in arrows]
                np.testing.assert_allclose(normal, run.true_normal[i, side], atol=1e-6)
    begin = translation(meshcat, "predicted centre of mass/0")
    assert np.linalg.norm(begin - run.com[i]) < 0.05  # the plan began here


def test_a_similar_robot_is_drawn_alike(meshcat, tmp_path):
    """Arrows and places are a quarter as large; a force of 3 N is large to it."""
    file, run = similar_robot(tmp_path), short_run()
    small, i = load_humanoid(file), int(np.argmin(np.abs(run.time - 0.3)))
    names = [f"{kind} contact force/left {end}" for kind in ("true", "estimated") for end in ENDS]
    seen = []
    for humanoid, drawn in ((HUMANOID, run), (small, similar_run(run, file))):
        meshcat.Delete("/overlays")
        OverlayPainter(humanoid, meshcat, 0.6).draw(drawn.sample(i))
        assert all(is_visible(meshcat, name) for name in names)
        lengths = [numbers(meshcat, f"{name}/shaft", "scale")[2] for name in names]
        places = ("footholds/left/0", "centre of mass/on ground", "capture point/point")
        seen.append(np.append(lengths, [translation(meshcat, place) for place in places]))
    np.testing.assert_allclose(seen[1], QUARTER * seen[0], atol=1e-6)


def test_a_robot_on_soles_is_drawn_with_its_corners(meshcat):
    """Arrows add up, the support is the hull of both soles, dots are where the feet press."""
    meshcat.Delete("/overlays")
    (robot, _), run = robot_on_soles(), walk_on_soles()
    i = int(np.flatnonzero(run.time > 0.75)[0])  # it stands
    OverlayPainter(robot, meshcat, 0.6).draw(run.sample(i))
    m, N = units_of(robot)["m"], units_of(robot)["N"]
    for side, foot in enumerate(("left", "right")):
        for kind, force in (("true", run.true_force), ("estimated", run.contact_wrench)):
            arrows = [arrow(meshcat, f"{kind} contact force/{foot} {c}") for c in CORNERS]
            total = N / m * np.sum(arrows, axis=0)
            np.testing.assert_allclose(total, force[i, side, :3], atol=1e-6)
        pressed = run.true_normal[i, side] @ run.contact_points[i, side]
        pressed /= run.true_normal[i, side].sum()
        drawn = translation(meshcat, f"centre of pressure/{foot}")
        np.testing.assert_allclose(drawn, pressed, atol=1e-9)
    points = run.contact_points[i].reshape(-1, 3)
    hull = ConvexHull(points[:, :2])
    assert [is_visible(meshcat, f"support/{k}") for k in range(8)] == [
        k < len(hull.vertices) for k in range(8)
    ]
    edges = [numbers(meshcat, f"support/{k}", "scale")[2] for k in range(len(hull.vertices))]
    assert sum(edges) == pytest.approx(hull.area, rel=1e-3)  # of a polygon: its circumference


def test_lines_on_the_ground_are_short_and_lie_along_the_axes():
    begin, end = _ground_lines(LINE_SPACING)
    step = np.abs(end - begin)
    np.testing.assert_allclose(step.sum(axis=0), LINE_SPACING)
    np.testing.assert_allclose(step.max(axis=0), LINE_SPACING)
    assert np.abs(np.hstack([begin, end])[:2]).max() == pytest.approx(LINES_AHEAD * LINE_SPACING)


def test_on_a_slope_lines_and_view_follow_the_ground(meshcat):
    ground = Ground(Scene(slope=0.2))
    begin, end = _lines_on(ground, *_ground_lines(LINE_SPACING))
    for points in (begin, end):
        wanted = np.maximum(np.tan(0.2) * (points[0] - 0.5), 0.0)
        np.testing.assert_allclose(points[2], wanted + LINE_HEIGHT, atol=2e-4)
    painter = OverlayPainter(HUMANOID, meshcat, 0.6, ground)
    com = np.array([1.5, 0.2, 0.8])
    painter.draw(sample_at(0.0, com=com))
    height = np.tan(0.2)
    for path in MOVED:
        np.testing.assert_allclose(translation(meshcat, path), [-1.5, -0.2, -height])
    shadow = translation(meshcat, "centre of mass/on ground")
    np.testing.assert_allclose(shadow, [1.5, 0.2, height + 0.004])
    planned = np.array([[1.5, 0.0, 0.0, 0.0], [1.5, 0.0, 0.5, 0.0]])  # below ground, above it
    painter.draw(sample_at(1.0, com=com, mpc_footholds=planned))
    for path, z in (
        ("planned footholds/0/line", height + 0.002),
        ("planned footholds/1/line", 0.502),
    ):
        np.testing.assert_allclose(translation(meshcat, path), [1.5, 0.0, z], err_msg=path)
    np.testing.assert_allclose(translation(meshcat, "capture point/point"), [1.5, 0.2, height])


def test_the_estimated_robot_is_drawn_with_its_doubt_where_there_is_an_estimate(draw, meshcat):
    draw(0.0)
    path = "estimated robot/3 sigma"
    turned = np.array([np.cos(0.25), 0.0, 0.0, np.sin(0.25)])
    place = np.array([0.3, 0.1, HUMANOID.q_nominal[6]])
    sigma = np.concatenate([np.zeros(6), [0.01, 0.02, 0.03]])
    draw(0.1, estimate_pose=np.concatenate([turned, place]), estimate_sigma=sigma)
    np.testing.assert_allclose(translation(meshcat, path), place)
    np.testing.assert_allclose(numbers(meshcat, path, "scale"), 3.0 * sigma[6:])
    knee = translation(meshcat, "estimated robot/left_knee")
    q = HUMANOID.q_nominal.copy()
    q[:4], q[4:7] = turned, place
    context = HUMANOID.plant.CreateDefaultContext()
    HUMANOID.plant.SetPositions(context, q)
    parent = HUMANOID.plant.GetJointByName("left_knee").parent_body()
    wanted = HUMANOID.plant.EvalBodyPoseInWorld(context, parent).translation()
    np.testing.assert_allclose(knee, wanted, atol=1e-12)
