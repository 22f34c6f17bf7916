import json

import numpy as np
import pytest

from drake_linefoot.lab.results.fall_indicators import OFF_COURSE, fall_indicators
from drake_linefoot.lab.results.metrics import compute_metrics, segment_velocity
from drake_linefoot.lab.results.tables import summary_rows
from drake_linefoot.lab.scenario import Segment
from drake_linefoot.lab.simulation.channels import LIMITS
from drake_linefoot.lab.simulation.run_view import humanoid_named
from drake_linefoot.lab.simulation.velocity import mean_velocity
from tests.helpers.recorded_runs import make_run, yaw_quaternion
from tests.helpers.similar import LENGTH, similar_robot, similar_run
from tests.helpers.similar import TIME as SECOND

KEYS = {
    "duration_s",
    "slowed",
    "fell",
    "fall_time_s",
    "fall_reason",
    "roll_max_rad",
    "pitch_max_rad",
    "segments",
    "solver_failures",
    "mpc_ms",
    "wbc_ms",
    "realtime_rate",
    "contact",
    "slip_m",
    "cop_at_edge",
    "torque_max_ratio",
    "torque_at_limit",
    "final_joint_speed_rms",
    "limited",
    "joints_at_stops",
    "steps",
}
TIME = np.arange(4001) * 1e-3


def stepping(time, stride, phase=0.0):
    """Normal forces of feet that swing in turn for a third of a stride, shape (n, 2, 2)."""
    at = ((time - phase) / stride) % 1.0
    load = np.full((len(time), 2, 2), 60.0)
    load[(at > 0.05) & (at < 0.4), 0] = 0.0
    load[(at > 0.55) & (at < 0.9), 1] = 0.0
    return load


def test_the_keys_are_those_that_are_promised_and_json_holds_them():
    metrics = compute_metrics(make_run(TIME))
    assert set(metrics) == KEYS
    assert json.loads(json.dumps(metrics, allow_nan=False)) == metrics


def test_a_robot_that_stands():
    metrics = compute_metrics(make_run(TIME))
    assert metrics["duration_s"] == 4.0
    assert not metrics["fell"]
    assert metrics["fall_time_s"] is None
    assert metrics["realtime_rate"] == pytest.approx(0.5)
    assert metrics["steps"] == 0
    assert metrics["slip_m"] == 0.0
    zeros = {"commanded": [0, 0, 0], "measured": [0, 0, 0], "error": [0, 0, 0]}
    assert metrics["segments"] == [{"name": "stand", **zeros, "off_course": False, "gait": None}]


@pytest.mark.parametrize(
    ("told", "does", "off"), [(0.25, -0.12, True), (0.25, 0.2, False), (0.0, -0.26, True)]
)
def test_a_walk_the_other_way_and_one_that_goes_on_are_said(told, does, off):
    com = np.column_stack([does * TIME, 0.0 * TIME, 0.64 + 0.0 * TIME])
    run = make_run(TIME, segments=[Segment("ahead", 4.0, walk=True, velocity=[told, 0.0])], com=com)
    metrics = compute_metrics(run)
    assert metrics["segments"][0]["off_course"] == off
    assert (summary_rows(metrics).get("not as commanded") == ("ahead",)) == off
    seen = [s.what for s in fall_indicators(run, 0, len(TIME)) if s.name == OFF_COURSE]
    text = f"ahead: {does:.2f} 0.00 0.00 instead of {told:.2f} 0.00 0.00"
    assert seen == ([text] if off else [])


