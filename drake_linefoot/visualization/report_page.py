"""The report of a run: one page that opens from disk and needs no network."""

from __future__ import annotations

import base64
import gzip
import html
import json
from functools import cache
from typing import Any

from drake_linefoot.report import SEGMENTS, segment_rows, summary_rows
from drake_linefoot.scenario_io import dump_scenario
from drake_linefoot.simulation.recording import Run
from drake_linefoot.visualization.report_plots import report_figures

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
<h1>%(name)s</h1>
<p class="small">drake_linefoot %(version)s, robot %(robot)s, seed %(seed)s</p>
%(fell)s
<p>%(links)s</p>
<h2>%(segments_title)s</h2>
%(segments)s
<h2>The whole run</h2>
%(summary)s
<p class="small">Plots: drag to zoom, double-click to see all, click a name in the legend to hide
it. Lines are drawn from at most 4000 points, extremes included; the log has every sample.</p>
%(plots)s
<h2>Scenario</h2>
<pre>%(scenario)s</pre>
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


def report_html(run: Run, metrics: dict[str, Any], links: dict[str, str]) -> str:
    """Return the report of a run as a page: figures, plots, scenario.

    Args:
        run: what was recorded.
        metrics: of `compute_metrics`.
        links: what is beside the page: the words, and the file they lead to.
    """
    figures = report_figures(run)
    ids = {f"plot{i}": heading for i, heading in enumerate(figures)}
    parts = {key: json.loads(figures[heading].to_json()) for key, heading in ids.items()}
    fell = ""
    if run.fell:
        text = f"The robot fell at {run.fall_time:.3f} s: {run.fall_reason}"
        fell = f'<p class="fell">{html.escape(text)}</p>'
    to = (f'<a href="{html.escape(f)}">{html.escape(t)}</a>' for t, f in links.items())
    head = ("", "commanded", "measured", "error")
    name = run.scenario.name
    return _PAGE % {
        "title": html.escape(f"{name}, report of drake_linefoot"),
        "name": html.escape(name),
        "version": html.escape(run.version),
        "robot": html.escape(run.scenario.robot),
        "seed": run.scenario.seed,
        "fell": fell,
        "links": " · ".join(to),
        "segments_title": html.escape(SEGMENTS),
        "segments": _table(segment_rows(metrics), head, numbers=True),
        "summary": _table(list(summary_rows(metrics).items())),
        "plots": "\n".join(
            f'<h2>{html.escape(heading)}</h2>\n<div id="{key}"></div>'
            for key, heading in ids.items()
        ),
        "scenario": html.escape(dump_scenario(run.scenario)),
        "library": _library(),
        "figures": _packed(json.dumps(parts)),
    }


@cache
def _library() -> str:
    """Return the plotting library, packed."""
    from plotly.offline import get_plotlyjs

    return _packed(get_plotlyjs())


def _packed(text: str) -> str:
    """Return a text compressed, in letters a page can hold; the same for the same text."""
    return base64.b64encode(gzip.compress(text.encode(), mtime=0)).decode()


def _table(
    rows: list[tuple[str, ...]], head: tuple[str, ...] = (), *, numbers: bool = False
) -> str:
    """Return a table; with `numbers` all columns but the first are numbers."""
    lines = ["<table>"]
    if head:
        lines.append("<tr>" + "".join(f"<th>{html.escape(h)}</th>" for h in head) + "</tr>")
    style = ' class="number"' if numbers else ""
    for first, *others in rows:
        cells = "".join(f"<td{style}>{html.escape(cell)}</td>" for cell in others)
        lines.append(f"<tr><th>{html.escape(first)}</th>{cells}</tr>")
    return "\n".join([*lines, "</table>"])
