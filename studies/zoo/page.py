"""The results of the zoo and what is asked of it; the page, as Markdown for the documentation."""

from collections.abc import Iterable, Mapping
from pathlib import Path

from drake_linefoot.lab.results.page import render
from drake_linefoot.lab.results.tables import NOTHING, number
from drake_linefoot.robot.description import LINE, SURFACE
from studies.common.types import Data
from studies.zoo.disturbed import AHEAD, BESIDE
from studies.zoo.robots import G1, HEAVY, MADE_UP, SMALL
from studies.zoo.trials import CONTACTS, RUNG, SKILLS

SHARE, HEAVY_SPEED, SMALL_SPEED = 0.4, 1.2, 0.2  # [-] of sqrt(g h), [m/s], [m/s] to reach
G1_SPEED = 1.1  # [m/s], likewise
SAME = 0.5 * RUNG  # [-] of sqrt(g h): walks that differ by less are as fast
DRIFT = 0.03  # [m/s] at most
COLUMNS = ("skills", "m/s", "share", "pushes", "drift")
HEAD = ("robot", "kg", *(f"{what}: {contact}" for what in COLUMNS for contact in CONTACTS))
BARS = {
    "commands": "commands from a model to a walk",
    "lines_typed": "lines typed from a model to a walk",
    "all_skills": "robots, as lines and as surfaces, that show every skill under every seed, of "
    "those not refused",
    "mean_share": "fastest walk of lines by sqrt(g h), mean of those not refused",
    "as_fast": "robots that walk as fast on soles as on lines, to half a step of the speeds, of "
    "those that do both",
    "g1": f"{G1} on its soles: fastest [m/s]",
    "pushed": f"robots on soles that stand up to each push: {AHEAD} m sqrt(g h) ahead and back, "
    f"{BESIDE} aside, an ellipse between, of those that walk",
    "side_drift": "largest drift of a robot on soles, walking in place on a slope of 10 degrees to "
    "its side [m/s]",
    "heavy": MADE_UP[HEAVY][0] + ": fastest [m/s]",
    "small": MADE_UP[SMALL][0] + ": fastest [m/s]",
}


def bars(robots: Mapping[str, Data], seeds: int) -> Data:
    """Return what is asked, by key: `value`, `bar`, and whether it `holds`; None: unknown.

    Args:
        robots: by name what `met` found of each, by contact.
        seeds: that each skill was tried under.
    """
    lines, surfaces = (_walking(robots, contact) for contact in CONTACTS)
    walking = [*lines.values(), *surfaces.values()]
    able = [robot for robot in walking if min(robot["skills"].values()) == seeds]
    shares = [robot["fastest"]["share"] for robot in lines.values()]
    both = [
        (surfaces[name]["fastest"]["share"], lines[name]["fastest"]["share"])
        for name in surfaces.keys() & lines.keys()
    ]
    as_fast = sum(surface > line - SAME for surface, line in both)
    stood = sum(all(robot["pushed"].values()) for robot in surfaces.values())
    drifts = [robot["side_drift"] for robot in surfaces.values()]
    drift = max(map(abs, drifts)) if drifts and None not in drifts else None
    speeds = {name: robot["fastest"]["speed"] for name, robot in lines.items()}
    on_soles = {name: robot["fastest"]["speed"] for name, robot in surfaces.items()}
    found = {  # nothing of a description is edited, see `met`
        "commands": (2, 2, bool(able)),
        "lines_typed": (0, 0, bool(able)),
        "all_skills": (len(able), len(walking), len(able) == len(walking)),
        "mean_share": _least(sum(shares) / len(shares) if shares else None, SHARE),
        "as_fast": (as_fast, len(both), as_fast == len(both) if both else None),
        "g1": _least(on_soles.get(G1), G1_SPEED),
        "pushed": (stood, len(surfaces), stood == len(surfaces) if surfaces else None),
        "side_drift": (drift, DRIFT, drift is not None and drift <= DRIFT if drifts else None),
        "heavy": _least(speeds.get(HEAVY), HEAVY_SPEED),
        "small": _least(speeds.get(SMALL), SMALL_SPEED),
    }
    keys = ("value", "bar", "holds")
    return {name: dict(zip(keys, values, strict=True)) for name, values in found.items()}


def _walking(robots: Mapping[str, Data], contact: str) -> dict[str, Data]:
    """Return what was found of the robots that were not refused with such feet."""
    return {name: r[contact] for name, r in robots.items() if not r[contact]["refused"]}


def _least(value: float | None, bar: float) -> tuple[float | None, float, bool | None]:
    return value, bar, None if value is None else value >= bar


def row_of(name: str, robot: Data) -> list[str]:
    """Return the row of a robot in a table with `HEAD`: what it does as a line, as a surface."""
    found = [robot[contact] for contact in CONTACTS]
    walked = [each for each in found if not each["refused"]]
    columns: list[list[str]] = []
    for each in found:
        if each["refused"]:
            columns.append(["refused" if not walked else NOTHING, *[NOTHING] * (len(COLUMNS) - 1)])
        else:
            best = each["fastest"]
            skills = _skills(each["skills"].values())
            upright = f"{sum(each['pushed'].values())} of {len(each['pushed'])}"
            drift = "fell" if each["side_drift"] is None else f"{each['side_drift']:.3f}"
            fast = [f"{best['speed']:.2f}", f"{best['share']:.2f}"]
            columns.append([skills, *fast, upright, drift])
    mass = f"{walked[0]['mass']:.1f}" if walked else NOTHING
    return [name, mass, *(cell for pair in zip(*columns, strict=True) for cell in pair)]


def _skills(seeds: Iterable[int]) -> str:
    """Return under how many seeds each skill was shown; once where it is the same."""
    counts = list(seeds)
    return f"all {counts[0]}" if len(set(counts)) == 1 else " ".join(map(str, counts))


def page_of(summary: Data) -> str:
    """Return the page of what `summary.json` holds."""
    return render(
        "index.md.j2",
        Path(__file__).parent,
        summary=summary,
        bars=BARS,
        number=number,
        head=HEAD,
        rows=[row_of(name, robot) for name, robot in summary["robots"].items()],
        skills=SKILLS,
        made_up={name: what for name, (what, _) in MADE_UP.items()},
        feet={LINE: "As a line", SURFACE: "On its soles"},
    )
