"""The walk that everything is measured on."""

from __future__ import annotations

from drake_linefoot.scenario import Scenario
from drake_linefoot.scenario_io import load_scenario

NAME = "paper"
QUICK_SEGMENTS = (0.5, 1.0, 1.0)  # [s] lengths of the segments


def walking(quick: bool = False) -> Scenario:
    """Return the shipped walk: forward, then forward and turning; shorter when `quick`."""
    scenario = load_scenario(NAME)
    if quick:
        for segment, length in zip(scenario.segments, QUICK_SEGMENTS, strict=True):
            segment.duration = length
    return scenario
