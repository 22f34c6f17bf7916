"""The report of a run: one page that opens from disk and needs no network."""

from typing import Any

from drake_linefoot.results.page import render
from drake_linefoot.results.plots_html import report_figures
from drake_linefoot.results.tables import SEGMENTS, segment_rows, summary_rows
from drake_linefoot.scenario.load import dump_scenario
from drake_linefoot.simulation.recording import Run


def report_html(run: Run, metrics: dict[str, Any], links: dict[str, str]) -> str:
    """Return the report of a run as a page: figures, plots, scenario.

    Args:
        run: what was recorded.
        metrics: of `compute_metrics`.
        links: what is beside the page: the words, and the file they lead to.
    """
    return render(
        "report.html.j2",
        title=f"{run.scenario.name}, report of drake_linefoot",
        run=run,
        links=links,
        segments_title=SEGMENTS,
        segments=segment_rows(metrics),
        summary=list(summary_rows(metrics).items()),
        figures=report_figures(run),
        scenario=dump_scenario(run.scenario),
    )
