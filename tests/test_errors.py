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
