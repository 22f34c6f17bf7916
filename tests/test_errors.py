"""Errors go from one process to another as they are."""

import pickle
from pathlib import Path

import pytest

from drake_linefoot.errors import (
    EstimateError,
    InputError,
    MissingPackageError,
    ModelError,
    OutputError,
    ScenarioError,
    SignalError,
    SolverError,
    legible,
)
from studies.common.pool import carry_out

ERRORS = [
    InputError(Path("a.yaml"), "gait.step_width", -1.0, "must be above 0"),
    ScenarioError("--vx", "", float("inf"), "must be finite"),
    ModelError(Path("robot.yaml"), "", "robot", "is missing"),
    SignalError("mpc.dynamics", "element 3 is nan"),
    SolverError("mpc", "kInfeasible"),
    EstimateError("lost"),
    OutputError("out/walk", "no space left"),
    MissingPackageError("drake_linefoot.walk", "pyarrow"),
]


@pytest.mark.parametrize("error", ERRORS, ids=lambda error: type(error).__name__)
def test_error_is_the_same_in_another_process(error):
    again = pickle.loads(pickle.dumps(error))
    assert type(again) is type(error)
    assert (str(again), vars(again)) == (str(error), vars(error))


def refuse(index):
    raise ERRORS[index]


def test_what_a_worker_refuses_is_said():
    """It was 'a worker process died', whatever the worker had to say."""
    with pytest.raises(InputError, match=r"a\.yaml: gait\.step_width = -1\.0: must be above 0"):
        carry_out(refuse, [0], lambda *_: None)


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("a name", "a name"),
        ("é ü 漢", "é ü 漢"),
        ("\x1b]0;pwned\a\x1b[2J", r"\x1b]0;pwned\x07\x1b[2J"),
        ("a\r\n\tb", "a b"),
        ("\u202eabc\u200b", r"\u202eabc\u200b"),
        ("\ud800", r"\ud800"),
        ("x" * 100_000, "x" * 200 + "..."),
        ("\x1b" * 100_000, None),
        (" " * 100_000 + "x", None),
    ],
)
def test_texts_of_others_are_one_short_line_that_moves_no_cursor(text, shown):
    line = legible(text)
    assert line == shown or shown is None
    assert line.isprintable()
    assert len(line) < 1300


def test_an_error_is_one_short_line_whatever_it_is_of():
    nasty = "\x1b[2J\n" + "x" * 100_000
    for error in (
        InputError(nasty, nasty, nasty, nasty),
        InputError(Path("a.yaml"), "", nasty, nasty),
        ModelError("robot", "model", [nasty], nasty),
    ):
        assert str(error).isprintable()
        assert len(str(error)) < 2500
