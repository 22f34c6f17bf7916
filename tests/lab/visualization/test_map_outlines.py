"""Outlines of known ground: what of it is drawn, where, and how high."""

import numpy as np
import pytest
from pydrake.geometry import Meshcat, MeshcatParams

from drake_linefoot.gait.patches import edges_of, outside
from drake_linefoot.lab.plants.scene import ground_of
from drake_linefoot.lab.scenario import Scenario
from drake_linefoot.lab.scenario.load import make_scenario
from drake_linefoot.lab.visualization.map_outlines import corners_within, outlines_of
from drake_linefoot.lab.visualization.overlays import legend_of
from drake_linefoot.lab.visualization.stage import Stage
from drake_linefoot.robot.humanoid import load_humanoid
from drake_linefoot.robot.scaling import scaled

HUMANOID = load_humanoid("mit_humanoid")
NOWHERE = np.full((2, 4), np.nan)
KNOWN = {"ground": {"stairs": {"at": 0.6, "steps": 9}}, "terrain": {"source": "scene"}}


class Watched(Stage):
    """A stage that tells what is on it."""

    def __init__(self, meshcat):
        super().__init__(meshcat, "/overlays", 1.0)
        self.lines, self.seen, self.moved = {}, {}, {}

    def add_line(self, name, corners, colour):
        super().add_line(name, corners, colour)
        self.lines[name] = corners

    def show(self, name, visible):
        super().show(name, visible)
        self.seen[name] = visible

    def move(self, name, pose):
        super().move(name, pose)
        self.moved[name] = pose.translation()


@pytest.fixture(scope="module")
def meshcat():
    return Meshcat(MeshcatParams(port=0))


def drawn(meshcat, *samples, **changes):
    scenario = make_scenario({**KNOWN, **changes})
    scenario = scaled(scenario, HUMANOID)
    outlines, stage = outlines_of(scenario, HUMANOID, ground_of(scenario)), Watched(meshcat)
    stage.clear(0.0)
    outlines.start(stage)
    for x, footholds in samples:
        q = HUMANOID.q_nominal.copy()
        q[4] = x
        outlines.draw(stage, {"time": stage.time, "q": q, "foothold": footholds})
        stage.time += 0.1
    return stage


def shown(stage, kind):
    return {name for name, seen in stage.seen.items() if seen and name.startswith(kind)}


def test_patches_in_range_are_drawn_where_they_are(meshcat):
    stage = drawn(meshcat, (0.0, NOWHERE), terrain={"source": "scene", "range": 1.0})
    assert shown(stage, "known") == {f"known ground/{k}" for k in (0, 1, 2)}
    assert meshcat.HasPath("/overlays/known ground/2")
    tread = stage.lines["known ground/2"]
    assert np.ptp(tread[:, 0]) == pytest.approx(0.28)
    np.testing.assert_allclose(tread[:, 2], 0.24 + 0.005, atol=1e-9)


def test_what_is_left_behind_is_hidden_and_comes_again(meshcat):
    near = {"source": "scene", "range": 0.5}
    samples = [(0.0, NOWHERE), (2.5, NOWHERE), (0.0, NOWHERE)]
    for k, expected in enumerate([True, False, True]):
        stage = drawn(meshcat, *samples[: k + 1], terrain=near)
        assert ("known ground/0" in shown(stage, "known")) is expected


def test_a_foot_in_its_room_is_whole_on_the_patch(meshcat):
    landing = NOWHERE.copy()
    landing[0] = 0.74, 0.0, 0.12, 0.21
    stage = drawn(meshcat, (0.3, landing))
    corners = stage.lines["room for a foot/1 at 2"][:, :2]
    edges_of(stage.lines["known ground/1"][:, :2], 4, edges := np.empty((4, 3)))
    way = HUMANOID.half_length * np.array([np.cos(0.2), np.sin(0.2)])
    away = [outside(edges, corner + s * way) for corner in corners for s in (-1, 1)]
    assert max(away) == pytest.approx(-0.015, abs=1e-9)  # gait.edge_margin


def test_outlines_are_as_high_as_the_controller_has_the_ground(meshcat):
    landing = NOWHERE.copy()
    landing[1] = 0.74, 0.0, 0.12 + 0.013, 0.0
    stage = drawn(meshcat, (0.3, landing))
    for root in ("known ground", "room for a foot"):
        np.testing.assert_allclose(stage.moved[root], [0.0, 0.0, 0.013], atol=1e-9)


def test_a_room_that_is_none_is_not_drawn(meshcat):
    narrow = {"stairs": {"at": 0.6, "tread": [0.1, 0.1]}}
    stage = drawn(meshcat, (0.3, NOWHERE), ground=narrow)
    assert "room for a foot/1 at 0" not in stage.lines
    assert "known ground/1" in stage.lines


def test_of_what_is_only_felt_there_is_nothing():
    felt, told = Scenario(), make_scenario(KNOWN)
    assert outlines_of(felt, HUMANOID, ground_of(felt)) is None
    more = [name for name, _ in legend_of(told)[len(legend_of(felt)) :]]
    assert more == ["known ground", "room for a foot"]


def test_corners_are_those_of_what_is_inside_edges():
    corners = np.array([[0.0, 0.0], [2.0, 0.0], [2.5, 1.0], [1.0, 2.0], [-0.5, 1.0]])
    edges_of(corners, 5, edges := np.empty((5, 3)))
    found = corners_within(edges)
    np.testing.assert_allclose(found, corners, atol=1e-12)
    edges[:, 2] -= 2.0
    assert len(corners_within(edges)) == 0
