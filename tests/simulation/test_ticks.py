from dataclasses import replace

import numpy as np
import pytest

from drake_linefoot.errors import SignalError
from drake_linefoot.robot.dynamics import robot_dynamics
from drake_linefoot.robot.humanoid import load_humanoid
from drake_linefoot.signals import GaitTargets, WholeBodyReport
from drake_linefoot.simulation.channels import MODES
from drake_linefoot.simulation.ticks import TickLayout
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


NUMBERS = {"wbc_success": 1.0, "dropped_rows": 3.0, "clipped_torques": 4.0, "wbc_ms": 0.5}


@pytest.fixture(scope="module")
def row():
    """Return a function that gives the row of a tick with a report."""
    humanoid = load_humanoid("mit_humanoid")
    dynamics = robot_dynamics(humanoid, humanoid.plant.CreateDefaultContext(), humanoid.x_nominal)
    layout = TickLayout(["torque"], {"dynamics": dynamics, "report": REPORT}, SIZES)

    def of(report):
        tick = layout.row(2.5, [np.full(SIZES["na"], 7.0)], [dynamics, report])
        (numbers,) = np.frombuffer(tick, layout.dtype)
        return numbers

    of.dynamics = dynamics
    return of


def test_every_number_of_a_row_is_in_the_place_of_its_name(row):
    tick, d = row(REPORT), row.dynamics
    assert tick["time"] == 2.5
    for name, value in NUMBERS.items():
        assert tick[name] == value, name
    arrays = {
        "q": d.q, "v": d.v, "com": d.p_WG, "p_WC": d.p_WC, "R_WC": d.R_WC,
        "torque": np.full(SIZES["na"], 7.0), "wbc_wrench": REPORT.wrench,
        "wrench_error": np.zeros((2, 5)), "acceleration_error": np.zeros(6),
    }  # fmt: skip
    assert set(tick.dtype.names) == {"time", *NUMBERS, *arrays}
    for name, values in arrays.items():
        np.testing.assert_array_equal(tick[name], values, err_msg=name)


def test_flags_mode_and_swing_foot_become_numbers():
    targets = GaitTargets(
        time=0.0, mode="swing", contact=(True, False), swing=None, foothold=np.arange(4.0),
        command=np.arange(3.0), yaw=0.1, slope=np.zeros(2), friction=1.0, grip=np.ones((2, 2)),
        external=np.arange(6.0), limited=3, steps=2, moved_footholds=3, clipped_commands=4,
    )  # fmt: skip
    layout = TickLayout([], {"targets": targets}, SIZES)
    (tick,) = np.frombuffer(layout.row(0.0, [], [targets]), layout.dtype)
    assert MODES[int(tick["mode"])] == "swing"
    np.testing.assert_array_equal(tick["planned_contact"], [1.0, 0.0])
    assert np.isnan(tick["swing_position"]).all()
    assert (tick["reference_yaw"], tick["gait_steps"]) == (0.1, 2.0)


@pytest.mark.parametrize(
    "wrench", [REPORT.wrench.T.copy().T, np.repeat(REPORT.wrench, 2, 1)[:, ::2]]
)
def test_an_array_that_is_laid_out_otherwise_is_recorded_as_what_it_says(row, wrench):
    assert not wrench.flags.c_contiguous
    np.testing.assert_array_equal(row(replace(REPORT, wrench=wrench)), row(REPORT))


@pytest.mark.parametrize("kind", [int, np.float32])
def test_numbers_that_are_no_doubles_are_refused(kind):
    report = replace(REPORT, wrench=REPORT.wrench.astype(kind))
    with pytest.raises(SignalError, match=r"recorder\.report: wbc_wrench is of (int|float32)"):
        TickLayout([], {"report": report}, SIZES)
