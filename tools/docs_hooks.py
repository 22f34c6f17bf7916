"""What the documentation site has beside the pages of `docs/`; used by mkdocs.yml.

* The reference: a page for each folder of the package that lists its modules, and one for all
  studies, so that it is never stale.
* Files that pages link to outside `docs/` (`../examples/04_walk.py`). Such links work in a
  checkout; the site gets copies of the files under `repository/`, where links lead instead.
* Docstrings as Markdown.
* Formulas as MathML, which browsers show by themselves.
* Nothing that is fetched from another host.
"""

from __future__ import annotations

import html as entities
import re
import unicodedata
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import griffe
from latex2mathml.converter import convert
from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = ROOT / "drake_linefoot"
STUDIES = ROOT / "studies"
COPIES = "repository"
FORMULA = re.compile(r'<(span|div) class="arithmatex">\\([(\[])(.*?)\\[)\]]</\1>', re.DOTALL)
KNOWN = {  # what the converter knows by another name
    r"{aligned}": r"{split}",
    r"\begin{bmatrix}": r"\left[\begin{matrix}",
    r"\end{bmatrix}": r"\end{matrix}\right]",
}
BOLD = re.compile(r"<mi>&#x(1D4[0-9A-F]{2});</mi>")  # a letter that few fonts have
HOST = "https://unpkg.com/"  # the theme asks it for scripts that these pages do not use
SHIM, SEARCH = "iframe-worker/shim", "search_from_file.js"  # of that host, and in its place
LINK = re.compile(r"\]\(([^)#\s:]+)(#[^)\s]*)?\)")


class PlainDocstrings(griffe.Extension):
    """Makes Markdown of docstrings: units are no links."""

    def on_object(self, *, obj: griffe.Object, **_: Any) -> None:
        """Change the docstring of a module, class, function or attribute."""
        if obj.docstring:
            obj.docstring.value = obj.docstring.value.replace("] [", "] \\[")  # [x, y] [m, m]

    def on_attribute_instance(self, *, attr: griffe.Attribute, **_: Any) -> None:
        """Let fields whose names say all be shown as well."""
        if attr.parent and "dataclass" in attr.parent.labels and not attr.docstring:
            words = attr.name.replace("_", " ").capitalize()
            attr.docstring = griffe.Docstring(f"{words}.", parent=attr)


def modules(folder: Path) -> list[str]:
    """Return the dotted names of the public modules of a folder, in order of the alphabet.

    Those of the studies are in folders of it.
    """
    files = folder.rglob("*.py") if folder == STUDIES else folder.glob("*.py")
    public = sorted(file for file in files if not file.stem.startswith("_"))
    return [".".join(file.relative_to(ROOT).with_suffix("").parts) for file in public]


def first_line(file: Path) -> str:
    """Return the first line of a module's docstring."""
    return file.read_text(encoding="utf-8").split('"""')[1].strip().splitlines()[0]


def reference_pages() -> dict[str, str]:
    """Return the text of every page of the reference by its name."""
    folders = [*sorted(p.parent for p in PACKAGE.rglob("__init__.py")), STUDIES]
    pages = {}
    rows = [
        "# Reference",
        "",
        "One page for each folder of the package, and one for the studies.",
        "",
    ]
    rows += ["| folder | what it holds |", "|---|---|"]
    for folder in folders:
        inside = folder.relative_to(ROOT if folder == STUDIES else PACKAGE).as_posix()
        name, title = ("package", "Top of the package") if folder == PACKAGE else (inside, inside)
        about = first_line(folder / "__init__.py")
        rows.append(f"| [{title}]({name}.md) | {about} |")
        names = "\n\n".join(f"::: {module}" for module in modules(folder))
        pages[f"reference/{name}.md"] = f"# {title}\n\n{about}\n\n{names}\n"
    pages["reference/index.md"] = "\n".join(rows) + "\n"
    return pages


def linked_files(page: Path) -> Iterator[Path]:
    """Yield the files outside `docs/` that a page links to, and those that they link to."""
    seen = set()
    left = [page]
    while left:
        file = left.pop()
        for target, _ in LINK.findall(file.read_text(encoding="utf-8")):
            linked = (file.parent / target).resolve()
            outside = linked.is_relative_to(ROOT) and not linked.is_relative_to(ROOT / "docs")
            if outside and linked.is_file() and linked not in seen:
                seen.add(linked)
                yield linked
                if linked.suffix == ".md":
                    left.append(linked)


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the reference and the copies."""
    for uri, text in reference_pages().items():
        files.append(File.generated(config, uri, content=text))
    for page in sorted((ROOT / "docs").rglob("*.md")):
        for linked in linked_files(page):
            uri = f"{COPIES}/{linked.relative_to(ROOT).as_posix()}"
            if uri not in files.src_uris:
                files.append(File.generated(config, uri, abs_src_path=str(linked)))
    return files


def on_page_markdown(markdown: str, page: Page, **_: Any) -> str:
    """Let links out of `docs/` lead to the copies, and links of copies into it back."""
    uri = page.file.src_uri
    if uri.startswith(f"{COPIES}/"):
        up = "../" * uri.count("/")
        return markdown.replace(f"]({up[3:]}docs/", f"]({up}")
    up = "../" * uri.count("/")
    return markdown.replace(f"]({up}../", f"]({up}{COPIES}/")


def on_page_content(html: str, **_: Any) -> str:
    """Turn formulas into MathML."""
    return FORMULA.sub(mathml, html)


def mathml(match: re.Match[str]) -> str:
    """Return a formula that arithmatex found as MathML."""
    tag, bracket, formula = match.groups()
    for latex, known in KNOWN.items():
        formula = formula.replace(latex, known)
    formula = re.sub(r"\\tag\{(.*?)\}", r"\\qquad \\text{(\1)}", formula)
    display = "block" if bracket == "[" else "inline"
    made = convert(entities.unescape(formula).strip(), display=display)
    return f"<{tag}>{BOLD.sub(bold, made)}</{tag}>"


def bold(match: re.Match[str]) -> str:
    """Return a bold letter as the plain one, which the style sheet makes bold."""
    letter = unicodedata.normalize("NFKC", chr(int(match[1], 16)))
    return f'<mi mathvariant="bold">{letter}</mi>'


def on_post_build(config: MkDocsConfig, **_: Any) -> None:
    """Let scripts and pages ask no other host; search from the disk with a script of ours."""
    site = Path(config.site_dir)
    for file in site.rglob("*"):
        if file.suffix in {".html", ".js"} and HOST in (text := file.read_text(encoding="utf-8")):
            up = "../" * (len(file.relative_to(site).parts) - 1)
            text = text.replace(f"{HOST}{SHIM}", f"{up}{SEARCH}")
            file.write_text(text.replace(HOST, ""), encoding="utf-8")
