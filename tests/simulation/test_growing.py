"""Samples that go to the disk as they come: flat memory, and a log that survives its process."""

import os
import resource
import signal
import subprocess
import sys
import time as clock
import zipfile

import numpy as np
import pytest

from drake_linefoot.errors import InputError, OutputError
from drake_linefoot.simulation import recorder as recorder_module
from drake_linefoot.simulation import recording
from drake_linefoot.simulation.growing import GrowingArrays
from drake_linefoot.simulation.recording import CHANNELS, SAMPLES, WALL_TIMES, Run
from drake_linefoot.simulation.run import keep_on_disk, run_so_far, simulate
from drake_linefoot.wiring.closed_loop import build_closed_loop
from tests.helpers.recorded_runs import SHORT, Limp, make_run, short_run

DTYPE = np.dtype([("time", "f8"), ("q", "f8", (25,)), ("points", "f8", (2, 2, 3))])


def random_rows(n):
    rows = np.empty(n, DTYPE)
    for name in DTYPE.names:
        rows[name] = np.random.default_rng(n).random(rows[name].shape)
    return rows


def test_the_files_are_those_that_numpy_saves_at_any_moment(tmp_path):
    rows, before = random_rows(250), 0
    grown = GrowingArrays(tmp_path / "log", DTYPE, {"version": "1"})
    for n in (0, 1, 9, 10, 99, 250):
        if n > before:
            grown.append(rows[before:n])
        before = n
        for name in DTYPE.names:
            np.save(tmp_path / "whole.npy", rows[name][:n])
            whole = (tmp_path / "whole.npy").read_bytes()
            assert (tmp_path / "log" / f"{name}.npy").read_bytes() == whole
            np.testing.assert_array_equal(grown.arrays()[name].read(), rows[name][:n])
    assert str(np.load(tmp_path / "log/version.npy")) == "1"


def test_the_folder_is_there_once_it_has_every_file(tmp_path, monkeypatch):
    seen, save = [], np.save

    def looked_at(*arguments, **named):
        seen.append((tmp_path / "log").exists())
        save(*arguments, **named)

    monkeypatch.setattr(np, "save", looked_at)
    GrowingArrays(tmp_path / "log", DTYPE, {"version": "1"})
    assert seen == [False]
    assert sorted(os.listdir(tmp_path)) == ["log"]
    found = {file.stem for file in (tmp_path / "log").iterdir()}
    assert found == {"version", *DTYPE.names}


def test_rows_that_were_cut_are_written_over(tmp_path):
    grown = GrowingArrays(tmp_path / "log", DTYPE, {})
    grown.append(random_rows(20))
    grown.cut(5)
    grown.append(random_rows(3))
    expected = np.concatenate([random_rows(20)[:5], random_rows(3)])
    for name in DTYPE.names:
        np.testing.assert_array_equal(grown.arrays()[name].read(), expected[name])


def test_a_disk_that_is_full_leaves_what_was_there(tmp_path):
    grown = GrowingArrays(tmp_path / "log", DTYPE, {})
    grown.append(random_rows(20))
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    handler = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (5000, before[1]))
    try:
        with pytest.raises(OutputError, match=r"log: cannot be written: File too large"):
            grown.append(random_rows(30))
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
        signal.signal(signal.SIGXFSZ, handler)
    for name in DTYPE.names:
        np.testing.assert_array_equal(grown.arrays()[name].read(), random_rows(20)[name])
        # One that was written before the disk was full may have more, see Run.load.
        again = np.load(tmp_path / "log" / f"{name}.npy")
        np.testing.assert_array_equal(again[:20], random_rows(20)[name])


@pytest.fixture
def small_pieces(monkeypatch):
    """Let samples go to the disk by twenties, and stay in memory by hundreds."""
    for name, count in (("_BATCH", 10), ("_TO_DISK", 0.02), ("_IN_MEMORY", 100)):
        monkeypatch.setattr(recorder_module, name, count)


@pytest.mark.usefixtures("small_pieces")
def test_a_run_from_the_disk_is_the_run_from_memory_and_so_is_its_file(tmp_path):
    loop = build_closed_loop(SHORT)
    keep_on_disk(loop, tmp_path)
    run, whole = simulate(loop), short_run()
    assert len(loop.recorder.samples("time")) < 130
    for each in (run, Run.load(tmp_path)):
        for name in CHANNELS:
            if name not in WALL_TIMES:
                values = getattr(each, name)
                np.testing.assert_array_equal(values, getattr(whole, name), err_msg=name)
    run.save(tmp_path / "log.npz")
    with np.load(tmp_path / "log.npz") as stored:
        assert stored.files == list(np.load(saved(whole, tmp_path / "whole.npz")))
        np.testing.assert_array_equal(stored["q"], whole.q)
    assert Run.load(tmp_path / "log.npz").wall_seconds == run.wall_seconds


def saved(run, path):
    run.save(path)
    return path


