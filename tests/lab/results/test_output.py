import json
import os
import shutil
import stat
import sys
import tempfile
from dataclasses import replace

import numpy as np
import pytest

from drake_linefoot.errors import LinefootError, OutputError
from drake_linefoot.lab.results import output
from drake_linefoot.lab.results.metrics import compute_metrics
from drake_linefoot.lab.results.output import (
    add_replay,
    check_output_dir,
    forget_unfinished,
    reserved,
    unfinished,
    write_outputs,
)
from drake_linefoot.lab.scenario import Segment
from drake_linefoot.lab.simulation.recording import CHANNELS, Run
from drake_linefoot.lab.visualization import replay
from tests.helpers.recorded_runs import leave_unfinished, make_run, short_run

SHOWN = ("velocity", "orientation", "wrenches", "torques", "contact", "pressure")
PLOTS = {f"{name}.png" for name in SHOWN}
FILES = {"report.html", "log.arrow", "log.mcap", "plots", "metrics.json"}
RUN = make_run(np.arange(11) * 1e-3)
AS_ROOT = os.geteuid() == 0  # who may write everywhere


@pytest.fixture(scope="module")
def run():
    return make_run(np.arange(101) * 1e-2)


@pytest.fixture
def no_plots(monkeypatch):
    from drake_linefoot.lab.results import plots_png, report

    monkeypatch.setattr(plots_png, "write_plots", lambda run, folder: [])
    monkeypatch.setattr(report, "report_html", lambda run, metrics, links: "")


def content(folder):
    return {path.name for path in folder.iterdir()}


def test_everything_is_written(run, tmp_path):
    target = tmp_path / "new" / "out"
    check_output_dir(target)
    write_outputs(run, target)
    assert content(target) == FILES
    assert content(target / "plots") == PLOTS
    assert json.loads((target / "metrics.json").read_text())["duration_s"] == 1.0
    assert Run.load(target / "log.arrow").scenario == run.scenario
    assert content(target.parent) == {"out"}
    assert stat.S_IMODE(target.stat().st_mode) == 0o777 & ~umask()


def umask():
    value = os.umask(0)
    os.umask(value)
    return value


def test_a_replay_is_added(tmp_path):
    run = short_run()
    metrics = write_outputs(run, tmp_path / "out", replay=True)
    assert content(tmp_path / "out") == FILES
    add_replay(run, metrics, tmp_path / "out")
    assert content(tmp_path / "out") == {"replay.html", *FILES}
    assert "StaticHtml" not in (tmp_path / "out/replay.html").read_text()
    assert '<a href="replay.html">' in (tmp_path / "out/report.html").read_text()


def test_a_replay_whose_process_dies_leaves_the_run_whole(run, tmp_path, monkeypatch):
    metrics = write_outputs(run, tmp_path / "out", replay=True)
    before = {p.name: p.stat().st_mtime_ns for p in (tmp_path / "out").iterdir()}
    dying = (sys.executable, "-c", "import os; os.abort()")
    monkeypatch.setattr(replay, "PROGRAM", dying)
    with pytest.raises(LinefootError, match=r"replay.html: not drawn: its process .* SIGABRT"):
        add_replay(run, metrics, tmp_path / "out")
    after = {p.name: p.stat().st_mtime_ns for p in (tmp_path / "out").iterdir()}
    assert {name for name in FILES if before[name] != after[name]} == {"report.html"}
    assert '<a href="replay.html">' not in (tmp_path / "out/report.html").read_text()


def test_a_name_with_dollars_is_drawn(tmp_path):
    segments = [Segment("to $4 \\frac{", 0.5), Segment("$x^{$", 0.5)]
    write_outputs(make_run(np.arange(101) * 1e-2, segments=segments), tmp_path / "out")
    assert content(tmp_path / "out") == FILES


def test_a_run_without_a_sample_leaves_its_log_and_its_reason(tmp_path):
    empty = make_run(np.arange(2) * 1e-2)
    empty = replace(empty, **{name: getattr(empty, name)[:0] for name in CHANNELS})
    empty = replace(empty, fell=True, fall_time=0.0, fall_reason="torque not finite")
    write_outputs(empty, tmp_path / "out")
    assert content(tmp_path / "out") == {"log.arrow", "metrics.json"}
    assert len(Run.load(tmp_path / "out").time) == 0
    metrics = json.loads((tmp_path / "out/metrics.json").read_text())
    assert metrics["fall_reason"] == "torque not finite"
    assert metrics.keys() == compute_metrics(make_run(np.arange(9.0))).keys()


def test_a_torque_that_is_not_a_number_is_no_reason_to_lose_the_run(tmp_path):
    torque = np.zeros((101, 18))
    torque[-1] = np.nan
    torque[60, 2] = -np.inf
    torque[50, 3] = -20.0
    metrics = write_outputs(make_run(np.arange(101) * 1e-2, torque=torque), tmp_path / "out")
    assert metrics["torque_max_ratio"] == 0.5
    assert content(tmp_path / "out") == FILES


