"""What is exact: the cone (18), the rows of r, r' and L_G in (31); and what early contact brings.

The cone is compared with all sums of forces at heel and toe inside (9), by non-negative least
squares on their extreme rays; the rows with an integration of Newton's and Euler's equations of
the centroid, moments about the moving CoM; early contact is the step up of `studies.contact`.
"""

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from drake_linefoot.centroidal import NO_WRENCH
from drake_linefoot.constants import GRAVITY
from drake_linefoot.contact.wrench_cone import line_cone, point_cone
from drake_linefoot.lab.scenario import Scenario
from drake_linefoot.lab.scenario.load import dump_scenario
from drake_linefoot.math.discretisation import zero_order_hold
from drake_linefoot.mpc.ecd import Linearisation, centroidal_state, input_matrices, system_matrices
from studies.common import runs
from studies.common.drawing import BLUE, ORANGE, blank, legend
from studies.common.pool import carry_out
from studies.common.types import Array, Data
from studies.contact.ledges import cross, crossings, lost
from studies.paper.figure import Claim, compared, shown

TITLE = "What is exact: cone (18), rows of r, v and L_G; and what early contact brings"
SEED = 0
WRENCHES = 20000
CLEAR = 1e-6  # [-] of the wrench: nearer to the boundary a side is not asked for
ROUNDING = 1e-9  # [-] of the largest entry that exact rows may be off
KNOTS, STEP = 14, 0.04  # intervals and their length [s]
PHASES = 8  # walks over the ledge, each with contact feedback and without


