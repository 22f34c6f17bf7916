"""Two processes that compile into one folder: none waits for nothing, and none compiles twice."""

import subprocess
import sys

import pytest

from drake_linefoot.math.claims import FILE, TakenError, claims, shared

HOLD = """
import sys
from pathlib import Path
from drake_linefoot.math.claims import claims, shared
with shared(Path(sys.argv[1]), waits=True):
    for name in sys.argv[2:]:
        claims().take(name)
    print("held", flush=True)
    sys.stdin.readline()
    for name in sys.argv[2:]:
        claims().free(name)
    print("free", flush=True)
    sys.stdin.readline()
"""


@pytest.fixture
def other(tmp_path):
    """Start a process that claims functions until it gets a line."""
    started = []

    def start(*names):
        words = [sys.executable, "-c", HOLD, str(tmp_path), *names]
        process = subprocess.Popen(words, stdin=-1, stdout=-1, text=True)
        started.append(process)
        assert process.stdout.readline() == "held\n"
        return process

    yield start
    for process in started:
        process.kill()
        process.communicate()


def go_on(process):
    process.stdin.write("\n")
    process.stdin.flush()


def test_who_does_not_wait_leaves_out_what_another_process_compiles(other, tmp_path):
    process = other("a", "b")
    with shared(tmp_path, waits=False):
        with pytest.raises(TakenError):
            claims().take("a")
        assert not claims().take("c")
        claims().free("c")
        go_on(process)
        assert process.stdout.readline() == "free\n"
        assert not claims().take("a")


@pytest.mark.parametrize("waits", [True, False])
def test_who_has_begun_a_function_waits_for_what_it_calls(other, tmp_path, waits):
    process = other("inner")
    with shared(tmp_path, waits=waits):
        assert not claims().take("outer")
        go_on(process)
        claims().take("inner")  # returns
        claims().free_all()


def test_what_a_process_claimed_is_free_after_its_end(other, tmp_path):
    process = other("a")
    with shared(tmp_path, waits=False):
        process.kill()
        process.wait()
        assert not claims().take("a")
        assert not claims().take("a")  # its own


def test_nothing_is_left_behind_and_alone_there_are_no_claims(tmp_path):
    assert claims() is None
    with shared(None, waits=True):
        assert claims() is None
    with shared(tmp_path / "missing", waits=True):
        assert claims() is None
    with shared(tmp_path, waits=True):
        assert (tmp_path / FILE).exists()
    assert list(tmp_path.iterdir()) == []