@pytest.mark.usefixtures("small_pieces")
def test_going_back_in_time_drops_what_is_not_past_on_the_disk_too(tmp_path):
    loop = build_closed_loop(SHORT, controller=Limp())
    keep_on_disk(loop, tmp_path)
    for end in (0.3, 0.05):
        simulator = loop.make_simulator()
        simulator.AdvanceTo(end)
    run = run_so_far(loop)
    np.testing.assert_allclose(run.time, np.arange(51) * 1e-3, atol=1e-12)
    assert loop.recorder.count == 51
    other = build_closed_loop(SHORT, controller=Limp())
    other.recorder.go_on_from(loop.recorder)
    assert other.recorder.count == 51
    other.make_simulator().AdvanceTo(0.07)
    # The other loop's simulator begins at 0, so what it took over is not past any more.
    np.testing.assert_allclose(run_so_far(other).time, np.arange(71) * 1e-3, atol=1e-12)


@pytest.mark.usefixtures("small_pieces")
def test_a_run_that_has_not_ended_is_read_where_its_folder_will_be(tmp_path):
    folder = tmp_path / "walk.part"
    folder.mkdir()
    loop = build_closed_loop(SHORT, controller=Limp())
    keep_on_disk(loop, folder)
    assert len(Run.load(tmp_path / "walk").time) == 0
    loop.make_simulator().AdvanceTo(0.1)
    run = Run.load(tmp_path / "walk")
    assert 0.06 < run.time[-1] <= 0.1
    assert (run.fell, run.fall_time, run.wall_seconds) == (False, None, run.time[-1])
    assert run.scenario == SHORT
    make_run(np.arange(11) * 1e-3).save(saved_in(tmp_path / "walk"))
    assert len(Run.load(tmp_path / "walk").time) == 11  # what has ended comes first
    assert len(Run.load(folder).time) == len(run.time)


def saved_in(folder):
    folder.mkdir()
    return folder / "log.npz"


@pytest.mark.usefixtures("small_pieces")
@pytest.mark.parametrize("damage", ["shorter", "missing", "text", "folder"])
def test_damaged_samples_are_refused_or_cut(tmp_path, damage):
    loop = build_closed_loop(SHORT, controller=Limp())
    keep_on_disk(loop, tmp_path)
    loop.make_simulator().AdvanceTo(0.3)
    file = tmp_path / SAMPLES / "v.npy"
    if damage == "shorter":  # a process that was killed between two headers
        np.save(file, np.load(file)[:100])
        assert len(Run.load(tmp_path).time) == len(Run.load(tmp_path).q) == 100
        return
    file.unlink()
    if damage == "text":
        file.write_text("nonsense")
    elif damage == "folder":
        file.mkdir()
    with pytest.raises(InputError, match=r"log: the recorded run (lacks v|cannot be read)"):
        Run.load(tmp_path)


def test_a_long_log_stays_on_the_disk(tmp_path, monkeypatch):
    monkeypatch.setattr(recording, "LARGEST", 1000)
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    run = make_run(np.arange(11) * 1e-3)
    again = Run.load(saved(run, tmp_path / "log.npz"))
    (scratch,) = tmp_path.glob("linefoot-*")
    assert not again.q.flags.writeable
    assert again.q is not again.q  # mapped at each use
    for name in CHANNELS:
        np.testing.assert_array_equal(getattr(again, name), getattr(run, name), err_msg=name)
    del again
    assert not scratch.exists()
    damaged = bytearray((tmp_path / "log.npz").read_bytes())
    with zipfile.ZipFile(tmp_path / "log.npz") as log:
        damaged[log.getinfo("q.npy").header_offset + 200] ^= 1  # behind the header: of its data
    (tmp_path / "log.npz").write_bytes(damaged)
    with pytest.raises(InputError, match=r"log\.npz"):
        Run.load(tmp_path / "log.npz")
    assert not list(tmp_path.glob("linefoot-*"))


WALK = (sys.executable, "-m", "drake_linefoot", "walk", "stand", "--duration", "60", "--no-replay")


@pytest.mark.slow
def test_a_killed_run_can_be_read_up_to_its_last_second(tmp_path):
    out = tmp_path / "walk"
    process = subprocess.Popen([*WALK, "--out", str(out)], stdout=subprocess.DEVNULL)
    times = []
    while process.poll() is None and len(times) < 2:
        clock.sleep(0.2)
        part = out.with_name("walk.part") / SAMPLES / "wall_seconds.npy"
        if part.exists() and len(time := Run.load(out).time) and time[-1] > max([1.0, *times]):
            times.append(time[-1])
    process.send_signal(signal.SIGKILL)
    process.wait()
    run = Run.load(out)
    assert times[0] < times[1] <= run.time[-1] < 60.0
    assert np.isfinite(run.q).all()
    log = subprocess.run(
        [*WALK[:3], "log", str(out)], capture_output=True, text=True, check=True
    ).stdout
    assert f"{run.time[-1]:.3f} s" in log
    assert os.listdir(tmp_path) == ["walk.part"]
    again = (*WALK[:4], "stand", "--duration", "0.1", "--no-replay", "--out", str(out))
    subprocess.run(again, check=True, stdout=subprocess.DEVNULL)
    assert os.listdir(tmp_path) == ["walk"]
