"""GTSAM's least squares of a short walk, beside the filter and the truth."""

import sys

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from drake_linefoot.lab.scenario import Scenario, Segment
from studies.common.command import run
from studies.estimation.smoother import STEP, Instant, Recording, measured, smoothed, smoother


def test_numbers_of_made_up_motions():
    turn = Rotation.from_rotvec
    true = turn([0.0, 0.0, 0.5]), np.array([0.6, 0.0, 0.0]), np.array([1.0, 2.0, 0.7])
    off = turn([0.02, 0.0, 0.0]) * true[0], true[1] + [0.0, 0.3, 0.4], true[2] + [0.3, -0.4, 0.1]
    last = turn([0.0, 0.0, 0.1]) * true[0], true[1], off[2]
    instants = [Instant(STEP * (i + 1), off, true, np.zeros(4), np.zeros(4)) for i in range(100)]
    assert max(measured(instants, [true] * 100).values()) == pytest.approx(0.0, abs=1e-7)
    found = measured(instants, [off] * 99 + [last])
    assert found["tilt_rmse_deg"] == pytest.approx(np.degrees(0.02) * np.sqrt(49 / 100))
    assert found["velocity_rmse"] == pytest.approx(0.5 * np.sqrt(49 / 50))
    assert found["drift_xy_m"] == pytest.approx(0.5)
    assert found["drift_z_m"] == pytest.approx(0.1)
    assert found["drift_yaw_deg"] == pytest.approx(np.degrees(0.1))


def test_without_gtsam_it_says_what_to_install(monkeypatch, tmp_path, capsys):
    monkeypatch.setitem(sys.modules, "gtsam", None)
    assert run(smoother, "estimation.smoother", ["--out", str(tmp_path / "new")]) == 3
    assert "drake_linefoot[smoother]" in capsys.readouterr().err
    assert not (tmp_path / "new").exists()


def test_smoother_and_filter_agree_with_the_truth():
    pytest.importorskip("gtsam")
    segments = [Segment("stand", 0.8), Segment("walk", 1.7, True, [0.4, 0.0], 0.3)]
    walk = Recording(Scenario(seed=1, estimation=True, segments=segments))
    assert {*np.diff([now.ticks for now in walk.instants])} == {STEP}
    best = measured(walk.instants, smoothed(walk))
    ours = measured(walk.instants, [now.found for now in walk.instants])
    for found in (best, ours):
        assert found["tilt_rmse_deg"] < 0.15
        assert found["velocity_rmse"] < 0.01
        assert found["drift_xy_m"] < 0.01
        assert found["drift_z_m"] < 0.01
        assert found["drift_yaw_deg"] < 0.3
    # It knows what comes later; by chance the filter may be better all the same (tilt, seed 0).
    for name in ("tilt_rmse_deg", "velocity_rmse", "drift_xy_m"):
        assert best[name] < ours[name]
    # Readings that contradict each other are seen: a gyroscope that says it turns.
    for imu, *_ in walk.tape.rows:
        imu[2] += 0.8
    turned = measured(walk.instants, smoothed(walk))
    assert turned["drift_yaw_deg"] > best["drift_yaw_deg"] + 1.0
