import json
import os
import stat

import numpy as np
import pytest

from drake_linefoot.errors import LinefootError, OutputError
from drake_linefoot.results import output
from drake_linefoot.results.output import check_output_dir, write_outputs
from drake_linefoot.simulation.recording import Run
from tests.helpers.recorded_runs import make_run

PLOTS = {"velocity.png", "orientation.png", "wrenches.png", "torques.png", "contact.png"}
FILES = {"report.html", "log.npz", "log.mcap", "plots", "metrics.json"}
AS_ROOT = os.geteuid() == 0  # who may write everywhere


@pytest.fixture(scope="module")
def run():
    return make_run(np.arange(101) * 1e-2)


@pytest.fixture
def no_plots(monkeypatch):
    from drake_linefoot.results import plots_png, report

    monkeypatch.setattr(plots_png, "write_plots", lambda run, folder: [])
    monkeypatch.setattr(report, "report_html", lambda run, metrics, links: "")


def content(folder):
    return {path.name for path in folder.iterdir()}


def test_everything_is_written(run, tmp_path):
    target = tmp_path / "new" / "out"
    check_output_dir(target)
    write_outputs(run, "<html></html>", target)
    assert content(target) == {"replay.html", *FILES}
    assert content(target / "plots") == PLOTS
    assert json.loads((target / "metrics.json").read_text())["duration_s"] == 1.0
    assert Run.load(target / "log.npz").scenario == run.scenario
    assert content(target.parent) == {"out"}
    assert stat.S_IMODE(target.stat().st_mode) == 0o777 & ~umask()


def umask():
    value = os.umask(0)
    os.umask(value)
    return value


@pytest.mark.usefixtures("no_plots")
def test_without_a_replay_there_is_no_such_file(run, tmp_path):
    write_outputs(run, None, tmp_path / "out")
    assert content(tmp_path / "out") == FILES


@pytest.mark.usefixtures("no_plots")
def test_an_older_result_is_replaced_as_a_whole(run, tmp_path):
    write_outputs(run, "old", tmp_path / "out")
    check_output_dir(tmp_path / "out")
    write_outputs(run, None, tmp_path / "out")
    assert content(tmp_path / "out") == FILES
    assert content(tmp_path) == {"out"}


@pytest.mark.usefixtures("no_plots")
def test_an_empty_folder_and_a_link_to_a_folder_will_do(run, tmp_path):
    (tmp_path / "real").mkdir()
    (tmp_path / "link").symlink_to(tmp_path / "real")
    write_outputs(run, "x", tmp_path / "link")
    assert (tmp_path / "link").is_symlink()
    assert "metrics.json" in content(tmp_path / "real")


@pytest.mark.parametrize("error", [OSError(28, "No space left on device"), KeyboardInterrupt()])
def test_on_failure_the_old_result_stays_and_nothing_else(run, tmp_path, monkeypatch, error):
    from drake_linefoot.results import plots_png

    monkeypatch.setattr(plots_png, "write_plots", lambda run, folder: [])
    write_outputs(run, "old", tmp_path / "out")
    before = {p.name: p.stat().st_mtime_ns for p in (tmp_path / "out").iterdir()}

    def fail(run, folder):
        (folder / "half.png").write_bytes(b"half")
        raise error

    monkeypatch.setattr(plots_png, "write_plots", fail)
    with pytest.raises(KeyboardInterrupt if isinstance(error, KeyboardInterrupt) else OutputError):
        write_outputs(run, "new", tmp_path / "out")
    assert {p.name: p.stat().st_mtime_ns for p in (tmp_path / "out").iterdir()} == before
    assert (tmp_path / "out" / "replay.html").read_text() == "old"
    assert content(tmp_path) == {"out"}


@pytest.mark.usefixtures("no_plots")
def test_a_failure_of_the_very_last_move_gives_the_old_result_back(run, tmp_path, monkeypatch):
    write_outputs(run, "old", tmp_path / "out")
    rename, calls = os.rename, []

    def second_fails(source, target):
        calls.append(target)
        if len(calls) == 2:
            raise KeyboardInterrupt
        rename(source, target)

    monkeypatch.setattr(output.os, "rename", second_fails)
    with pytest.raises(KeyboardInterrupt):
        write_outputs(run, "new", tmp_path / "out")
    assert (tmp_path / "out" / "replay.html").read_text() == "old"
    assert content(tmp_path) == {"out"}


def test_foreign_files_are_never_replaced(run, tmp_path):
    (tmp_path / "thesis.tex").write_text("mine")
    for refuse in (check_output_dir, lambda path: write_outputs(run, "x", path)):
        with pytest.raises(OutputError, match=r"holds other files \(thesis.tex\)"):
            refuse(tmp_path)
    assert content(tmp_path) == {"thesis.tex"}


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
