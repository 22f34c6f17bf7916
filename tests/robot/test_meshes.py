"""Meshes that Drake does not draw: where their points are, and what is drawn for them."""

import sys

import numpy as np
import pytest
import trimesh
from pydrake.geometry import Mesh, Role, SceneGraph
from pydrake.multibody.plant import MultibodyPlant

from drake_linefoot.errors import MissingPackageError
from drake_linefoot.lab.new_robot.analysis import analyse
from drake_linefoot.robot.meshes import drawable, mesh_triangles
from tests.helpers import made_up_robots as made_up


def spans(points):
    return np.array([points.min(axis=0), points.max(axis=0)])


@pytest.fixture
def box(tmp_path):
    """Write a box of 1 x 2 x 3 mm about (0, 0, 10 mm), in some formats."""

    def write(kind):
        shape = trimesh.creation.box((1e-3, 2e-3, 3e-3))
        shape.apply_translation([0.0, 0.0, 1e-2])
        file = tmp_path / f"box.{kind}"
        shape.export(file)
        return file

    return write


CORNERS = np.array([[-0.5e-3, -1e-3, 8.5e-3], [0.5e-3, 1e-3, 11.5e-3]])


@pytest.mark.parametrize("kind", ["stl", "obj", "ply"])
def test_points_are_where_the_file_has_them(box, kind):
    np.testing.assert_allclose(spans(mesh_triangles(box(kind))[0]), CORNERS, atol=1e-9)


def collada(file, unit, up):
    """Change unit and vertical of a COLLADA file."""
    text = file.read_text()
    assert "<up_axis>" in text or "</asset>" in text
    head, tail = text.split("</asset>", 1)
    head = head.split("<up_axis>")[0] if "<up_axis>" in head else head
    head = head.split("<unit")[0] if "<unit" in head else head
    asset = f'<unit name="u" meter="{unit}"/><up_axis>{up}</up_axis></asset>'
    file.write_text(head + asset + tail)
    return file


def test_collada_has_its_unit_and_its_vertical(box):
    np.testing.assert_allclose(
        spans(mesh_triangles(collada(box("dae"), "1", "Z_UP"))[0]), CORNERS, atol=1e-9
    )
    scaled = spans(mesh_triangles(collada(box("dae"), "0.01", "Z_UP"))[0])
    np.testing.assert_allclose(scaled, 0.01 * CORNERS, atol=1e-9)
    # With y up, what the file calls y is our z, and its z is our -y.
    turned = spans(mesh_triangles(collada(box("dae"), "1", "Y_UP"))[0])
    expected = np.array([[-0.5e-3, -11.5e-3, -1e-3], [0.5e-3, -8.5e-3, 1e-3]])
    np.testing.assert_allclose(turned, expected, atol=1e-9)


def test_what_is_no_mesh_is_said(tmp_path):
    file = tmp_path / "odd.stl"
    file.write_text("nothing")
    with pytest.raises(ValueError, match="no mesh that can be read"):
        mesh_triangles(file)


@pytest.mark.parametrize(("kind", "package"), [("stl", "trimesh"), ("dae", "collada")])
def test_what_reads_meshes_and_is_not_installed_is_said_and_nothing_left_out(
    box, monkeypatch, kind, package
):
    file = box(kind)
    monkeypatch.setitem(sys.modules, package, None)
    if package == "collada":  # trimesh has looked for it already
        monkeypatch.setitem(trimesh.exchange.load.mesh_loaders, "dae", without_collada)
    with pytest.raises(MissingPackageError, match=rf"{file.name} needs .*linefoot\[lab\]"):
        drawable(file)


def without_collada(*_, **__):
    raise ImportError("missing `pip install pycollada`")


def test_an_stl_is_drawn_as_an_obj_of_the_same_form(box):
    file = box("stl")
    shown = drawable(file)
    assert shown.suffix == ".obj" and drawable(file) == shown
    np.testing.assert_allclose(spans(mesh_triangles(shown)[0]), CORNERS, atol=1e-7)
    assert drawable(box("obj")) == file.with_suffix(".obj")


def feet_of_meshes(folder, tree):
    """Give the robot feet whose shapes and drawings are STL boxes of a package; write it."""
    made_up.box_feet(tree)
    (folder / "biped_description" / "meshes").mkdir(parents=True)
    trimesh.creation.box(made_up.BOX).export(folder / "biped_description" / "meshes" / "foot.stl")
    for side in made_up.SIDES:
        foot = made_up.named(tree, "link", f"{side}_foot_link")
        geometry = foot.find("collision/geometry")
        geometry.remove(geometry.find("box"))
        name = "package://biped_description/meshes/foot.stl"
        made_up.add_element(geometry, "mesh", filename=name)
        visual = foot.find("visual/geometry")
        visual.clear()
        made_up.add_element(visual, "mesh", filename=name)
    (folder / "biped_description" / "urdf").mkdir()
    return made_up.write(tree, folder / "biped_description" / "urdf")


def test_feet_of_stl_meshes_are_measured_and_drawn(tmp_path):
    found = analyse(feet_of_meshes(tmp_path, made_up.mit()))
    heel, toe = np.array(found.data["feet"][0]["contact_points"])
    np.testing.assert_allclose([heel, toe], [[-0.07, 0, -0.06], [0.13, 0, -0.06]], atol=1e-5)
    for drawn in (True, False):
        plant, scene_graph = MultibodyPlant(1e-3), SceneGraph()
        plant.RegisterAsSourceForSceneGraph(scene_graph)
        found.humanoid.add_to(plant, drawn)
        inspector = scene_graph.model_inspector()
        foot = plant.GetBodyByName("left_foot_link")
        shapes = [inspector.GetShape(g) for g in plant.GetVisualGeometriesForBody(foot)]
        names = [s.source().path().name for s in shapes if isinstance(s, Mesh)]
        assert ("foot.obj" in names) == drawn
        assert bool(inspector.GetAllGeometryIds(Role.kIllustration)) == drawn
        assert plant.num_collision_geometries() == 4
