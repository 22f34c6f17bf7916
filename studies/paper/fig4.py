"""Figure 4: orientation of the torso under the ECD MPC, the baselines and a model beyond it.

The Base MPC is that of the paper's reference [22], which starts from the torso's rate; the other
baseline puts the momentum of the whole body into the same model. The figure shows the paper's walk;
a faster and longer one with the same models and seeds is judged beside it. Models are compared by
the geometric mean over the seeds of the ratio of their RMS, its interval by a bootstrap over the
seeds; see `statistic`.
"""

from itertools import product
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from drake_linefoot.lab.results.judge import judge as judge_run
from drake_linefoot.lab.simulation.recording import Run
from drake_linefoot.lab.simulation.run import simulate
from drake_linefoot.lab.wiring.closed_loop import build_closed_loop
from studies.common import runs
from studies.common.drawing import BLUE, GREEN, GREY, ORANGE, array, fallen, legend, over
from studies.common.runs import MODELS
from studies.common.trial import walk
from studies.common.trials import FRESH
from studies.common.types import Array, Data
from studies.paper import statistic
from studies.paper.figure import BETTER, Claim, compared, fell_at, shown, steadier

TITLE = "Roll, pitch and yaw of the torso: commanded, ECD, Base MPC, contact-consistent"
PAIR = ("ecd", "srbm")  # of the paper
BEYOND = ("contact_consistent", "ecd")
PAIRS = {"ecd_over_srbm": PAIR, "cc_over_ecd": BEYOND}
ANGLES = ("roll", "pitch", "yaw")
PAPER, FAST = "paper", "fast"  # walks
FAST_COMMAND, FAST_DURATION = (1.2, 0.0, 0.0), 12.5  # [m/s, m/s, rad/s], [s]
SEEDS = tuple(range(FRESH, FRESH + 10))
QUICK_SEEDS = (0,)
CLOSE = 0.05  # [rad] of the command; ours, the paper names no number
SAFE = 0.2  # [rad] of roll and pitch; the same
FORECAST = 0.25  # [-] of the true change of roll and pitch that the forecast may be off


def compute(quick: bool) -> Data:
    """Simulate the same walks with all models, everything else the same."""
    seeds, walks = (QUICK_SEEDS, (PAPER,)) if quick else (SEEDS, (PAPER, FAST))
    rows: list[dict[str, Any]] = []
    shown_run: dict[str, Run] = {}
    for kind, seed, model in product(walks, seeds, MODELS):
        scenario = runs.paper_scenario(quick, model, seed)
        if kind == FAST:
            scenario = walk(scenario, FAST_COMMAND, FAST_DURATION)
        run = simulate(build_closed_loop(scenario))  # not kept: there are many
        shown_run.setdefault(model, run)
        rows.append({"walk": kind, "seed": seed, "model": model, **judge(run)})
    return assemble(shown_run, rows)


def judge(run: Run) -> dict[str, Any]:
    """Return the outcome, and RMS and maximum of roll, pitch and the error of yaw while walking."""
    w = runs.walking(run)
    off = run.rpy - np.outer(np.unwrap(run.reference_yaw), (0.0, 0.0, 1.0))
    return {
        **judge_run(run),
        **{f"{name}_rms": runs.jsonable(runs.rms(off[w, i])) for i, name in enumerate(ANGLES)},
        **{f"{name}_max": float(np.abs(off[:, i]).max()) for i, name in enumerate(ANGLES)},
        "forecast": runs.jsonable(forecast_error(run)),
        "slopes": [runs.jsonable(slope) for slope in forecast_slopes(run)],
    }


def tilt_changes(run: Run) -> tuple[Array, Array]:
    """Return the forecast and the true change of roll and pitch while each plan was used.

    The desired torso is level, so that eta_x and eta_y are roll and pitch up to squares. All
    plans of the walk count; shapes (m, 2).
    """
    begins, ends = runs.uses_of_plans(run)
    forecast = (run.mpc_orientation[ends] - run.mpc_orientation[begins])[:, :2]
    return forecast, run.rpy[ends, :2] - run.rpy[begins, :2]


def forecast_error(run: Run) -> float:
    """Return the RMS error of the forecast in shares of the RMS true change; NaN without one."""
    forecast, true = tilt_changes(run)
    change = runs.rms(true)
    return runs.rms(forecast - true) / change if change > 0.0 else float("nan")


