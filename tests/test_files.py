"""What killed processes leave: cleaned or adopted, but never that of a process that lives."""

import os
import signal
import subprocess
import sys

import pytest

from drake_linefoot.files import scratch_folder, write_file
from drake_linefoot.lab.results import output
from drake_linefoot.lab.results.output import write_outputs
from tests.helpers.recorded_runs import short_run

HOLD = """
import sys, time
from pathlib import Path
from drake_linefoot.files import scratch_folder
with scratch_folder(Path(sys.argv[1]), ".out-", lambda folder: None) as scratch:
    (scratch / "new").mkdir()
    print(scratch, flush=True)
    time.sleep(600)
"""


def names(folder):
    return sorted(path.name for path in folder.iterdir())


def nothing(folder):
    pass


def test_scratch_of_a_killed_process_is_removed_and_of_a_living_one_is_not(tmp_path):
    process = subprocess.Popen(
        [sys.executable, "-c", HOLD, tmp_path], stdout=subprocess.PIPE, text=True
    )
    held = process.stdout.readline().strip()
    mine = tmp_path / ".out-abcdefgh"
    mine.mkdir()
    (mine / "diary.txt").touch()
    (tmp_path / ".out-notes").mkdir()
    for alive in (True, False):
        with scratch_folder(tmp_path, ".out-", nothing) as scratch:
            assert scratch.is_dir()
            assert os.path.exists(held) is alive
        assert not scratch.exists()
        process.send_signal(signal.SIGKILL)
        process.wait()
        process.stdout.close()
    assert names(tmp_path) == [".out-abcdefgh", ".out-notes"]


def test_a_file_is_written_beside_what_a_killed_process_left(tmp_path):
    left = tmp_path / ".linefoot-abcdefgh"
    left.mkdir()
    (left / "new").write_text("half")
    write_file(tmp_path / "a.txt", b"whole")
    assert names(tmp_path) == ["a.txt"]


@pytest.mark.parametrize(("new", "kept"), [(True, "after"), (False, "before")])
def test_a_result_that_was_not_put_in_its_place_is_put_there(tmp_path, new, kept):
    """A process that was killed between the two renames."""
    left, target = tmp_path / ".out-abcdefgh", tmp_path / "out"
    for name, content in (("old", "before"), *((("new", "after"),) if new else ())):
        (left / name).mkdir(parents=True)
        (left / name / "metrics.json").write_text(content)
    with scratch_folder(tmp_path, ".out-", lambda folder: output._adopt(target, folder)):
        pass
    assert names(tmp_path) == ["out"]
    assert (target / "metrics.json").read_text() == kept


def test_a_result_takes_the_place_of_one_that_a_killed_process_has_half_written(tmp_path):
    (tmp_path / ".out-abcdefgh" / "new").mkdir(parents=True)
    (tmp_path / ".out-abcdefgh" / "new" / "log.arrow").write_bytes(b"half")
    write_outputs(short_run(), tmp_path / "out")
    assert names(tmp_path) == ["out"]
