from dataclasses import replace

import numpy as np
import pytest

from drake_linefoot.lab.results import plots
from drake_linefoot.lab.results.plots_png import draw, write_plots
from drake_linefoot.lab.scenario import Segment
from drake_linefoot.lab.simulation.recording import CHANNELS
from drake_linefoot.robot.humanoid import load_humanoid
from tests.helpers.recorded_runs import make_run, short_run

ALL = ["velocity", "orientation", "wrenches", "torques", "contact", "pressure"]
TIME = np.arange(1001) * 1e-3


def picture(run, name):
    return draw(run, plots.pictures(run)[name])


def png_size(file):
    head = file.read_bytes()[:24]
    assert head[:8] == b"\x89PNG\r\n\x1a\n"
    return int.from_bytes(head[16:20], "big"), int.from_bytes(head[20:24], "big")


def test_files_and_their_size(tmp_path):
    files = write_plots(short_run(), tmp_path)
    assert {file.stem for file in files} == set(ALL)
    assert {png_size(file) for file in files} == {(1200, 800)}


@pytest.mark.parametrize("name", ALL)
def test_axes_have_names_and_units_and_segments_are_named(name):
    figure = picture(short_run(), name)
    for ax in figure.axes:
        assert ax.get_ylabel().endswith("]"), ax.get_ylabel()
    assert "time [s]" in {ax.get_xlabel() for ax in figure.axes}
    texts = {text.get_text() for text in figure.axes[0].texts}
    assert {"stand", "step"} <= texts
    assert figure.legends


@pytest.mark.parametrize("name", ALL)
def test_a_fall_is_marked(name):
    run = make_run(TIME, fell=True, segments=[Segment("stand", 2.0), Segment("later", 1.0)])
    figure = picture(run, name)
    assert "fell at 1.00 s" in figure.get_suptitle()
    for ax in figure.axes:
        assert any(line.get_color() == plots.RED and line.get_lw() == 3.0 for line in ax.lines)
    assert "later" not in {text.get_text() for text in figure.axes[0].texts}


@pytest.mark.parametrize("length", [1, 2, 50])
def test_a_run_of_a_few_samples_is_plotted(tmp_path, length):
    run = short_run()
    part = {name: getattr(run, name)[:length] for name in CHANNELS}
    end = float(run.time[length - 1])
    fallen = replace(run, fell=True, fall_time=end, fall_reason="x", **part)
    assert all(file.stat().st_size for file in write_plots(fallen, tmp_path))


def test_a_controller_that_reports_nothing_is_plotted(tmp_path):
    names = ("mpc_wrench", "wbc_wrench", "contact_wrench", "contact_flag", "reference_command")
    run = make_run(TIME)
    nothing = {name: np.full_like(getattr(run, name), np.nan) for name in names}
    silent = make_run(TIME, **nothing, reference_yaw=np.full(len(TIME), np.nan))
    assert all(file.stat().st_size for file in write_plots(silent, tmp_path))


def test_torques_are_drawn_with_the_limits_of_their_joint():
    run = make_run(TIME)
    figure = picture(run, "torques")
    assert len(figure.axes) == 9
    heights = {line.get_ydata()[0] for line in figure.axes[3].lines if line.get_ls() == "--"}
    assert heights == {40.0, -40.0}
    assert figure.axes[3].get_ylabel() == "knee [N m]"


def test_left_and_right_are_those_of_the_robot(small_biped_files):
    """Whatever joints are called."""
    run = make_run(TIME)
    robot = str(small_biped_files["small biped"])
    humanoid = load_humanoid(robot)
    names = humanoid.description.actuated_joints
    run = replace(
        run,
        scenario=replace(run.scenario, robot=robot),
        joint_names=names,
        effort_limits=np.full(len(names), 150.0),
        torque=np.zeros((len(TIME), len(names))),
        q=np.zeros((len(TIME), humanoid.nq)),
        v=np.zeros((len(TIME), humanoid.nv)),
    )
    panels = plots.torques(run).panels
    assert [panel.label for panel in panels] == ["yaw L", "roll L", "pitch L", "knee L", "ankle L"]
    for panel in panels:
        assert [line.name for line in panel.lines[2:]] == ["left", "right"]


def test_flights_are_shaded_where_no_foot_bears():
    load = np.full((len(TIME), 2, 2), 60.0)
    load[400:, 0], load[:460, 1], load[700:, 1] = 0.0, 0.0, 0.0
    run = make_run(TIME, true_normal=load, true_force=2.0 * load[..., [0, 0, 0]])
    for name in ("wrenches", "contact"):
        for panel in plots.pictures(run)[name].panels:
            np.testing.assert_allclose(panel.flights, [[0.4, 0.46]])  # and one that does not end
        for ax in picture(run, name).axes:
            (bars,) = ax.collections
            (corners,) = [path.vertices[:, 0] for path in bars.get_paths()]
            assert [corners.min(), corners.max()] == pytest.approx([0.4, 0.46])
    assert not picture(make_run(TIME), "wrenches").axes[0].collections