def forecast_slopes(run: Run) -> list[float]:
    """Return which multiple of the true change of roll and of pitch is foreseen: 1 is right.

    The slope of the line through the origin that fits forecast over truth best; NaN where
    nothing changes.
    """
    forecast, true = tilt_changes(run)
    squares = np.sum(true**2, axis=0)
    products = np.sum(forecast * true, axis=0)
    return [
        float(p / s) if s > 0.0 else float("nan") for p, s in zip(products, squares, strict=True)
    ]


def assemble(shown_run: dict[str, Run], rows: list[dict[str, Any]]) -> Data:
    """Return the data: one run of each model in full, the numbers of all, the ratios.

    The rows are what `judge` says of every run, with `walk`, `seed` and `model`.
    """
    ours = shown_run["ecd"]
    fall: Data = next((row for row in rows if row["model"] == "ecd" and row["fell"]), {})
    return {
        **runs.facts(ours),
        "seeds": sorted({row["seed"] for row in rows}),
        "fell": bool(fall),
        "fall_time": fall.get("fall_time"),
        "fall_reason": fall.get("fall_reason", ""),
        "curves": {
            model: {
                "time": runs.decimated(run.time),
                "rpy": runs.decimated(run.rpy),
                "fall_time": run.fall_time,
                "fall_reason": run.fall_reason,
            }
            for model, run in shown_run.items()
        },
        "time": runs.decimated(ours.time),
        "yaw": runs.decimated(np.unwrap(ours.reference_yaw)),
        "rows": rows,
        "ratios": {
            f"{angle}_rms_{words}{key}": found[of]
            for angle in ANGLES
            for words, pair in PAIRS.items()
            for found in [ratio(rows, f"{angle}_rms", pair)]
            for key, of in statistic.KEYS.items()
        },
        "statistic": statistic.over(
            "the seeds with which neither falls,", "seeds", len({row["seed"] for row in rows})
        ),
        "forecast_contact_consistent": worst_forecast(rows, "contact_consistent"),
    }


def rows_of(rows: list[dict[str, Any]], model: str, kind: str = PAPER) -> list[dict[str, Any]]:
    """Return the rows of a model in one of the walks."""
    return [row for row in rows if row["model"] == model and row["walk"] == kind]


def ratio(
    rows: list[dict[str, Any]], key: str, pair: tuple[str, str] = PAIR, kind: str = PAPER
) -> Data:
    """Return what `compared_by_cluster` says of one model over the other, each seed by itself."""
    both = zip(*(rows_of(rows, model, kind) for model in pair), strict=True)
    return statistic.compared_by_cluster([(one["seed"], one, other) for one, other in both], key)


def worst_forecast(rows: list[dict[str, Any]], model: str) -> float | None:
    """Return the forecast error of a model with the worst seed; None without a number."""
    found = [row["forecast"] for row in rows_of(rows, model)]
    return None if None in found else max(found)


def draw(data: Data) -> Figure:
    """Draw roll, pitch and yaw of both models over time."""
    figure, axes = over(f"Figure 4. {TITLE}\nseed {data['seeds'][0]}", data, 3)
    base = data["curves"]["srbm"]
    if base["fall_time"] is not None:
        fallen(figure, axes, base["fall_time"], base["fall_reason"], MODELS["srbm"])
    time, level = array(data["time"]), np.zeros(len(data["time"]))
    for i, (ax, name) in enumerate(zip(axes, ("roll", "pitch", "yaw"), strict=True)):
        desired = array(data["yaw"]) if i == 2 else level
        ax.plot(time, desired, color=GREY, ls="--", label="commanded")
        for model, colour in (("srbm", ORANGE), ("ecd", BLUE), ("contact_consistent", GREEN)):
            curve = data["curves"][model]
            label = MODELS[model]
            ax.plot(array(curve["time"]), array(curve["rpy"])[:, i], color=colour, label=label)
        ax.set_ylabel(f"{name} [rad]")
    return legend(figure, axes[0])


def table(data: Data) -> list[list[str]]:
    """Return the numbers of every run, and the ratios."""
    keys = [f"{angle}_{kind}" for angle in ANGLES for kind in ("rms", "max")]
    header = ["walk", "model", "seed", *(f"{key.replace('_', ' ')} [rad]" for key in keys)]
    header += ["error of forecast", "fell"]
    rows = [header]
    for row in data["rows"]:
        values = [shown(row[key], ".4f") for key in keys]
        off = row["forecast"]
        percent = "-" if off is None else f"{100 * off:.0f} %"
        about = row["walk"], MODELS[row["model"]], str(row["seed"])
        rows.append([*about, *values, percent, fell_at(row)])
    kinds = dict.fromkeys(row["walk"] for row in data["rows"])
    for kind, pair in product(kinds, PAIRS.values()):
        ratios = [statistic.mean(ratio(data["rows"], key, pair, kind)) for key in keys]
        rows.append([kind, " / ".join(MODELS[model] for model in pair), "all", *ratios, "", ""])
    return rows


