"""A run, a scenario and a loop at a prompt and in a notebook; channels as tables and lines."""

import sys
from xml.etree import ElementTree

import matplotlib.pyplot as plt
import numpy as np
import pytest

from drake_linefoot.errors import InputError, LinefootError
from drake_linefoot.lab.scenario import Scenario, Segment
from drake_linefoot.lab.simulation.recording import CHANNELS
from drake_linefoot.lab.wiring.closed_loop import build_closed_loop
from tests.helpers.recorded_runs import SHORT, make_run, short_run


@pytest.fixture
def pandas():
    return pytest.importorskip("pandas")


def test_what_is_shown_is_short_and_says_what_it_is():
    loop = build_closed_loop(SHORT)
    for thing, words in (
        (short_run(), ("Run of 'short'", "mit_humanoid", "upright", 'run.plot("com")')),
        (make_run(np.arange(3.0) / 10, fell=True), ("FELL: torso low",)),
        (SHORT, ("Scenario 'short'", "step 0.3 s [0.1, 0.0, 0.0]", "nothing else")),
        (loop, ("Closed loop of 'short'", "recorder", "18 motors")),
    ):
        text, html = repr(thing), thing._repr_html_()
        assert len(text) < 900 and len(text.splitlines()) <= 7
        cells = list(ElementTree.fromstring(html).itertext())
        for word in words:
            assert word in text and any(word in cell for cell in cells)


def test_a_table_keeps_its_units_in_parquet(pandas, tmp_path):
    short_run().to_pandas("com", "torque").to_parquet(tmp_path / "run.parquet")
    units = pandas.read_parquet(tmp_path / "run.parquet").attrs["units"]
    assert (units["com.x"], units["torque.left_knee"]) == ("m", "N m")


def test_a_scenario_shows_what_was_changed_and_html_is_escaped():
    scenario = Scenario(name="<b>", segments=[Segment()])
    scenario.gait.swing_height = 0.07
    assert "changed   gait" in repr(scenario)
    assert "&lt;b&gt;" in scenario._repr_html_()


def test_a_table_has_every_number_of_a_run_under_its_name(pandas):
    run = short_run()
    frame = run.to_pandas()
    assert frame.shape == (len(run.time), sum(run.sample(0)[n].size for n in CHANNELS) - 1)
    np.testing.assert_array_equal(frame.index, run.time)
    units = frame.attrs["units"]
    for column, values, unit in (
        ("com.y", run.com[:, 1], "m"),
        ("true_normal.right.heel", run.true_normal[:, 1, 0], "N"),
        ("torque.left_knee", run.torque[:, run.joint_names.index("left_knee")], "N m"),
        ("wbc_wrench.left.tau_z", run.wbc_wrench[:, 0, 4], "N m"),
        ("mode", run.mode, "-"),
    ):
        np.testing.assert_array_equal(frame[column], values)
        assert units[column] == unit
    assert list(run.to_pandas("rpy", "com").columns)[2:4] == ["rpy.yaw", "com.x"]


def test_a_channel_is_found_by_its_name_and_by_signal_and_part(pandas):
    """Every channel that is a part of a signal as it travels; `com` is `dynamics.p_WG`."""
    run = short_run()
    for name, part in (("com", "dynamics.p_WG"), ("wrench_error", "report.wrench_error")):
        np.testing.assert_array_equal(run[part], getattr(run, name))
        np.testing.assert_array_equal(run[name], run[part])
        assert run.unit(part) == run.unit(name)
        assert list(run.to_pandas(part).columns) == list(run.to_pandas(name, part).columns)
    sources = [f"{c.signal}.{c.attribute}" for c in CHANNELS.values() if c.attribute]
    assert len(sources) == len(set(sources)) > 20


def test_a_channel_that_is_none_is_refused_by_name():
    run = make_run(np.zeros(1))
    for look in (run.to_pandas, run.plot, run.unit, run.__getitem__):
        with pytest.raises(InputError, match=r"channel = 'speed': must be one of"):
            look("speed")


def test_without_pandas_it_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(LinefootError, match=r"pip install drake_linefoot\[pandas\]"):
        short_run().to_pandas("com")


def test_a_plot_has_a_line_for_each_number():
    run = short_run()
    figure, given = plt.subplots()
    axes = run.plot("com", "mode", axes=given)
    assert axes is given
    assert [line.get_label() for line in axes.lines] == ["com.x", "com.y", "com.z", "mode"]
    np.testing.assert_array_equal(axes.lines[2].get_ydata(), run.com[:, 2])
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("time [s]", "[m], [-]")
    own = run.plot("com")
    assert own.figure is not figure
    for each in (figure, own.figure):
        plt.close(each)
