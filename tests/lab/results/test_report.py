"""The report of a run: opens from disk, shows every plot with its units, says a fall first."""

import base64
import gzip
import json
import re
from dataclasses import replace

import numpy as np
import pytest

from drake_linefoot.lab.results import metrics as metrics_module
from drake_linefoot.lab.results.metrics import compute_metrics
from drake_linefoot.lab.results.panels import thin
from drake_linefoot.lab.results.report import report_figures, report_html, velocity_rows, verdict
from drake_linefoot.lab.scenario import Segment
from drake_linefoot.lab.simulation.recording import CHANNELS
from tests.helpers.recorded_runs import make_run, short_run

TIME = np.arange(1001) * 1e-3
LINKS = {"replay": "replay.html", "log (Arrow)": "log.arrow"}


def page_of(run):
    return report_html(run, compute_metrics(run), LINKS)


def unpacked(page, name):
    """What the page keeps compressed under a name."""
    (packed,) = re.findall(rf'id="{name}">([A-Za-z0-9+/=]+)</script>', page)
    return gzip.decompress(base64.b64decode(packed)).decode()


def test_page_holds_library_figures_links_and_scenario():
    page = page_of(short_run())
    assert "Plotly" in unpacked(page, "library")
    figures = json.loads(unpacked(page, "figures"))
    assert len(figures) == 7
    assert all(f'<div id="{key}"></div>' in page for key in figures)
    assert all(figure["data"] and figure["layout"] for figure in figures.values())
    for target in LINKS.values():
        assert f'href="{target}"' in page
    assert "duration: 0.3" in page
    assert "largest slip of a foot" in page


def test_page_loads_nothing_and_is_of_modest_size():
    page = page_of(short_run())
    shell = re.sub(r'id="(library|figures)">[^<]+<', "", page)
    assert re.findall(r'https?:|src="(?!data:)|@import|<link', shell) == []
    assert len(page) < 4_000_000


def test_it_begins_with_what_came_of_the_run_and_a_picture():
    run = short_run()
    metrics = compute_metrics(run)
    page = report_html(run, metrics, LINKS)
    places = [page.index(s) for s in ("Stayed up for 0.4 s; ", "<img", "<table", "<details")]
    assert places == sorted(places)
    assert page.index("<details") < page.index("duration: 0.3")  # folded
    metrics["segments"] = [{**metrics["segments"][0], "error": [0.03, -0.04, 0.2]}]
    metrics |= {"slowed": [{"share": 0.25}], "solver_failures": {"mpc": 2, "wbc": 0}, "fell": True}
    said = "Fell after 0.4 s; followed its commands within 0.05 m/s and 0.2 rad/s; "
    assert verdict(metrics) == f"{said}slowed: 25% of the time; not always solved: MPC."


def test_each_cell_of_its_tables_of_velocities_has_one_number():
    rows = velocity_rows(compute_metrics(short_run()))
    assert {len(row) for row in rows} == {7}
    assert all(re.fullmatch(r"-?\d+\.\d\d|-", cell) for row in rows for cell in row[1:])


def test_same_run_gives_the_same_page():
    assert page_of(short_run()) == page_of(short_run())


def test_every_axis_has_a_name_and_a_unit():
    for figure in report_figures(short_run()).values():
        layout = figure.to_dict()["layout"]
        axes = {key: value for key, value in layout.items() if re.match(r"[xy]axis", key)}
        named = [a["title"]["text"] for a in axes.values() if "title" in a]
        hidden = [a for a in axes.values() if "title" not in a]
        assert all(re.search(r"\[[^\]]+\]$", name) for name in named), named
        assert all(a["showticklabels"] is False for a in hidden)  # of the panels above


def test_a_fall_is_said_at_the_top_and_marked():
    run = make_run(TIME, fell=True)
    page = page_of(replace(run, fall_reason="torso <low>"))
    before, _, _ = page.partition("<h2>")
    assert "The robot fell at 1.000 s: torso &lt;low&gt;" in before
    assert "robot fell" not in page_of(make_run(TIME))
    figure = report_figures(run)["Orientation of the torso"]
    lines = [s for s in figure.to_dict()["layout"]["shapes"] if s["type"] == "line"]
    assert [line["x0"] for line in lines] == [1.0] * 3


