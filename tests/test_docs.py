"""README and docs/ say what is there: links, anchors, names and commands exist.

The strict build of the site (`make docs`) checks more, and takes longer.
"""

import importlib
import re
import tomllib
from pathlib import Path

import pytest
import typer
import yaml

from drake_linefoot.lab.cli import app

ROOT = Path(__file__).resolve().parents[1]
DOCS = ROOT / "docs"
PAGES = [ROOT / "README.md", *sorted(DOCS.glob("*.md"))]
PACKAGE = ROOT / "drake_linefoot"

FENCE = re.compile(r"^```.*?^```", re.MULTILINE | re.DOTALL)
LINK = re.compile(r"\]\(([^)\s]+)\)")
HEADING = re.compile(r"^#+ +(.+?) *$", re.MULTILINE)
DOTTED = re.compile(r"\b(?:drake_linefoot|studies)(?:\.[A-Za-z_]\w*)+")
COMMAND = re.compile(r"(?:^ {4}|`)(?:\.venv/bin/)?linefoot +([a-z][a-z-]*)", re.MULTILINE)
SNIPPET = re.compile(r'^--8<-- "(.+)"$', re.MULTILINE)
IMPORT = re.compile(r"^from (drake_linefoot[\w.]*) import (.+)$", re.MULTILINE)
EQUATION = re.compile(r"\\tag\{(\d+)\}|\\quad \((\d+)\)")

each_page = pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)


def anchors(file):
    """Return the anchors of the headings of a page, or the ids of an HTML file."""
    text = file.read_text(encoding="utf-8")
    if file.suffix == ".html":
        return set(re.findall(r'\bid="([^"]+)"', text))
    headings = HEADING.findall(FENCE.sub("", text))
    slugs = (re.sub(r"[^\w\s-]", "", heading).strip().lower() for heading in headings)
    return {re.sub(r"[-\s]+", "-", slug) for slug in slugs}


def nav_pages(entry):
    """Yield the files of the navigation of mkdocs.yml."""
    if isinstance(entry, str):
        yield entry
    elif isinstance(entry, dict):
        for value in entry.values():
            yield from nav_pages(value)
    else:
        for item in entry:
            yield from nav_pages(item)


def navigation():
    text = (ROOT / "mkdocs.yml").read_text(encoding="utf-8")
    return list(nav_pages(yaml.safe_load(text)["nav"]))


def find(dotted):
    """Return what a dotted name means: a module, or something in one."""
    parts = dotted.split(".")
    for length in range(len(parts), 0, -1):
        try:
            found = importlib.import_module(".".join(parts[:length]))
        except ModuleNotFoundError:
            continue
        for name in parts[length:]:
            fields = getattr(found, "__dataclass_fields__", {})
            found = fields[name] if name in fields else getattr(found, name)
        return found
    raise AssertionError(f"no module {dotted}")


@each_page
def test_links_lead_somewhere(page):
    text = FENCE.sub("", page.read_text(encoding="utf-8"))
    for link in LINK.findall(text):
        if re.match(r"[a-z]+:", link):
            continue
        target, _, anchor = link.partition("#")
        file = (page.parent / target).resolve() if target else page
        assert file.exists(), link
        assert file.is_relative_to(ROOT), link
        if anchor:
            assert anchor in anchors(file), link


@each_page
def test_names_exist(page):
    text = page.read_text(encoding="utf-8")
    for dotted in set(DOTTED.findall(text)):
        find(dotted.removesuffix(".py"))
    for module, names in IMPORT.findall(text):
        for name in names.split(","):
            find(f"{module}.{name.strip()}")


@each_page
def test_commands_exist(page):
    commands = typer.main.get_command(app).commands
    for name in COMMAND.findall(page.read_text(encoding="utf-8")):
        assert name in commands


@each_page
def test_snippets_exist(page):
    text = page.read_text(encoding="utf-8")
    for name in SNIPPET.findall(text):
        assert (ROOT / name).is_file()
    # In a fence of `python` the formatter takes the line for code, and spaces it out.
    assert text.count("--8") == len(SNIPPET.findall(text))


def test_every_command_is_explained():
    explained = COMMAND.findall((DOCS / "commands.md").read_text(encoding="utf-8"))
    assert set(explained) == set(typer.main.get_command(app).commands)


def test_every_page_is_in_the_navigation():
    listed = [page for page in navigation() if "/" not in page]
    assert sorted(listed) == sorted(page.name for page in DOCS.glob("*.md"))


def test_every_folder_is_in_the_reference():
    listed = {page for page in navigation() if page.startswith("reference/")}
    inside = {file.parent.relative_to(PACKAGE).as_posix() for file in PACKAGE.rglob("__init__.py")}
    folders = {f"reference/{folder}.md" for folder in inside - {"."}}
    others = {f"reference/{name}.md" for name in ("index", "package", "studies")}
    assert listed == folders | others


@pytest.mark.parametrize("part", ["The controller", "The laboratory"])
def test_every_dependency_is_said_to_be_for_something(part):
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    extra = project["optional-dependencies"]["lab"]
    wanted = project["dependencies"] if part == "The controller" else extra
    text = (DOCS / "dependencies.md").read_text(encoding="utf-8")
    section = text.split(f"## {part}\n")[1].split("\n## ")[0]
    assert sorted(re.findall(r"^\| (\S+) \| \S", section, re.MULTILINE)[1:]) == sorted(
        re.match(r"[\w-]+", requirement)[0] for requirement in wanted
    )


def test_every_equation_of_the_paper_is_there_once():
    text = (DOCS / "mathematics.md").read_text(encoding="utf-8")
    numbers = [int(a or b) for a, b in EQUATION.findall(text)]
    assert len(set(numbers)) == len(numbers)
    # (6) only says that the eta of (7) exists.
    assert set(numbers) == set(range(1, 54)) - {6}
