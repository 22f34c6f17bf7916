"""Pages made from templates: HTML that opens from disk and needs no network, and Markdown.

A template `NAME.html.j2` extends `page.html.j2`, which has the frame, the style and the plots; what
goes into it is escaped. Macros for tables are in `parts.html.j2` and `parts.md.j2`.
"""

from __future__ import annotations

import base64
import gzip
import json
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined, select_autoescape

if TYPE_CHECKING:
    from plotly.graph_objects import Figure

TEMPLATES = Path(__file__).parent / "templates"


def render(template: str, folder: Path | None = None, /, **values: Any) -> str:
    """Return a page; the same for the same values.

    Args:
        template: file name of the template, `report.html.j2`.
        folder: of the caller's own templates, which may extend and import those here.
        values: what the template names. `figures` are interactive plots by their headings (an
            HTML page needs `title` too); a picture is shown with `data_uri(png)` or
            `data_uri(svg, "svg+xml")` as the source of an `img`.

    Raises:
        jinja2.UndefinedError: the template names a value that is not given.
    """
    return _environment(folder).get_template(template).render(values)


@cache
def _environment(folder: Path | None) -> Environment:
    environment = Environment(
        loader=FileSystemLoader([TEMPLATES] if folder is None else [folder, TEMPLATES]),
        autoescape=select_autoescape(["html.j2"]),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    environment.globals |= {
        "data_uri": _data_uri,
        "packed_figures": _packed_figures,
        "packed_library": _packed_library,
    }
    return environment


def _data_uri(picture: bytes, kind: str = "png") -> str:
    """Return a picture as the address of an image."""
    return f"data:image/{kind};base64,{base64.b64encode(picture).decode()}"


def _packed_figures(figures: Mapping[str, Figure]) -> str:
    """Return plots by the ids of their places."""
    parts = {f"plot{i}": json.loads(f.to_json()) for i, f in enumerate(figures.values())}
    return _packed(json.dumps(parts))


@cache
def _packed_library() -> str:
    """Return the plotting library."""
    from plotly.offline import get_plotlyjs

    return _packed(get_plotlyjs())


def _packed(text: str) -> str:
    """Return a text compressed, in letters a page can hold: a page is a third as large."""
    return base64.b64encode(gzip.compress(text.encode(), mtime=0)).decode()
