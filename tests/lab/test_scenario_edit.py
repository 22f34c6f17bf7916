"""Scenarios that options change."""

import pytest

from drake_linefoot.lab.scenario.edit import with_command, with_duration
from drake_linefoot.lab.scenario.load import load_scenario


def test_shorter_duration_cuts():
    scenario = load_scenario("walk")
    cut = with_duration(scenario, 1.5)
    assert [s.duration for s in cut.segments] == [1.0, 0.5]
    assert scenario == load_scenario("walk")
    assert [s.duration for s in with_duration(scenario, 1.0).segments] == [1.0]


def test_longer_duration_holds_the_last_segment():
    scenario = load_scenario("walk")
    longer = with_duration(scenario, scenario.duration + 2.0)
    assert longer.segments[:-1] == scenario.segments[:-1]
    assert longer.segments[-1].duration == pytest.approx(scenario.segments[-1].duration + 2.0)


def test_same_duration_changes_nothing():
    scenario = load_scenario("walk")
    assert with_duration(scenario, scenario.duration) == scenario


def test_command_keeps_the_length():
    scenario = load_scenario("walk")
    changed = with_command(scenario, 0.4, 0.0, 0.0)
    assert changed.duration == pytest.approx(scenario.duration)
    assert [s.walk for s in changed.segments] == [False, True]
