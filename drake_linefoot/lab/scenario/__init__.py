"""The scenario: the schema of a run with bounds and units, read, checked and changed."""

from drake_linefoot.lab.scenario.schema import Perturbation, PlantParameters, Scenario, Segment

__all__ = ["Perturbation", "PlantParameters", "Scenario", "Segment"]
