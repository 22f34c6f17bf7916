import numpy as np
import pytest
from pydrake.geometry import Meshcat, MeshcatParams

from drake_linefoot.visualization.overlays import OverlayPainter
from drake_linefoot.visualization.view import LINE_REACH, LINE_SPACING, _ground_lines

LENGTH = 0.15
COM = np.array([0.0, 0.0, 0.6])
FEET = np.array([[[-0.05, 0.1, 0], [0.1, 0.1, 0]], [[-0.05, -0.1, 0], [0.1, -0.1, 0]]])
BOTH = np.array([1.0, 1.0])
NOTHING = np.empty((0, 4))


@pytest.fixture(scope="module")
def meshcat():
    return Meshcat(MeshcatParams(port=0))


@pytest.fixture
def painter(meshcat):
    meshcat.Delete("/overlays")
    return OverlayPainter(meshcat, LENGTH)


def translation(meshcat, path):
    """Return the position at which an object is drawn (from MessagePack: 16 doubles)."""
    packed = meshcat._GetPackedTransform(path)
    at = packed.index(b"\xdc\x00\x10") + 3
    numbers = np.frombuffer(packed[at : at + 16 * 9], dtype=[("tag", "u1"), ("value", ">f8")])
    return numbers["value"].reshape(4, 4)[3, :3]


def is_visible(meshcat, path):
    return meshcat._GetPackedProperty(path, "visible").endswith(b"\xc3")


def test_each_touchdown_leaves_a_foothold(meshcat, painter):
    painter.draw(0.0, COM, FEET, BOTH, NOTHING)
    assert meshcat.HasPath("/overlays/footholds/left/0")
    assert meshcat.HasPath("/overlays/footholds/right/0")
    painter.draw(0.1, COM, FEET, np.array([1.0, 0.0]), NOTHING)
    assert not meshcat.HasPath("/overlays/footholds/right/1")
    painter.draw(0.2, COM, FEET, BOTH, NOTHING)
    assert meshcat.HasPath("/overlays/footholds/right/1")
    assert not meshcat.HasPath("/overlays/footholds/left/1")


def test_going_back_in_time_starts_afresh(meshcat, painter):
    painter.draw(0.0, COM, FEET, BOTH, NOTHING)
    painter.draw(0.1, COM, FEET, np.zeros(2), NOTHING)
    painter.draw(0.2, COM, FEET, BOTH, NOTHING)
    painter.draw(0.0, COM, FEET, BOTH, NOTHING)
    assert meshcat.HasPath("/overlays/footholds/left/0")
    assert not meshcat.HasPath("/overlays/footholds/left/1")


def test_feet_of_an_unknown_controller_leave_none(meshcat, painter):
    painter.draw(0.0, COM, FEET, np.full(2, np.nan), NOTHING)
    assert not meshcat.HasPath("/overlays/footholds")
    assert meshcat.HasPath("/overlays/com/now")


def test_a_trail_grows_only_when_the_robot_moves(meshcat, painter):
    for i in range(10):
        painter.draw(0.125 * i, COM, FEET, BOTH, NOTHING)
    assert not meshcat.HasPath("/overlays/com/trail")
    for i in range(10, 13):
        painter.draw(0.125 * i, np.array([0.05 * i, 0.0, 0.6]), FEET, BOTH, NOTHING)
    assert meshcat.HasPath("/overlays/com/trail/2")
    assert not meshcat.HasPath("/overlays/com/trail/3")


def test_any_number_of_planned_footholds(meshcat, painter):
    planned = np.array([[0.1 * k, 0.1, 0.0, 0.2] for k in range(5)])
    for n in range(6):
        painter.draw(0.1 * n, COM, FEET, BOTH, planned[:n])
    planned[1:] = np.nan
    painter.draw(1.0, COM, FEET, BOTH, planned)
    assert not meshcat.HasPath("/overlays/planned/3")
    assert [is_visible(meshcat, f"/overlays/planned/{k}") for k in range(3)] == [True, False, False]
    np.testing.assert_allclose(translation(meshcat, "/overlays/planned/0"), [0.0, 0.1, 0.002])


def test_things_are_drawn_where_they_are(meshcat, painter):
    painter.draw(0.0, np.array([0.3, 0.2, 0.6]), FEET, BOTH, NOTHING)
    place = "/overlays/footholds"
    np.testing.assert_allclose(translation(meshcat, f"{place}/left/0"), [0.025, 0.1, 0.002])
    np.testing.assert_allclose(translation(meshcat, f"{place}/right/0"), [0.025, -0.1, 0.002])
    np.testing.assert_allclose(translation(meshcat, "/overlays/com/now"), [0.3, 0.2, 0.6])
    np.testing.assert_allclose(translation(meshcat, "/overlays/com/on_ground"), [0.3, 0.2, 0.004])


def test_lines_on_the_ground_are_short_and_lie_along_the_axes():
    begin, end = _ground_lines()
    step = np.abs(end - begin)
    np.testing.assert_allclose(step.sum(axis=0), LINE_SPACING)
    np.testing.assert_allclose(step.max(axis=0), LINE_SPACING)
    assert np.abs(np.hstack([begin, end])[:2]).max() == pytest.approx(LINE_REACH)
