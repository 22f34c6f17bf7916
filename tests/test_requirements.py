"""Files that pip installs are checked by the hashes in requirements/, and those are complete."""

import re
import subprocess
import tomllib
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

ROOT = Path(__file__).resolve().parents[1]
LOCKS = {file.stem: file for file in (ROOT / "requirements").glob("*.txt")}
HASHES = re.compile(r"(?: --hash=sha256:[0-9a-f]{64})+")
ENVIRONMENTS = [
    {
        "python_full_version": f"{python}.1",
        "python_version": python,
        "sys_platform": system,
        "platform_system": {"linux": "Linux", "darwin": "Darwin"}[system],
        "platform_machine": machine,
    }
    for python, system, machine in (
        ("3.11", "linux", "x86_64"),
        *((f"3.{minor}", "linux", "aarch64") for minor in (12, 13, 14)),
        *((f"3.{minor}", "darwin", "arm64") for minor in (12, 13, 14)),
    )
]


def entries(lock):
    """Lines of a file without comments, each with its continuations."""
    text = re.sub(r" *\\\n *", " ", LOCKS[lock].read_text(encoding="utf-8"))
    return [line for line in text.splitlines() if line and not line.startswith("#")]


def pins(lock, environment):
    """Version of each distribution that a file installs there, by its name."""
    found = [Requirement(entry.partition(" --hash")[0]) for entry in entries(lock)[1:]]
    there = [one for one in found if not one.marker or one.marker.evaluate(environment)]
    by_name = {canonicalize_name(one.name): str(one.specifier)[2:] for one in there}
    assert len(by_name) == len(there)  # one version of each
    return by_name


@pytest.mark.parametrize("lock", LOCKS)
def test_each_requirement_has_one_version_and_hashes(lock):
    option, *pinned = entries(lock)
    assert option == "--only-binary :all:"  # what builds another file would be unchecked
    assert pinned
    for entry in pinned:
        requirement, _, rest = entry.partition(" --hash")
        assert re.fullmatch(r"[\w.-]+==[\w.]+( ; [^@]+)?", requirement), requirement
        assert HASHES.fullmatch(f" --hash{rest}"), requirement


@pytest.mark.parametrize("environment", ENVIRONMENTS, ids=lambda e: "-".join([*e.values()][1:3]))
def test_what_pyproject_names_is_locked_at_a_version_that_it_allows(environment):
    content = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    named = {"base": content["build-system"]["requires"] + content["project"]["dependencies"]}
    named |= content["project"]["optional-dependencies"]
    named["base"] = named["base"] + named.pop("lab")
    assert set(LOCKS) <= set(named)
    locked = {lock: pins(lock, environment) for lock in LOCKS}
    for part, requirements in named.items():
        versions = locked.get(part, locked["dev"])  # which has the extras without a file, too
        for requirement in map(Requirement, requirements):
            assert versions[canonicalize_name(requirement.name)] in requirement.specifier
    everything = {pin for versions in locked.values() for pin in versions.items()}
    assert len(everything) == len(dict(everything))  # the files agree


def test_make_installs_by_hash_and_the_project_alone_without():
    targets = [f"new/.{name}" for name in ("installed", *sorted({*LOCKS} - {"base", "dev"}))]
    command = ["make", "--dry-run", "VENV=new", *targets]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
    installs = [line.split(" ", 4)[4] for line in done.stdout.splitlines() if "pip install" in line]
    by_hash = [line for line in installs if "--require-hashes" in line]
    assert sorted(re.findall(r"-r requirements/(\w+)\.txt", " ".join(by_hash))) == sorted(LOCKS)
    (project,) = set(installs) - set(by_hash)
    assert "--no-deps --no-build-isolation --config-settings editable_mode=compat -e ." in project
