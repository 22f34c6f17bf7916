"""What the recorder makes of signals: a tick in its channels, and the numbers of n samples."""

import numpy as np
import pytest

from drake_linefoot.axes import WRENCH
from drake_linefoot.lab.simulation.channels import MODES, Channel, part
from drake_linefoot.lab.simulation.recorder import dtype_of, rows_of
from drake_linefoot.lab.simulation.recording import CHANNELS
from drake_linefoot.layout import flat, parts_of
from drake_linefoot.robot.dynamics import robot_dynamics
from drake_linefoot.signals import SIGNALS, GaitTargets, WholeBodyReport, layouts
from drake_linefoot.statuses import Limit, Solved
from tests.helpers.recorded_runs import SIZES

KNOTS = 9
LAYOUTS = layouts(SIZES, KNOTS)
REPORT = WholeBodyReport(
    torque=np.zeros(SIZES["na"]),
    wrench=np.arange(10.0).reshape(2, 5),
    wrench_error=-np.arange(10.0).reshape(2, 5),
    acceleration_error=np.arange(6.0),
    vdot=np.zeros(SIZES["nv"]),
    status=float(Solved.ACTIVE_SET),
    active=2.0,
    dropped_rows=3.0,
    clipped=4.0,
    milliseconds=0.5,
)
TARGETS = GaitTargets(
    time=0.0, contact=np.array([1.0, 0.0]), touchdown=np.array([-0.1, 0.1]), queued=1e9,
    swings=np.array([0.0, 1.0]),
    swing=np.arange(36.0).reshape(2, 6, 3), foothold=np.arange(8.0).reshape(2, 4),
    command=np.arange(3.0), yaw=0.1, slope=np.zeros((2, 2)), friction=0.7,
    friction_share=np.ones((2, 2)), external=np.arange(6.0), arms=np.zeros(3),
    limited=float(Limit.UNEVEN), steps=2.0, moved_footholds=3.0, clipped_commands=4.0,
)  # fmt: skip


def written(**signals):
    """The rows of ticks, each signal given as a list of the vectors on its port."""
    ticks = {"time": 2.5 + np.arange(len(next(iter(signals.values()))))}
    for name, vectors in signals.items():
        values = np.stack(vectors)
        ticks[name] = values.view(LAYOUTS[name].dtype)[:, 0] if name in LAYOUTS else values
    return rows_of(ticks, dtype_of(CHANNELS, SIZES))


@pytest.fixture(scope="module")
def dynamics(humanoid, walking_state):
    """Of a robot at two places."""
    context = humanoid.plant.CreateDefaultContext()
    return [robot_dynamics(humanoid, context, walking_state(humanoid, seed)) for seed in (1, 2)]


def test_every_number_of_a_tick_is_in_the_channel_of_its_name(dynamics):
    reports = [REPORT, REPORT._replace(wrench=2.0 * REPORT.wrench, status=float(Solved.FAILED))]
    torques = [np.full(SIZES["na"], 7.0), np.full(SIZES["na"], 8.0)]
    rows = written(
        torque=torques, dynamics=[flat(d) for d in dynamics], report=[flat(r) for r in reports]
    )
    for row, d, report, torque, time in zip(
        rows, dynamics, reports, torques, (2.5, 3.5), strict=True
    ):
        values = {
            "time": time, "q": d.q, "v": d.v, "com": d.p_WG,
            "torque": torque, "push": np.zeros(3),
            "wbc_wrench": report.wrench, "wrench_error": REPORT.wrench_error,
            "acceleration_error": REPORT.acceleration_error,
            "wbc_success": float(report is REPORT), "dropped_rows": 3.0,
            "clipped_torques": 4.0, "wbc_ms": 0.5,
        }  # fmt: skip
        for name in CHANNELS:  # the others are left alone
            expected = values.get(name, np.full(row[name].shape, np.nan))
            np.testing.assert_array_equal(row[name], expected, err_msg=name)


def test_flags_mode_and_swing_foot_become_numbers(dynamics):
    standing = TARGETS._replace(
        contact=np.ones(2), queued=0.0, swings=np.zeros(2), swing=np.zeros((2, 6, 3)),
        foothold=np.zeros((2, 4)),
    )  # fmt: skip
    swing, stand = written(
        dynamics=[flat(d) for d in dynamics], targets=[flat(TARGETS), flat(standing)]
    )
    assert (MODES[int(swing["mode"])], MODES[int(stand["mode"])]) == ("swing", "stand")
    np.testing.assert_array_equal(swing["planned_contact"], [1.0, 0.0])
    assert np.isnan(swing["swing_position"][0]).all() and np.isnan(swing["foothold"][0]).all()
    np.testing.assert_array_equal(swing["swing_position"][1], TARGETS.swing_target(1).p_WC)
    np.testing.assert_array_equal(swing["foothold"][1], TARGETS.foothold[1])
    assert np.isnan(stand["swing_position"]).all() and np.isnan(stand["foothold"]).all()
    for tick in (swing, stand):
        assert (tick["reference_yaw"], tick["reference_friction"]) == (0.1, 0.7)
        assert (tick["gait_steps"], tick["reference_limited"]) == (2.0, Limit.UNEVEN)


@pytest.mark.parametrize(
    "wrench", [REPORT.wrench.T.copy().T, np.repeat(REPORT.wrench, 2, 1)[:, ::2]]
)
def test_an_array_that_is_laid_out_otherwise_is_recorded_as_what_it_says(wrench):
    assert not wrench.flags.c_contiguous
    other = REPORT._replace(wrench=wrench)
    for vector in (flat(other), LAYOUTS["report"].vector(other)):
        np.testing.assert_array_equal(vector, flat(REPORT))


