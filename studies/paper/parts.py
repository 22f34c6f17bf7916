"""Which part of the model brings what: one thing after the other taken away, and one added."""

from dataclasses import replace
from itertools import product
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from drake_linefoot.lab.scenario.load import dump_scenario, parse_scenario
from drake_linefoot.lab.simulation.closed_loop import ClosedLoop
from drake_linefoot.lab.simulation.run import simulate
from drake_linefoot.lab.wiring.closed_loop import build_closed_loop
from drake_linefoot.mpc.centroidal_reference import CentroidalReference
from drake_linefoot.mpc.models.motion import write_momentum
from drake_linefoot.mpc.reference import ReferenceGenerator
from drake_linefoot.robot.humanoid import load_humanoid
from drake_linefoot.robot.leg_inertia import whole_in_torso
from drake_linefoot.signals import GaitHorizon
from drake_linefoot.wiring.controller import build_controller
from studies.common import runs
from studies.common.drawing import BLUE, GREY, blank
from studies.common.pool import carry_out
from studies.common.stamp import Probed
from studies.common.trial import judge_walk, lost_walk, walk
from studies.common.types import Array, Data
from studies.paper.figure import Claim, fell_at, shown

TITLE = "What the parts of the ECD bring: one thing after the other taken away"
COMMANDS = {  # forward, left [m/s], turn rate [rad/s]; single and double support [s]
    "0.8 m/s": ((0.8, 0.0, 0.0), (0.20, 0.03)),
    "0.5 m/s, 0.8 rad/s": ((0.5, 0.0, 0.8), (0.20, 0.03)),
    "the same, slow steps": ((0.5, 0.0, 0.8), (0.30, 0.05)),
}
QUICK_COMMANDS = ("0.8 m/s",)
DURATION, QUICK_DURATION = 6.0, 3.0  # [s] of a run
ANGLES = ("roll", "pitch")


class NoMomentum(ReferenceGenerator):
    """The inertia follows the planned legs, their momentum does not count."""

    def vector(self, horizon: Array, dynamics: Array) -> Array:
        """Return the planned inertia, and the momentum of it when locked."""
        flat = super().vector(horizon, dynamics)
        ref = self.reference.open(flat)
        write_momentum(ref, np.matvec(ref.I_B, ref.Omega_mid))
        return flat


class FrozenInertia(ReferenceGenerator):
    """The momentum of the planned legs counts, the inertia stays as it is."""

    def vector(self, horizon: Array, dynamics: Array) -> Array:
        """Return the present inertia, and the planned momentum."""
        flat, d = super().vector(horizon, dynamics), self.dynamics.open(dynamics)
        self.reference.open(flat).I_B[:] = whole_in_torso(d.q, d.p_WG, d.R_WB, d.A)[1]
        return flat


class EvenKnots(ReferenceGenerator):
    """Knots in even steps, wherever feet switch."""

    def knots(self, horizon: GaitHorizon) -> Array:
        """Return knots `knot_step` apart."""
        p = self._parameters
        return horizon.time + p.knot_step * np.arange(p.knots + 1.0)


HELD = "with the horizontal CoM held"
VARIANTS = {
    "ECD": ("ecd", ReferenceGenerator),
    "knots in even steps": ("ecd", EvenKnots),
    "without the legs' momentum": ("ecd", NoMomentum),
    "with a frozen inertia": ("ecd", FrozenInertia),
    "single rigid body": ("srbm", ReferenceGenerator),
    "the same from the whole momentum": ("srbm_momentum", ReferenceGenerator),
    "contact-consistent": ("contact_consistent", ReferenceGenerator),
    HELD: ("ecd", ReferenceGenerator),
}


def build(variant: str, text: str) -> ClosedLoop:
    """Return the closed loop of a variant for a scenario (YAML text)."""
    model, kind = VARIANTS[variant]
    scenario = parse_scenario(text)
    mpc = replace(scenario.mpc, model=model)
    if variant == HELD:  # as the height is
        mpc = replace(mpc, weights=replace(mpc.weights, position=[mpc.weights.position[2]] * 3))
    scenario = replace(scenario, mpc=mpc)
    humanoid = load_humanoid(scenario.robot)
    reference = CentroidalReference(humanoid, scenario.mpc, kind(humanoid, scenario.mpc))
    controller = build_controller(humanoid, scenario, reference=reference)
    return build_closed_loop(scenario, controller=controller)


