"""A page with plots that opens from disk and needs no network: frame, plots and tables."""

from __future__ import annotations

import base64
import gzip
import html
import json
from collections.abc import Mapping, Sequence
from functools import cache
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from plotly.graph_objects import Figure

# The library and the plots are packed, or the page would be three times as large.
_PAGE = """\
<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>%(title)s</title>
<style>
body { font: 15px/1.5 system-ui, sans-serif; color: #222; max-width: 1200px;
       margin: 0 auto; padding: 1.5em; }
h1 { margin: 0 0 .2em; } h2 { font-size: 1.15em; margin: 2em 0 .4em; }
p.fell { background: #c02020; color: white; font-size: 1.1em; padding: .6em 1em; }
table { border-collapse: collapse; } th, td { padding: .25em .9em; text-align: left; }
tr { border-bottom: 1px solid #ddd; } td.number { font-variant-numeric: tabular-nums;
text-align: right; white-space: pre; } pre { background: #f5f6f7; padding: 1em; overflow-x: auto; }
.small { color: #555; }
</style>
</head>
<body>
%(body)s
<script type="application/octet-stream" id="library">%(library)s</script>
<script type="application/octet-stream" id="figures">%(figures)s</script>
<script>
async function unpacked(id) {
  const packed = Uint8Array.from(
    atob(document.getElementById(id).textContent), (letter) => letter.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Response(stream).text();
}
async function show() {
  const library = document.createElement("script");
  library.textContent = await unpacked("library");
  document.head.append(library);
  for (const [id, figure] of Object.entries(JSON.parse(await unpacked("figures")))) {
    const buttons = ["toImage", "zoom2d", "pan2d", "zoomIn2d", "zoomOut2d", "resetScale2d"];
    const options = {responsive: true, displaylogo: false, modeBarButtons: [buttons]};
    await Plotly.newPlot(id, figure.data, figure.layout, options);
  }
  document.body.dataset.shown = "yes";
}
show().catch((error) => {
  const line = document.createElement("p");
  line.className = "fell";
  line.textContent = "This browser cannot show the plots: " + error;
  document.body.prepend(line);
});
</script>
</body>
</html>
"""


def plot_page(title: str, body: str, figures: Mapping[str, Figure]) -> str:
    """Return a page; the same for the same content.

    Args:
        title: of the page.
        body: HTML in which `plots` of the same figures stand.
        figures: by their headings.
    """
    parts = {_id(i): json.loads(figure.to_json()) for i, figure in enumerate(figures.values())}
    return _PAGE % {
        "title": html.escape(title),
        "body": body,
        "library": _library(),
        "figures": _packed(json.dumps(parts)),
    }


def plots(headings: Sequence[str]) -> str:
    """Return the places of plots, each under its heading."""
    return "\n".join(
        f'<h2>{html.escape(heading)}</h2>\n<div id="{_id(i)}"></div>'
        for i, heading in enumerate(headings)
    )


def _id(i: int) -> str:
    return f"plot{i}"


@cache
def _library() -> str:
    """Return the plotting library, packed."""
    from plotly.offline import get_plotlyjs

    return _packed(get_plotlyjs())


def _packed(text: str) -> str:
    """Return a text compressed, in letters a page can hold; the same for the same text."""
    return base64.b64encode(gzip.compress(text.encode(), mtime=0)).decode()


def table(rows: Sequence[Sequence[str]], head: Sequence[str] = (), *, numbers: bool = False) -> str:
    """Return a table; with `numbers` all columns but the first are numbers."""
    lines = ["<table>"]
    if head:
        lines.append("<tr>" + "".join(f"<th>{html.escape(h)}</th>" for h in head) + "</tr>")
    style = ' class="number"' if numbers else ""
    for first, *others in rows:
        cells = "".join(f"<td{style}>{html.escape(cell)}</td>" for cell in others)
        lines.append(f"<tr><th>{html.escape(first)}</th>{cells}</tr>")
    return "\n".join([*lines, "</table>"])
