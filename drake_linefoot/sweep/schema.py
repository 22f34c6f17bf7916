"""The fields of a sweep file."""

import re
from dataclasses import dataclass, field
from typing import Annotated, Any

from annotated_types import Ge, Le
from pydantic import AfterValidator, Field, Strict

from drake_linefoot.fields import Whole, misfit, together

MOST_RUNS = 1_000_000
_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]*")


def _plain_name(text: str) -> str:
    if not _NAME.fullmatch(text):
        raise ValueError("must be a name of letters, digits, '_', '-' and '.'")
    return text


FileName = Annotated[str, Strict(), AfterValidator(_plain_name), Field(validate_default=True)]
Changes = dict[Any, Any]  # by dotted path, which is looked up later


@dataclass
class GroupEntry:
    """A case of a sweep: what it has beside what all cases share."""

    name: FileName = ""
    """Of the case, in every table."""
    set: Changes = field(default_factory=dict)
    """Dotted path -> value."""
    sample: Changes = field(default_factory=dict)
    """Dotted path -> distribution."""


@dataclass
class SweepFile:
    """The fields of a sweep file."""

    name: FileName = ""
    """Names the folder of the results."""
    scenario: Annotated[str, Strict()] = "walk"
    """A shipped one, or the path of one."""
    runs: Annotated[Whole, Ge(1), Le(MOST_RUNS)] = 100
    """Of each group."""
    seed: Annotated[Whole, Ge(0)] = 0
    """Of everything that is drawn."""
    groups: Annotated[list[GroupEntry], Strict()] = field(default_factory=list)
    set: Changes = field(default_factory=dict)
    """Dotted path -> value."""
    sample: Changes = field(default_factory=dict)
    """Dotted path -> distribution."""

    @together
    def _names_groups_apart(self) -> None:
        names = [group.name for group in self.groups]
        for i, name in enumerate(names):
            if name in names[:i]:
                raise misfit(f"groups[{i}].name", name, "is the name of another group")
