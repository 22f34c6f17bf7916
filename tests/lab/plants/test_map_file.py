"""Maps from files: what is read of them, what is made of a grid, and what is refused."""

import numpy as np
import pytest
import yaml

from drake_linefoot.errors import InputError
from drake_linefoot.lab.plants.ground import Ground
from drake_linefoot.lab.plants.height_grid import HeightGrid, patches_of
from drake_linefoot.lab.plants.map_file import read_map
from drake_linefoot.lab.plants.patch_ground import distances, heights
from drake_linefoot.lab.scenario.courses import GapsParameters, StairsParameters, StonesParameters
from drake_linefoot.lab.scenario.load import make_scenario
from drake_linefoot.lab.scenario.scene import Scene
from drake_linefoot.lab.wiring.closed_loop import build_closed_loop

CELL = 0.02
SQUARE = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]]
SCENES = {
    "stairs": Scene(stairs=StairsParameters(tread=[0.25, 0.3], heading=0.15)),
    "gaps": Scene(gaps=GapsParameters(heading=-0.3)),
    "stones": Scene(stones=StonesParameters(heading=0.1)),
}


def grid_of(ground, noise=0.0):
    """Heights of ground, as a sensor would have them."""
    x, y = np.arange(-1.0, 3.5, CELL), np.arange(-1.2, 1.2, CELL)
    z = ground.height(*np.meshgrid(x, y, indexing="ij"))
    z[np.isinf(z)] = np.nan
    z += noise * np.random.default_rng(0).standard_normal(z.shape)
    return HeightGrid(z, CELL, np.array([x[0], y[0]]))


@pytest.mark.parametrize("noise", [0.0, 0.002])
@pytest.mark.parametrize("name", SCENES)
def test_patches_of_a_grid_are_those_of_the_ground(name, noise):
    """Each lies on one of the ground, at its height, and reaches nearly as far."""
    ground = Ground(SCENES[name], seed=1)
    grid, true = grid_of(ground, noise), ground.patches()
    found = patches_of(grid)
    areas = np.zeros(len(true.sides))
    for k, sides in enumerate(found.sides.astype(int)):
        corners = found.corners[k, :sides]
        on = int(np.argmin(distances(true, corners).max(axis=0)))
        assert distances(true, corners)[:, on].max() <= 1e-9
        off = heights(found, corners)[:, k] - heights(true, corners)[:, on]
        assert np.abs(off).max() <= 1e-9 + 2.0 * noise
        x, y = corners.T
        areas[on] += 0.5 * np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))
        assert noise <= found.sigma[k] <= 3.0 * noise + 1e-9
    known = np.isfinite(grid.heights).sum() * CELL**2
    assert 0.94 * known < areas.sum() < known


def test_small_steps_of_a_grid_are_seen_and_walls_are_no_ground():
    x, _ = np.meshgrid(np.arange(60.0), np.arange(40.0), indexing="ij")
    step = patches_of(HeightGrid(np.where(x < 30, 0.0, 0.03), CELL, np.zeros(2)))
    np.testing.assert_allclose(np.sort(step.plane[:, 0]), [0.0, 0.03], atol=1e-9)
    assert patches_of(HeightGrid(1.5 * CELL * x, CELL, np.zeros(2))).number == 0
    ramp = patches_of(HeightGrid(np.maximum(0.0, 0.2 * CELL * (x - 30)), CELL, np.zeros(2)))
    rises = np.sort(ramp.plane[:, 1])
    np.testing.assert_allclose([rises[0], rises[-1]], [0.0, 0.2], atol=0.03)


def test_what_is_not_convex_is_cut_and_holes_stay_free():
    z = np.zeros((60, 60))
    z[20:30, 25:35] = np.nan
    z[40:, 40:] = np.nan
    found = patches_of(HeightGrid(z, CELL, np.zeros(2)))
    assert found.number > 2
    places = CELL * np.argwhere(np.isnan(z))
    assert distances(found, places).min() > 0.0
    cells = CELL * np.argwhere(np.isfinite(z))
    assert (distances(found, cells).min(axis=1) <= 1e-9).mean() > 0.85


