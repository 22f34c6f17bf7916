"""Trials of other code hold when the code of today finds the same."""

import json
import os
from dataclasses import dataclass

import pytest

from drake_linefoot.lab.results.provenance import made_with
from studies.common.trials import SAMPLE, Trials, kept

OTHER = {**made_with(), "lab": "other"}


@dataclass(frozen=True)
class Square:
    """A job whose row anybody knows."""

    number: int

    @property
    def key(self):
        return str(self.number)


def squared(job):
    return {"key": job.key, "square": job.number**2 / 3.0, "ways": (1, 2)}


def squared_otherwise(job):
    return squared(job) | {"square": job.number**2 / 3.0 + 1e-15}


def odd_otherwise(job):
    return squared_otherwise(job) if job.number % 2 else squared(job)


def parity(key):
    return "odd" if int(key) % 2 else "even"


def dying(job):
    os._exit(1)


def written(folder, jobs):
    file = folder / "trials.jsonl"
    rows = [squared(job) | {"seconds": 7.0} for job in jobs]
    file.write_text("".join(json.dumps(line) + "\n" for line in [OTHER, *rows]))
    return file


def over(jobs, file, tried):
    return Trials(file, tried, lost, limit, 1, parity).carried_over(jobs)


def test_they_hold_when_a_sample_is_the_same(tmp_path):
    jobs = [Square(number) for number in range(SAMPLE + 20)]
    file = written(tmp_path, jobs)
    rows = over([*jobs[5:], Square(999)], file, squared)
    assert list(rows) == [job.key for job in jobs]
    assert rows == kept(file, made_with())
    assert rows["6"] == {"key": "6", "square": 12.0, "ways": [1, 2], "seconds": 7.0}


@pytest.mark.parametrize("tried", [squared_otherwise, dying])
def test_they_do_not_when_one_differs_and_stay_where_they_are(tmp_path, tried):
    jobs = [Square(1), Square(2)]
    before = written(tmp_path, jobs).read_text()
    file = tmp_path / "trials.jsonl"
    assert over(jobs, file, tried) == {}
    assert file.read_text() == before


def test_those_of_a_kind_hold_when_another_kind_differs(tmp_path):
    jobs = [Square(number) for number in range(SAMPLE + 20)]
    file = written(tmp_path, jobs)
    rows = over(jobs, file, odd_otherwise)
    assert {*rows} == {job.key for job in jobs if job.number % 2 == 0}
    assert rows == kept(file, made_with())


def test_without_any_there_are_none(tmp_path):
    assert over([Square(1)], tmp_path / "none.jsonl", squared) == {}
    assert over([Square(1)], written(tmp_path, [Square(2)]), squared) == {}


def lost(job, error):
    return {"key": job.key, "lost": error}


def limit(_):
    return 60.0


def keys_after(jobs, file, fresh=False, walked=squared, also=()):
    """Begin a study, add rows that are known without a walk, go on; what was carried out."""
    trials = Trials(file, walked, lost, limit, 1)
    rows = trials.begun(jobs, fresh)
    rows |= {row["key"]: row for row in also}
    return [row["key"] for _, row in trials.carried_out(jobs, rows)]


def test_a_study_goes_on_with_what_holds(tmp_path):
    """Also where rows are known beforehand, which are not kept."""
    jobs, file = [Square(number) for number in range(4)], tmp_path / "new" / "trials.jsonl"
    assert keys_after(jobs[:3], file, also=[squared(Square(0))]) == ["1", "2"]
    assert set(kept(file, made_with())) == {"1", "2"}
    assert set(keys_after(jobs, file)) == {"0", "3"}
    assert set(keys_after(jobs, file, fresh=True)) == {"0", "1", "2", "3"}
    written(file.parent, jobs[:2])
    assert set(keys_after(jobs, file)) == {"2", "3"}, "others hold"
    written(file.parent, jobs[:2])
    assert len(keys_after(jobs, file, walked=squared_otherwise)) == 4
    assert kept(file, made_with())["1"]["square"] == 1 / 3.0 + 1e-15
