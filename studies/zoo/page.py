"""The results of the zoo and what is asked of it; the page, as Markdown for the documentation."""

from collections.abc import Mapping
from pathlib import Path

from drake_linefoot.lab.results.page import render
from drake_linefoot.lab.results.tables import NOTHING, number
from studies.common.types import Data
from studies.zoo.robots import HEAVY, MADE_UP, SMALL
from studies.zoo.trials import SKILLS

SHARE, HEAVY_SPEED, SMALL_SPEED = 0.4, 1.2, 0.2  # [-] of sqrt(g h), [m/s], [m/s] to reach
HEAD = (
    *("robot", "mass [kg]", "CoM height [m]", "joints locked", "skills"),
    *("fastest [m/s]", "of sqrt(g h)", "stopped by"),
)
BARS = {
    "commands": "commands from a model to a walk",
    "lines_typed": "lines typed from a model to a walk",
    "all_skills": "robots that show every skill under every seed, of those not refused",
    "mean_share": "fastest walk by sqrt(g h), mean of those not refused",
    "heavy": MADE_UP[HEAVY][0] + ": fastest [m/s]",
    "small": MADE_UP[SMALL][0] + ": fastest [m/s]",
}


def bars(robots: Mapping[str, Data], seeds: int) -> Data:
    """Return what is asked, by key: `value`, `bar`, and whether it `holds`; None: unknown."""
    walking = {name: robot for name, robot in robots.items() if not robot["refused"]}
    able = [name for name, r in walking.items() if min(r["skills"].values()) == seeds]
    shares = [robot["fastest"]["share"] for robot in walking.values()]
    speeds = {name: robot["fastest"]["speed"] for name, robot in walking.items()}
    found = {  # nothing of a description is edited, see `met`
        "commands": (2, 2, bool(able)),
        "lines_typed": (0, 0, bool(able)),
        "all_skills": (len(able), len(walking), len(able) == len(walking)),
        "mean_share": _least(sum(shares) / len(shares) if shares else None, SHARE),
        "heavy": _least(speeds.get(HEAVY), HEAVY_SPEED),
        "small": _least(speeds.get(SMALL), SMALL_SPEED),
    }
    keys = ("value", "bar", "holds")
    return {name: dict(zip(keys, values, strict=True)) for name, values in found.items()}


def _least(value: float | None, bar: float) -> tuple[float | None, float, bool | None]:
    return value, bar, None if value is None else value >= bar


def row_of(name: str, robot: Data) -> list[str]:
    """Return the row of a robot in a table with `HEAD`."""
    if robot["refused"]:
        return [name, *[NOTHING] * (len(HEAD) - 2), f"refused: {robot['refused']}"]
    best = robot["fastest"]
    shown = " ".join(str(robot["skills"][skill]) for skill in SKILLS)
    return [
        *(name, f"{robot['mass']:.1f}", f"{robot['com_height']:.2f}", str(len(robot["locked"]))),
        *(shown, f"{best['speed']:.2f}", f"{best['share']:.2f}", best["stopped_by"] or NOTHING),
    ]


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
    )
