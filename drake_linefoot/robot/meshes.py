"""Meshes of other kinds than Drake draws: what they look like, and OBJ files of them."""

from __future__ import annotations

import re
import tempfile
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from drake_linefoot.errors import MissingPackageError
from drake_linefoot.types import Array

if TYPE_CHECKING:
    import trimesh

DRAWN = (".obj", ".gltf")  # what Drake's Meshcat shows


def mesh_triangles(path: Path) -> tuple[Array, NDArray[np.int64]]:
    """Return the vertices of a mesh [m], shape (n, 3), and those of its triangles, shape (m, 3).

    Raises:
        ValueError: it cannot be read.
        MissingPackageError: what reads it is not installed.
    """
    mesh = _read(path)
    return mesh.vertices.view(float).reshape(-1, 3), mesh.faces.view(np.int64).reshape(-1, 3)


def drawable(path: Path) -> Path:
    """Return a file of a mesh that Meshcat shows: itself, or an OBJ file while this process lasts.

    Raises:
        ValueError: it cannot be read.
        MissingPackageError: what reads it is not installed.
    """
    return path if path.suffix.lower() in DRAWN else as_obj(path)


@cache
def as_obj(path: Path) -> Path:
    """Return an OBJ file of a mesh: itself, or one that lasts as long as this process.

    Raises:
        ValueError: it cannot be read.
        MissingPackageError: what reads it is not installed.
    """
    if path.suffix.lower() == ".obj":
        return path
    folder = Path(tempfile.mkdtemp(dir=_folder().name))
    text = _read(path).export(file_type="obj", include_normals=False, include_color=False)
    (folder / f"{path.stem}.obj").write_text(str(text))
    return folder / f"{path.stem}.obj"


@cache
def _folder() -> tempfile.TemporaryDirectory[str]:
    """Return a folder that is removed at the end of the process."""
    return tempfile.TemporaryDirectory(prefix="linefoot-")


def _read(path: Path) -> trimesh.Trimesh:
    """Return a mesh in metres with z up.

    Raises:
        ValueError: it cannot be read.
        MissingPackageError: what reads it is not installed.
    """
    try:
        import trimesh

        mesh = trimesh.load_mesh(path)
        if not len(mesh.vertices):
            raise ValueError("it is empty")
        if path.suffix.lower() == ".dae":  # whose unit and vertical trimesh leaves to us
            text = path.read_text(encoding="utf-8", errors="replace")
            unit = re.search(r'<unit[^>]*meter="([^"]+)"', text)
            mesh.apply_scale(float(unit[1]) if unit else 1.0)
            if "<up_axis>Z_UP" not in text:  # y is COLLADA's default
                mesh.vertices = mesh.vertices[:, [0, 2, 1]] * [1.0, -1.0, 1.0]
    except ImportError as error:  # trimesh, or what it reads COLLADA with
        needed = error.name or "pycollada"
        raise MissingPackageError(f"reading the mesh {path.name}", needed) from error
    except Exception as error:  # trimesh raises all kinds for odd files
        raise ValueError(f"{path}: no mesh that can be read: {error}") from error
    return mesh
