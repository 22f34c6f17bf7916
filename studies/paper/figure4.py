"""Figure 4: orientation of the torso under the ECD MPC, the baselines and a model beyond it.

The Base MPC is that of the paper's reference [22], which starts from the torso's rate; the other
baseline puts the momentum of the whole body into the same model.
"""

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from drake_linefoot.simulation.recording import Run
from studies.common import runs
from studies.common.drawing import BLUE, GREEN, GREY, ORANGE, array, fallen, legend, over
from studies.common.types import Array, Data, Progress
from studies.paper.figure import Claim, fell_at, shown, steadier

NAME = "fig4"
TITLE = "Roll, pitch and yaw of the torso: commanded, ECD, Base MPC, contact-consistent"
MODELS = {
    "ecd": "ECD",
    "srbm": "Base MPC",
    "srbm_momentum": "Base, whole momentum",
    "contact_consistent": "contact-consistent",
}
PAIR = ("ecd", "srbm")  # of the paper
BEYOND = ("contact_consistent", "ecd")
SEEDS = (0, 1, 2)
SAFE = 0.5  # [rad] of roll and pitch; ours, the paper names no number
FORECAST = 0.25  # [-] of the true change of roll and pitch that the forecast may be off


def compute(quick: bool, progress: Progress) -> Data:
    """Simulate the same walk with both models, everything else the same."""
    seeds = SEEDS[:1] if quick else SEEDS
    jobs = [(seed, model) for seed in seeds for model in MODELS]
    rows: list[dict[str, Any]] = []
    drawn: dict[str, Run] = {}
    for i, (seed, model) in enumerate(jobs):

        def report(share: float, text: str, i: int = i, who: str = f"{model}, seed {seed}") -> None:
            progress((i + share) / len(jobs), f"{who}, {text}")

        run = runs.simulated(runs.paper_scenario(quick, model, seed), report)
        drawn.setdefault(model, run)
        rows.append({"seed": seed, "model": model, **judge(run)})
    return assemble(drawn, rows)


def judge(run: Run) -> dict[str, Any]:
    """Return RMS and maximum of roll and pitch from the first step on, and the yaw error."""
    w = runs.walking(run)
    yaw = run.rpy[:, 2] - np.unwrap(run.reference_yaw)
    return {
        "fell": run.fell,
        "fall_time": run.fall_time,
        "fall_reason": run.fall_reason,
        **{
            f"{name}_{kind}": runs.jsonable(value)
            for i, name in enumerate(("roll", "pitch"))
            for kind, value in (
                ("rms", runs.rms(run.rpy[w, i])),
                ("max", float(np.abs(run.rpy[:, i]).max())),
            )
        },
        "yaw_rms": runs.jsonable(runs.rms(yaw[w])),
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


def assemble(drawn: dict[str, Run], rows: list[dict[str, Any]]) -> Data:
    """Return the data: one run of each model in full, the numbers of all, the ratios.

    Args:
        drawn: model -> the run that is drawn.
        rows: what `judge` says of every run, with `seed` and `model`.
    """
    ours = drawn["ecd"]
    fall: Data = next((row for row in rows if row["model"] == "ecd" and row["fell"]), {})
    return {
        **runs.facts(ours),
        "seeds": sorted({row["seed"] for row in rows}),
        "fell": bool(fall),
        "fall_time": fall.get("fall_time"),
        "fall_reason": fall.get("fall_reason", ""),
        "curves": {
            model: {
                "time": runs.stored(run.time),
                "rpy": runs.stored(run.rpy),
                "fall_time": run.fall_time,
                "fall_reason": run.fall_reason,
            }
            for model, run in drawn.items()
        },
        "time": runs.stored(ours.time),
        "yaw": runs.stored(np.unwrap(ours.reference_yaw)),
        "rows": rows,
        "ratios": {
            f"{name}_rms_{words}": ratio(rows, f"{name}_rms", pair)
            for name in ("roll", "pitch")
            for words, pair in (("ecd_over_srbm", PAIR), ("cc_over_ecd", BEYOND))
        },
        "forecast_contact_consistent": worst_forecast(rows, "contact_consistent"),
    }


def ratio(rows: list[dict[str, Any]], key: str, pair: tuple[str, str] = PAIR) -> float | None:
    """Return one model over the other of an RMS, pooled over the seeds; None without a number."""
    return runs.ratio(*([row[key] for row in rows if row["model"] == model] for model in pair))


def worst_forecast(rows: list[dict[str, Any]], model: str) -> float | None:
    """Return the forecast error of a model with the worst seed; None without a number."""
    found = [row["forecast"] for row in rows if row["model"] == model]
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
    keys = ("roll_rms", "roll_max", "pitch_rms", "pitch_max", "yaw_rms")
    header = ["model", "seed", *(f"{key.replace('_', ' ')} [rad]" for key in keys)]
    header += ["error of forecast", "fell"]
    rows = [header]
    for row in data["rows"]:
        values = [shown(row[key], ".4f") for key in keys]
        off = row["forecast"]
        percent = "-" if off is None else f"{100 * off:.0f} %"
        rows.append([MODELS[row["model"]], str(row["seed"]), *values, percent, fell_at(row)])
    for words, pair in (("ECD / Base", PAIR), ("contact-consistent / ECD", BEYOND)):
        ratios = [shown(ratio(data["rows"], key, pair), ".2f") for key in keys]
        rows.append([words, "all", *ratios, "", ""])
    return rows


def _slopes(data: Data) -> str:
    slopes = next(row["slopes"] for row in data["rows"] if row["model"] == "ecd")
    return " and ".join(shown(slope, ".2f") for slope in slopes)


def claims(data: Data) -> list[Claim]:
    """Return: ECD follows the orientation, the base leaves the limits, ECD's errors are smaller."""
    largest = {
        model: max(
            max(row["roll_max"], row["pitch_max"]) for row in data["rows"] if row["model"] == model
        )
        for model in PAIR
    }
    note = f"Safe is taken as {SAFE} rad of roll and pitch; the paper names no limit."
    result = [
        Claim(
            NAME,
            "With the ECD the torso follows the commanded orientation",
            "performs pretty well (a picture)",
            f"roll and pitch within {largest['ecd']:.3f} rad",
            largest["ecd"] < SAFE and not data["fell"],
            note,
        ),
        Claim(
            NAME,
            "The single-rigid-body MPC leaves the safe limits of roll and pitch",
            "breaks them eventually",
            f"roll and pitch within {largest['srbm']:.3f} rad",
            largest["srbm"] > SAFE,
            note + " Same gait, weights, gains and seeds; at this speed. The grid has others.",
        ),
    ]
    for name in ("roll", "pitch"):
        value = data["ratios"][f"{name}_rms_ecd_over_srbm"]
        result.append(
            steadier(
                NAME,
                f"The ECD keeps the {name} closer to the command than the single rigid body",
                value,
                "the base's",
                f"RMS from the first step on, pooled over seeds {data['seeds']}.",
            )
        )
    return [*result, _forecast_claim(data), _beyond_claim(data)]


def _beyond_claim(data: Data) -> Claim:
    """Return: with legs that follow the torso the forecast is that of the robot."""
    found = data["forecast_contact_consistent"]
    return Claim(
        NAME,
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
        NAME,
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
