"""Maps from files: patches in YAML, or a grid of heights, of which patches are made."""

import os
import zipfile
from dataclasses import dataclass, field
from functools import lru_cache
from io import BytesIO
from pathlib import Path
from typing import Annotated

import numpy as np
from annotated_types import Len
from pydantic import Strict

from drake_linefoot.checks import check
from drake_linefoot.errors import InputError
from drake_linefoot.files import read_file
from drake_linefoot.lab.plants.height_grid import HeightGrid, patches_of
from drake_linefoot.lab.plants.patch_ground import distances, terrain_of
from drake_linefoot.lab.scenario.courses import PatchParameters
from drake_linefoot.parameters import Parameters
from drake_linefoot.terrain import Terrain
from drake_linefoot.yaml_file import read_yaml

LARGEST = 2**24  # bytes of a grid, packed and unpacked
MOST_CELLS = 10**6
WHAT = "map of the ground"
_ARRAYS = {"heights": 2, "cell": 0, "origin": 1}  # and their dimensions


@dataclass
class PatchMap(Parameters):
    """A map of patches."""

    patches: Annotated[list[PatchParameters], Strict(), Len(1, 2500)] = field(
        default_factory=lambda: [PatchParameters()]
    )


def read_map(file: str | Path) -> Terrain:
    """Return the patches of a map, any number of them.

    Args:
        file: a YAML file with `patches`, each as of `PatchParameters`; or a .npz file with
            `heights` [m], shape (n, m), rows along x and columns along y, NaN where it is not
            known, `cell` [m], and `origin`, x and y of the middle of the first cell [m].

    Raises:
        InputError: the file cannot be used; names it, and the patch or array.
    """
    path = Path(file)
    try:
        changed = os.stat(path).st_mtime_ns
    except (OSError, ValueError) as wrong:
        reason = getattr(wrong, "strerror", None) or "is no path"
        raise InputError(path, "", WHAT, f"cannot be read: {reason}") from wrong
    return _read(path, changed)


@lru_cache(maxsize=8)  # that which is walked is that which is drawn
def _read(path: Path, changed: int) -> Terrain:
    if path.suffix == ".npz":
        found = patches_of(_read_grid(path))
        if not len(found.sides):
            raise InputError(path, "heights", WHAT, "must have ground that is flat to 1 cm")
    else:
        data = read_yaml(path, WHAT, InputError)
        found = terrain_of(check(data, PatchMap, path, error=InputError).patches)
    if distances(found, np.zeros((1, 2))).min() > 0.0:
        raise InputError(path, "", WHAT, "must have a patch where the robot starts, at 0, 0")
    return found


def _read_grid(path: Path) -> HeightGrid:
    try:
        content = read_file(path, LARGEST)
        with zipfile.ZipFile(BytesIO(content)) as packed:
            if sum(part.file_size for part in packed.infolist()) > LARGEST:
                raise OSError(f"is larger than {LARGEST >> 10} KiB")
        with np.load(BytesIO(content), allow_pickle=False) as arrays:
            read = {name: np.asarray(arrays[name], dtype=float) for name in _ARRAYS}
    except KeyError as wrong:
        raise InputError(path, "", WHAT, f"must have the arrays {list(_ARRAYS)}") from wrong
    except Exception as wrong:  # zipfile and numpy raise all kinds for odd files
        reason = str(getattr(wrong, "strerror", None) or wrong).partition("\n")[0]
        raise InputError(path, "", WHAT, f"cannot be read: {reason}") from wrong
    heights, cell, origin = read.values()
    for name, dimensions in _ARRAYS.items():
        if read[name].ndim != dimensions:
            allowed = f"must have {dimensions} dimensions"
            raise InputError(path, name, f"an array of {read[name].ndim}", allowed)
    if not 1e-3 <= cell <= 1.0:
        raise InputError(path, "cell", float(cell), "must be 0.001 to 1 m")
    if origin.shape != (2,) or not np.all(np.abs(origin) <= 1e3):
        raise InputError(path, "origin", origin.tolist()[:3], "must be x and y, within 1000 m")
    if min(heights.shape) < 3 or heights.size > MOST_CELLS:
        allowed = f"must have 3 cells along x and y, and {MOST_CELLS} at most"
        raise InputError(path, "heights", list(heights.shape), allowed)
    if np.isinf(heights).any() or np.any(np.abs(heights[np.isfinite(heights)]) > 1e3):
        raise InputError(path, "heights", WHAT, "must be NaN, or within 1000 m")
    return HeightGrid(heights, float(cell), origin)
