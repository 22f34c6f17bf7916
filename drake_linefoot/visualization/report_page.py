"""The report of a run: one page that opens from disk and needs no network."""

from __future__ import annotations

import html
from typing import Any

from drake_linefoot.report import SEGMENTS, segment_rows, summary_rows
from drake_linefoot.scenario_io import dump_scenario
from drake_linefoot.simulation.recording import Run
from drake_linefoot.visualization.plot_page import plot_page, plots, table
from drake_linefoot.visualization.report_plots import report_figures

_BODY = """\
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
<pre>%(scenario)s</pre>"""


def report_html(run: Run, metrics: dict[str, Any], links: dict[str, str]) -> str:
    """Return the report of a run as a page: figures, plots, scenario.

    Args:
        run: what was recorded.
        metrics: of `compute_metrics`.
        links: what is beside the page: the words, and the file they lead to.
    """
    figures = report_figures(run)
    fell = ""
    if run.fell:
        text = f"The robot fell at {run.fall_time:.3f} s: {run.fall_reason}"
        fell = f'<p class="fell">{html.escape(text)}</p>'
    to = (f'<a href="{html.escape(f)}">{html.escape(t)}</a>' for t, f in links.items())
    head = ("", "commanded", "measured", "error")
    name = run.scenario.name
    body = _BODY % {
        "name": html.escape(name),
        "version": html.escape(run.version),
        "robot": html.escape(run.scenario.robot),
        "seed": run.scenario.seed,
        "fell": fell,
        "links": " · ".join(to),
        "segments_title": html.escape(SEGMENTS),
        "segments": table(segment_rows(metrics), head, numbers=True),
        "summary": table(list(summary_rows(metrics).items())),
        "plots": plots(list(figures)),
        "scenario": html.escape(dump_scenario(run.scenario)),
    }
    return plot_page(f"{name}, report of drake_linefoot", body, figures)