def test_segments_are_shaded_in_every_panel():
    run = make_run(TIME, segments=[Segment("stand <up>", 0.4), Segment("later", 1.0)])
    layout = report_figures(run)["Orientation of the torso"].to_dict()["layout"]
    spans = [(s["x0"], s["x1"]) for s in layout["shapes"] if s["type"] == "rect"]
    assert sorted(set(spans)) == [(0.0, 0.4), (0.4, 1.0)]
    assert len(spans) == 6


def test_flights_are_shaded_in_one_trace_of_each_panel():
    load = np.full((len(TIME), 2, 2), 60.0)
    load[400:460] = load[700:760] = 0.0
    run = make_run(TIME, true_normal=load, true_force=2.0 * load[..., [0, 0, 0]])
    shades = [
        t for t in report_figures(run)["Normal force of each foot"].data if t.name == "flight"
    ]
    assert len(shades) == 2
    for shade in shades:
        x = np.array(shade.x).reshape(2, 6)
        np.testing.assert_allclose(x[:, :5].min(axis=1), [0.4, 0.7])
        np.testing.assert_allclose(x[:, :5].max(axis=1), [0.46, 0.76])
    assert "flight" not in {
        t.name for t in report_figures(make_run(TIME))["Normal force of each foot"].data
    }


@pytest.mark.parametrize("length", [1, 2, 50])
def test_a_run_of_a_few_samples_has_a_report(length):
    run = short_run()
    part = {name: getattr(run, name)[:length] for name in CHANNELS}
    end = float(run.time[length - 1])
    short = replace(run, fell=True, fall_time=end, fall_reason="x", **part)
    assert "The robot fell" in page_of(short)


def test_a_controller_that_reports_nothing_has_a_report():
    run = make_run(TIME)
    names = ("mpc_wrench", "contact_wrench", "contact_flag", "reference_command", "mpc_ms")
    names += ("wbc_ms", "mpc_failures", "wbc_success", "reference_yaw")
    nothing = {name: np.full_like(getattr(run, name), np.nan) for name in names}
    assert len(page_of(make_run(TIME, **nothing))) > 1_000_000


def test_solver_failures_are_counted_and_marked():
    failures = np.zeros(len(TIME))
    failures[500:] = 2.0
    success = np.ones(len(TIME))
    success[[10, 20, 30]] = 0.0
    run = make_run(TIME, mpc_failures=failures, wbc_success=success)
    figure = report_figures(run)["Solver times and failures"]
    marks = {t.name: list(t.x) for t in figure.data if t.name.startswith("not solved")}
    assert marks == {"not solved (1)": [0.5], "not solved (3)": [0.01, 0.02, 0.03]}


def test_thinned_line_keeps_extremes_and_gaps():
    time = np.arange(10000) * 1e-3
    values = np.zeros(10000)
    values[[1234, 7777]] = 9.0, -9.0
    values[3000:4000] = np.nan
    x, y = thin(time, values, 100)
    assert len(x) == len(y) == 100
    assert (np.diff(x) >= 0.0).all()
    assert np.nanmax(y) == 9.0 and np.nanmin(y) == -9.0
    assert np.isnan(y[(x >= 3.0) & (x < 4.0)]).all()
    assert thin(time[:50], values[:50], 100)[0] is not None


def test_a_run_of_thousands_of_segments_is_drawn_and_listed_in_short(monkeypatch):
    """As a drive with a trembling stick makes them: each number is worked with once."""
    calls = []
    real = metrics_module.touchdowns
    monkeypatch.setattr(metrics_module, "touchdowns", lambda flags: calls.append(1) or real(flags))
    segments = [Segment(str(i + 1), 1e-3) for i in range(20_000)]
    run = make_run(TIME, segments=segments)
    metrics = compute_metrics(run)
    assert len(metrics["segments"]) == 20_000
    assert len(calls) <= 6  # however many segments
    layout = report_figures(run)["Solver times and failures"].to_dict()["layout"]
    shades = [s for s in layout["shapes"] if s["xref"] == "x"]
    assert len(shades) == len(layout["annotations"]) == 40
    assert (shades[0]["x0"], shades[-1]["x1"]) == (0.0, pytest.approx(1.0))
    assert layout["annotations"][1]["text"] == "26 to 50"
    rows = velocity_rows(metrics)
    assert rows[-1][0] == "19900 more in metrics.json"
    assert len(rows) == 101