def _slopes(data: Data) -> str:
    slopes = rows_of(data["rows"], "ecd")[0]["slopes"]
    return " and ".join(shown(slope, ".2f") for slope in slopes)


def claims(data: Data) -> list[Claim]:
    """Return: ECD follows the orientation, the base leaves the limits, ECD's errors are smaller."""
    rows = data["rows"]
    off = [max(row[f"{angle}_max"] for angle in ANGLES) for row in rows_of(rows, "ecd")]
    result = [
        Claim(
            "With the ECD the torso follows the commanded orientation",
            "performs pretty well (a picture)",
            f"roll, pitch and yaw within {max(off):.3f} rad",
            max(off) < CLOSE and not any(row["fell"] for row in rows_of(rows, "ecd")),
            f"Holds below {CLOSE} rad, with every seed; the paper names no number.",
        ),
        _leaves_claim(rows),
    ]
    for angle, (words, pair) in product(ANGLES, PAIRS.items()):
        found = ratio(rows, f"{angle}_rms", pair)
        note = f"{data['statistic']}. RMS from the first step on, seeds {data['seeds']}."
        first, other = (MODELS[model] for model in pair)
        claim = f"The {first} keeps the {angle} closer to the command than the {other}"
        if words == "ecd_over_srbm":
            result.append(steadier(claim, found, "the base's", note))
        else:
            result.append(compared(claim, found, "the ECD's", BETTER, "beyond the paper", note))
    return [*result, _forecast_claim(data), _beyond_claim(data)]


def _leaves_claim(rows: list[dict[str, Any]]) -> Claim:
    """Return: the base leaves the safe limits of roll and pitch, where the ECD does not."""
    words, left = [], {}
    for kind, model in product(dict.fromkeys(row["walk"] for row in rows), PAIR):
        own = rows_of(rows, model, kind)
        tilts = [max(row["roll_max"], row["pitch_max"]) for row in own]
        left[kind, model] = [tilt > SAFE for tilt in tilts]
        words.append(f"{kind}, {MODELS[model]} within {max(tilts):.3f} rad")
    eventually = any(all(left[kind, "srbm"]) and not any(left[kind, "ecd"]) for kind, model in left)
    return Claim(
        "The single-rigid-body MPC leaves the safe limits of roll and pitch",
        "breaks them eventually",
        "; ".join(words),
        eventually,
        f"Safe is taken as {SAFE} rad; the paper names no limit. Holds when the base leaves "
        f"them with every seed in a walk in which the ECD never does: the paper's, or "
        f"{FAST_COMMAND[0]:g} m/s for {FAST_DURATION:g} s. Same gait, weights, gains and seeds.",
    )


def _beyond_claim(data: Data) -> Claim:
    """Return: with legs that follow the torso the forecast is that of the robot."""
    found = data["forecast_contact_consistent"]
    return Claim(
        "The contact-consistent model predicts the orientation",
        "beyond the paper",
        "no plan while walking" if found is None else f"forecast off by {100 * found:.0f} %",
        found is not None and found <= FORECAST,
        f"As for the ECD, the worst seed; at most {100 * FORECAST:g} %.",
    )


def _forecast_claim(data: Data) -> Claim:
    """Return: the model's orientation is that of the robot, which the base's is not."""
    found = [worst_forecast(data["rows"], model) for model in PAIR]
    known = None not in found
    ours, base = (0.0 if value is None else value for value in found)
    return Claim(
        "The ECD predicts the orientation, the effects of the legs included",
        "only quadratic errors in the orientation",
        f"forecast off by {100 * ours:.0f} %, the base's by {100 * base:.0f} %"
        if known
        else "no plan while walking",
        known and ours <= FORECAST and ours < base,
        "Change of roll and pitch that the MPC's model predicts for the use of each plan, against "
        "the true change, RMS over all plans; the worst seed. Holds when the ECD is off by at most "
        f"{100 * FORECAST:g} % and by less than the base. Of the true change the ECD foresees "
        f"{_slopes(data)} times as much (roll, pitch).",
    )
