"""The journal: nothing is lost that was written, and nothing is counted twice."""

import resource
import signal
import sqlite3

import pytest

from drake_linefoot.errors import InputError, OutputError
from drake_linefoot.lab.sweep.journal import JOURNAL, OLDER, open_journal
from drake_linefoot.lab.sweep.rows import problem_of
from tests.helpers.tiny_sweeps import made_up_row

HEADER = {"name": "a", "fingerprint": "0123", "made_with": {"code": "x", "drake": "1"}}


def filled(folder, n=3):
    with open_journal(folder, HEADER, fresh=False) as journal:
        for i in range(n):
            assert journal.add(made_up_row(index=i))
    return folder / JOURNAL


def rows_of(folder, header=HEADER, fresh=False):
    with open_journal(folder, header, fresh) as journal:
        return journal.rows()


def refusal(folder, header=HEADER):
    with pytest.raises(InputError) as refused:
        rows_of(folder, header)
    message = str(refused.value)
    assert "\n" not in message
    assert message.endswith("name another --out, or --fresh")
    return message


def changed(file, *statements):
    """Change a journal as nobody should."""
    connection = sqlite3.connect(file)
    for statement in statements:
        connection.execute(statement)
    connection.commit()
    connection.close()


def test_rows_are_found_again(tmp_path):
    filled(tmp_path)
    assert rows_of(tmp_path) == [made_up_row(index=i) for i in range(3)]
    fallen = made_up_row("high", 0, True, sampled={"y": [1, {"z": None}], "w": "left"}, steps=2)
    with open_journal(tmp_path, HEADER, fresh=False) as journal:
        assert journal.add(fallen)
    assert rows_of(tmp_path)[0] == fallen


def test_run_counts_once(tmp_path):
    filled(tmp_path)
    with open_journal(tmp_path, HEADER, fresh=False) as journal:
        assert not journal.add(made_up_row(index=1, fell=True))
        assert [row["fell"] for row in journal.rows()] == [False] * 3


def test_a_run_without_an_outcome_may_be_done_again(tmp_path):
    bad, good = made_up_row(error="hung"), made_up_row()
    with open_journal(tmp_path, HEADER, fresh=False) as journal:
        assert journal.add(bad)
        assert journal.rows() == [bad]
        assert journal.add(good)
        assert not journal.add(bad)
    assert rows_of(tmp_path) == [good]


def test_it_can_be_read_while_it_grows(tmp_path):
    with open_journal(tmp_path, HEADER, fresh=False) as journal:
        reader = sqlite3.connect(f"file:{tmp_path / JOURNAL}?mode=ro", uri=True)
        for i in range(3):
            journal.add(made_up_row(index=i, fell=i == 1))
            found = reader.execute('SELECT "index", fell FROM runs').fetchall()
            assert found == [(k, k == 1) for k in range(i + 1)]
        reader.close()


def test_a_full_disk_leaves_no_half_row(tmp_path):
    file = filled(tmp_path, 3)
    whole = file.read_bytes()
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    old = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    large = made_up_row(index=3, sampled={"x": "a" * 10_000})
    try:
        with open_journal(tmp_path, HEADER, fresh=False) as journal:
            resource.setrlimit(resource.RLIMIT_FSIZE, (len(whole) + 100, before[1]))
            with pytest.raises(OutputError):
                journal.add(large)
            resource.setrlimit(resource.RLIMIT_FSIZE, before)
            assert len(journal.rows()) == 3
            assert journal.add(large)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
        signal.signal(signal.SIGXFSZ, old)
    assert len(rows_of(tmp_path)) == 4


def test_an_empty_file_is_a_beginning(tmp_path):
    (tmp_path / JOURNAL).touch()
    assert rows_of(tmp_path) == []
    assert rows_of(tmp_path) == []


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
    assert said in refusal(tmp_path, {**HEADER, **change})
    assert rows_of(tmp_path, {**HEADER, **change}, fresh=True) == []