def tried(job: tuple[str, str, str]) -> dict[str, Any]:
    """Simulate and judge a variant: its name, the command's name, and the scenario."""
    variant, command, text = job
    return {"variant": variant, "command": command, **judge_walk(simulate(build(variant, text)))}


def probe() -> dict[str, Probed]:
    """Return a quick form of the paper's figures: how steady a walk of the ECD and of one body is.

    The single rigid body is what the ECD is held against everywhere.
    """
    found, command = {}, QUICK_COMMANDS[0]
    for model in ("ecd", "srbm"):
        made = walk(runs.paper_scenario(False, model), COMMANDS[command][0], QUICK_DURATION)
        row = judge_walk(simulate(build_closed_loop(made)))
        found[f"{model}_upright"] = Probed(float(row["upright"]), 0.0)
        for angle in ANGLES:
            rms = row[f"{angle}_rms"] or 0.0
            found[f"{model}_{angle}_rms_rad"] = Probed(rms, 0.15 * rms)
    return found


def lost(job: tuple[str, str, str], error: str) -> dict[str, Any]:
    """Return what stands for `tried` of a walk whose process crashed or took too long."""
    return {"variant": job[0], "command": job[1], **lost_walk(error)}


def compute(quick: bool) -> Data:
    """Walk every command with every variant."""
    base = runs.paper_scenario(quick=False)
    duration = QUICK_DURATION if quick else DURATION
    jobs = []
    for name, variant in product(QUICK_COMMANDS if quick else COMMANDS, VARIANTS):
        command, (single, double) = COMMANDS[name]
        gait = replace(base.gait, single_support=single, double_support=double)
        text = dump_scenario(walk(replace(base, gait=gait), command, duration))
        jobs.append((variant, name, text))
    rows = carry_out(tried, jobs, lost)
    fallen = [row for row in rows if row["fell"] and row["variant"] == "ECD"]
    return {
        **runs.facts_of_rows(base, [base.seed], fallen),
        "duration": duration,
        "rows": rows,
    }


def draw(data: Data) -> Figure:
    """Draw the RMS of roll and pitch of every variant."""
    commands = list(dict.fromkeys(row["command"] for row in data["rows"]))
    size = (11.0, 1.0 + 2.4 * len(commands))
    figure, axes = blank(TITLE, len(commands), 2, size, sharex="col")
    for (i, command), (j, angle) in product(enumerate(commands), enumerate(ANGLES)):
        ax = axes[2 * i + j]
        rows = [row for row in data["rows"] if row["command"] == command]
        names = [row["variant"] + (" (FELL)" if row["fell"] else "") for row in rows][::-1]
        values = [1e3 * (row[f"{angle}_rms"] or 0.0) for row in rows][::-1]
        ax.barh(
            range(len(rows)),
            values,
            color=[BLUE if name.startswith("ECD") else GREY for name in names],
        )
        ax.set_yticks(range(len(rows)), names if j == 0 else [""] * len(rows))
        ax.set_title(f"{angle}, {command}", fontsize=10)
        if i == len(commands) - 1:
            ax.set_xlabel(f"RMS of {angle} [mrad]")
    return figure


def table(data: Data) -> list[list[str]]:
    """Return every run."""
    rows = [
        ["command", "variant", "roll rms [rad]", "pitch rms [rad]", "speed error [m/s]", "fell"]
    ]
    for row in data["rows"]:
        numbers = [shown(row[key], ".4f") for key in ("roll_rms", "pitch_rms", "speed_error")]
        rows.append([row["command"], row["variant"], *numbers, fell_at(row)])
    return rows


def claims(data: Data) -> list[Claim]:
    """Return: both the changing inertia and the legs' momentum are needed."""
    by = {(row["command"], row["variant"]): row for row in data["rows"]}
    ours = [row for row in data["rows"] if row["variant"] == "ECD"]
    result = []
    for name in ("without the legs' momentum", "with a frozen inertia", HELD):
        pairs = [(row, by[row["command"], name]) for row in ours]
        ratios = {a: runs.compared_where_both_stand(pairs, f"{a}_rms")["ratio"] for a in ANGLES}
        words = ", ".join(f"{angle} {shown(r, '.2f')}" for angle, r in ratios.items())
        result.append(
            Claim(
                f"The robot tilts more {name}",
                "no number" if name == HELD else "the ECD has both",
                f"RMS of the ECD over that {name}: {words}",
                all(r is not None and r < 1.0 for r in ratios.values()),
                f"Pooled over {len(ours)} commands, {data['duration']:g} s each",
            )
        )
    return result
