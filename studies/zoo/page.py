"""The results of the zoo and what is asked of it; the page, as Markdown for the documentation."""

from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path

from drake_linefoot.lab.results.page import render
from drake_linefoot.lab.results.tables import NOTHING, number
from drake_linefoot.robot.description import LINE, SURFACE
from studies.common.bars import HEAD as BAR_HEAD
from studies.common.bars import Asked, bar_rows, judged
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
BARS = {  # those without a bar are asked of all robots that there are
    "commands": Asked("commands from a model to a walk", 2, most=True),
    "lines_typed": Asked("lines typed from a model to a walk", 0, most=True),
    "all_skills": Asked(
        "robots, as lines and as surfaces, that show every skill under every seed, of those not "
        "refused"
    ),
    "mean_share": Asked("fastest walk of lines by sqrt(g h), mean of those not refused", SHARE),
    "as_fast": Asked(
        "robots that walk as fast on soles as on lines, to half a step of the speeds, of those "
        "that do both"
    ),
    "g1": Asked(f"{G1} on its soles: fastest", G1_SPEED, "m/s"),
    "pushed": Asked(
        f"robots on soles that stand up to each push: {AHEAD} m sqrt(g h) ahead and back, "
        f"{BESIDE} aside, an ellipse between, of those that walk"
    ),
    "side_drift": Asked(
        "largest drift of a robot on soles, walking in place on a slope of 10 degrees to its side",
        DRIFT,
        "m/s",
        most=True,
    ),
    "heavy": Asked(f"{MADE_UP[HEAVY][0]}: fastest", HEAVY_SPEED, "m/s"),
    "small": Asked(f"{MADE_UP[SMALL][0]}: fastest", SMALL_SPEED, "m/s"),
}


def bars(robots: Mapping[str, Data], seeds: int) -> dict[str, Data]:
    """Return what is asked, by key, see `judged`.

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
    drifts = [robot["side_drift"] for robot in surfaces.values()]
    fell, unable = None in drifts, bool(walking) and not able
    values = {
        "commands": 2 if able else None,  # nothing of a description is edited, see `met`
        "lines_typed": 0 if able else None,
        "all_skills": len(able),
        "mean_share": sum(shares) / len(shares) if shares else None,
        "as_fast": sum(surface > line - SAME for surface, line in both),
        "g1": surfaces[G1]["fastest"]["speed"] if G1 in surfaces else None,
        "pushed": sum(all(robot["pushed"].values()) for robot in surfaces.values()),
        "side_drift": None if fell else max(map(abs, drifts), default=None),
        "heavy": lines[HEAVY]["fastest"]["speed"] if HEAVY in lines else None,
        "small": lines[SMALL]["fastest"]["speed"] if SMALL in lines else None,
    }
    wholes = {"all_skills": len(walking), "as_fast": len(both), "pushed": len(surfaces)}
    found = {
        key: judged(replace(one, bar=wholes[key] or None) if key in wholes else one, values[key])
        for key, one in BARS.items()
    }
    failed = {"commands": unable, "lines_typed": unable, "side_drift": fell}  # without a number
    return {key: one | {"met": False} if failed.get(key) else one for key, one in found.items()}


def _walking(robots: Mapping[str, Data], contact: str) -> dict[str, Data]:
    """Return what was found of the robots that were not refused with such feet."""
    return {name: r[contact] for name, r in robots.items() if not r[contact]["refused"]}


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
        bars=bar_rows(summary["bars"]),
        bar_head=BAR_HEAD,
        number=number,
        head=HEAD,
        rows=[row_of(name, robot) for name, robot in summary["robots"].items()],
        skills=SKILLS,
        made_up={name: what for name, (what, _) in MADE_UP.items()},
        feet={LINE: "As a line", SURFACE: "On its soles"},
    )