def test_pictures_that_fail_do_not_take_the_data_with_them(run, tmp_path, monkeypatch):
    from drake_linefoot.lab.results import plots_png

    def fail(run, folder):
        raise ValueError("mathtext")

    monkeypatch.setattr(plots_png, "write_plots", fail)
    with pytest.raises(ValueError, match="mathtext"):
        write_outputs(run, tmp_path / "out")
    assert {"log.arrow", "metrics.json"} <= content(tmp_path / "out")
    assert Run.load(tmp_path / "out").scenario == run.scenario
    check_output_dir(tmp_path / "out")


@pytest.mark.usefixtures("no_plots")
def test_an_older_result_is_replaced_as_a_whole(run, tmp_path):
    write_outputs(run, tmp_path / "out")
    (tmp_path / "out/replay.html").write_text("old")
    check_output_dir(tmp_path / "out")
    write_outputs(run, tmp_path / "out")
    assert content(tmp_path / "out") == FILES
    assert content(tmp_path) == {"out"}


@pytest.mark.usefixtures("no_plots")
def test_an_empty_folder_and_a_link_to_a_folder_will_do(run, tmp_path):
    (tmp_path / "real").mkdir()
    (tmp_path / "link").symlink_to(tmp_path / "real")
    write_outputs(run, tmp_path / "link")
    assert (tmp_path / "link").is_symlink()
    assert "metrics.json" in content(tmp_path / "real")


def test_on_a_full_disk_the_old_result_stays_and_nothing_else(run, tmp_path, monkeypatch):
    from drake_linefoot.lab.results import plots_png

    monkeypatch.setattr(plots_png, "write_plots", lambda run, folder: [])
    write_outputs(run, tmp_path / "out")
    (tmp_path / "out/replay.html").write_text("old")
    before = {p.name: p.stat().st_mtime_ns for p in (tmp_path / "out").iterdir()}

    def fail(run, folder):
        (folder / "half.png").write_bytes(b"half")
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(plots_png, "write_plots", fail)
    with pytest.raises(OutputError):
        write_outputs(run, tmp_path / "out")
    assert {p.name: p.stat().st_mtime_ns for p in (tmp_path / "out").iterdir()} == before
    assert (tmp_path / "out" / "replay.html").read_text() == "old"
    assert content(tmp_path) == {"out"}


def test_what_is_interrupted_while_it_is_drawn_is_kept_without_pictures(run, tmp_path, monkeypatch):
    """As by a second Ctrl-C: the recording and its figures are safe first."""
    from drake_linefoot.lab.results import plots_png

    def interrupt(run, folder):
        (folder / "half.png").write_bytes(b"half")
        raise KeyboardInterrupt

    monkeypatch.setattr(plots_png, "write_plots", interrupt)
    with pytest.raises(KeyboardInterrupt):
        write_outputs(run, tmp_path / "out")
    assert content(tmp_path / "out") == {"log.arrow", "metrics.json"}
    np.testing.assert_array_equal(Run.load(tmp_path / "out").time, run.time)
    assert content(tmp_path) == {"out"}


@pytest.mark.usefixtures("no_plots")
def test_a_failure_of_the_very_last_move_gives_the_old_result_back(run, tmp_path, monkeypatch):
    write_outputs(run, tmp_path / "out")
    (tmp_path / "out/replay.html").write_text("old")
    rename, calls = os.rename, []

    def second_fails(source, target):
        calls.append(target)
        if len(calls) == 2:
            raise KeyboardInterrupt
        rename(source, target)

    monkeypatch.setattr(output.os, "rename", second_fails)
    with pytest.raises(KeyboardInterrupt):
        write_outputs(run, tmp_path / "out")
    assert (tmp_path / "out" / "replay.html").read_text() == "old"
    assert content(tmp_path) == {"out"}


def test_samples_of_a_run_are_beside_its_folder_until_it_is_written(tmp_path):
    out = tmp_path / "new" / "out"
    said = []
    with unfinished(out, said.append) as part:
        leave_unfinished(part, RUN, 11)
        assert content(tmp_path / "new") == {"out.part"}
    assert len(Run.load(out).time) == 11
    check_output_dir(out)
    with pytest.raises(LinefootError, match=r"^not built$"), unfinished(out, said.append) as part:
        raise LinefootError("not built")  # before there is a sample
    assert not part.exists()
    with unfinished(out, said.append) as part:  # one without a sample is removed
        assert content(part) == set()
        leave_unfinished(part, RUN, 0)
    assert content(tmp_path / "new") == {"out.old.part"}
    assert len(Run.load(tmp_path / "new" / "out.old").time) == 11
    shutil.rmtree(tmp_path / "new" / "out.old.part")
    with unfinished(out, said.append) as part:
        leave_unfinished(part, RUN, 11)
        metrics = write_outputs(Run.load(part), out)
        assert content(tmp_path / "new") == {"out", "out.part"}
        forget_unfinished(out)
    assert content(tmp_path / "new") == {"out"}
    assert metrics["duration_s"] == pytest.approx(0.01)
    assert said == [f"samples of a run that was never written are kept in {out}.old.part"]


