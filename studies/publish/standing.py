"""How a published result stands: whether its study would find the same with the code of today."""

import importlib
import json
from collections.abc import Iterable
from dataclasses import dataclass
from enum import Enum

from drake_linefoot.lab.results.provenance import CONTROLLER, LAB, differences
from studies.common.command import DOCS
from studies.common.stamp import STUDY, Probe, disagreements, made_by
from studies.common.types import Data
from studies.publish.results import Result

DIGESTS = (CONTROLLER, LAB, STUDY)


class State(Enum):
    """What is known of a result."""

    FRESH = "of this code"
    AGREES = "its quick form agrees"
    OF_A_MACHINE = "of a machine: not compared"
    STALE = "to be made again"


@dataclass(frozen=True)
class Standing:
    """How a result stands.

    Attributes:
        result: the one.
        state: what is known of it.
        why: it is not fresh, in words.
        seconds: of one processor, that it took; None where nobody knows.
    """

    result: Result
    state: State
    why: str = ""
    seconds: float | None = None


def standing(result: Result, quick_forms: bool = True) -> Standing:
    """Return how a result stands; without `quick_forms` all that is of other code is stale."""
    try:
        data: Data = json.loads((DOCS / result.data).read_text(encoding="utf-8"))
        page = (DOCS / result.page).read_bytes()
    except (OSError, ValueError) as error:
        return Standing(result, State.STALE, f"cannot be read: {error}")
    state, why = _judged(result, data, page, quick_forms)
    return Standing(result, state, why, data.get("seconds"))


def probe_of(result: Result) -> Probe:
    """Return the quick form of a study."""
    module, _, name = result.probe.partition(":")
    probe: Probe = getattr(importlib.import_module(f"studies.{module}"), name)
    return probe


def cheapest_first(standings: Iterable[Standing]) -> list[Standing]:
    """Return them by what they took, those of which nobody knows last."""
    return sorted(standings, key=lambda one: (one.seconds is None, one.seconds or 0.0))


def _judged(result: Result, data: Data, page: bytes, quick_forms: bool) -> tuple[State, str]:
    made, today = data.get("made_with") or {}, made_by(result.study)
    if untold := [name for name in DIGESTS if name not in made]:
        return State.STALE, f"it does not say which {', '.join(untold)} made it"
    is_picture = result.page.endswith(".png")
    if not is_picture and any(made[name].encode() not in page for name in DIGESTS):
        return State.STALE, f"{result.page} is not of {result.data}"
    changed = differences({k: today[k] for k in DIGESTS}, {k: made[k] for k in DIGESTS})
    if not changed:
        return State.FRESH, ""
    if not result.probe:
        return State.OF_A_MACHINE, changed
    if not quick_forms:
        return State.STALE, changed
    stored = data.get("probe")
    others = disagreements(stored, probe_of(result)) if stored else ["it has no quick form"]
    return State.STALE if others else State.AGREES, "; ".join([changed, *others])
