"""The fields of a sweep file and their types."""

from dataclasses import dataclass, field
from typing import Any


@dataclass
class GroupEntry:
    """A case of a sweep: what it has beside what all cases share."""

    name: str = ""  # of the case, in every table
    set: dict[str, Any] = field(default_factory=dict)  # dotted path -> value
    sample: dict[str, Any] = field(default_factory=dict)  # dotted path -> distribution


@dataclass
class SweepFile:
    """The fields of a sweep file."""

    name: str = ""  # names the folder of the results
    scenario: str = "walk"  # a shipped one, or the path of one
    runs: int = 100  # [-] of each group
    seed: int = 0  # [-] of everything that is drawn
    groups: list[GroupEntry] = field(default_factory=list)
    set: dict[str, Any] = field(default_factory=dict)  # dotted path -> value
    sample: dict[str, Any] = field(default_factory=dict)  # dotted path -> distribution
