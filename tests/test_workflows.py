"""The workflow files of the forge: valid YAML whose commands and files exist here."""

import re
from pathlib import Path

import pytest
import yaml

from drake_linefoot.lab.cli import app

ROOT = Path(__file__).resolve().parents[1]
WORKFLOWS = sorted((ROOT / ".github" / "workflows").glob("*.yml"))
TEMPLATES = sorted((ROOT / ".github" / "ISSUE_TEMPLATE").glob("[!c]*.yml"))
COMMANDS = {command.callback.__name__.replace("_", "-") for command in app.registered_commands}


def steps(file):
    data = yaml.safe_load(file.read_text(encoding="utf-8"))
    return [step for job in data["jobs"].values() for step in job["steps"]], data


def test_there_are_the_three():
    assert [file.stem for file in WORKFLOWS] == ["docs", "release", "tests"]


@pytest.mark.parametrize("file", WORKFLOWS, ids=lambda file: file.stem)
def test_what_a_workflow_runs_is_there(file):
    found, data = steps(file)
    script = "\n".join(step.get("run", "") for step in found)
    targets = re.findall(r"^(\w+)[^:=\n]*:", (ROOT / "Makefile").read_text("utf-8"), re.MULTILINE)
    for target in re.findall(r"\bmake (\w+)", script):
        assert target in targets
    for command in re.findall(r"^linefoot (\w[\w-]*)", script, re.MULTILINE):
        assert command in COMMANDS
    for path in re.findall(r"bash (\S+)|-r (\S+\.txt)", script):
        assert (ROOT / "".join(path)).is_file()
    for install in re.findall(r"\bpip install (.*)", script):
        assert install.startswith(("--require-hashes", "--no-deps"))
    assert data["permissions"] == {"contents": "read"}
    assert all("uses" in step or "run" in step for step in found)
    for step in found:
        if "checkout" in step.get("uses", ""):
            assert step["with"]["fetch-depth"] == 0  # else there are no tags


def test_only_publishing_and_pages_may_sign_in_and_only_a_tag_releases():
    for file in WORKFLOWS:
        data = yaml.safe_load(file.read_text(encoding="utf-8"))
        may = {
            name for name, job in data["jobs"].items() if "id-token" in job.get("permissions", {})
        }
        assert may == {"release": {"publish"}, "docs": {"deploy"}}.get(file.stem, set())
    release = yaml.safe_load(WORKFLOWS[1].read_text(encoding="utf-8"))
    assert release[True] == {"push": {"tags": ["v*"]}}  # `on` is a truth value in YAML 1.1
    assert "secrets" not in WORKFLOWS[1].read_text(encoding="utf-8")


@pytest.mark.parametrize("file", TEMPLATES, ids=lambda file: file.stem)
def test_a_template_has_a_name_and_fields_with_labels(file):
    data = yaml.safe_load(file.read_text(encoding="utf-8"))
    assert data["name"] and data["description"]
    fields = [(field["id"], field["attributes"]["label"]) for field in data["body"]]
    assert len(dict(fields)) == len(fields) > 1
