"""Records of a robot that stands or swings a foot, and then falls: made by hand."""

import numpy as np

from drake_linefoot.lab.simulation.channels import MODES
from drake_linefoot.robot.humanoid import load_humanoid
from tests.helpers.recorded_runs import make_run

HUMANOID = load_humanoid("mit_humanoid")
TIME = np.arange(0.0, 2.0, 0.001)
ONSET = 1.5  # [s]
LIFT, DUE = 1.2, 1.4  # [s] of a swing of the right foot
WIDTH = 0.16  # [m] between the feet
LEFT, RIGHT, HEEL, TOE = 0, 1, 0, 1


def between(begin, end):
    """Return which samples are in [begin, end) [s]."""
    return (TIME > begin - 1e-6) & (TIME < end - 1e-6)


def channels():
    """Return the channels of a robot that stands until `ONSET` and then tips over forward."""
    n = len(TIME)
    pitch = np.where(ONSET < TIME, 0.15 + 4.0 * (TIME - ONSET), 0.0)
    q = np.tile(HUMANOID.q_nominal, (n, 1))
    q[:, 0], q[:, 2] = np.cos(0.5 * pitch), np.sin(0.5 * pitch)
    points = np.zeros((n, 2, 2, 3))
    points[:, LEFT, :, 1], points[:, RIGHT, :, 1] = 0.5 * WIDTH, -0.5 * WIDTH
    points[:, :, HEEL, 0], points[:, :, TOE, 0] = -0.075, 0.075
    return {
        "q": q,
        "com": np.tile([0.0, 0.0, 0.642], (n, 1)),
        "contact_points": points,
        "true_normal": np.full((n, 2, 2), 60.0),
        "planned_contact": np.ones((n, 2)),
        "foothold": np.full((n, 2, 4), np.nan),
        "swing_position": np.full((n, 2, 3), np.nan),
        "moved_footholds": np.zeros(n),
        "mpc_failures": np.zeros(n),
        "wbc_success": np.ones(n),
        "mode": np.zeros(n),
    }


def swing(values, lands=DUE, until=DUE):
    """Let the right foot swing from `LIFT` on; it bears again at `lands`, for the gait at `until`.

    The DCM is in the middle between the feet, where any step takes it up.
    """
    air, swings = between(LIFT, lands), between(LIFT, until)
    values["true_normal"][air, RIGHT] = 0.0
    values["planned_contact"][swings, RIGHT] = 0.0
    values["mode"][swings] = MODES.index("swing")
    values["foothold"][swings, 1] = [0.0, -0.5 * WIDTH, 0.0, 0.0]
    down = np.maximum(DUE - TIME, 0.0)[:, None]
    values["swing_position"][swings, 1] = ([0.0, -0.5 * WIDTH, 0.0] + down * [0.5, 0.0, 0.2])[
        swings
    ]
    return values


def fallen(values):
    """Return the record as a run that fell."""
    return make_run(TIME, fell=True, **values)
