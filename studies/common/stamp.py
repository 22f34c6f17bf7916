"""What every result of a study carries: what made it, how long that took, and a quick form of it.

The quick form, a study's `probe`, is a few of its numbers that are soon computed again, each with
what it may be off by while the study would still say the same.
"""

import resource
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import NamedTuple

from drake_linefoot.lab.results.provenance import digest, made_with
from studies.common.types import Data

STUDIES = Path(__file__).resolve().parent.parent
STUDY = "study"


class Probed(NamedTuple):
    """A number of a probe."""

    value: float
    within: float  # it may be off by, and the study would still say the same


Probe = Callable[[], Mapping[str, Probed]]


@cache
def made_by(study: str) -> dict[str, str]:
    """Return `made_with`, and as `study` the digest of a study's code and of what all share.

    Args:
        study: its module, `running` or `estimation.smoother`.

    Raises:
        ValueError: there is no such study.
    """
    name = study.partition(".")[0]
    files = [*STUDIES.glob(f"{name}.py"), *(STUDIES / name).rglob("*.py")]
    if not files:
        raise ValueError(f"there is no study {name!r}")
    return {**made_with(), STUDY: digest({STUDIES: [*files, *(STUDIES / "common").rglob("*.py")]})}


def stamped(study: str, seconds: float, probe: Probe | None = None) -> Data:
    """Return what a result has beside its numbers.

    Args:
        study: see `made_by`.
        seconds: of one processor, that it took.
        probe: of a result that is published; None of another.
    """
    numbers = probe() if probe else {}
    return {
        "made_with": made_by(study),
        "seconds": round(seconds, 1),
        "probe": {name: list(number) for name, number in numbers.items()},
    }


def cpu_seconds() -> float:
    """Return how long this process and those it has waited for have computed [s]."""
    of = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(one.ru_utime + one.ru_stime for one in of)


def disagreements(stored: Mapping[str, Sequence[float]], probe: Probe) -> list[str]:
    """Return in words which numbers of a stored probe are others today."""
    now, words = probe(), []
    for name in dict.fromkeys([*stored, *now]):
        if name not in now or name not in stored:
            words.append(f"{name} is {'new' if name in now else 'gone'}")
            continue
        (value, within), found = stored[name], now[name].value
        if not abs(found - value) <= within:
            words.append(f"{name} is {found:.4g}, was {value:.4g} +- {within:.3g}")
    return words
