from dataclasses import replace

import numpy as np
import pytest

from drake_linefoot.errors import SignalError
from drake_linefoot.robot.dynamics import SharedDynamics
from drake_linefoot.robot.humanoid import load_humanoid
from drake_linefoot.signals import WholeBodyReport
from drake_linefoot.simulation.tick_batch import check_arrays, tick_row
from tests.helpers.recorded_runs import SIZES

REPORT = WholeBodyReport(
    torque=np.zeros(SIZES["na"]),
    wrench=np.arange(10.0).reshape(2, 5),
    wrench_error=np.zeros((2, 5)),
    acceleration_error=np.zeros(6),
    vdot=np.zeros(SIZES["nv"]),
    success=True,
    status="",
    dropped_rows=3,
    clipped=4,
    milliseconds=0.5,
)


@pytest.fixture(scope="module")
def row():
    """Return the numbers of a tick with a report."""
    humanoid = load_humanoid("mit_humanoid")
    x = humanoid.x_nominal
    dynamics = SharedDynamics(humanoid)(x)

    def of(report):
        return np.frombuffer(tick_row(2.5, x, dynamics, [], [("report", report)]))

    of.before, of.after = [*x, *dynamics.p_WG], [*dynamics.lines.ravel(), *dynamics.R_WC.ravel()]
    return of


def test_a_row_holds_numbers_then_arrays_in_order(row):
    arrays = np.r_[np.arange(10.0), np.zeros(16)]
    np.testing.assert_array_equal(
        row(REPORT), [2.5, 1.0, 3.0, 4.0, 0.5, *row.before, *arrays, *row.after]
    )


@pytest.mark.parametrize(
    "wrench", [REPORT.wrench.T.copy().T, np.repeat(REPORT.wrench, 2, 1)[:, ::2]]
)
def test_an_array_that_is_laid_out_otherwise_is_recorded_as_what_it_says(row, wrench):
    assert not wrench.flags.c_contiguous
    np.testing.assert_array_equal(row(replace(REPORT, wrench=wrench)), row(REPORT))


@pytest.mark.parametrize("kind", [int, np.float32])
def test_numbers_that_are_no_doubles_are_refused(kind):
    check_arrays([("report", REPORT)])
    report = replace(REPORT, wrench=REPORT.wrench.astype(kind))
    with pytest.raises(SignalError, match=r"recorder\.report: wbc_wrench is of (int|float32)"):
        check_arrays([("report", report)])
