"""PlaCo's whole-body controller on recorded states, in an interpreter that has PlaCo."""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np

from drake_linefoot.benchmark import placo_worker, robots
from drake_linefoot.benchmark.recording import Tick
from drake_linefoot.errors import LinefootError
from drake_linefoot.math.so3 import rot_z
from drake_linefoot.robot.dynamics import GRAVITY
from drake_linefoot.robot.humanoid import Humanoid
from drake_linefoot.scenario import Scenario

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


class PlacoPeer:
    """The worker process; a context manager.

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
        self._folder = tempfile.TemporaryDirectory(prefix="linefoot-")
        urdf = Path(self._folder.name) / "robot.urdf"
        robots.for_placo(humanoid, urdf)
        command = [str(python), "-B", placo_worker.__file__]
        try:
            self._process = subprocess.Popen(
                command,
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                text=True,
            )
        except OSError as error:
            self._folder.cleanup()
            raise LinefootError(f"{python}: {error.strerror}") from error
        try:
            first = self._ask(_setup(humanoid, scenario, ticks, urdf))
        except LinefootError:
            self._close()
            raise
        self.version = str(first["version"])
        ours = [float(tick.report.wrench[:, 2].sum()) for tick in ticks]
        self.force_difference = float(np.median(np.abs(np.subtract(first["vertical_force"], ours))))
        self._count = len(ticks)

    def __enter__(self) -> PlacoPeer:
        """Return self."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """End the worker."""
        self._close()

    def batch(self) -> list[float]:
        """Return the time of one tick [s] for each state."""
        times: list[float] = self._ask({"batch": list(range(self._count))})["times"]
        return times

    def _ask(self, question: dict[str, Any]) -> dict[str, Any]:
        """Send a line and return the answer; the worker's last words are the error's."""
        process = self._process
        assert process.stdin is not None and process.stdout is not None
        try:
            process.stdin.write(json.dumps(question) + "\n")
            process.stdin.flush()
            line = process.stdout.readline()
        except OSError:
            line = ""
        if not line:
            _, said = process.communicate()
            last = (said.strip().splitlines() or ["no answer"])[-1]
            raise LinefootError(f"PlaCo: {last}")
        answer: dict[str, Any] = json.loads(line)
        return answer

    def _close(self) -> None:
        if self._process.poll() is None:
            self._process.communicate()
        self._folder.cleanup()


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
    """Return what PlaCo needs of a tick: state, standing feet, targets."""
    x, targets = tick.before.x, tick.targets
    sample = tick.plan.sample(targets.time, GRAVITY)
    joints_q, joints_v = humanoid.actuated_q, humanoid.nq + humanoid.actuated_v
    v = x[humanoid.nq :]
    state = {
        "q": np.concatenate([x[:7], x[joints_q]]),
        "v": np.concatenate([v[:6], x[joints_v]]),
        "com": sample.r,
        "com_acceleration": sample.a,
        "R_torso": rot_z(np.array(targets.yaw)),
    }
    if targets.swing is not None:
        s, T = targets.swing, np.eye(4)
        level = np.cross([0.0, 0.0, 1.0], s.d_W)
        level /= np.linalg.norm(level)
        T[:3, :3] = np.column_stack([s.d_W, level, np.cross(s.d_W, level)])
        T[:3, 3] = s.p_WC
        state |= {"T_swing": T, "v_swing": s.v_WC, "a_swing": s.a_WC}
    return {name: value.tolist() for name, value in state.items()} | {
        "standing": [bool(c) for c in targets.contact]
    }
