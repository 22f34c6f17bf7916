"""Room on patches of ground, against points of feet and of patches that are tried one by one."""

import numpy as np
from hypothesis import assume, given
from hypothesis import strategies as st

from drake_linefoot.gait.patches import (
    chord,
    clear_of_risers,
    edges_of,
    moved_inside,
    outside,
    rises_beyond,
    room,
    seen_from,
    span,
)

numbers = st.floats(-1.0, 1.0)
yaws = st.floats(-7.0, 7.0)
places = st.tuples(numbers, numbers).map(np.array)


@st.composite
def patches(draw):
    """Corners on an ellipse anywhere, counter-clockwise: a convex polygon."""
    n = draw(st.integers(3, 8))
    early = np.array([draw(st.floats(0.0, 0.6)) for _ in range(n)])
    at = 2.0 * np.pi / n * (np.arange(n) + early)
    long, short = draw(st.floats(0.2, 1.0)), draw(st.floats(0.2, 1.0))
    ellipse = np.stack([long * np.cos(at), short * np.sin(at)], axis=1)
    c, s = np.cos(0.4), np.sin(0.4)
    return draw(places) + ellipse @ np.array([[c, s], [-s, c]])


def edges(corners):
    out = np.empty((len(corners), 3))
    edges_of(corners, len(corners), out)
    return out


def is_inside(corners, points):
    """Whether points are to the left of every side."""
    to = np.roll(corners, -1, axis=0) - corners
    away = points[:, None] - corners
    return np.all(to[:, 0] * away[..., 1] - to[:, 1] * away[..., 0] >= 0.0, axis=1)


def foot(place, yaw, size):
    """Points all over a foot."""
    along, across = np.meshgrid(np.linspace(-1, 1, 9) * size[0], np.linspace(-1, 1, 5) * size[1])
    c, s = np.cos(yaw), np.sin(yaw)
    points = np.stack([c * along - s * across, s * along + c * across], axis=-1)
    return place + points.reshape(-1, 2)


@given(patches(), places, yaws, st.floats(0.0, 0.1), st.floats(0.0, 0.05))
def test_a_foot_has_room_where_all_of_it_is_on_the_patch(corners, place, yaw, X, Y):
    inner = outside(room(edges(corners), yaw, (X, Y), 0.0), place)
    assume(abs(inner) > 1e-9)
    assert np.all(is_inside(corners, foot(place, yaw, (X, Y)))) == (inner < 0.0)


@given(patches(), places, st.floats(0.0, 0.1))
def test_a_margin_is_a_distance_from_the_sides(corners, place, margin):
    found = outside(room(edges(corners), 0.3, (0.0, 0.0), margin), place)
    around = np.linspace(0.0, 2.0 * np.pi, 721)
    circle = place + max(margin - 1e-3, 0.0) * np.stack([np.cos(around), np.sin(around)], axis=1)
    if found < 0.0:
        assert np.all(is_inside(corners, circle))


@given(patches())
def test_chord_and_span_are_those_of_points_inside(corners):
    sides, grid = edges(corners), np.linspace(-2.5, 2.5, 501)
    least, most = span(sides, 1)
    assert least == np.float64(corners[:, 1].min()) or abs(least - corners[:, 1].min()) < 1e-9
    assert abs(most - corners[:, 1].max()) < 1e-9
    for across in np.linspace(least - 0.1, most + 0.1, 7):
        inside = grid[is_inside(corners, np.stack([grid, np.full_like(grid, across)], axis=1))]
        first, last = chord(sides, across)
        if len(inside):
            assert first - 1e-9 <= inside[0] < first + 0.0101
            assert last - 0.0101 < inside[-1] <= last + 1e-9
        else:
            assert last - first < 0.0101


@given(patches(), places)
def test_what_is_moved_inside_is_inside_and_hardly_farther_than_need_be(corners, place):
    there, found = moved_inside(edges(corners), place)
    assert found
    assert outside(edges(corners), there) < 1e-3
    share = np.linspace(0.0, 1.0, 400)[:, None]
    sides = [
        a + share * (b - a) for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True)
    ]
    nearest = np.linalg.norm(np.vstack(sides) - place, axis=1).min()
    if outside(edges(corners), place) <= 0.0:
        np.testing.assert_array_equal(there, place)
    else:
        assert np.linalg.norm(there - place) < 1.5 * nearest + 0.01


