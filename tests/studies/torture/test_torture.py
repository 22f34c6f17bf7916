"""A small part of the torture, and that it notices what is wrong."""

import numpy as np
import pytest

from drake_linefoot.errors import InputError
from studies.torture import bad_inputs as module
from studies.torture.bad_inputs import KINDS, bad_inputs
from studies.torture.faults import remains
from studies.torture.torture import page, trials


@pytest.mark.parametrize("kind", KINDS)
def test_odd_files_are_taken_or_refused(tmp_path, kind):
    tally = bad_inputs(kind, 40, 0, tmp_path)
    assert tally.wrong == []
    assert tally.ends.total() == 40
    assert tally.ends["refused"] > 10  # most are bad indeed
    assert set(tally.ends) <= {"taken", "refused"}


def break_down(file):
    raise KeyError("gait")


def exit_of_drake(file):
    raise SystemExit("assertion")


def refuse_at_length(file):
    raise InputError(file, "gait", "x", "must be\none of " + "many " * 1000)


@pytest.mark.parametrize("load", [break_down, exit_of_drake, refuse_at_length])
def test_what_is_wrong_is_noticed(tmp_path, monkeypatch, load):
    make = KINDS["sweeps"][0]
    monkeypatch.setitem(module.KINDS, "sweeps", (make, load, 5))
    tally = bad_inputs("sweeps", 5, 0, tmp_path)
    assert len(tally.wrong) == 5
    text = page([tally], 7, 1.0)
    assert "| sweeps | 5 | 5 " in text and "| 5 |" in text and tally.wrong[0] in text


def test_files_of_a_seed_are_the_same_every_time(tmp_path):
    for make, _, _ in KINDS.values():
        first, again = (make(np.random.default_rng(5), tmp_path).read_bytes() for _ in range(2))
        assert first == again


def test_a_half_written_result_is_noticed(tmp_path):
    assert remains(tmp_path / "none", "linefoot: interrupted") == ""
    assert "traceback" in remains(tmp_path / "none", "Traceback (most recent call last):\n\nX\n")
    (tmp_path / "log.npz").write_bytes(b"half")
    assert "half-written" in remains(tmp_path, "")


def test_everything_is_tried(tmp_path):
    counts = [kind[2] for kind in KINDS.values()]
    assert sum(counts) >= 10_000
    assert len(trials(0, 1.0, tmp_path)) == 2 * len(KINDS) + 2