def compute(quick: bool) -> Data:
    """Compare cone and rows with what they stand for, and walk over the ledges."""
    rng = np.random.default_rng(SEED)
    cone = cone_errors(rng, WRENCHES // 10 if quick else WRENCHES)
    rows = row_errors(rng)
    phases = 2 if quick else PHASES
    jobs = [one for one in crossings(phases) if one.case == "up"]
    walks = carry_out(cross, jobs, lost)
    return {
        "scenario": dump_scenario(Scenario()),
        "seeds": [SEED],
        "fell": any(not row["upright"] for row in walks if row["feedback"]),
        "fall_time": None,
        "fall_reason": "; ".join(row["cause"] for row in walks if not row["upright"]),
        "cone": cone,
        "rows": {name: values.tolist() for name, values in rows.items()},
        "walks": walks,
    }


def cone_errors(rng: np.random.Generator, count: int) -> Data:
    """Return on how many random wrenches (18) and two points differ, and the size of both."""
    from scipy.optimize import nnls

    differ, inside, asked = 0, 0, 0
    for mu, X in rng.uniform((0.2, 0.04), (1.2, 0.2), (count // 100, 2)):
        rays = np.array([[a * mu, b * mu, 1.0] for a in (1, -1) for b in (1, -1)])
        columns = [_wrench(ray, at) for at in (-X, X) for ray in rays]
        generators = np.column_stack(columns) / np.array([1.0, 1.0, 1.0, X, X])[:, None]
        cone = line_cone(mu, X)
        for w in rng.normal(size=(100, 5)) * (mu, mu, 1.0, 1.0, mu) + (0, 0, 1, 0, 0):
            margin = float((cone @ (w * (1.0, 1.0, 1.0, X, X))).max())
            off = float(nnls(generators, w)[1])
            if abs(margin) < CLEAR * float(np.linalg.norm(w)):
                continue
            asked, inside = asked + 1, inside + (margin < 0.0)
            differ += (margin < 0.0) != (off < ROUNDING)
    line, point = line_cone(1.0, 1.0).shape, point_cone(1.0).shape
    return {
        "asked": asked,
        "inside": int(inside),
        "differ": int(differ),
        "line": list(line),
        "points": [2 * point[0], 2 * point[1]],
    }


def _wrench(force: Array, at: float) -> Array:
    """Return the five numbers in the middle of a line of a force at `at` along it."""
    moment = np.cross([at, 0.0, 0.0], force)
    return np.array([*force, *moment[1:]])


def row_errors(rng: np.random.Generator) -> dict[str, Array]:
    """Return how far (31), discretised, is off after each interval of a random motion.

    Returns:
        For r, v and L_G the largest entry of the error over that of the value, shape (KNOTS,).
    """
    from scipy.integrate import solve_ivp

    m, r_G = 24.0, rng.normal(size=3)
    about = Linearisation(
        np.tile(np.eye(3), (KNOTS, 1, 1)), np.tile(np.eye(3), (KNOTS, 1, 1)),
        *rng.normal(size=(4, KNOTS, 3)),
    )  # fmt: skip
    p, frames = rng.normal(size=(KNOTS, 2, 3)), np.tile(np.eye(3), (KNOTS, 2, 1, 1))
    u = 100.0 * rng.normal(size=(KNOTS, 2, 5))
    A, C = system_matrices(about, r_G, m, NO_WRENCH)
    B = input_matrices(p, frames, r_G, m, 5)
    A, B, C = zero_order_hold(A, B, C, np.full(KNOTS, STEP), 4)
    y = rng.normal(size=9)  # r, v and L about the moving CoM
    x = centroidal_state(y[:3], y[3:6], y[6:], np.zeros(3), r_G, m)
    found = np.empty((KNOTS, 3))
    for k in range(KNOTS):
        x = A[k] @ x + B[k] @ u[k].ravel() + C[k]

        def rate(_: float, y: Array, k: int = k) -> Array:
            force = u[k, :, :3]
            moment = np.cross(p[k] - y[:3], force).sum(axis=0)
            moment[1:] += u[k, :, 3:].sum(axis=0)
            return np.concatenate([y[3:6], force.sum(axis=0) / m + GRAVITY, moment])

        y = solve_ivp(rate, (0.0, STEP), y, method="DOP853", rtol=1e-13, atol=1e-12).y[:, -1]
        true = centroidal_state(y[:3], y[3:6], y[6:], np.zeros(3), r_G, m)
        for i, part in enumerate((slice(0, 3), slice(3, 6), slice(6, 9))):
            found[k, i] = np.abs(x[part] - true[part]).max() / np.abs(true[part]).max()
    return dict(zip(("r", "v", "L_G"), found.T, strict=True))


def _pairs(data: Data, key: str) -> list[tuple[float, float]]:
    """Return a number of each walk, with contact feedback and without."""
    of = {(row["feedback"], row["ledge_at"]): row[key] for row in data["walks"]}
    pairs = [(of[True, at], of[False, at]) for on, at in of if on]
    return [pair for pair in pairs if None not in pair]


def draw(data: Data) -> Figure:
    """Draw the errors of the rows over the horizon, and the impacts of the walks."""
    figure, (left, right) = blank(TITLE, 1, 2, (11.0, 4.5))
    for name, values in data["rows"].items():
        left.semilogy(np.arange(1, KNOTS + 1), np.maximum(values, 1e-17), marker=".", label=name)
    left.axhline(ROUNDING, color="grey", ls="--", label="counts as exact")
    left.set_xlabel(f"interval of {STEP:g} s")
    left.set_ylabel("largest error over largest value [-]")
    pairs = np.array(_pairs(data, "impact_n")).reshape(-1, 2)
    for k, (words, colour) in enumerate((("with", BLUE), ("without", ORANGE))):
        at = np.arange(len(pairs)) + 0.4 * k - 0.2
        right.bar(at, pairs[:, k], 0.38, color=colour, label=f"{words} contact feedback")
    right.set_xlabel("walk over a step up of 3 cm")
    right.set_ylabel("largest normal force in 30 ms [N]")
    left.legend()
    return legend(figure, right)


def table(data: Data) -> list[list[str]]:
    """Return medians and largest values over the step up, with contact feedback and without."""
    rows = [["step up of 3 cm", "walks", "median, with", "without", "largest, with", "without"]]
    for key, title in (("impact_n", "impact [N]"), ("roll_rad", "roll [rad]")):
        pairs = np.array(_pairs(data, key)).reshape(-1, 2)
        numbers = [*np.median(pairs, axis=0), *pairs.max(axis=0)] if len(pairs) else [None] * 4
        rows.append([title, str(len(pairs)), *(shown(value, ".3g") for value in numbers)])
    return rows


def claims(data: Data) -> list[Claim]:
    """Return: (18) is two points, three rows are exact, early contact softens a landing."""
    cone: dict[str, Any] = data["cone"]
    worst = max(max(values) for values in data["rows"].values())
    line, points = ("{} rows in {} unknowns".format(*cone[form]) for form in ("line", "points"))
    pairs = _pairs(data, "impact_n")
    return [
        Claim(
            "The simplified cone (18) is that of two point contacts",
            "equivalent, fewer rows and unknowns",
            f"{cone['differ']} of {cone['asked']} wrenches differ; {line} against {points}",
            cone["differ"] == 0 and 0 < cone["inside"] < cone["asked"],
            f"Random wrenches, friction and length, {cone['inside']} inside.",
        ),
        Claim(
            "The dynamics of r, v and L_G are exact",
            "exact",
            f"off by {worst:.1e} over {KNOTS} intervals",
            worst <= ROUNDING,
            "Discretised (37) to (39) against an integration of Newton's and Euler's equations "
            f"with random wrenches that are constant in each interval of {STEP:g} s.",
        ),
        compared(
            "Knowing of an early contact softens the landing",
            runs.compared(pairs),
            "that without contact feedback",
            1.0,
            "the estimator detects early contacts (no number)",
            f"Largest normal force in the 30 ms after an unexpected step up of 3 cm, {len(pairs)} "
            "pairs of walks; interval by a bootstrap over the pairs.",
        ),
    ]
