"""The models and scenarios are found in a checkout and in a wheel, and nowhere else."""

import pytest

from drake_linefoot import resources
from drake_linefoot.errors import LinefootError


@pytest.fixture
def package(tmp_path, monkeypatch):
    """An empty package in an empty folder, in place of the real one."""
    folder = tmp_path / "site" / "drake_linefoot"
    folder.mkdir(parents=True)
    monkeypatch.setattr(resources, "PACKAGE", folder)
    return folder


def touch(path):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.touch()


FOLDERS = pytest.mark.parametrize(
    ("find", "name", "content"),
    [
        (resources.models_dir, "models", "package.xml"),
        (resources.diagrams_dir, "diagrams", "walk.yaml"),
    ],
)


def test_shipped_models_are_found():
    assert (resources.models_dir() / "package.xml").is_file()


def test_shipped_scenarios_are_found():
    assert list(resources.diagrams_dir().glob("*.yaml"))


@FOLDERS
def test_folder_beside_the_package_is_found(package, find, name, content):
    touch(package.parent / name / content)
    assert find() == package.parent / name


@FOLDERS
def test_folder_inside_the_package_wins(package, find, name, content):
    touch(package.parent / name / content)
    touch(package / name / content)
    assert find() == package / name


@FOLDERS
def test_foreign_folder_of_the_same_name_is_skipped(package, find, name, content):
    (package / name).mkdir()
    touch(package / name / "unrelated.txt")
    touch(package.parent / name / content)
    assert find() == package.parent / name


@FOLDERS
def test_missing_folder_names_both_places(package, find, name, content):
    with pytest.raises(LinefootError) as raised:
        find()
    assert str(package / name) in str(raised.value)
    assert str(package.parent / name) in str(raised.value)


def test_missing_package_xml_is_said(package):
    with pytest.raises(LinefootError, match=r"package\.xml"):
        resources.models_dir()