@given(patches(), places, places, yaws, st.sampled_from([1.0, -1.0]))
def test_edges_seen_from_a_foot_hold_the_same_places(corners, stance, place, yaw, outward):
    away, (c, s) = place - stance, (np.cos(yaw), np.sin(yaw))
    seen = np.array([c * away[0] + s * away[1], outward * (c * away[1] - s * away[0])])
    sides = edges(corners)
    found = outside(seen_from(sides, stance, yaw, outward), seen)
    assert abs(found - outside(sides, place)) < 1e-9


def test_a_patch_without_edges_has_room_everywhere():
    nothing, place = np.empty((0, 3)), np.array([3.0, -2.0])
    assert chord(nothing, 1.0) == (-np.inf, np.inf)
    assert span(nothing, 1) == (-np.inf, np.inf)
    there, found = moved_inside(nothing, place)
    assert found
    np.testing.assert_array_equal(there, place)


# Its edges: right, ahead, left, behind.
SQUARE = np.array([[-0.2, -0.2], [0.2, -0.2], [0.2, 0.2], [-0.2, 0.2]])


def squares(*placed):
    """Squares at places, each with a plane: sides, edges, corners and planes."""
    corners = np.array([SQUARE + place for place, _ in placed])
    planes = np.array([plane for _, plane in placed], dtype=float)
    return np.full(len(placed), 4.0), np.array([edges(c) for c in corners]), corners, planes


@given(st.floats(-0.2, 0.2), st.floats(-0.2, 0.2), st.floats(-0.3, 0.3))
def test_risers_are_the_differences_of_the_planes_beyond_the_edges(ahead, left, slope):
    sides, E, corners, planes = squares(
        ([0.0, 0.0], [0.0, slope, 0.0]),
        ([0.4, 0.0], [ahead, slope, 0.0]),
        ([0.0, 0.4], [left, slope, 0.0]),
        ([-0.8, 0.0], [1.0, 0.0, 0.0]),  # there is a gap before it
    )
    found = rises_beyond(0, sides, E, corners[0], planes)
    expected = [0.0, max(ahead, 0.0), max(left, 0.0), 0.0]
    np.testing.assert_allclose(found, expected, atol=1e-12)
    of_that_ahead = rises_beyond(1, sides, E, corners[1], planes)
    np.testing.assert_allclose(of_that_ahead, [0.0, 0.0, 0.0, max(-ahead, 0.0)], atol=1e-12)


@given(st.floats(0.04, 0.3), st.floats(0.0, 1.0), yaws)
def test_a_shank_that_leans_at_the_edge_of_its_room_is_clear_of_the_riser(rise, lean, yaw):
    """Its axis up to the riser's edge is no nearer than the radius, along the foot."""
    toe, height, radius, X = 0.1, 0.04, 0.02, 0.075
    outer, rises = edges(SQUARE), np.array([0.0, rise, 0.0, 0.0])
    clear = clear_of_risers(outer, rises, yaw, (toe, height, radius, lean), 0.0)
    inner, ahead = room(clear, yaw, (X, 0.0), 0.0), np.array([np.cos(yaw), np.sin(yaw)])
    same = room(outer, yaw, (X, 0.0), 0.0)
    np.testing.assert_array_equal(inner[rises == 0.0], same[rises == 0.0])
    n, faces = outer[1, :2], outer[1, :2] @ ahead
    if faces <= 0.0:
        np.testing.assert_array_equal(inner, same)
        return
    place = inner[1, 2] * n  # of the middle of the foot
    up = np.linspace(0.0, rise - height, 50)
    axis = place + ((X - toe) + up * np.tan(lean))[:, None] * ahead
    assert np.all(outer[1, 2] - axis @ n >= faces * radius / np.cos(lean) - 1e-9)