def test_joints_that_are_long_at_their_stops_are_said():
    q = np.zeros((len(TIME), 25))
    q[:, 0], q[:, 6], q[:, 7:] = 1.0, 0.65, 0.5
    ankle = humanoid_named("mit_humanoid").leg_q[0, -1]
    q[: len(TIME) // 4, ankle] = 0.8
    metrics = compute_metrics(make_run(TIME, q=q, true_normal=np.full((len(TIME), 2, 2), 60.0)))
    assert metrics["joints_at_stops"] == pytest.approx({"left_ankle": 0.25}, abs=1e-3)
    assert summary_rows(metrics)["at joint limit, share of time"] == ("left_ankle 25%",)
    metrics = compute_metrics(make_run(TIME, q=q, true_normal=np.zeros((len(TIME), 2, 2))))
    assert metrics["joints_at_stops"] == {}  # a foot in the air


def test_largest_roll_pitch_torque_and_final_joint_speed():
    q = np.zeros((len(TIME), 25))
    q[:, 0], q[:, 6] = 1.0, 0.65
    q[1000, :4] = np.cos(0.1), -np.sin(0.1), 0.0, 0.0  # roll -0.2
    q[2000, :4] = np.cos(0.15), 0.0, np.sin(0.15), 0.0  # pitch 0.3
    torque = np.zeros((len(TIME), 18))
    torque[5, 3] = -30.0
    v = np.zeros((len(TIME), 24))
    v[:, :6] = 9.0  # of the base, does not count
    v[:3000, 6:] = 9.0  # before the last second, does not count
    v[3000:, 6:] = 0.5
    metrics = compute_metrics(make_run(TIME, q=q, torque=torque, v=v))
    assert metrics["roll_max_rad"] == pytest.approx(0.2)
    assert metrics["pitch_max_rad"] == pytest.approx(0.3)
    assert metrics["torque_max_ratio"] == pytest.approx(0.75)
    assert metrics["final_joint_speed_rms"] == pytest.approx(0.5)


def test_wall_times_and_failures():
    mpc_ms = np.full(len(TIME), np.nan)
    mpc_ms[::20] = np.linspace(1.0, 3.0, len(mpc_ms[::20]))
    failures = np.where(TIME > 2.0, 3.0, 0.0)
    success = np.ones(len(TIME))
    success[[7, 9]] = 0.0
    run = make_run(TIME, mpc_ms=mpc_ms, mpc_failures=failures, wbc_success=success)
    metrics = compute_metrics(run)
    assert metrics["mpc_ms"] == pytest.approx({"median": 2.0, "p95": 2.9})
    assert metrics["solver_failures"] == {"mpc": 3, "wbc": 2}


def test_what_was_kept_to_limits_is_counted():
    commands = np.minimum(np.arange(len(TIME)), 12.0)
    footholds = np.where(TIME > 1.0, 5.0, 0.0)
    torques = np.zeros(len(TIME))
    torques[[3, 4]] = (1.0, 2.0)
    run = make_run(
        TIME, clipped_commands=commands, moved_footholds=footholds, clipped_torques=torques
    )
    assert compute_metrics(run)["limited"] == {"commands": 12, "footholds": 5, "torques": 3}


def test_what_a_controller_does_not_report_is_none():
    nan = np.full(len(TIME), np.nan)
    pairs = np.full((len(TIME), 2), np.nan)
    names = ("mpc_ms", "wbc_ms", "mpc_failures", "wbc_success")
    metrics = compute_metrics(make_run(TIME, contact_flag=pairs, **dict.fromkeys(names, nan)))
    assert metrics["mpc_ms"] == {"median": None, "p95": None}
    assert metrics["solver_failures"] == {"mpc": None, "wbc": None}
    assert metrics["contact"] == {"latency_ms": None, "false_positives": None, "missed": None}


def test_contact_and_steps():
    load = stepping(TIME, 0.5, phase=-0.05)
    delay = 4  # ms
    flag = (load.sum(axis=2) > 0.0).astype(float)
    flag[delay:] = flag[:-delay].copy()
    force = np.zeros((len(TIME), 2, 3))
    force[:, :, 2] = load.sum(axis=2)
    metrics = compute_metrics(make_run(TIME, true_normal=load, true_force=force, contact_flag=flag))
    assert metrics["steps"] == 16
    assert metrics["contact"]["latency_ms"] == pytest.approx(delay)
    assert metrics["contact"]["false_positives"] == 0
    assert metrics["contact"]["missed"] == 0


def test_velocity_on_a_circle_is_forward():
    speed, rate = 0.5, 0.8
    yaw = rate * TIME + 3.0  # passes pi, where the angle jumps
    p = speed / rate * np.column_stack([np.sin(yaw), -np.cos(yaw), 0.0 * yaw])
    assert mean_velocity(TIME, p, yaw) == pytest.approx([speed, 0.0, rate], abs=1e-6)
    q = np.column_stack([yaw_quaternion(yaw), p, np.zeros((len(TIME), 18))])
    segment = Segment("circle", 4.0, True, [speed, 0.0], rate)
    row = compute_metrics(make_run(TIME, segments=[segment], q=q))["segments"][0]
    assert row["commanded"] == [speed, 0.0, rate]
    assert row["measured"] == pytest.approx([speed, 0.0, rate], abs=1e-6)
    assert row["error"] == pytest.approx([0.0, 0.0, 0.0], abs=1e-6)


@pytest.mark.parametrize("phase", [0.0, 0.1, 0.2, 0.3])
def test_sway_within_a_stride_does_not_count(phase):
    stride = 0.46
    q = np.zeros((len(TIME), 25))
    q[:, 0], q[:, 6] = 1.0, 0.65
    angle = 2.0 * np.pi * (TIME - phase) / stride
    q[:, 4] = 0.4 * TIME + 0.01 * np.sin(2.0 * angle)
    q[:, 5] = 0.03 * np.sin(angle)  # mean speed up to 0.06 m/s over half a stride
    run = make_run(TIME, q=q, true_normal=stepping(TIME, stride, phase))
    measured = segment_velocity(run, 1.0, 3.0)
    assert measured == pytest.approx([0.4, 0.0, 0.0], abs=2e-3)


def test_only_the_second_half_of_a_segment_counts():
    q = np.zeros((len(TIME), 25))
    q[:, 0], q[:, 6] = 1.0, 0.65
    q[:, 4] = np.where(TIME < 1.0, 5.0 * TIME, 5.0 + 0.2 * (TIME - 1.0))
    segments = [Segment("go", 2.0, True, [0.2, 0.0]), Segment("on", 2.0, True, [0.1, 0.0])]
    rows = compute_metrics(make_run(TIME, segments=segments, q=q))["segments"]
    assert [row["name"] for row in rows] == ["go", "on"]
    assert rows[0]["measured"] == pytest.approx([0.2, 0.0, 0.0])
    assert rows[1]["error"] == pytest.approx([0.1, 0.0, 0.0])


def test_a_fall_leaves_later_segments_without_measurement():
    segments = [Segment("one", 3.0), Segment("two", 3.0), Segment("three", 1.0)]
    metrics = compute_metrics(make_run(TIME, fell=True, segments=segments))
    assert metrics["fell"]
    assert metrics["fall_time_s"] == 4.0
    assert metrics["fall_reason"] == "torso low"
    assert [row["measured"] is None for row in metrics["segments"]] == [False, True, True]


def test_metrics_of_a_similar_robot_are_those_in_its_units(tmp_path):
    """Of one that is a quarter as high, and so light that 5 N is more than a heel bears."""
    load = stepping(TIME, 0.8)
    points = np.zeros((len(TIME), 2, 2, 3))
    points[..., 0] = 0.01 * np.sin(9.0 * TIME)[:, None, None]
    flag = np.roll(load[:, :, 0] > 0.0, 4, axis=0).astype(float)
    q = np.zeros((len(TIME), 25))
    q[:, 0], q[:, 4], q[:, 6] = 1.0, 0.3 * TIME, 0.65
    v = np.random.default_rng(0).normal(size=(len(TIME), 24))
    segments = [Segment("walk", 3.0, True, [0.3, 0.1], 0.2)]
    run = make_run(
        TIME,
        segments=segments,
        q=q,
        v=v,
        true_normal=load,
        contact_points=points,
        contact_flag=flag,
    )
    mit, small = compute_metrics(run), compute_metrics(similar_run(run, similar_robot(tmp_path)))
    assert mit["steps"] == 10
    assert 0.0 < mit["slip_m"]
    alike = ("steps", "solver_failures", "limited", "fell")
    assert [small[key] for key in alike] == [mit[key] for key in alike]
    for key, unit in (
        ("duration_s", SECOND),
        ("slip_m", LENGTH),
        ("final_joint_speed_rms", 1.0 / SECOND),
    ):
        assert small[key] == pytest.approx(unit * mit[key]), key
    for few, many in zip(small["segments"], mit["segments"], strict=True):
        for key in ("commanded", "measured"):
            units = np.array([LENGTH, LENGTH, 1.0]) / SECOND
            assert few[key] == pytest.approx(units * many[key], abs=1e-9)
    mit["contact"]["latency_ms"] *= SECOND
    assert small["contact"] == pytest.approx(mit["contact"])


def test_what_slows_a_walk_is_said_with_its_share_of_the_time_and_its_speed():
    n = len(TIME)
    command = np.tile([0.8, 0.0, 0.0, 1.0], (n, 1))
    command[: n // 4, 3] = 0.0  # told to stand: nothing slows it then
    limited, reference = np.zeros(n), np.tile([0.8, 0.0, 0.0], (n, 1))
    limited[: n // 2] = LIMITS.index("feet slide")
    reference[: n // 2, 0] = 0.48
    limited[-4:] = LIMITS.index("slope")  # too short for a word
    channels = {
        "command": command, "reference_limited": limited, "reference_command": reference
    }  # fmt: skip
    metrics = compute_metrics(make_run(TIME, **channels))
    (part,) = metrics["slowed"]
    assert part["why"] == "feet slide"
    assert part["share"] == pytest.approx(1 / 3, abs=1e-3)
    assert part["speed"] == pytest.approx(0.48)
    metrics |= compute_metrics(make_run(TIME)) | {"slowed": metrics["slowed"]}
    said = summary_rows(metrics)["command limited"]
    assert said == ("to 0.48 m/s for 33 % of the time: feet slide",)
    assert "command limited" not in summary_rows(compute_metrics(make_run(TIME)))