def test_journal_of_an_older_version_is_refused(tmp_path):
    (tmp_path / OLDER).write_text('{"name": "a"}\n')
    assert "journal.jsonl: the journal is of an older version" in refusal(tmp_path)
    assert rows_of(tmp_path, fresh=True) == []
    assert not (tmp_path / OLDER).exists()


@pytest.mark.parametrize("way", ["text", "end", "middle", "tables", "header"])
def test_a_damaged_file_is_refused(tmp_path, way):
    file = filled(tmp_path, 40)
    content = file.read_bytes()
    if way == "text":
        file.write_bytes(b"nonsense" * 1000)
    elif way == "end":
        file.write_bytes(content[: len(content) // 2])
    elif way == "middle":
        middle = len(content) // 2
        file.write_bytes(content[:middle] + b"\xff" * 4096 + content[middle + 4096 :])
    elif way == "tables":
        changed(file, "DROP TABLE runs")
    else:
        changed(file, "UPDATE sweep SET made_with = '{'")
    assert "journal.sqlite: the journal is damaged: " in refusal(tmp_path)


@pytest.mark.parametrize(
    ("field", "value", "said"),
    [
        ("roll_max", "'[0.1]'", "run 1 of low: roll_max = '[0.1]' must be a number"),
        ("roll_max", "'x'", "run 1 of low: roll_max = 'x' must be a number"),
        ("roll_max", "9e999", "run 1 of low: roll_max = 'inf' must be a number"),
        ("steps", str(2**70), "run 1 of low: steps = '1.1805916207174113e+21' must be a whole"),
        ("fell", "7", "run 1 of low: fell = '7' must be a flag"),
        ("cause", "NULL", "run 1 of low: cause is missing"),
        ("worker", "x'07'", "run 1 of low: worker = "),
        ("sampled", "'[1]'", "run 1 of low: sampled must be values by dotted path"),
    ],
)
def test_a_value_of_the_wrong_kind_is_named(tmp_path, field, value, said):
    """In tables that take everything, as those of the journal do not."""
    changed(
        filled(tmp_path),
        "CREATE TABLE others AS SELECT * FROM runs",
        "DROP TABLE runs",
        "ALTER TABLE others RENAME TO runs",
        f'UPDATE runs SET "{field}" = {value} WHERE "index" = 1',
    )
    assert said in refusal(tmp_path)


@pytest.mark.parametrize("value", [2**53, 2**63 - 1, -(2**60)])
def test_a_whole_number_that_no_double_holds_is_named(value):
    """As a column without a type gives it."""
    said = problem_of({**made_up_row(), "speed_error": value})
    assert said == f"run 0 of low: speed_error = '{value}' must be a number"
    assert problem_of({**made_up_row(), "speed_error": 7}) == ""


@pytest.mark.parametrize(
    ("fell", "time", "said"), [("1", "NULL", "None"), ("0", "1.5", "1.5"), ("NULL", "1.5", "1.5")]
)
def test_a_fall_without_its_time_and_a_time_without_a_fall_are_named(tmp_path, fell, time, said):
    update = f'UPDATE runs SET fell = {fell}, fall_time = {time} WHERE "index" = 1'
    changed(filled(tmp_path), update)
    expected = "run 1 of low: fall_time = {} must be there for a fall, and for nothing else"
    assert expected.format(said) in refusal(tmp_path)


@pytest.mark.parametrize("name", ["cause", "speed_error", "fell", "worker_mb"])
def test_a_missing_field_is_named(tmp_path, name):
    file = filled(tmp_path)
    changed(file, f"ALTER TABLE runs DROP COLUMN {name}")
    assert f"run 0 of low: {name} is missing" in refusal(tmp_path)


def test_two_processes_do_not_write_to_one(tmp_path):
    with (
        open_journal(tmp_path, HEADER, fresh=False),
        pytest.raises(OutputError, match="another sweep is writing to it"),
    ):
        rows_of(tmp_path)
