"""Results as rows of text, for the terminal and for the page."""

from typing import Any

from rich.markup import escape
from rich.table import Table

from drake_linefoot.lab.results.tables import NOTHING, number_table
from studies.common.bars import bar_table

Rows = list[list[str]]

PARTS = {
    "plant_step": "plant step alone",
    "plant_step_cold": "plant step alone, nothing of it in the caches",
    "mujoco_step": "MuJoCo, one step of the same robot",
    "dynamics": "dynamics of a state, which WBC, estimator and gait below contain",
    "dynamics_drake": "- the same by Drake's calls",
    "wbc_tick": "whole-body controller, one tick",
    "placo_tick": "PlaCo, one tick",
    "estimator_update": "contact estimator, one update",
    "gait_update": "gait, one update",
    "mpc_update": "MPC, one update, all parts",
    "mpc_update_active_set": "- with `active_set`",
    "mpc_references": "- references",
    "mpc_matrices": "- matrices",
    "mpc_condensing": "- condensing",
    "mpc_solve": "- solve",
    "loop_1khz": "closed loop at 1 kHz, per simulated ms",
    "loop_with_map": "- with a map of 24 patches",
    "loop_500hz": "closed loop at 500 Hz, per simulated ms",
    "plant_step_busy": "plant step alone, beside another closed loop",
    "loop_busy": "closed loop at 1 kHz, beside another",
    "own_plant_step": "plant step alone, in a process of its own",
    "other_plant_step": "- of the other environment",
    "own_loop": "closed loop at 1 kHz, in a process of its own",
    "other_loop": "- of the other environment",
    "own_sweep_run": "a run of a sweep, in a process of its own",
    "other_sweep_run": "- of the other environment",
    "walk_to_first_step": "`linefoot walk` to its first step",
    "import_drake_linefoot": "`import drake_linefoot`",
    "help": "`linefoot --help`",
    "import_pydrake": "`import pydrake.multibody.plant`",
}


def number(value: float | None) -> str:
    """Return a number with three digits, or a dash."""
    return NOTHING if value is None else f"{value:.3g}" if abs(value) < 1000.0 else f"{value:.0f}"


def time_rows(data: dict[str, Any]) -> Rows:
    """Return median, 95th percentile and number of each part, the kinds of a part behind it."""
    rows = [["", "median [ms]", "p95 [ms]", "n"]]
    for part, meaning in PARTS.items():
        for name, time in data["times"].items():
            kind = name.removeprefix(f"{part}: ")
            if time is not None and (name == part or kind != name):
                values = [number(time["median_ms"]), number(time["p95_ms"]), str(time["n"])]
                rows.append([meaning if name == part else f"- {kind}", *values])
    return rows


def solver_rows(data: dict[str, Any]) -> Rows:
    """Return what each solver takes for the MPC's problems, and how accurate it then is."""
    rows = [["solver", "version", "tolerance", "error [N]", "median [ms]", "p95 [ms]"]]
    for name, peer in data["peers"].items():
        if "tolerance" not in peer:
            continue
        time = data["times"].get(f"solve_{name}") or {"median_ms": None, "p95_ms": None}
        tolerance = "none to set" if peer["tolerance"] == 0.0 else number(peer["tolerance"])
        error, times = number(peer["first_wrench_error_n"]), (time["median_ms"], time["p95_ms"])
        how = f"{name}, {peer['how'].split(';')[0]}"
        rows.append([how, peer["version"] or NOTHING, tolerance, error, *map(number, times)])
    return rows


def growth_rows(growth: dict[str, Any], size: str) -> Rows:
    """Return the times of `growth` over its `size`, one row for each part, with the exponent."""
    exponents = growth.get("exponent", {})
    rows = [["median [ms]", *(f"{value:g}" for value in growth[size]), "exponent"]]
    for name, times in growth["median_ms"].items():
        rows.append([name, *map(number, times), number(exponents.get(name))])
    return rows


def notes(data: dict[str, Any]) -> list[str]:
    """Return the notes, one line each."""
    return [f"{name}: {' '.join(text.split())}" for name, text in data["notes"].items()]


def tables(data: dict[str, Any]) -> list[Table | str]:
    """Return what the terminal shows of `bench.json`."""
    shown: list[Table | str] = [bar_table(data["bars"], "Ratios and rates")]
    for title, rows in (
        ("Times", time_rows(data)),
        ("The MPC's program, at most 1 N of error", solver_rows(data)),
        ("MPC over knots", growth_rows(data["scaling"]["mpc_over_knots"], "knots")),
    ):
        shown.append(number_table(rows[0], rows[1:], title, wrapped=rows[0][0]))
    return [*shown, *(escape(f"Note on {note}") for note in notes(data))]
