"""The MIT Humanoid's drawn shapes: closed, small, mirrored, and never below the sole."""

from collections import Counter

import numpy as np
import pytest
from pydrake.geometry import Capsule, Mesh, Role, SceneGraph
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant

from drake_linefoot.resources import models_dir

ROBOT = models_dir() / "mit_humanoid"
MESHES = sorted((ROBOT / "meshes").glob("*.obj"))


@pytest.fixture(scope="module")
def drawn():
    """Link, shape and pose of every drawn part."""
    plant, scene_graph = MultibodyPlant(0.0), SceneGraph()
    plant.RegisterAsSourceForSceneGraph(scene_graph)
    Parser(plant).AddModels(str(ROBOT / "mit_humanoid.urdf"))
    plant.Finalize()
    inspector = scene_graph.model_inspector()
    return [
        (
            inspector.GetName(inspector.GetFrameId(part)).split("::")[-1],
            inspector.GetShape(part),
            inspector.GetPoseInFrame(part),
        )
        for part in inspector.GetAllGeometryIds(Role.kIllustration)
    ]


def read_obj(path):
    """Vertices, normals and faces of a Wavefront file."""
    rows = [line.split() for line in path.read_text(encoding="utf-8").splitlines()]
    vertices = np.array([row[1:] for row in rows if row[0] == "v"], dtype=float)
    normals = np.array([row[1:] for row in rows if row[0] == "vn"], dtype=float)
    pairs = [[word.split("//") for word in row[1:]] for row in rows if row[0] == "f"]
    assert all(vertex == normal for face in pairs for vertex, normal in face)
    return vertices, normals, [[int(vertex) - 1 for vertex, _ in face] for face in pairs]


def triangles(faces):
    """Splits convex faces into fans."""
    return np.array([[f[0], f[i], f[i + 1]] for f in faces for i in range(1, len(f) - 1)])


@pytest.mark.parametrize("path", MESHES, ids=lambda path: path.stem)
def test_mesh_is_closed_and_faces_outwards(path):
    vertices, normals, faces = read_obj(path)
    edges = Counter((f[i - 1], f[i]) for f in faces for i in range(len(f)))
    assert set(edges.values()) == {1}
    assert all((b, a) in edges for a, b in edges)
    corners = vertices[triangles(faces)]
    volume = np.einsum("ij,ij->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6
    assert 1e-6 < volume < 2e-2
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1.0, atol=2e-3)
    flat = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert np.all(np.einsum("ij,ij->i", flat, normals[triangles(faces)].mean(axis=1)) >= -1e-9)


def test_meshes_are_small_and_all_used():
    assert sum(path.stat().st_size for path in MESHES) < 600_000
    urdf = (ROBOT / "mit_humanoid.urdf").read_text(encoding="utf-8")
    assert [path.name for path in MESHES if f'"meshes/{path.name}"' not in urdf] == []


def test_side_meshes_are_mirror_images_and_the_others_symmetric():
    stems = {path.stem: read_obj(path)[0] for path in MESHES}
    assert any(stem.startswith("left_") for stem in stems)
    for stem, vertices in stems.items():
        if not stem.startswith("right_"):
            twin = stems[stem.replace("left_", "right_")]
            gaps = [np.abs(twin - row).max(axis=1).min() for row in vertices * [1, -1, 1]]
            assert max(gaps) < 2e-5, stem


def test_every_link_is_drawn_and_the_drawing_is_mirrored(drawn):
    parts = Counter(
        (link, type(shape).__name__, *pose.translation().round(9)) for link, shape, pose in drawn
    )
    assert len({link for link, *_ in parts}) == 19
    swap = {"left": "right", "right": "left"}
    for (link, shape, x, y, z), count in parts.items():
        side, _, rest = link.partition("_")
        twin = f"{swap[side]}_{rest}" if side in swap else link
        assert parts[(twin, shape, x, -y, z)] == count, link


def test_contact_line_is_the_lowest_drawn_part_of_the_foot(drawn):
    foot = {type(shape): (shape, pose) for link, shape, pose in drawn if link == "left_foot_link"}
    assert set(foot) == {Capsule, Mesh}
    shape, pose = foot[Capsule]
    assert pose.translation()[2] - shape.radius() == pytest.approx(-0.041, abs=1e-9)
    ends = pose.multiply(np.array([[0, 0, -0.5], [0, 0, 0.5]]).T * shape.length())
    np.testing.assert_allclose(sorted(ends[0]), [-0.05, 0.1], atol=1e-6)
    vertices = read_obj(ROBOT / "meshes" / "foot_shell.obj")[0]
    assert -0.041 < vertices[:, 2].min() < -0.03