@pytest.mark.parametrize("kind", [int, np.float32])
def test_numbers_that_are_no_doubles_travel_as_doubles(kind):
    other = REPORT._replace(wrench=REPORT.wrench.astype(kind), clipped=kind(4))
    for vector in (flat(other), LAYOUTS["report"].vector(other)):
        assert vector.dtype == np.float64
        np.testing.assert_array_equal(vector, flat(REPORT))


@pytest.mark.parametrize("status", Solved)
def test_a_success_is_what_the_status_says(status):
    (flag,) = part("report.status", CHANNELS["wbc_success"].convert).convert(np.array([status]))
    assert flag == float(status.success)


def test_a_part_has_the_units_and_axes_of_its_signal():
    for name, channel in CHANNELS.items():
        if channel.signal in SIGNALS and channel.attribute and channel.convert is None:
            of = parts_of(SIGNALS[channel.signal])[channel.attribute]
            assert channel.shape(SIZES) == of.shape(SIZES | {"knots": KNOTS}), name
    wrench = part("contact.wrench")
    assert wrench.entry_units(5) == ["N", "N", "N", "N m", "N m"]
    assert wrench.names({"nw": WRENCH[:5]})[0] == ("left", "right")


def test_a_channel_reads_a_signal_or_a_part_of_it():
    record = np.frombuffer(flat(REPORT), LAYOUTS["report"].dtype)
    np.testing.assert_array_equal(Channel("report.wrench", "N").read(record)[0], REPORT.wrench)
    both = Channel("report", "-", convert=lambda r: r["clipped"] + r["active"])
    assert both.read(record) == [6.0]


def plans(count, **parts):
    """Records of plans; of what is not given all is zero."""
    records = np.zeros(count, LAYOUTS["plan"].dtype)
    for name, values in parts.items():
        records[name] = values
    return records


@pytest.mark.parametrize("coming", range(5))
def test_of_coming_footholds_the_first_are_recorded_and_none_that_is_not_there(coming):
    footholds = np.arange(2.0 * (KNOTS + 1) * 4).reshape(2, KNOTS + 1, 4)
    records = plans(2, footholds=footholds, coming=[coming, 1.0])
    found = CHANNELS["mpc_footholds"].read(records)
    assert found.shape == (2, 3, 4)
    for places, there, n in zip(found, footholds, (min(coming, 3), 1), strict=True):
        np.testing.assert_array_equal(places[:n], there[:n])
        assert np.isnan(places[n:]).all()


def test_a_plan_of_one_interval_has_room_for_two_footholds():
    """Fewer than are recorded."""
    records = np.zeros(1, layouts(SIZES, 1)["plan"].dtype)
    records["coming"], records["footholds"] = 2.0, 7.0
    (places,) = CHANNELS["mpc_footholds"].read(records)
    np.testing.assert_array_equal(places[:2], 7.0)
    assert np.isnan(places[2]).all()


def test_the_horizon_is_seen_from_end_to_end():
    """Of a centre of mass at a steady velocity, and its mean velocity."""
    times, v = 3.0 + 0.05 * np.arange(KNOTS + 1), np.array([0.5, -0.2, 0.1])
    states = np.zeros((2, KNOTS + 1, 12))
    states[:, :, :3] = times[:, None] * v
    states[1] *= 2.0
    records = plans(2, times=times, states=states)
    np.testing.assert_allclose(CHANNELS["mpc_mean_velocity"].read(records), [v, 2.0 * v])
    ahead = CHANNELS["mpc_horizon"].read(records)
    assert ahead.shape == (2, 8, 3)
    np.testing.assert_array_equal(ahead[:, [0, -1]], states[:, [0, -1], :3])
    knots = (ahead[0, :, 0] / v[0] - 3.0) / 0.05
    assert (np.diff(knots) > 0.5).all()


def test_of_a_contact_that_says_nothing_there_is_no_nis():
    records = np.zeros(1, LAYOUTS["estimate"].dtype)
    records["nis"], records["measured"] = [1.0, 2.0, 3.0, 4.0], [1.0, 0.0, 0.0, 1.0]
    found = CHANNELS["estimate_nis"].read(records)
    np.testing.assert_array_equal(found, [[1.0, np.nan, np.nan, 4.0]])


@pytest.mark.parametrize(
    ("contact", "touchdown", "queued", "word"),
    [
        ([1.0, 1.0], [-0.2, -0.1], 0.0, "stand"),
        ([1.0, 1.0], [-0.2, 0.1], 1e9, "shift"),  # the weight is to come
        ([1.0, 1.0], [-0.2, 0.0], 1e9, "double"),
        ([1.0, 0.0], [-0.2, 0.1], 1e9, "swing"),
        ([0.0, 1.0], [0.1, -0.2], 0.0, "swing"),  # the last
        ([0.0, 0.0], [0.1, 0.2], 1e9, "flight"),
    ],
)
def test_contacts_and_queue_have_a_name_for_people(dynamics, contact, touchdown, queued, word):
    touchdown = np.array(touchdown)
    targets = TARGETS._replace(contact=np.array(contact), touchdown=touchdown, queued=queued)
    (row, *_) = written(dynamics=[flat(d) for d in dynamics], targets=[flat(targets)] * 2)
    assert MODES[int(row["mode"])] == word