def saved(tmp_path, name, data):
    file = tmp_path / name
    if name.endswith(".npz"):
        np.savez(file, **data)
    else:
        file.write_text(data if isinstance(data, str) else yaml.safe_dump(data))
    return file


def test_corners_are_taken_either_way_round(tmp_path):
    maps = [{"patches": [{"corners": way}]} for way in (SQUARE, SQUARE[::-1])]
    one, other = (read_map(saved(tmp_path, f"{k}.yaml", m)) for k, m in enumerate(maps))
    assert distances(one, np.zeros((1, 2))) == distances(other, np.zeros((1, 2))) == -1.0


def test_a_grid_is_read_with_its_place(tmp_path):
    data = {"heights": np.full((40, 60), 0.1), "cell": 0.05, "origin": [-1.0, -1.5]}
    found = read_map(saved(tmp_path, "grid.npz", data))
    corners = found.corners[0, : int(found.sides[0])]
    np.testing.assert_allclose(
        [corners.min(axis=0), corners.max(axis=0)], [[-1, -1.5], [0.95, 1.45]]
    )
    np.testing.assert_allclose(found.plane, [[0.1, 0.0, 0.0]], atol=1e-12)


FLAT = {"heights": np.zeros((50, 50)), "cell": 0.05, "origin": [-1.0, -1.0]}
BAD = {
    "nan.yaml": (
        {"patches": [{}, {"corners": [[0, 0], [1, 0], [1, float("nan")]]}]},
        "[1].corners",
    ),
    "two.yaml": ({"patches": [{"corners": SQUARE[:2]}]}, "patches[0].corners"),
    "dent.yaml": ({"patches": [{"corners": [*SQUARE, [0.5, 0.0]]}]}, "must be convex"),
    "star.yaml": (
        {"patches": [{"corners": [[0, 1], [0.6, -0.8], [-0.9, 0.3], [0.9, 0.3], [-0.6, -0.8]]}]},
        "must be convex",
    ),
    "twice.yaml": ({"patches": [{"corners": [*SQUARE, SQUARE[-1]]}]}, "must be convex"),
    "nine.yaml": ({"patches": [{"corners": [[k, k * k] for k in range(9)]}]}, "patches[0].corners"),
    "wall.yaml": ({"patches": [{"plane": [0.0, 2.0, 0.0]}]}, "patches[0].plane"),
    "far.yaml": ({"patches": [{"corners": [[5, 5], [6, 5], [5, 6]]}]}, "where the robot starts"),
    "none.yaml": ({"patches": []}, "patches = []"),
    "word.yaml": ("patches: [", "is no YAML"),
    "large.yaml": ("# " + "x" * 2**19, "is larger than"),
    "text.npz": (None, "cannot be read"),
    "part.npz": ({"heights": np.zeros((5, 5))}, "must have the arrays"),
    "cell.npz": ({**FLAT, "cell": 0.0}, "cell = 0.0"),
    "line.npz": ({**FLAT, "heights": np.zeros(50)}, "must have 2 dimensions"),
    "thin.npz": ({**FLAT, "heights": np.zeros((2, 50))}, "must have 3 cells"),
    "high.npz": ({**FLAT, "heights": np.full((5, 5), np.inf)}, "heights"),
    "rough.npz": (
        {**FLAT, "heights": np.random.default_rng(0).uniform(0.0, 1.0, (50, 50))},
        "must have ground that is flat",
    ),
    "huge.npz": ({**FLAT, "heights": np.zeros((2000, 2000))}, "is larger than"),
    "away.npz": ({**FLAT, "origin": [2.0, 0.0]}, "where the robot starts"),
}


@pytest.mark.parametrize("name", BAD)
def test_bad_maps_are_refused_in_a_line_that_names_file_and_part(name, tmp_path):
    data, message = BAD[name]
    file = tmp_path / name
    if data is None:
        file.write_text("no archive")
    else:
        saved(tmp_path, name, data)
    with pytest.raises(InputError) as caught:
        read_map(file)
    assert str(file) in str(caught.value)
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_map_that_is_not_there_is_refused_before_anything_walks(tmp_path):
    scenario = make_scenario({"terrain": {"source": "file", "file": str(tmp_path / "no.yaml")}})
    with pytest.raises(InputError, match=r"no\.yaml.*cannot be read"):
        build_closed_loop(scenario)
