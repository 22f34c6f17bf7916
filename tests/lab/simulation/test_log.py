"""A run on the disk as it comes: flat memory, and a log that survives its process."""

import os
import resource
import signal
import subprocess
import sys
import time as clock

import numpy as np
import pyarrow as pa
import pytest

from drake_linefoot.errors import InputError, OutputError
from drake_linefoot.lab.simulation import log as log_module
from drake_linefoot.lab.simulation import recorder as recorder_module
from drake_linefoot.lab.simulation.log import LogFile, read_log
from drake_linefoot.lab.simulation.recording import CHANNELS, LOG, WALL_TIMES, Run
from drake_linefoot.lab.simulation.run import keep_on_disk, run_so_far, simulate
from drake_linefoot.lab.wiring.closed_loop import build_closed_loop
from drake_linefoot.layout import Part
from tests.helpers.recorded_runs import SHORT, Limp, make_run, short_run

DTYPE = np.dtype([("time", "f8"), ("q", "f8", (25,)), ("points", "f8", (2, 2, 3))])
PARTS = {
    "time": Part("", "s"),
    "q": Part("", ("-", "m", "rad"), "nq", groups=(4, 3, 0)),
    "points": Part("", "m", 2, 2, 3),
}
FACTS = {"version": "1", "robot": "none"}


def random_rows(n):
    rows = np.empty(n, DTYPE)
    for name in DTYPE.names:
        rows[name] = np.random.default_rng(n).random(rows[name].shape)
    return rows


def begun(tmp_path):
    return LogFile(tmp_path / LOG, DTYPE, PARTS, FACTS)


def assert_holds(file, rows):
    log = read_log(file)
    assert log.count == len(rows)
    assert log.facts == FACTS
    for name in DTYPE.names:
        np.testing.assert_array_equal(log.channel(name), rows[name], err_msg=name)
    return log


def test_it_can_be_read_at_any_moment(tmp_path):
    rows, before = random_rows(250), 0
    log = begun(tmp_path)
    for n in (0, 1, 9, 10, 99, 250):
        log.append(rows[before:n])
        before = n
        assert assert_holds(log.path, rows[:n]).ended is None
    log.end({"fell": False})
    assert assert_holds(log.path, rows).ended == {"fell": False}


def test_pyarrow_and_pandas_read_it_without_us(tmp_path):
    log, rows = begun(tmp_path), random_rows(20)
    log.append(rows[:15])
    log.append(rows[15:])
    log.end({})
    stream = pa.ipc.open_stream(str(log.path))
    assert stream.schema.field("q").metadata[b"unit"] == b"-, m, rad"
    table = stream.read_all()
    np.testing.assert_array_equal(np.stack(table["q"].to_numpy()), rows["q"])
    np.testing.assert_array_equal(table.to_pandas()["time"], rows["time"])


def test_rows_that_were_cut_do_not_count(tmp_path):
    log = begun(tmp_path)
    log.append(random_rows(20))
    log.append(random_rows(7))
    log.cut(5)
    log.append(random_rows(3))
    assert_holds(log.path, np.concatenate([random_rows(20)[:5], random_rows(3)]))
    log.cut(6)
    log.end({})
    assert_holds(log.path, np.concatenate([random_rows(20)[:5], random_rows(3)[:1]]))


@pytest.mark.parametrize("share", [0.0, 0.1, 0.35, 0.5, 0.77, 0.999])
def test_a_log_that_is_cut_short_holds_what_is_whole(tmp_path, share):
    log, rows = begun(tmp_path), random_rows(100)
    beginning = log.path.stat().st_size
    for at in range(0, 100, 10):
        log.append(rows[at : at + 10])
    size = log.path.stat().st_size
    os.truncate(log.path, beginning + int(share * (size - beginning)))
    found = read_log(log.path)
    assert found.count % 10 == 0
    assert abs(found.count - 100 * share) <= 10
    np.testing.assert_array_equal(found.channel("q"), rows["q"][: found.count])


def test_a_disk_that_is_full_leaves_what_was_there(tmp_path):
    log = begun(tmp_path)
    log.append(random_rows(20))
    size = log.path.stat().st_size
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    handler = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size + 1000, before[1]))
    try:
        with pytest.raises(OutputError, match=r"log\.arrow: cannot be written"):
            log.append(random_rows(30))
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
        signal.signal(signal.SIGXFSZ, handler)
    assert_holds(log.path, random_rows(20))


def test_a_channel_of_one_piece_is_the_file_itself(tmp_path):
    log = begun(tmp_path)
    log.append(random_rows(20))
    q = read_log(log.path).channel("q")
    assert not q.flags.writeable
    assert not q.flags.owndata


def test_a_log_that_is_written_anew_leaves_a_run_that_was_read_alone(tmp_path):
    make_run(np.arange(101) * 1e-3).save(tmp_path / LOG)
    run = Run.load(tmp_path)
    q = run.q
    run.save(tmp_path / LOG, step=10)
    assert len(run.com) == len(q) == 101
    assert len(Run.load(tmp_path).com) == 11


@pytest.mark.parametrize("kept", [True, False])
def test_a_long_log_is_put_together_at_each_use(tmp_path, monkeypatch, kept):
    log = begun(tmp_path)
    for _ in range(2):
        log.append(random_rows(10))
    if not kept:
        monkeypatch.setattr(log_module, "LARGEST", 1000)
    found = read_log(log.path)
    assert (found.channel("q") is found.channel("q")) == kept


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
    run.save(tmp_path / "again")  # by any name
    again = Run.load(tmp_path / "again")
    for each in (run, Run.load(tmp_path), again):
        for name in CHANNELS:
            if name not in WALL_TIMES:
                values = getattr(each, name)
                np.testing.assert_array_equal(values, getattr(whole, name), err_msg=name)
    assert again.wall_seconds == run.wall_seconds


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
    (tmp_path / "walk").mkdir()
    make_run(np.arange(11) * 1e-3).save(tmp_path / "walk" / LOG)
    assert len(Run.load(tmp_path / "walk").time) == 11  # what has ended comes first
    assert len(Run.load(folder).time) == len(run.time)


@pytest.mark.parametrize("where", ["walk", "walk/log.npz"])
def test_a_run_of_an_older_version_is_refused_by_name(tmp_path, where):
    (tmp_path / "walk").mkdir()
    np.savez(tmp_path / "walk" / "log.npz", time=np.zeros(3))
    with pytest.raises(InputError, match=r"log\.npz: the recorded run is of version 0\.2\.0"):
        Run.load(tmp_path / where)


WALK = (sys.executable, "-m", "drake_linefoot", "walk", "stand", "--duration", "60", "--no-replay")


@pytest.mark.slow
def test_a_killed_run_can_be_read_up_to_its_last_second(tmp_path):
    out = tmp_path / "walk"
    process = subprocess.Popen([*WALK, "--out", str(out)], stdout=subprocess.DEVNULL)
    times = []
    while process.poll() is None and len(times) < 2:
        clock.sleep(0.2)
        part = out.with_name("walk.part") / LOG
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
    assert sorted(os.listdir(tmp_path)) == ["walk", "walk.old.part"]
