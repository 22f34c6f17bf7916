"""PlaCo's whole-body controller on recorded states, in an interpreter that has PlaCo."""

import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from drake_linefoot.centroidal import sample_plan
from drake_linefoot.lab.scenario import Scenario
from drake_linefoot.robot.humanoid import Humanoid
from studies.bench import placo_worker
from studies.bench.line_worker import LineWorker
from studies.common import models
from studies.common.recorder import Tick

ENVIRONMENT = Path(".venv-placo")
HOW = (
    f"PlaCo 0.10 asks for numpy < 2.4 and has an environment of its own: `python -m venv "
    f"{ENVIRONMENT} && {ENVIRONMENT}/bin/pip install placo==0.10.2`, or `--placo PYTHON`"
)


def interpreter(given: Path | None) -> Path:
    """Return the interpreter to run PlaCo with: the given one, `ENVIRONMENT`'s, or this one."""
    if given is not None:
        return given
    own = ENVIRONMENT / "bin" / "python"
    return own if own.exists() else Path(sys.executable)


class PlacoPeer(LineWorker):
    """The worker process; it ends with this context manager.

    Attributes:
        version: of PlaCo.
        force_difference: median difference of the vertical force of both feet to that of our
            controller, over the states [N].
    """

    def __init__(
        self, python: Path, humanoid: Humanoid, scenario: Scenario, ticks: Sequence[Tick]
    ) -> None:
        """Start the worker and give it the states.

        Raises:
            LinefootError: there is no PlaCo, or it does not work.
        """
        super().__init__("PlaCo", [str(python), "-B", placo_worker.__file__])
        urdf = Path(self.enter_context(tempfile.TemporaryDirectory())) / "robot.urdf"
        models.for_placo(humanoid, urdf)
        first = self.ask(_setup(humanoid, scenario, ticks, urdf))
        self.version = str(first["version"])
        ours = [float(tick.report.wrench[:, 2].sum()) for tick in ticks]
        self.force_difference = float(np.median(np.abs(np.subtract(first["vertical_force"], ours))))
        self._count = len(ticks)

    def batch(self) -> list[float]:
        """Return the time of one tick [s] for each state."""
        times: list[float] = self.ask({"batch": list(range(self._count))})["times"]
        return times


def _setup(
    humanoid: Humanoid, scenario: Scenario, ticks: Sequence[Tick], urdf: Path
) -> dict[str, Any]:
    d, q = humanoid.description, humanoid.q_nominal
    at = dict(zip(d.actuated_joints, humanoid.actuated_q.tolist(), strict=True))
    return {
        "urdf": str(urdf),
        "base": d.floating_base,
        "joints": list(d.actuated_joints),
        "arms": {name: float(q[at[name]]) for name in d.arm_joints},
        "half_length": humanoid.half_length,
        "friction": scenario.wbc.friction,
        "states": [_state(humanoid, tick) for tick in ticks],
    }


def _state(humanoid: Humanoid, tick: Tick) -> dict[str, Any]:
    """Return what PlaCo needs of a tick: state as it has it, standing feet, targets."""
    x, targets = tick.before.x, tick.targets
    sample = sample_plan(tick.plan, targets.time)
    joints_q, joints_v = humanoid.actuated_q, humanoid.nq + humanoid.actuated_v
    v, R = x[humanoid.nq :], Rotation.from_quat(x[:4], scalar_first=True).as_matrix()
    state = {
        "q": np.concatenate([x[4:7], x[[1, 2, 3, 0]], x[joints_q]]),
        "v": np.concatenate([R.T @ v[3:6], R.T @ v[:3], x[joints_v]]),
        "com": sample.r,
        "com_acceleration": sample.a,
        "R_torso": Rotation.from_euler("z", targets.yaw).as_matrix(),
    }
    for side in np.flatnonzero(targets.swings):  # one at most: it walks
        s, T = targets.swing_target(int(side)), np.eye(4)
        level = np.cross([0.0, 0.0, 1.0], s.d_W)
        level /= np.linalg.norm(level)
        T[:3, :3] = np.column_stack([s.d_W, level, np.cross(s.d_W, level)])
        T[:3, 3] = s.p_WC
        state |= {"T_swing": T, "v_swing": s.v_WC, "a_swing": s.a_WC}
    return {name: value.tolist() for name, value in state.items()} | {
        "standing": [bool(c) for c in targets.contact]
    }
