import pytest

from drake_linefoot.lab.drive.telemetry import Pace


def test_a_fast_simulation_is_held_back():
    pace = Pace()
    assert pace.wait(5.0, 100.0) == 0.0
    assert pace.wait(5.25, 100.1) == pytest.approx(0.15)
    assert pace.wait(5.5, 100.5) == pytest.approx(0.0)
    assert pace.rate == pytest.approx(1.0)
    assert pace.keeps_up


def test_a_slow_one_says_its_rate_and_does_not_race_afterwards():
    pace = Pace()
    for i in range(40):
        assert pace.wait(0.1 * i, 0.2 * i) == 0.0
    assert pace.rate == pytest.approx(0.5)
    assert not pace.keeps_up
    # it is 0.1 s late at most, whatever it lost before
    assert pace.wait(4.2, 7.8 + 0.1) == pytest.approx(0.1)
    assert pace.wait(4.5, 7.8 + 0.11) > 0.2


def test_after_a_pause_it_counts_anew():
    pace = Pace()
    pace.wait(1.0, 10.0)
    pace.restart()
    assert pace.wait(1.5, 50.0) == 0.0
    assert pace.wait(1.6, 50.0) == pytest.approx(0.1)
