"""The journal: nothing is lost that was written, and nothing is counted twice."""

import json
import resource
import signal

import pytest

from drake_linefoot.errors import InputError, OutputError
from drake_linefoot.lab.sweep.journal import JOURNAL, open_journal
from tests.helpers.tiny_sweeps import made_up_row

HEADER = {"name": "a", "fingerprint": "0123", "made_with": {"code": "x", "drake": "1"}}


def filled(folder, n=3):
    with open_journal(folder, HEADER, fresh=False) as journal:
        for i in range(n):
            assert journal.add(made_up_row(index=i))
    return folder / JOURNAL


def rows_of(folder, header=HEADER, fresh=False):
    with open_journal(folder, header, fresh) as journal:
        return journal.rows


def test_rows_are_found_again(tmp_path):
    filled(tmp_path)
    assert rows_of(tmp_path) == {("low", i): made_up_row(index=i) for i in range(3)}


def test_run_counts_once(tmp_path):
    file = filled(tmp_path)
    with open_journal(tmp_path, HEADER, fresh=False) as journal:
        assert not journal.add(made_up_row(index=1, fell=True))
        assert journal.rows["low", 1]["fell"] is False
    again = json.dumps(made_up_row(index=1, fell=True)).encode() + b"\n"
    file.write_bytes(file.read_bytes() + again)
    assert rows_of(tmp_path)["low", 1]["fell"] is False


@pytest.mark.parametrize(("error", "n"), [(KeyboardInterrupt, 2), (OSError, 1)])
def test_row_that_was_written_counts_when_the_disk_is_interrupted(tmp_path, monkeypatch, error, n):
    def sync(file):
        raise error

    with open_journal(tmp_path, HEADER, fresh=False) as journal:
        journal.add(made_up_row(index=0))
        monkeypatch.setattr("drake_linefoot.lab.sweep.journal.os.fsync", sync)
        with pytest.raises(OutputError if error is OSError else error):
            journal.add(made_up_row(index=1))
        assert len(journal.rows) == n


def test_a_run_without_an_outcome_may_be_done_again(tmp_path):
    bad, good = made_up_row(error="hung"), made_up_row()
    with open_journal(tmp_path, HEADER, fresh=False) as journal:
        assert journal.add(bad)
        assert not journal.add(good)
    with open_journal(tmp_path, HEADER, fresh=False, retry=True) as journal:
        assert journal.rows == {}
    assert rows_of(tmp_path) == {("low", 0): bad}  # until it is
    with open_journal(tmp_path, HEADER, fresh=False, retry=True) as journal:
        assert journal.add(good)
    with open_journal(tmp_path, HEADER, fresh=False, retry=True) as journal:
        assert journal.rows == {("low", 0): good}
        assert not journal.add(bad)


def test_a_full_disk_leaves_no_half_row(tmp_path):
    file = filled(tmp_path, 3)
    whole = file.read_bytes()
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    old = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    try:
        with open_journal(tmp_path, HEADER, fresh=False) as journal:
            resource.setrlimit(resource.RLIMIT_FSIZE, (len(whole) + 100, before[1]))
            with pytest.raises(OutputError):  # the first 100 bytes were written
                journal.add(made_up_row(index=3))
            assert set(journal.rows) == {("low", i) for i in range(3)}
            resource.setrlimit(resource.RLIMIT_FSIZE, before)
            assert file.read_bytes() == whole
            assert journal.add(made_up_row(index=3))
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
        signal.signal(signal.SIGXFSZ, old)
    assert set(rows_of(tmp_path)) == {("low", i) for i in range(4)}


@pytest.mark.parametrize("cut", [1, 10, 200])
def test_half_written_line_is_dropped_and_the_next_row_follows(tmp_path, cut):
    file = filled(tmp_path)
    file.write_bytes(file.read_bytes()[:-cut])
    with open_journal(tmp_path, HEADER, fresh=False) as journal:
        assert set(journal.rows) == {("low", 0), ("low", 1)}
        journal.add(made_up_row(index=7))
    assert set(rows_of(tmp_path)) == {("low", 0), ("low", 1), ("low", 7)}


def test_half_written_header_is_a_beginning(tmp_path):
    (tmp_path / JOURNAL).write_bytes(b'{"name": "a", "finger')
    assert rows_of(tmp_path) == {}
    assert rows_of(tmp_path) == {}


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"fingerprint": "9876"}, "is of the sweep a (0123), not of a (9876); name another --out"),
        ({"name": "b"}, "is of the sweep a (0123), not of b (0123)"),
        ({"made_with": {"code": "y", "drake": "1"}}, "was made with code x instead of y; name"),
    ],
)
def test_journal_of_something_else_is_refused(tmp_path, change, said):
    filled(tmp_path)
    with pytest.raises(InputError) as refused:
        rows_of(tmp_path, {**HEADER, **change})
    assert said in str(refused.value)
    assert rows_of(tmp_path, {**HEADER, **change}, fresh=True) == {}


def test_damage_is_said(tmp_path):
    file = filled(tmp_path)
    lines = file.read_bytes().splitlines(keepends=True)
    file.write_bytes(b"".join([lines[0], b"nonsense\n", *lines[2:]]))
    with pytest.raises(InputError, match="is damaged"):
        rows_of(tmp_path)


def test_two_processes_do_not_write_to_one(tmp_path):
    with (
        open_journal(tmp_path, HEADER, fresh=False),
        pytest.raises(OutputError, match="another sweep is writing to it"),
    ):
        rows_of(tmp_path)
