"""What is counted of trials."""

from collections import Counter
from dataclasses import dataclass, field

LONGEST = 1500  # characters of a message, of which the names of all fields take most
SLOW = 5.0  # [s] of processor time after which a message comes too late


@dataclass
class Tally:
    """Trials of one kind."""

    what: str  # was tried, in words
    ends: Counter[str] = field(default_factory=Counter)  # how often they ended in which way
    wrong: list[str] = field(default_factory=list)  # what should not have been, a line each

    def count(self, end: str, problem: str = "") -> None:
        """Count a trial; `problem` says what was wrong with its end."""
        self.ends[end] += 1
        if problem:
            self.wrong.append(f"{self.what}: {problem}")