def test_samples_that_nobody_has_written_never_go_without_a_word(tmp_path):
    said = []
    for n in (5, 7, 9):
        with unfinished(tmp_path / "out", said.append) as part:
            leave_unfinished(part, RUN, n)
        assert len(Run.load(tmp_path / "out").time) == n
    assert len(Run.load(tmp_path / "out.old").time) == 7
    assert len(said) == 2
    assert said[1].endswith("out.old.part, in place of those of another one")
    (tmp_path / "out.part" / "log.arrow").write_bytes(b"damaged")  # there may be some in it
    with unfinished(tmp_path / "out", said.append):
        pass
    assert (tmp_path / "out.old.part" / "log.arrow").read_bytes() == b"damaged"


@pytest.mark.parametrize("name", ["x" * 300, "loop/out", "loop"])
def test_a_path_that_is_none_is_refused(tmp_path, name):
    (tmp_path / "loop").symlink_to("loop")
    with pytest.raises(OutputError, match=name):
        check_output_dir(tmp_path / name)


@pytest.mark.usefixtures("no_plots")
@pytest.mark.parametrize("stored", [False, True])
def test_a_log_has_the_rate_that_is_asked_for_and_metrics_are_of_all_samples(tmp_path, stored):
    torque = np.zeros((101, 18))
    torque[77, 3] = 20.0  # in no sample that is kept
    run = make_run(np.arange(101) * 1e-3, torque=torque)
    if stored:
        leave_unfinished(tmp_path / "run.part", run, 101)
        run = Run.load(tmp_path / "run.part")
    metrics = write_outputs(run, tmp_path / "out", rate=90.0)
    again = Run.load(tmp_path / "out")
    np.testing.assert_array_equal(again.time, run.time[::11])
    np.testing.assert_array_equal(again.q, run.q[::11])
    assert metrics["torque_max_ratio"] == 0.5
    assert metrics["duration_s"] == pytest.approx(0.1)


def test_foreign_files_beside_it_are_never_replaced(tmp_path):
    (tmp_path / "out.part").mkdir()
    (tmp_path / "out.part" / "thesis.tex").write_text("mine")
    with pytest.raises(OutputError, match=r"out\.part: .*holds other files \(thesis\.tex\)"):
        check_output_dir(tmp_path / "out")
    with (
        pytest.raises(OutputError, match=r"holds other files"),
        unfinished(tmp_path / "out", print),
    ):
        pass
    assert content(tmp_path / "out.part") == {"thesis.tex"}


def test_foreign_files_are_never_replaced(run, tmp_path):
    (tmp_path / "thesis.tex").write_text("mine")
    for refuse in (check_output_dir, lambda path: write_outputs(run, path)):
        with pytest.raises(OutputError, match=r"holds other files \(thesis.tex\)"):
            refuse(tmp_path)
    assert content(tmp_path) == {"thesis.tex"}


@pytest.mark.parametrize("name", ["", "."])
def test_the_current_folder_is_never_replaced(run, tmp_path, monkeypatch, name):
    monkeypatch.chdir(tmp_path)
    for refuse in (check_output_dir, lambda path: write_outputs(run, path)):
        with pytest.raises(OutputError, match="is the current folder"):
            refuse(name)
    assert content(tmp_path) == set()


def test_two_runs_into_one_folder_are_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    (tmp_path / "link").symlink_to(tmp_path / "out")
    with reserved(tmp_path / "out"):
        for same in (tmp_path / "out", tmp_path / "link", tmp_path / "a" / ".." / "out"):
            with pytest.raises(OutputError, match="another run writes there"), reserved(same):
                pass
        with reserved(tmp_path / "other"):
            pass
    with reserved(tmp_path / "out"):
        pass


def test_a_file_in_the_way_is_refused(tmp_path):
    (tmp_path / "out").write_text("mine")
    with pytest.raises(OutputError, match="is a file"):
        check_output_dir(tmp_path / "out")
    with pytest.raises(LinefootError, match="out/deeper"):
        check_output_dir(tmp_path / "out" / "deeper")


@pytest.mark.skipif(AS_ROOT, reason="root may write everywhere")
def test_a_folder_without_permission_is_refused_early(tmp_path):
    tmp_path.chmod(0o500)
    try:
        with pytest.raises(OutputError, match="Permission denied"):
            check_output_dir(tmp_path / "out")
    finally:
        tmp_path.chmod(0o700)


def test_proc_is_refused_early():
    with pytest.raises(OutputError, match="/proc/out"):
        check_output_dir("/proc/out")


def test_checking_leaves_nothing_behind(tmp_path):
    check_output_dir(tmp_path / "a" / "b")
    assert content(tmp_path) == set()
