"""The report of a run in a browser."""

import pytest

from drake_linefoot.lab.results.metrics import compute_metrics
from drake_linefoot.lab.results.report import report_figures, report_html
from tests.helpers.recorded_runs import short_run


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    """The report of a log of 0.4 s."""
    run = short_run()
    path = tmp_path_factory.mktemp("report") / "report.html"
    path.write_text(report_html(run, compute_metrics(run), {"replay": "replay.html"}))
    return path


def test_it_opens_from_disk_and_shows_every_plot(page, file, shot):
    requested = []
    page.on("request", lambda request: requested.append(request.url))
    page.goto(file.as_uri())
    page.wait_for_selector("body[data-shown]", timeout=60_000)
    figures = report_figures(short_run())
    plots = page.locator(".js-plotly-plot")
    assert plots.count() == len(figures) > 3
    for i, name in enumerate(figures):
        plot = plots.nth(i).locator(".main-svg").first
        box = plot.bounding_box()
        assert box["width"] > 400, name
        assert box["height"] > 200, name
    assert {url for url in requested if url.startswith("http")} == set()
    shot("report")


def test_a_plot_is_zoomed_and_says_what_is_under_the_mouse(page, file, shot):
    page.goto(file.as_uri())
    page.wait_for_selector("body[data-shown]", timeout=60_000)
    plot = page.locator(".js-plotly-plot").first
    plot.scroll_into_view_if_needed()
    seen = "document.querySelector('.js-plotly-plot')._fullLayout.xaxis.range"
    before = page.evaluate(seen)
    area = plot.locator(".nsewdrag").first.bounding_box()
    y = area["y"] + 0.5 * area["height"]
    page.mouse.move(area["x"] + 0.5 * area["width"], y)
    page.mouse.move(area["x"] + 0.55 * area["width"], y, steps=5)
    hover = "document.querySelector('.js-plotly-plot .hoverlayer').children.length > 0"
    page.wait_for_function(hover, timeout=10_000)
    shot("report_hover")
    page.mouse.move(area["x"] + 0.25 * area["width"], y)
    page.mouse.down()
    page.mouse.move(area["x"] + 0.75 * area["width"], y, steps=5)
    page.mouse.up()
    page.wait_for_timeout(500)
    after = page.evaluate(seen)
    assert after[1] - after[0] == pytest.approx(0.5 * (before[1] - before[0]), rel=0.1)
